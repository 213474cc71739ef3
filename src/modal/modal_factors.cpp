#include "modal/modal_factors.hpp"

#include <petscsys.h>
// needs the one above
#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "modal/rough_factors.hpp"
#include "support/event.hpp"

namespace dovetail {

void gemm(const char *ta, const char *tb, std::size_t m, std::size_t n, std::size_t k, const double *A, std::size_t lda,
          const double *B, std::size_t ldb, double beta, double *C, std::size_t ldc) {
  const PetscBLASInt rows = static_cast<PetscBLASInt>(m), columns = static_cast<PetscBLASInt>(n),
                     inner = static_cast<PetscBLASInt>(k), la = static_cast<PetscBLASInt>(lda),
                     lb = static_cast<PetscBLASInt>(ldb), lc = static_cast<PetscBLASInt>(ldc);
  const double one = 1;
  if (m > 0 && n > 0) BLASgemm_(ta, tb, &rows, &columns, &inner, &one, A, &la, B, &lb, &beta, C, &lc);
}

int factor_in_place(std::vector<double> &matrix, std::vector<PetscBLASInt> &pivots) {
  PetscBLASInt n = static_cast<PetscBLASInt>(std::lround(std::sqrt(static_cast<double>(matrix.size())))), info = 0;
  pivots.resize(n);
  if (n > 0) LAPACKgetrf_(&n, &n, matrix.data(), &n, pivots.data(), &info);
  return sign_of_factors(matrix, pivots);
}

void solve_in_place(const std::vector<double> &factors, const std::vector<PetscBLASInt> &pivots, double *x) {
  PetscBLASInt n = static_cast<PetscBLASInt>(pivots.size()), one = 1, info;
  if (n > 0)
    LAPACKgetrs_("T", &n, &one, const_cast<double *>(factors.data()), &n, const_cast<PetscBLASInt *>(pivots.data()), x,
                 &n, &info);
}

ModalFactors::ModalFactors(const StuckBases &bases, const Layout &layout)
    : bases_(bases), basis_(bases.mean()), layout_(layout), n_(layout.dofs()) {
  for (IndexGroup &group : groups_of(bases.wave, layout.width)) {
    const StuckBasis &basis = *bases.of_index[group.index];
    const std::size_t length = group.complex ? 2 * n_ : n_;
    sheaves_.push_back({std::move(group), basis, length, {}});
  }
}

// q (rows, 2H+1) = rows of Phi, `stride` numbers apart, times y (n, 2H+1): the coefficients of these harmonics.
void ModalFactors::move(const Sheaf &of, std::size_t rows, const double *phi, std::size_t stride, const double *y,
                        double *q) const {
  const std::size_t w = layout_.width, columns = of.of.columns();
  if (of.of.whole) return gemm("N", "N", w, rows, n_, y, w, phi, stride, 0, q, w);
  std::vector<double> parted(of.length * columns), moved(rows * columns);
  for (std::size_t j = 0; j < n_; ++j)
    for (std::size_t c = 0; c < columns; ++c) {
      parted[j * columns + c] = of.of.real(static_cast<int>(c), y + j * w);
      if (of.of.complex) parted[(n_ + j) * columns + c] = of.of.imaginary(static_cast<int>(c), y + j * w);
    }
  gemm("N", "N", columns, rows, of.length, parted.data(), columns, phi, stride, 0, moved.data(), columns);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t c = 0; c < columns; ++c) q[i * w + of.of.coefficients[c]] = moved[i * columns + c];
}

// y += Phi^H f, likewise.
void ModalFactors::press(const Sheaf &of, std::size_t rows, const double *phi, std::size_t stride, const double *f,
                         double *y) const {
  const std::size_t w = layout_.width, columns = of.of.columns();
  if (of.of.whole) return gemm("N", "T", w, n_, rows, f, w, phi, stride, 1, y, w);
  std::vector<double> parted(of.length * columns), forces(rows * columns);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t c = 0; c < columns; ++c) forces[i * columns + c] = f[i * w + of.of.coefficients[c]];
  gemm("N", "T", columns, of.length, rows, forces.data(), columns, phi, stride, 0, parted.data(), columns);
  for (std::size_t j = 0; j < n_; ++j)
    for (int c = 0; c < of.of.columns(); ++c)
      y[j * w + of.of.coefficients[c]] += of.of.joined(
          c, parted[j * columns + c], of.of.complex ? parted[(n_ + j) * columns + of.of.partners[c]] : 0.0);
}

// One letter for each contact dof: all ranks know how many of these others have.
void ModalFactors::share_moving() {
  std::vector<char> moves(3 * layout_.points, false);
  for (const int dof : moving_) moves[3 * layout_.own_points.begin + dof] = true;
  std::vector<int> counts(layout_.size), starts(layout_.size);
  for (int r = 0; r < layout_.size; ++r) {
    const Range points = share_of(layout_.points, r, layout_.size);
    counts[r] = static_cast<int>(3 * points.size()), starts[r] = static_cast<int>(3 * points.begin);
  }
  MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, moves.data(), counts.data(), starts.data(), MPI_CHAR,
                 layout_.comm);
  all_moving_.clear();
  for (std::size_t dof = 0; dof < moves.size(); ++dof)
    if (moves[dof]) all_moving_.push_back(static_cast<PetscInt>(dof));
  rows_ = static_cast<PetscInt>(all_moving_.size()), shared_ = true;
}

void ModalFactors::count_moving(std::optional<double> told) {
  double count = told.value_or(static_cast<double>(moving_.size()));
  if (!told) MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_DOUBLE, MPI_SUM, layout_.comm);
  rows_ = static_cast<PetscInt>(count), shared_ = false;
}

void ModalFactors::gather_rows() {
  if (factored_ == all_moving_) return;
  factored_ = all_moving_;
  for (Sheaf &sheaf : sheaves_) {
    std::vector<double> own;
    for (const int dof : moving_) {
      const double *row = sheaf.basis.exact.row(layout_.own_modes.size() + dof);
      own.insert(own.end(), row, row + sheaf.length);
    }
    gather(layout_, std::move(own), sheaf.rows, MPI_DOUBLE);
  }
}

// D^-1. The damping of the other points' springs, which the structure does not have, leaves the diagonal.
void ModalFactors::weigh() {
  const int harmonics = layout_.width / 2;
  own_.resize(n_ * (harmonics + 1)), other_.resize(own_.size());
  for (const Sheaf &sheaf : sheaves_) {
    const StuckBasis &basis = sheaf.basis;
    std::vector<double> damped(n_);
    std::size_t next = 0;
    for (PetscInt dof = 0; dof < 3 * layout_.own_points.size(); ++dof) {
      if (next < moving_.size() && moving_[next] == dof) {
        ++next;
        continue;
      }
      const double *row = basis.exact.row(layout_.own_modes.size() + dof), spring = basis.springs[dof];
      for (std::size_t j = 0; j < sheaf.length; ++j) damped[j % n_] -= spring * row[j] * row[j];
    }
    MPI_Allreduce(MPI_IN_PLACE, damped.data(), static_cast<int>(n_), MPI_DOUBLE, MPI_SUM, layout_.comm);
    for (int k = 0; k <= harmonics; ++k) {
      if (&bases_.of(k) != &basis) continue;
      for (std::size_t j = 0, at = k; j < n_; ++j, at += harmonics + 1) {
        const double lambda = basis.lambda[j], a = structure_.in_phase(k, lambda, 1),
                     b = structure_.quadrature(k, std::max(0.0, lambda + damped[j]), 1) +
                         basis.damper(structure_, k, j),
                     square = std::max(a * a + b * b, 1e-20 * lambda * lambda); // no mode is undamped so exactly
        own_[at] = a / square, other_[at] = b / square;
      }
    }
  }
}

// With Phi_c = R + i I and D^-1 = o - i t it is [R o + I t, I o - R t] [R I]^T - i [R t - I o, I t + R o] [R I]^T.
void ModalFactors::flexibility(int k, double *in_phase, double *out_of_phase) {
  const Sheaf &of = *std::find_if(sheaves_.begin(), sheaves_.end(),
                                  [&](const Sheaf &sheaf) { return &sheaf.basis == &bases_.of(k); });
  const std::size_t rows = factored_.size(), stride = layout_.width / 2 + 1, length = of.length;
  const double *own = own_.data() + k, *other = other_.data() + k;
  const double sign = bases_.wave.index(k) < 0 ? -1 : 1;
  scaled_.resize(rows * length);
  for (const bool phase : {true, false}) {
    if (k == 0 && !phase) break;
    const double *same = phase ? own : other, *across = phase ? other : own;
    for (std::size_t i = 0; i < rows; ++i) {
      const double *R = &of.rows[i * length], *I = R + n_;
      double *to = &scaled_[i * length];
      for (std::size_t j = 0; j < n_; ++j) to[j] = same[j * stride] * R[j];
      if (!of.of.complex) continue;
      const double turn = phase ? sign : -sign;
      for (std::size_t j = 0; j < n_; ++j) {
        to[j] += turn * across[j * stride] * I[j];
        to[n_ + j] = same[j * stride] * I[j] - turn * across[j * stride] * R[j];
      }
    }
    gemm("T", "N", rows, rows, length, of.rows.data(), length, scaled_.data(), length, 0,
         phase ? in_phase : out_of_phase, rows);
  }
}

bool ModalFactors::factor(const JacobianParts &parts, bool precisely) {
  const Timed timed(Work::factors);
  structure_ = parts.structure;
  if (!shared_) share_moving();
  gather_rows();
  weigh();
  sign_ = decompose(parts, precisely);
  double corner = layout_.owns_omega() ? parts.border[layout_.own_coefficients()] : 0;
  to_modes({{parts.column, &b_}, {parts.border, &c_}}, corner);
  if (sign_ != 0) solve_in_modes(b_);
  schur_ = corner - std::inner_product(c_.begin(), c_.end(), b_.begin(), 0.0);
  if (!std::isfinite(schur_) || schur_ == 0) sign_ = 0;
  if (schur_ < 0) sign_ = -sign_;
  return sign_ != 0;
}

// Each y (n, 2H+1) = Phi^T of all ranks' coefficients; `last`, of which one rank has another value than 0, on all.
void ModalFactors::to_modes(const std::vector<std::pair<const double *, std::vector<double> *>> &forces,
                            double &last) const {
  const std::size_t size = n_ * layout_.width;
  std::vector<double> all(forces.size() * size + 1);
  all.back() = last;
  for (std::size_t i = 0; i < forces.size(); ++i)
    for (const Sheaf &sheaf : sheaves_)
      press(sheaf, layout_.own_dofs(), sheaf.basis.exact.row(0), sheaf.basis.exact.stride(), forces[i].first,
            &all[i * size]);
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, layout_.comm);
  for (std::size_t i = 0; i < forces.size(); ++i)
    forces[i].second->assign(all.begin() + i * size, all.begin() + (i + 1) * size);
  last = all.back();
}

void ModalFactors::solve_in_modes(std::vector<double> &y) {
  const int w = layout_.width;
  const std::size_t rows = factored_.size();
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
  motion_.resize(rows * w), force_.assign(rows * w, 0);
  for (const Sheaf &of : sheaves_) move(of, rows, of.rows.data(), of.length, y.data(), motion_.data());
  react();
  y.swap(y_);
  for (const Sheaf &of : sheaves_) press(of, rows, of.rows.data(), of.length, force_.data(), y.data());
  divide();
}

void ModalFactors::solve(const double *r, double *x) {
  const Timed timed(Work::factors);
  std::vector<double> y;
  double last = layout_.owns_omega() ? r[layout_.own_coefficients()] : 0;
  to_modes({{r, &y}}, last);
  solve_in_modes(y);
  last = (last - std::inner_product(c_.begin(), c_.end(), y.begin(), 0.0)) / schur_;
  for (std::size_t i = 0; i < y.size(); ++i) y[i] -= last * b_[i];
  for (const Sheaf &of : sheaves_)
    move(of, layout_.own_dofs(), of.basis.exact.row(0), of.basis.exact.stride(), y.data(), x);
  if (layout_.owns_omega()) x[layout_.own_coefficients()] = last;
}

} // namespace dovetail
