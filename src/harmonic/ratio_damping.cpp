#include "harmonic/ratio_damping.hpp"

#include <algorithm>
#include <numeric>

namespace dovetail {

RatioDamping::RatioDamping(LinearPart &part, const StuckBasis &basis, const std::vector<ModeRatio> &ratios,
                           const Layout &layout)
    : comm_(layout.comm), first_(layout.first_dof()), own_(layout.own_dofs()), all_(layout.dofs()) {
  const std::size_t r = ratios.size(), w = layout.width;
  std::vector<double> q(layout.own_coefficients()), stiff(q.size()), heavy(q.size());
  shapes_.resize(own_ * r);
  for (std::size_t j = 0; j < r; ++j) {
    const PetscInt mode = ratios[j].mode - 1;
    rates_.push_back(rate_of(basis, ratios[j]));
    for (PetscInt d = 0; d < own_; ++d) q[d * w] = basis.exact.row(d)[mode];
    part.multiply(q.data(), stiff.data(), heavy.data());
    for (PetscInt d = 0; d < own_; ++d) shapes_[d * r + j] = heavy[d * w];
  }
}

void RatioDamping::multiply(const double *q, int width, double *out) const {
  const std::size_t r = rates_.size(), w = width;
  std::vector<double> along(r * w, 0.0); // c V^T q
  for (PetscInt d = 0; d < own_; ++d)
    for (std::size_t j = 0; j < r; ++j)
      for (std::size_t i = 0; i < w; ++i) along[j * w + i] += rates_[j] * shapes_[d * r + j] * q[d * w + i];
  MPI_Allreduce(MPI_IN_PLACE, along.data(), static_cast<int>(along.size()), MPI_DOUBLE, MPI_SUM, comm_);
  std::fill_n(out, own_ * w, 0.0);
  for (PetscInt d = 0; d < own_; ++d)
    for (std::size_t j = 0; j < r; ++j)
      for (std::size_t i = 0; i < w; ++i) out[d * w + i] += shapes_[d * r + j] * along[j * w + i];
}

std::vector<RatioDamping::Entry> RatioDamping::entries() const {
  const std::size_t r = rates_.size();
  int size;
  MPI_Comm_size(comm_, &size);
  const int own = static_cast<int>(shapes_.size());
  std::vector<int> counts(size), starts(size);
  MPI_Allgather(&own, 1, MPI_INT, counts.data(), 1, MPI_INT, comm_);
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  std::vector<double> all(all_ * r); // ranks one after the other, as rows of the harmonic system are
  MPI_Allgatherv(shapes_.data(), own, MPI_DOUBLE, all.data(), counts.data(), starts.data(), MPI_DOUBLE, comm_);
  std::vector<Entry> out;
  for (PetscInt d = 0; d < own_; ++d)
    for (PetscInt e = 0; e < all_; ++e) {
      double value = 0;
      for (std::size_t j = 0; j < r; ++j) value += shapes_[d * r + j] * rates_[j] * all[e * r + j];
      out.push_back({first_ + d, e, value});
    }
  return out;
}

} // namespace dovetail
