#include "harmonic/lowest_modes.hpp"

#include <cmath>

#include "support/event.hpp"

extern "C" { // PETSc knows the names of its own precision only
void sgetrf_(int *, int *, float *, int *, int *, int *);
void sgetrs_(const char *, int *, int *, float *, int *, int *, float *, int *, int *);
}

namespace dovetail {
LowestModes::LowestModes(const StuckBasis &basis, const Layout &layout, PetscInt count)
    : basis_(basis), layout_(layout), count_(std::min(count, share_of(layout.dofs(), 0, layout.size).size())) {}

void LowestModes::factor(const ModalOperator &contacts, double omega, double damping) {
  if (count_ == 0) return;
  const Timed timed(Work::factors);
  const int w = layout_.width;
  const std::size_t block = static_cast<std::size_t>(w) * w;
  std::vector<float> own = contacts.among_lowest(count_), all(layout_.rank == 0 ? own.size() : 0);
  MPI_Reduce(own.data(), all.data(), static_cast<int>(own.size()), MPI_FLOAT, MPI_SUM, 0, layout_.comm);
  sign_ = 1;
  if (layout_.rank == 0) {
    int n = static_cast<int>(count_) * w, info = 0;
    factors_.resize(own.size()), pivots_.resize(n), v_.resize(n);
    for (PetscInt j = 0; j < count_; ++j)
      for (PetscInt k = 0; k < count_; ++k)
        for (int b = 0; b < w; ++b)
          std::copy_n(&all[(j * count_ + k) * block + b * w], w,
                      &factors_[static_cast<std::size_t>(k * w + b) * n + j * w]);
    for (PetscInt j = 0; j < count_; ++j)
      for (int k = 0; k <= w / 2; ++k) {
        const double lambda = basis_.lambda[j], a = lambda - k * omega * k * omega, b = k * omega * damping * lambda;
        const auto at = [&](int row, int column) -> float & {
          return factors_[static_cast<std::size_t>(j * w + column) * n + j * w + row];
        };
        if (k == 0) {
          at(0, 0) += static_cast<float>(a);
          continue;
        }
        at(cosine(k), cosine(k)) += static_cast<float>(a), at(sine(k), sine(k)) += static_cast<float>(a);
        at(cosine(k), sine(k)) += static_cast<float>(b), at(sine(k), cosine(k)) -= static_cast<float>(b);
      }
    sgetrf_(&n, &n, factors_.data(), &n, pivots_.data(), &info);
    for (int i = 0; i < n; ++i) {
      const float pivot = factors_[i + static_cast<std::size_t>(i) * n];
      if (!std::isfinite(pivot) || pivot == 0) sign_ = 0;
      if (pivot < 0) sign_ = -sign_;
      if (pivots_[i] != i + 1) sign_ = -sign_;
    }
  }
  MPI_Bcast(&sign_, 1, MPI_INT, 0, layout_.comm);
}

void LowestModes::solve(const double *in, double *out, bool transposed) {
  if (layout_.rank != 0 || sign_ == 0) return;
  int n = static_cast<int>(v_.size()), one = 1, info;
  std::copy_n(in, n, v_.begin());
  sgetrs_(transposed ? "T" : "N", &n, &one, factors_.data(), &n, pivots_.data(), v_.data(), &n, &info);
  std::copy_n(v_.begin(), n, out);
}

} // namespace dovetail
