#pragma once
// Small dense matrices, column by column, and what LAPACK does with them.
#include <complex>
#include <vector>

namespace dovetail {

struct Dense {
  int rows = 0, columns = 0;
  std::vector<double> values;

  Dense() = default;
  Dense(int r, int c) { reset(r, c); }
  void reset(int r, int c) {
    rows = r, columns = c;
    values.assign(static_cast<std::size_t>(r) * c, 0.0);
  }
  double &operator()(int i, int j) { return values[static_cast<std::size_t>(j) * rows + i]; }
  double operator()(int i, int j) const { return values[static_cast<std::size_t>(j) * rows + i]; }
  double *column(int j) { return values.data() + static_cast<std::size_t>(j) * rows; }
  const double *column(int j) const { return values.data() + static_cast<std::size_t>(j) * rows; }
};

/// C = a A B + c C.
void multiply(double a, const Dense &A, const Dense &B, double c, Dense &C);

/// All eigenvalues of a square matrix, and its right eigenvectors as LAPACK's geev gives them; empty if it fails. A is
/// destroyed.
std::vector<std::complex<double>> eigenvalues(Dense &A, Dense *vectors = nullptr);

/// h = V^T u, u -= V h with the first `columns` columns of V.
void transposed_times(const Dense &V, int columns, const double *u, double *h);
void subtract_columns(const Dense &V, int columns, const double *h, double *u);

/// Eigenvectors of K v = k M v with v^T M v = 1 in the columns of K, the values returned in rising order; M is
/// destroyed. Empty if M is not positive definite.
std::vector<double> symmetric_modes(Dense &K, Dense &M);

/// LU with partial pivoting.
class Factors {
public:
  /// False if singular.
  bool factor(const Dense &A);
  void solve(double *b) const; ///< one right-hand side, in place
  int sign() const;            ///< of the determinant

private:
  Dense lu_;
  std::vector<int> pivots_;
};

/// exp(t A), by scaling and squaring. Holds scratch memory.
class Exponential {
public:
  /// Relative error below 1e-11 while the norm of t A stays below a few hundred.
  const Dense &of(const Dense &A, double t);

private:
  Dense power_[5], sum_, next_; // power_[1..4]
};

} // namespace dovetail
