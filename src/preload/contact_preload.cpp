#include "preload/contact_preload.hpp"

#include "preload/preload_problem.hpp"

namespace dovetail {

PreloadedModel contact_preload(ReducedModel reduced, std::vector<ContactPoint> contact,
                               const std::vector<double> &initial, std::string &note) {
  PreloadedModel out{std::move(reduced), std::move(contact), {}};
  out.standstill.resize(out.contact.size());
  if (out.reduced.points == 0) return out;
  PreloadProblem problem(out.reduced, out.contact);
  std::vector<double> x = initial;
  if (!problem.find(x, 1, note))
    throw ComputeError(
        "contact preload (eq 7) found no equilibrium: K_xx x + g(x) = -R has no solution Newton could "
        "reach, nor with load or friction in steps. A body held by its joint alone must be pressed against it: check "
        "the sign of /preload and of the normals (positive x_n closes), contact.gap, and try "
        "preload.initial.");
  for (std::size_t p = 0; p < out.contact.size(); ++p) {
    const StaticForce g = static_force(out.contact[p], &x[3 * p]);
    out.standstill[p] = {{x[3 * p], x[3 * p + 1], x[3 * p + 2]}, g.force, g.w};
  }
  return out;
}

} // namespace dovetail
