#pragma once
// LU factors in single precision: PETSc knows the names of LAPACK's routines in its own precision only.
#include <cmath>
#include <vector>

namespace dovetail {

/// Sign of the determinant, from LAPACK's LU factors (n, n) and exchanges: 0 where it is zero, or no number.
template <class Real, class Whole>
int sign_of_factors(const std::vector<Real> &factors, const std::vector<Whole> &pivots) {
  const std::size_t n = pivots.size();
  int sign = 1;
  for (std::size_t i = 0; i < n; ++i) {
    const Real pivot = factors[i * (n + 1)];
    if (!std::isfinite(pivot) || pivot == 0) return 0;
    if ((pivot < 0) != (pivots[i] != static_cast<Whole>(i + 1))) sign = -sign;
  }
  return sign;
}

class RoughFactors {
public:
  /// Of a square matrix by columns, in whose place they are. False: singular, or no number.
  bool factor(std::vector<float> matrix);
  /// x = inverse times x.
  void solve(float *x, bool transposed = false) const;
  int size() const { return static_cast<int>(pivots_.size()); }
  int sign() const { return sign_; } ///< of the determinant; 0: there are none

private:
  std::vector<float> matrix_;
  std::vector<int> pivots_;
  int sign_ = 0;
};

} // namespace dovetail
