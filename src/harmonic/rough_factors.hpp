#pragma once
// LU factors in single precision: PETSc knows the names of LAPACK's routines in its own precision only.
#include <vector>

namespace dovetail {

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
