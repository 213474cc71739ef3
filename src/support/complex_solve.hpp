#pragma once
// General dense complex matrices: LU, eigenvalues, and what Arnoldi's iteration does with its basis.
#include "support/hermitian.hpp"

namespace dovetail {

/// LU with partial pivoting.
class ComplexFactors {
public:
  bool factor(ComplexDense A);              ///< false if singular
  void solve(ComplexDense::Value *b) const; ///< one right-hand side, in place

private:
  ComplexDense lu_;
  std::vector<int> pivots_;
};

/// All eigenvalues of a square matrix, and its right eigenvectors of length 1; empty if LAPACK fails.
std::vector<ComplexDense::Value> eigenvalues(ComplexDense A, ComplexDense &vectors);

/// h = V^H u, u -= V h with the first `columns` columns of V.
void adjoint_times(const ComplexDense &V, int columns, const ComplexDense::Value *u, ComplexDense::Value *h);
void subtract_columns(const ComplexDense &V, int columns, const ComplexDense::Value *h, ComplexDense::Value *u);

} // namespace dovetail
