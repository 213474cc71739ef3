#include "modal/rough_factors.hpp"

#include <cmath>

extern "C" {
void sgetrf_(int *, int *, float *, int *, int *, int *);
void sgetrs_(const char *, const int *, const int *, const float *, const int *, const int *, float *, const int *,
             int *);
}

namespace dovetail {

bool RoughFactors::factor(std::vector<float> matrix) {
  matrix_ = std::move(matrix);
  int n = static_cast<int>(std::lround(std::sqrt(static_cast<double>(matrix_.size())))), info = 0;
  pivots_.resize(n);
  if (n > 0) sgetrf_(&n, &n, matrix_.data(), &n, pivots_.data(), &info);
  sign_ = sign_of_factors(matrix_, pivots_);
  return sign_ != 0;
}

void RoughFactors::solve(float *x, bool transposed) const {
  const int n = size(), one = 1;
  int info;
  if (n > 0) sgetrs_(transposed ? "T" : "N", &n, &one, matrix_.data(), &n, pivots_.data(), x, &n, &info);
}

} // namespace dovetail
