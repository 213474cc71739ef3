#include "support/complex_solve.hpp"

#include <utility>

extern "C" {
using Z = std::complex<double>;
void zgetrf_(const int *, const int *, Z *, const int *, int *, int *);
void zgetrs_(const char *, const int *, const int *, const Z *, const int *, const int *, Z *, const int *, int *);
void zgeev_(const char *, const char *, const int *, Z *, const int *, Z *, Z *, const int *, Z *, const int *, Z *,
            const int *, double *, int *);
void zgemv_(const char *, const int *, const int *, const Z *, const Z *, const int *, const Z *, const int *,
            const Z *, Z *, const int *);
}

namespace dovetail {

bool ComplexFactors::factor(ComplexDense A) {
  lu_ = std::move(A);
  const int n = lu_.rows;
  int info = 0;
  pivots_.resize(n);
  if (n > 0) zgetrf_(&n, &n, lu_.values.data(), &n, pivots_.data(), &info);
  return info == 0;
}

void ComplexFactors::solve(Z *b) const {
  const int n = lu_.rows, one = 1;
  int info = 0;
  if (n > 0) zgetrs_("N", &n, &one, lu_.values.data(), &n, pivots_.data(), b, &n, &info);
}

std::vector<Z> eigenvalues(ComplexDense A, ComplexDense &vectors) {
  const int n = A.rows, one = 1;
  int room = -1, info = 0;
  std::vector<Z> values(n), work(1);
  std::vector<double> real_work(2 * n);
  vectors = ComplexDense(n, n);
  if (n == 0) return {};
  for (const bool ask : {true, false}) {
    zgeev_("N", "V", &n, A.values.data(), &n, values.data(), nullptr, &one, vectors.values.data(), &n, work.data(),
           &room, real_work.data(), &info);
    if (ask) room = static_cast<int>(work[0].real()), work.resize(room);
  }
  if (info != 0) return {};
  return values;
}

void adjoint_times(const ComplexDense &V, int columns, const Z *u, Z *h) {
  const int one = 1;
  const Z a = 1, b = 0;
  zgemv_("C", &V.rows, &columns, &a, V.values.data(), &V.rows, u, &one, &b, h, &one);
}

void subtract_columns(const ComplexDense &V, int columns, const Z *h, Z *u) {
  const int one = 1;
  const Z a = -1, b = 1;
  zgemv_("N", &V.rows, &columns, &a, V.values.data(), &V.rows, h, &one, &b, u, &one);
}

} // namespace dovetail
