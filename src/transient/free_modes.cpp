#include "transient/free_modes.hpp"

#include <slepcblaslapack.h>

#include <algorithm>
#include <numeric>

#include "support/error.hpp"
#include "transient/weighted_sum.hpp"

namespace dovetail {

FreeModes free_modes(const DenseModel &model) {
  if (!model.damping.acts_in_time()) throw ComputeError("time integration: not with hysteretic damping");
  const int n = model.dofs(), m = 3 * model.points;
  FreeModes out;
  out.count = n;
  out.shapes = model.K;
  out.w2.resize(n);
  std::vector<double> M = model.M, work(1);
  PetscBLASInt size = n, type = 1, lwork = -1, info = 0;
  for (int pass = 0; pass < 2 && n > 0; ++pass) { // the first one asks for the size of the workspace
    LAPACKsygv_(&type, "V", "L", &size, out.shapes.data(), &size, M.data(), &size, out.w2.data(), work.data(), &lwork,
                &info);
    if (info > n) throw InputError(mass_not_positive(model.file));
    if (info != 0) throw ComputeError("time integration: no free modes (LAPACK's sygv: " + std::to_string(info) + ")");
    lwork = static_cast<PetscBLASInt>(work[0]);
    work.resize(lwork);
  }
  for (double &w2 : out.w2) w2 = std::max(w2, 0.0); // rigid motion, to round-off
  const double *shapes = out.shapes.data();         // column-major: mode after mode
  out.contact.resize(static_cast<std::size_t>(n) * m);
  out.momentum.resize(out.shapes.size());
  for (const LoadCase &load : model.loads) out.loads.push_back({std::vector<double>(n), load.fourier});
  for (int i = 0; i < n; ++i) {
    const double *shape = shapes + static_cast<std::size_t>(i) * n;
    for (std::size_t load = 0; load < out.loads.size(); ++load)
      for (int j = 0; j < n; ++j) out.loads[load].vector[i] += shape[j] * model.loads[load].vector[j];
    std::copy_n(shape + model.modes, m, &out.contact[static_cast<std::size_t>(i) * m]);
    combine(n, n, shape, model.M.data(), &out.momentum[static_cast<std::size_t>(i) * n]);
  }
  if (model.C.empty()) return out;
  out.viscous.resize(out.shapes.size());
  std::vector<double> moved(n);
  for (int i = 0; i < n; ++i) {
    combine(n, n, shapes + static_cast<std::size_t>(i) * n, model.C.data(), moved.data());
    for (int j = 0; j < n; ++j)
      out.viscous[static_cast<std::size_t>(i) * n + j] =
          std::inner_product(moved.begin(), moved.end(), shapes + static_cast<std::size_t>(j) * n, 0.0);
  }
  return out;
}

} // namespace dovetail
