#pragma once
// Dense complex matrices, column by column, and what LAPACK does with them. PETSc is built for real numbers alone.
#include <complex>
#include <vector>

namespace dovetail {

struct ComplexDense {
  using Value = std::complex<double>;
  int rows = 0, columns = 0;
  std::vector<Value> values;

  ComplexDense() = default;
  ComplexDense(int r, int c) : rows(r), columns(c), values(static_cast<std::size_t>(r) * c) {}
  Value &operator()(int i, int j) { return values[static_cast<std::size_t>(j) * rows + i]; }
  Value operator()(int i, int j) const { return values[static_cast<std::size_t>(j) * rows + i]; }
  Value *column(int j) { return values.data() + static_cast<std::size_t>(j) * rows; }
  const Value *column(int j) const { return values.data() + static_cast<std::size_t>(j) * rows; }
  /// Rows [i, i + m) of columns [j, j + n).
  ComplexDense block(int i, int j, int m, int n) const;
};

/// The factor of absolute value 1 that makes the first large entry of those real and positive; 1 if all are zero.
ComplexDense::Value phase_of(const ComplexDense::Value *begin, const ComplexDense::Value *end);

ComplexDense product(const ComplexDense &A, const ComplexDense &B);         ///< A B
ComplexDense adjoint_product(const ComplexDense &A, const ComplexDense &B); ///< A^H B
ComplexDense adjoint(const ComplexDense &A);                                ///< A^H
/// A^H B + B^H A, Hermitian to the last bit, in half the time of two products.
ComplexDense mutual_product(const ComplexDense &A, const ComplexDense &B);

/// Orthonormal columns that span those of A, and more where these span less: its Q.
ComplexDense orthonormal(ComplexDense A);

/// X of A X = B for Hermitian positive definite A; empty (no rows) if A is not.
ComplexDense solve_positive(ComplexDense A, ComplexDense B);

struct HermitianModes {
  enum class Fault { none, stiffness, mass } fault = Fault::none; ///< which matrix is not positive definite
  std::vector<double> squares;                                    ///< ascending
  ComplexDense shapes;                                            ///< v^H M v = 1, phases as LAPACK has them
};

/// Whether w^2 is no more than round-off of the strain energy that the entries of its mode v would meet one by one, by
/// the diagonal of K.
bool is_rigid(double square, const ComplexDense::Value *v, const std::vector<double> &diagonal);

/// The `count` lowest modes of K v = w^2 M v, both Hermitian, K positive definite, to full accuracy relative to each
/// w^2. ComputeError if LAPACK does not find them.
HermitianModes lowest_modes(ComplexDense K, ComplexDense M, int count);
/// All of them, with an error relative to the largest; M alone has to be positive definite.
HermitianModes all_modes(ComplexDense K, ComplexDense M);

} // namespace dovetail
