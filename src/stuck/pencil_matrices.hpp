#pragma once
// K_s + shift M and M of the reduced structure as PETSc's matrices, K_s = K with springs on its contact dofs: made of
// the rows as they are, without a copy, and solved with by Cholesky factors that all ranks share.
#include <optional>

#include "stuck/layout.hpp"
#include "stuck/pencil_rows.hpp"
#include "support/block_cyclic.hpp"
#include "support/error.hpp"
#include "support/handle.hpp"

namespace dovetail {

/// Rows by the numbers of the dofs (Layout::number).
BlockCyclic grid_of(const Layout &layout);
/// Columns (n, columns) by number, on all ranks, of what the ranks have of them by own dofs, `stride` apart.
/// Collective.
std::vector<double> by_number(const Layout &layout, const double *own, std::size_t stride, std::size_t columns);

class PencilMatrices {
public:
  /// `springs`: (own contact dofs). Collective, like all that follows.
  PencilMatrices(const PencilRows &rows, const std::vector<double> &springs, double shift, const Layout &layout);
  PencilMatrices(const PencilMatrices &) = delete; // PETSc knows where it is

  Mat stiffness() const { return stiffness_; } ///< K_s + shift M
  Mat mass() const { return mass_; }
  /// Factors of it become what `ksp` solves by. False: it is not positive definite.
  bool set_inverse(KSP ksp);
  /// Own row `d` of it, by number, good until another is asked for.
  const double *row(std::size_t d);
  const BlockCyclic &grid() const { return grid_; }
  void rethrow() { courier_.rethrow(); } ///< what was thrown within PETSc

  template <class Work> PetscErrorCode run(Work &&work) { return courier_.run(work); } ///< for PETSc
  void multiply_block(Mat A, Mat X, Mat Y);                                            ///< likewise
  void solve_block(Mat R, Mat X);

private:
  void multiply_stiffness(Vec x, Vec y);
  void multiply_mass(Vec x, Vec y);
  void solve(Vec r, Vec x);
  void take_own(double *own, std::size_t stride, int columns) const;
  void multiply(bool stiff, const double *x, std::size_t from, double *y, std::size_t to, int columns);

  PencilRows rows_;
  std::vector<double> springs_;
  double shift_;
  Layout layout_;
  const BlockCyclic grid_;
  std::optional<SpreadCholesky> factors_;
  std::vector<double> all_, line_; // (n, columns) by number; (n)
  UniqueMat stiffness_, mass_;
  Courier courier_;
};

} // namespace dovetail
