#include "preload/contact_preload.hpp"

#include <algorithm>

#include "preload/preload_problem.hpp"

namespace dovetail {

PreloadedModel contact_preload(ReducedModel reduced, std::vector<ContactPoint> contact,
                               const std::vector<double> &initial, std::string &note) {
  PreloadedModel out{std::move(reduced), std::move(contact), {}};
  out.standstill.resize(out.contact.size());
  if (out.reduced.points == 0) return out;
  PreloadProblem problem(out.reduced, out.contact);
  UniqueVec x = problem.unknown();
  double *values;
  check(VecGetArray(x, &values), "contact preload");
  std::copy(initial.begin(), initial.end(), values);
  check(VecRestoreArray(x, &values), "contact preload");
  if (!problem.find(x, 1, note))
    throw ComputeError(
        "contact preload (eq 7) found no equilibrium: K_xx x + g(x) = -R has no solution Newton could "
        "reach, nor with load or friction in steps. A body held by its joint alone must be pressed against it: check "
        "the sign of /preload and of the normals (positive x_n closes), contact.gap, and try "
        "preload.initial.");
  const double *found;
  check(VecGetArrayRead(x, &found), "contact preload");
  for (std::size_t p = 0; p < out.contact.size(); ++p) {
    const StaticForce g = static_force(out.contact[p], found + 3 * p);
    out.standstill[p] = {{found[3 * p], found[3 * p + 1], found[3 * p + 2]}, g.force, g.w};
  }
  check(VecRestoreArrayRead(x, &found), "contact preload");
  return out;
}

} // namespace dovetail
