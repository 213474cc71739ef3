#include "harmonic/coarse_space.hpp"

#include <petscsys.h>
// needs the one above
#include <petscblaslapack.h>

#include <cmath>

#include "support/event.hpp"

namespace dovetail {
namespace {

constexpr PetscInt least = 250;  // dofs: with fewer an iteration costs next to nothing
constexpr double iterations = 8; // that factoring may cost
constexpr double near_by = 1.5;  // times the highest harmonic's frequency are the highest modes it comes near to

// c motions take 2 c^2 (2H+1)^2 3 N_x operations, an iteration 4 n (2H+1) 3 N_x.
PetscInt worth_factoring(const Layout &layout) {
  if (layout.dofs() < least) return 0;
  return static_cast<PetscInt>(std::sqrt(2 * iterations * layout.dofs() / layout.width));
}

} // namespace

CoarseSpace::CoarseSpace(const StuckBases &bases, const Layout &layout)
    : basis_(bases.mean()), layout_(layout), own_(own_share(layout.comm, layout.dofs())),
      most_(worth_factoring(layout)) {
  PetscBool given;
  check(PetscOptionsGetInt(nullptr, "hb_modal_", "-lowest", &most_, &given), "reading options");
  given_ = given;
  if (bases.wave.sectors > 0) most_ = 0;
}

// Motions for this frequency.
void CoarseSpace::choose(double omega) {
  const PetscInt n = layout_.dofs();
  const double reach = near_by * (layout_.width / 2) * omega;
  const PetscInt known = static_cast<PetscInt>(basis_.shapes.size()) / n,
                 near =
                     static_cast<PetscInt>(std::lower_bound(basis_.lambda.begin(), basis_.lambda.end(), reach * reach) -
                                           basis_.lambda.begin()),
                 shapes = given_ ? known : std::min(known, most_ / 2),
                 lowest = given_ ? std::min(most_, n) : std::clamp<PetscInt>(near, 1, most_ - shapes);
  if (lowest == lowest_) return;
  lowest_ = lowest, count_ = lowest + std::min(shapes, n - lowest);
  const std::size_t c = count_, rows = 3 * layout_.own_points.size();
  motions_.assign(n * c, 0);
  for (PetscInt k = 0; k < lowest; ++k) motions_[k * n + k] = 1;
  for (std::size_t k = lowest; k < c; ++k)
    std::copy(&basis_.shapes[(k - lowest) * n] + lowest, &basis_.shapes[(k - lowest) * n] + n,
              &motions_[k * n] + lowest);
  if (rows > 0) {
    const PetscBLASInt count = static_cast<PetscBLASInt>(c), own = static_cast<PetscBLASInt>(rows),
                       all = static_cast<PetscBLASInt>(n), stride = static_cast<PetscBLASInt>(basis_.exact.stride());
    const double one = 1, zero = 0;
    std::vector<double> moved(rows * c);
    BLASgemm_("T", "N", &count, &own, &all, &one, motions_.data(), &all, basis_.exact.row(layout_.own_modes.size()),
              &stride, &zero, moved.data(), &count);
    at_contacts_.assign(moved.begin(), moved.end());
  }
  stiff_.assign(c * c, 0), heavy_ = damped_ = rates_ = losses_ = stiff_;
  for (std::size_t i = 0; i < c; ++i)
    for (std::size_t k = 0; k < c; ++k)
      for (PetscInt j = 0; j < n; ++j) {
        const double product = motions_[i * n + j] * motions_[k * n + j];
        heavy_[i * c + k] += product, stiff_[i * c + k] += basis_.lambda[j] * product;
        damped_[i * c + k] += basis_.damped[j] * product, rates_[i * c + k] += basis_.rates[j] * product;
        losses_[i * c + k] += basis_.losses[j] * product;
      }
}

void CoarseSpace::factor(const ModalOperator &contacts, const DynamicStiffness &structure) {
  const Timed timed(Work::factors);
  choose(structure.omega());
  const std::size_t c = count_, w = layout_.width, size = c * w, block = w * w;
  std::vector<float> blocks = contacts.among(at_contacts_, count_), matrix(size * size);
  MPI_Allreduce(MPI_IN_PLACE, blocks.data(), static_cast<int>(blocks.size()), MPI_FLOAT, MPI_SUM, layout_.comm);
  for (std::size_t i = 0; i < c; ++i)
    for (std::size_t k = 0; k < c; ++k) {
      float *const at = &matrix[k * w * size + i * w];
      for (std::size_t b = 0; b < w; ++b) std::copy_n(&blocks[(i * c + k) * block + b * w], w, at + b * size);
      at[0] += static_cast<float>(stiff_[i * c + k]);
      for (int h = 1; h <= layout_.width / 2; ++h) {
        const double stiff = stiff_[i * c + k], heavy = heavy_[i * c + k];
        const auto own = static_cast<float>(structure.in_phase(h, stiff, heavy)),
                   other = static_cast<float>(structure.quadrature(h, stiff, heavy) + damper(structure, h, i * c + k));
        at[cosine(h) * size + cosine(h)] += own, at[sine(h) * size + sine(h)] += own;
        at[sine(h) * size + cosine(h)] += other, at[cosine(h) * size + sine(h)] -= other;
      }
    }
  jacobian_.factor(std::move(matrix));
  factor_diagonal(structure);
}

// Its determinant is not negative: that of the mean is of a stiffness, those of harmonics are of complex matrices.
void CoarseSpace::factor_diagonal(const DynamicStiffness &structure) {
  const std::size_t c = count_;
  diagonal_.resize(layout_.width / 2 + 1);
  bool regular = true;
  for (int h = 0; h <= layout_.width / 2; ++h) {
    const std::size_t size = h == 0 ? c : 2 * c;
    std::vector<float> matrix(size * size);
    for (std::size_t i = 0; i < c; ++i)
      for (std::size_t k = 0; k < c; ++k) {
        const double heavy = heavy_[i * c + k];
        const auto own = static_cast<float>(structure.in_phase(h, stiff_[i * c + k], heavy)),
                   other = static_cast<float>(structure.quadrature(h, damped_[i * c + k], heavy) +
                                              damper(structure, h, i * c + k));
        matrix[k * size + i] = own;
        if (h == 0) continue;
        matrix[(c + k) * size + c + i] = own, matrix[(c + k) * size + i] = other, matrix[k * size + c + i] = -other;
      }
    regular = diagonal_[h].factor(std::move(matrix)) && regular;
  }
  sign_ = regular ? jacobian_.sign() : 0;
}

void CoarseSpace::to_motions(const double *v, double *g) const {
  PetscBLASInt w = layout_.width, count = static_cast<PetscBLASInt>(count_), own = own_.size(),
               n = static_cast<PetscBLASInt>(layout_.dofs());
  const double one = 1, zero = 0;
  std::fill_n(g, size(), 0.0);
  if (own > 0) BLASgemm_("N", "N", &w, &count, &own, &one, v, &w, motions_.data() + own_.begin, &n, &zero, g, &w);
}

void CoarseSpace::add(const double *g, double *v) const {
  PetscBLASInt w = layout_.width, count = static_cast<PetscBLASInt>(count_), own = own_.size(),
               n = static_cast<PetscBLASInt>(layout_.dofs());
  const double one = 1;
  if (own > 0) BLASgemm_("N", "T", &w, &own, &count, &one, g, &w, motions_.data() + own_.begin, &n, &one, v, &w);
}

void CoarseSpace::solve(double *g, bool transposed) {
  const std::size_t c = count_, w = layout_.width;
  rough_.assign(g, g + c * w);
  jacobian_.solve(rough_.data(), transposed);
  for (std::size_t h = 0; h < diagonal_.size(); ++h) {
    part_.resize(diagonal_[h].size());
    const auto each = [&](auto &&work) {
      for (std::size_t i = 0; i < part_.size(); ++i)
        work(part_[i], (i % c) * w + (h == 0 ? 0 : i < c ? cosine(static_cast<int>(h)) : sine(static_cast<int>(h))));
    };
    each([&](float &value, std::size_t at) { value = static_cast<float>(g[at]); });
    diagonal_[h].solve(part_.data(), transposed);
    each([&](float value, std::size_t at) { rough_[at] -= value; });
  }
  std::copy(rough_.begin(), rough_.end(), g);
}

} // namespace dovetail
