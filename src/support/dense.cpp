#include "support/dense.hpp"

#include <petscsys.h> // first

#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

static_assert(sizeof(PetscBLASInt) == sizeof(int), "BLAS with integers of 64 bits");

void multiply(double a, const Dense &A, const Dense &B, double c, Dense &C) {
  const PetscBLASInt m = A.rows, n = B.columns, k = A.columns, least = 1, ldb = std::max(least, k),
                     lda = std::max(least, m);
  BLASgemm_("N", "N", &m, &n, &k, &a, A.values.data(), &lda, B.values.data(), &ldb, &c, C.values.data(), &lda);
}

std::vector<std::complex<double>> eigenvalues(Dense &A, Dense *vectors) {
  const PetscBLASInt n = A.rows, one = 1, rows = vectors ? n : 1;
  std::vector<double> real(n), imaginary(n), work(1);
  PetscBLASInt lwork = -1, info = 0;
  if (n == 0) return {};
  if (vectors) vectors->reset(n, n);
  const auto run = [&] {
    LAPACKgeev_("N", vectors ? "V" : "N", &n, A.values.data(), &n, real.data(), imaginary.data(), nullptr, &one,
                vectors ? vectors->values.data() : nullptr, &rows, work.data(), &lwork, &info);
  };
  run();
  lwork = static_cast<PetscBLASInt>(work[0]);
  work.resize(lwork);
  run();
  if (info != 0) return {};
  std::vector<std::complex<double>> values(n);
  for (int i = 0; i < n; ++i) values[i] = {real[i], imaginary[i]};
  return values;
}

void transposed_times(const Dense &V, int columns, const double *u, double *h) {
  const PetscBLASInt m = V.rows, n = columns, one = 1;
  const double a = 1, b = 0;
  BLASgemv_("T", &m, &n, &a, V.values.data(), &m, u, &one, &b, h, &one);
}

void subtract_columns(const Dense &V, int columns, const double *h, double *u) {
  const PetscBLASInt m = V.rows, n = columns, one = 1;
  const double a = -1, b = 1;
  BLASgemv_("N", &m, &n, &a, V.values.data(), &m, h, &one, &b, u, &one);
}

std::vector<double> symmetric_modes(Dense &K, Dense &M) {
  const PetscBLASInt n = K.rows, kind = 1;
  std::vector<double> values(n), work(1);
  PetscBLASInt lwork = -1, info = 0;
  const auto run = [&] {
    LAPACKsygv_(&kind, "V", "U", &n, K.values.data(), &n, M.values.data(), &n, values.data(), work.data(), &lwork,
                &info);
  };
  if (n == 0) return {};
  run();
  lwork = static_cast<PetscBLASInt>(work[0]);
  work.resize(lwork);
  run();
  if (info != 0) return {};
  return values;
}

bool Factors::factor(const Dense &A) {
  lu_ = A;
  const PetscBLASInt n = A.rows;
  PetscBLASInt info = 0;
  pivots_.resize(n);
  LAPACKgetrf_(&n, &n, lu_.values.data(), &n, pivots_.data(), &info);
  return info == 0;
}

void Factors::solve(double *b) const {
  const PetscBLASInt n = lu_.rows, one = 1;
  PetscBLASInt info = 0;
  LAPACKgetrs_("N", &n, &one, lu_.values.data(), &n, pivots_.data(), b, &n, &info);
}

int Factors::sign() const {
  int sign = 1;
  for (int i = 0; i < lu_.rows; ++i)
    if ((pivots_[i] != i + 1) != (lu_(i, i) < 0)) sign = -sign;
  return sign;
}

// Taylor's series to t^16 in powers of A^4 (Paterson & Stockmeyer): six products, and one for each halving of t.
const Dense &Exponential::of(const Dense &A, double t) {
  constexpr double largest = 1.5; // norm for which the series is good to 1e-12
  const int n = A.rows;
  double norm = 0;
  for (int j = 0; j < n; ++j) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += std::abs(A(i, j));
    norm = std::max(norm, sum);
  }
  norm *= std::abs(t);
  const int halvings = norm > largest ? static_cast<int>(std::ceil(std::log2(norm / largest))) : 0;
  const double step = std::ldexp(t, -halvings);
  for (Dense *D : {&power_[1], &power_[2], &power_[3], &power_[4], &sum_, &next_})
    if (D->rows != n) D->reset(n, n);
  const std::size_t size = A.values.size();
  for (std::size_t i = 0; i < size; ++i) power_[1].values[i] = step * A.values[i];
  for (int p = 2; p <= 4; ++p) multiply(1, power_[1], power_[p - 1], 0, power_[p]);
  double inverse[17] = {1}; // 1 / q!
  for (int q = 1; q <= 16; ++q) inverse[q] = inverse[q - 1] / q;
  const double *p1 = power_[1].values.data(), *p2 = power_[2].values.data(), *p3 = power_[3].values.data(),
               *p4 = power_[4].values.data();
  const auto add_terms = [&](int q) { // sum += terms t^q to t^(q + 3) over t^q
    double *sum = sum_.values.data();
    for (std::size_t i = 0; i < size; ++i)
      sum[i] += inverse[q + 1] * p1[i] + inverse[q + 2] * p2[i] + inverse[q + 3] * p3[i];
    for (int i = 0; i < n; ++i) sum_(i, i) += inverse[q];
  };
  for (std::size_t i = 0; i < size; ++i) sum_.values[i] = inverse[16] * p4[i];
  add_terms(12);
  for (int q = 8; q >= 0; q -= 4) {
    multiply(1, sum_, power_[4], 0, next_);
    std::swap(sum_, next_);
    add_terms(q);
  }
  for (int i = 0; i < halvings; ++i) {
    multiply(1, sum_, sum_, 0, next_);
    std::swap(sum_, next_);
  }
  return sum_;
}

} // namespace dovetail
