#include "harmonic/contact_factors.hpp"

#include <petscsys.h>

#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "support/event.hpp"

namespace dovetail {
namespace {

// C (m, n) = A B + beta C by columns, with op(A) (m, k), op(B) (k, n).
void gemm(const char *ta, const char *tb, std::size_t m, std::size_t n, std::size_t k, const double *A, std::size_t lda,
          const double *B, std::size_t ldb, double beta, double *C) {
  const PetscBLASInt rows = static_cast<PetscBLASInt>(m), columns = static_cast<PetscBLASInt>(n),
                     inner = static_cast<PetscBLASInt>(k), la = static_cast<PetscBLASInt>(lda),
                     lb = static_cast<PetscBLASInt>(ldb);
  const double one = 1;
  if (m > 0 && n > 0) BLASgemm_(ta, tb, &rows, &columns, &inner, &one, A, &la, B, &lb, &beta, C, &rows);
}

} // namespace

ContactFactors::ContactFactors(const StuckBasis &basis, const Layout &layout)
    : basis_(basis), layout_(layout), n_(layout.dofs()), shares_(layout.size) {}

void ContactFactors::look_at(const ContactForces &contact, bool all) {
  moving_.clear();
  for (int p = 0; p < contact.size(); ++p) {
    const auto springs = stuck_springs(contact.points()[p]);
    if (!all && contact.springs_only(p) && std::equal(springs.begin(), springs.end(), &basis_.springs[3 * p])) continue;
    for (int d = has_friction(contact.points()[p].law) ? 0 : 2; d < 3; ++d) moving_.push_back(3 * p + d);
  }
  const int own = static_cast<int>(moving_.size());
  MPI_Allgather(&own, 1, MPI_INT, shares_.data(), 1, MPI_INT, layout_.comm);
  std::vector<int> starts(layout_.size);
  std::exclusive_scan(shares_.begin(), shares_.end(), starts.begin(), 0);
  std::vector<PetscInt> numbers;
  for (const int dof : moving_) numbers.push_back(3 * layout_.own_points.begin + dof);
  all_moving_.resize(starts.back() + shares_.back());
  MPI_Allgatherv(numbers.data(), own, MPIU_INT, all_moving_.data(), shares_.data(), starts.data(), MPIU_INT,
                 layout_.comm);
}

// LAPACK reaches more than half of what a core can do, the products of gather and fill less.
double ContactFactors::work() const {
  const double rows = static_cast<double>(all_moving_.size()), size = rows * layout_.width;
  return size * size * size + 100 * size * size + 6.0 * layout_.width * rows * rows * n_ + 4e5;
}

double ContactFactors::work_to_solve() const {
  const double rows = static_cast<double>(all_moving_.size()), size = rows * layout_.width, n = static_cast<double>(n_);
  return 5 * size * size + 8 * n * layout_.width * (rows + n) + 1e5;
}

void ContactFactors::gather_rows() {
  if (factored_ == all_moving_) return;
  factored_ = all_moving_;
  points_ = 0, blocks_.clear();
  for (std::size_t first = 0, last; first < factored_.size(); first = last, ++points_) {
    for (last = first; last < factored_.size() && factored_[last] / 3 == factored_[first] / 3;) ++last;
    for (std::size_t row = first; row < last; ++row)
      for (std::size_t column = first; column < last; ++column) blocks_.push_back({row, column, true});
  }
  std::vector<double> own;
  for (const int dof : moving_) {
    const double *row = basis_.exact.row(layout_.own_modes.size() + dof);
    own.insert(own.end(), row, row + n_);
  }
  rows_.resize(factored_.size() * n_);
  std::vector<int> counts(layout_.size), starts(layout_.size);
  for (int r = 0; r < layout_.size; ++r) counts[r] = static_cast<int>(shares_[r] * n_);
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  MPI_Allgatherv(own.data(), counts[layout_.rank], MPI_DOUBLE, rows_.data(), counts.data(), starts.data(), MPI_DOUBLE,
                 layout_.comm);
}

// D^-1. The damping of the stuck points' springs, which the structure does not have, leaves the diagonal.
void ContactFactors::weigh() {
  std::vector<double> damped(n_);
  std::size_t next = 0;
  for (PetscInt dof = 0; dof < 3 * layout_.own_points.size(); ++dof) {
    if (next < moving_.size() && moving_[next] == dof) {
      ++next;
      continue;
    }
    const double *row = basis_.exact.row(layout_.own_modes.size() + dof), spring = basis_.springs[dof];
    for (std::size_t j = 0; j < n_; ++j) damped[j] -= spring * row[j] * row[j];
  }
  MPI_Allreduce(MPI_IN_PLACE, damped.data(), static_cast<int>(n_), MPI_DOUBLE, MPI_SUM, layout_.comm);
  const int harmonics = layout_.width / 2;
  own_.resize(n_ * (harmonics + 1)), other_.resize(own_.size());
  for (std::size_t j = 0, at = 0; j < n_; ++j)
    for (int k = 0; k <= harmonics; ++k, ++at) {
      const double lambda = basis_.lambda[j], a = lambda - k * omega_ * k * omega_,
                   b = k * omega_ * damping_ * std::max(0.0, lambda + damped[j]),
                   square = std::max(a * a + b * b, 1e-20 * lambda * lambda); // no mode is undamped so exactly
      own_[at] = a / square, other_[at] = b / square;
    }
}

// delta_ of all that move.
void ContactFactors::gather_deltas(const JacobianParts &parts) {
  const int w = layout_.width;
  const std::size_t size = static_cast<std::size_t>(w) * w;
  const auto owner = [&](const Block &block) {
    return owner_of(layout_.points, factored_[block.row] / 3, layout_.size);
  };
  std::vector<int> counts(layout_.size), starts(layout_.size);
  for (const Block &block : blocks_) counts[owner(block)] += static_cast<int>(size);
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  std::vector<double> own;
  std::vector<double> &kept = layout_.size == 1 ? delta_ : own;
  kept.resize(counts[layout_.rank]), written_.resize(9 * size);
  double *to = kept.data();
  PetscInt point = -1;
  for (const Block &block : blocks_) {
    if (owner(block) != layout_.rank) continue;
    const PetscInt p = factored_[block.row] / 3 - layout_.own_points.begin;
    const int row = static_cast<int>(factored_[block.row] % 3), column = static_cast<int>(factored_[block.column] % 3);
    const auto &places = block_places(parts.contact.points()[p].law);
    if (std::exchange(point, p) != p) parts.contact.write(static_cast<int>(p), written_.data());
    const auto place = std::find_if(places.begin(), places.end(),
                                    [&](const BlockPlace &at) { return at.row == row && at.column == column; });
    if (place == places.end())
      std::fill_n(to, size, 0.0);
    else
      std::copy_n(&written_[(place - places.begin()) * size], size, to);
    const double spring = row == column ? basis_.springs[3 * p + row] : 0;
    if (row == column && parts.held) to[0] += parts.held[3 * p + row];
    for (int i = 0; i < w && spring != 0; ++i) {
      to[i * w + i] -= spring;
      const double cross = spring * ((i + 1) / 2) * omega_ * damping_;
      if (i > 0) to[i * w + (i % 2 ? i + 1 : i - 1)] -= i % 2 ? cross : -cross;
    }
    to += size;
  }
  if (layout_.size == 1) return;
  delta_.resize(size * blocks_.size());
  MPI_Allgatherv(own.data(), counts[layout_.rank], MPI_DOUBLE, delta_.data(), counts.data(), starts.data(), MPI_DOUBLE,
                 layout_.comm);
}

// matrix_ = I + F Delta, harmonic by harmonic of its rows.
void ContactFactors::fill() {
  const int w = layout_.width, harmonics = w / 2;
  const std::size_t rows = factored_.size(), size = rows * w;
  matrix_.assign(size * size, 0);
  flexible_.resize(2 * rows * rows), scaled_.resize(rows * n_);
  double *in_phase = flexible_.data(), *out_of_phase = in_phase + rows * rows;
  for (int k = 0; k <= harmonics; ++k) {
    for (const bool phase : {true, false}) {
      if (k == 0 && !phase) break;
      const double *weight = (phase ? own_ : other_).data() + k;
      for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t j = 0; j < n_; ++j) scaled_[i * n_ + j] = weight[j * (harmonics + 1)] * rows_[i * n_ + j];
      gemm("T", "N", rows, rows, n_, rows_.data(), n_, scaled_.data(), n_, 0, phase ? in_phase : out_of_phase);
    }
    for (std::size_t i = 0; i < rows; ++i) {
      const double *part = delta_.data();
      for (const Block &block : blocks_) {
        if (block.acts) {
          const double a = in_phase[i * rows + block.row], b = k > 0 ? out_of_phase[i * rows + block.row] : 0;
          double *c = &matrix_[(i * w + (k > 0 ? cosine(k) : 0)) * size + block.column * w], *s = c + size;
          const double *pc = part + (k > 0 ? cosine(k) : 0) * w, *ps = pc + w;
          if (k == 0)
            for (int j = 0; j < w; ++j) c[j] += a * pc[j];
          else
            for (int j = 0; j < w; ++j) c[j] += a * pc[j] - b * ps[j], s[j] += b * pc[j] + a * ps[j];
        }
        part += static_cast<std::size_t>(w) * w;
      }
    }
  }
  for (std::size_t i = 0; i < size; ++i) matrix_[i * size + i] += 1;
}

void ContactFactors::decompose(bool precisely) {
  constexpr PetscInt small = 300;
  PetscBLASInt n = static_cast<PetscBLASInt>(factored_.size() * layout_.width), info = 0;
  pivots_.clear(), rough_ = {};
  if (n > small && !precisely) {
    rough_.factor({matrix_.begin(), matrix_.end()});
    sign_ = rough_.sign();
    return;
  }
  pivots_.resize(n);
  if (n > 0) LAPACKgetrf_(&n, &n, matrix_.data(), &n, pivots_.data(), &info);
  sign_ = info == 0 ? 1 : 0;
  for (PetscBLASInt i = 0; i < n; ++i) { // its sign is that of the pivots and of their exchanges
    if (matrix_[i + static_cast<std::size_t>(i) * n] < 0) sign_ = -sign_;
    if (pivots_[i] != i + 1) sign_ = -sign_;
  }
}

bool ContactFactors::factor(const JacobianParts &parts, bool precisely) {
  const Timed timed(Work::factors);
  omega_ = parts.omega, damping_ = parts.damping;
  gather_rows();
  weigh();
  gather_deltas(parts);
  const double *part = delta_.data();
  for (Block &block : blocks_) {
    const double *end = part + static_cast<std::size_t>(layout_.width) * layout_.width;
    block.acts = std::any_of(std::exchange(part, end), end, [](double value) { return value != 0; });
  }
  fill();
  decompose(precisely);
  to_modes(parts.column, b_);
  to_modes(parts.border, c_);
  if (sign_ != 0) solve_in_modes(b_);
  double corner = layout_.owns_omega() ? parts.border[layout_.own_coefficients()] : 0;
  MPI_Bcast(&corner, 1, MPI_DOUBLE, layout_.size - 1, layout_.comm);
  schur_ = corner - std::inner_product(c_.begin(), c_.end(), b_.begin(), 0.0);
  if (!std::isfinite(schur_) || schur_ == 0) sign_ = 0;
  if (schur_ < 0) sign_ = -sign_;
  return sign_ != 0;
}

// y (n, 2H+1) = Phi^T of all ranks' coefficients.
void ContactFactors::to_modes(const double *own, std::vector<double> &y) const {
  const std::size_t w = layout_.width;
  y.assign(n_ * w, 0);
  gemm("N", "T", w, n_, layout_.own_dofs(), own, w, basis_.exact.row(0), basis_.exact.stride(), 0, y.data());
  MPI_Allreduce(MPI_IN_PLACE, y.data(), static_cast<int>(y.size()), MPI_DOUBLE, MPI_SUM, layout_.comm);
}

void ContactFactors::solve_in_modes(std::vector<double> &y) {
  const int w = layout_.width;
  const std::size_t rows = factored_.size(), size = rows * w;
  const auto divide = [&] {
    for (std::size_t j = 0, at = 0; j < n_; ++j)
      for (int k = 0; k <= w / 2; ++k, ++at) {
        double *of_mode = &y[j * w];
        if (k == 0) {
          of_mode[0] *= own_[at];
          continue;
        }
        const double c = of_mode[cosine(k)], s = of_mode[sine(k)];
        of_mode[cosine(k)] = own_[at] * c - other_[at] * s, of_mode[sine(k)] = other_[at] * c + own_[at] * s;
      }
  };
  if (rows == 0) return divide();
  y_ = y;
  divide();
  motion_.resize(size), force_.assign(size, 0);
  gemm("N", "N", w, rows, n_, y.data(), w, rows_.data(), n_, 0, motion_.data());
  PetscBLASInt n = static_cast<PetscBLASInt>(size), one = 1, info;
  if (rough_.size() == 0) {
    LAPACKgetrs_("T", &n, &one, matrix_.data(), &n, pivots_.data(), motion_.data(), &n, &info);
  } else {
    rough_motion_.assign(motion_.begin(), motion_.end());
    rough_.solve(rough_motion_.data(), true);
    std::copy(rough_motion_.begin(), rough_motion_.end(), motion_.begin());
  }
  const PetscBLASInt width = w;
  const double plus = 1, minus = -1;
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    if (blocks_[b].acts)
      BLASgemv_("T", &width, &width, &minus, &delta_[b * w * w], &width, &motion_[blocks_[b].column * w], &one, &plus,
                &force_[blocks_[b].row * w], &one);
  y.swap(y_);
  gemm("N", "T", w, n_, rows, force_.data(), w, rows_.data(), n_, 1, y.data());
  divide();
}

void ContactFactors::solve(const double *r, double *x) {
  const Timed timed(Work::factors);
  std::vector<double> y;
  to_modes(r, y);
  solve_in_modes(y);
  double last = layout_.owns_omega() ? r[layout_.own_coefficients()] : 0;
  MPI_Bcast(&last, 1, MPI_DOUBLE, layout_.size - 1, layout_.comm);
  last = (last - std::inner_product(c_.begin(), c_.end(), y.begin(), 0.0)) / schur_;
  for (std::size_t i = 0; i < y.size(); ++i) y[i] -= last * b_[i];
  gemm("N", "N", layout_.width, layout_.own_dofs(), n_, y.data(), layout_.width, basis_.exact.row(0),
       basis_.exact.stride(), 0, x);
  if (layout_.owns_omega()) x[layout_.own_coefficients()] = last;
}

} // namespace dovetail
