#include "support/hermitian.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"
#include "support/int_count.hpp"

extern "C" {
using Z = std::complex<double>;
void zgemm_(const char *, const char *, const int *, const int *, const int *, const Z *, const Z *, const int *,
            const Z *, const int *, const Z *, Z *, const int *);
void zher2k_(const char *, const char *, const int *, const int *, const Z *, const Z *, const int *, const Z *,
             const int *, const double *, Z *, const int *);
void zgeqrf_(const int *, const int *, Z *, const int *, Z *, Z *, const int *, int *);
void zungqr_(const int *, const int *, const int *, Z *, const int *, const Z *, Z *, const int *, int *);
void zpotrf_(const char *, const int *, Z *, const int *, int *);
void zpotrs_(const char *, const int *, const int *, const Z *, const int *, Z *, const int *, int *);
void zhegvx_(const int *, const char *, const char *, const char *, const int *, Z *, const int *, Z *, const int *,
             const double *, const double *, const int *, const int *, const double *, int *, double *, Z *,
             const int *, Z *, const int *, double *, int *, int *, int *);
void zhegvd_(const int *, const char *, const char *, const int *, Z *, const int *, Z *, const int *, double *, Z *,
             const int *, double *, const int *, int *, const int *, int *);
}

namespace dovetail {
namespace {

constexpr double among_equals = 1e-6; // entries this near to the largest count as large: round-off does not choose

int leading(int rows) { return std::max(1, rows); }

ComplexDense times(const char *how, const ComplexDense &A, const ComplexDense &B) {
  const bool turned = *how == 'C';
  const int m = turned ? A.columns : A.rows, k = turned ? A.rows : A.columns, lda = leading(A.rows),
            ldb = leading(B.rows), ldc = leading(m);
  const Z one = 1, zero = 0;
  ComplexDense C(m, B.columns);
  if (m > 0 && B.columns > 0 && k > 0)
    zgemm_(how, "N", &m, &B.columns, &k, &one, A.values.data(), &lda, B.values.data(), &ldb, &zero, C.values.data(),
           &ldc);
  return C;
}

} // namespace

Z phase_of(const Z *begin, const Z *end) {
  double largest = 0;
  for (const Z *at = begin; at != end; ++at) largest = std::max(largest, std::abs(*at));
  if (largest == 0) return 1;
  const Z chosen = *std::find_if(begin, end, [&](Z value) { return std::abs(value) >= (1 - among_equals) * largest; });
  return std::conj(chosen) / std::abs(chosen);
}

bool is_rigid(double square, const Z *v, const std::vector<double> &diagonal) {
  constexpr double round_off = 1e-9;
  double stiff = 0;
  for (std::size_t i = 0; i < diagonal.size(); ++i) stiff += diagonal[i] * std::norm(v[i]);
  return square <= round_off * stiff;
}

ComplexDense ComplexDense::block(int i, int j, int m, int n) const {
  ComplexDense out(m, n);
  for (int at = 0; at < n; ++at) std::copy_n(column(j + at) + i, m, out.column(at));
  return out;
}

ComplexDense product(const ComplexDense &A, const ComplexDense &B) { return times("N", A, B); }
ComplexDense adjoint_product(const ComplexDense &A, const ComplexDense &B) { return times("C", A, B); }

ComplexDense mutual_product(const ComplexDense &A, const ComplexDense &B) {
  ComplexDense C(A.columns, A.columns);
  const int lead = leading(A.rows), n = leading(A.columns);
  const Z one = 1;
  const double zero = 0;
  if (A.rows > 0 && A.columns > 0)
    zher2k_("L", "C", &A.columns, &A.rows, &one, A.values.data(), &lead, B.values.data(), &lead, &zero, C.values.data(),
            &n);
  for (int j = 0; j < C.columns; ++j)
    for (int i = j + 1; i < C.rows; ++i) C(j, i) = std::conj(C(i, j));
  return C;
}

ComplexDense adjoint(const ComplexDense &A) {
  ComplexDense out(A.columns, A.rows);
  for (int j = 0; j < A.columns; ++j)
    for (int i = 0; i < A.rows; ++i) out(j, i) = std::conj(A(i, j));
  return out;
}

ComplexDense orthonormal(ComplexDense A) {
  int info;
  const int room = 64 * std::max(1, A.columns);
  std::vector<Z> tau(A.columns), work(room);
  zgeqrf_(&A.rows, &A.columns, A.values.data(), &A.rows, tau.data(), work.data(), &room, &info);
  zungqr_(&A.rows, &A.columns, &A.columns, A.values.data(), &A.rows, tau.data(), work.data(), &room, &info);
  return A;
}

ComplexDense solve_positive(ComplexDense A, ComplexDense B) {
  if (A.rows == 0) return B;
  int info = 0;
  zpotrf_("L", &A.rows, A.values.data(), &A.rows, &info);
  if (info != 0) return {};
  zpotrs_("L", &A.rows, &B.columns, A.values.data(), &A.rows, B.values.data(), &B.rows, &info);
  return B;
}

HermitianModes lowest_modes(ComplexDense K, ComplexDense M, int count) {
  HermitianModes modes;
  const int n = K.rows, kind = 1, first = n - count + 1;
  modes.shapes = ComplexDense(n, count);
  if (count == 0) return modes;
  const double unused = 0, tolerance = 0;
  int found = 0, room = -1, info = 0;
  std::vector<double> inverses(n), real_work(7 * n);
  std::vector<int> int_work(5 * n), failed(n);
  std::vector<Z> work(1);
  for (const bool ask : {true, false}) { // M v = K v / w^2: of these the largest are the accurate ones
    zhegvx_(&kind, "V", "I", "L", &n, M.values.data(), &n, K.values.data(), &n, &unused, &unused, &first, &n,
            &tolerance, &found, inverses.data(), modes.shapes.values.data(), &n, work.data(), &room, real_work.data(),
            int_work.data(), failed.data(), &info);
    if (ask) room = static_cast<int>(work[0].real()), work.resize(room);
  }
  if (info > n) modes.fault = HermitianModes::Fault::stiffness;
  if (modes.fault != HermitianModes::Fault::none) return modes;
  if (info != 0 || found != count) throw ComputeError("LAPACK's zhegvx failed (" + std::to_string(info) + ")");
  for (int j = 0; j < count / 2; ++j)
    std::swap_ranges(modes.shapes.column(j), modes.shapes.column(j) + n, modes.shapes.column(count - 1 - j));
  for (int j = 0; j < count; ++j) {
    const double inverse = inverses[count - 1 - j];
    if (!(inverse > 0)) {
      modes.fault = HermitianModes::Fault::mass;
      return modes;
    }
    modes.squares.push_back(1 / inverse);
    std::for_each(modes.shapes.column(j), modes.shapes.column(j) + n, [&](Z &value) { value /= std::sqrt(inverse); });
  }
  return modes;
}

HermitianModes all_modes(ComplexDense K, ComplexDense M) {
  HermitianModes modes;
  const std::size_t order = K.rows;
  int_count(1 + 5 * order + 2 * order * order, "room of zhegvd for all modes of so large a sector");
  const int n = K.rows, kind = 1;
  int room = -1, real_room = -1, int_room = -1, info = 0;
  std::vector<Z> work(1);
  std::vector<double> real_work(1);
  std::vector<int> int_work(1);
  modes.squares.resize(n);
  for (const bool ask : {true, false}) {
    zhegvd_(&kind, "V", "L", &n, K.values.data(), &n, M.values.data(), &n, modes.squares.data(), work.data(), &room,
            real_work.data(), &real_room, int_work.data(), &int_room, &info);
    if (!ask) break;
    room = static_cast<int>(work[0].real()), real_room = static_cast<int>(real_work[0]), int_room = int_work[0];
    work.resize(room), real_work.resize(real_room), int_work.resize(int_room);
  }
  if (info > n) modes.fault = HermitianModes::Fault::mass;
  if (info < 0 || (info > 0 && info <= n)) throw ComputeError("LAPACK's zhegvd failed (" + std::to_string(info) + ")");
  modes.shapes = std::move(K);
  return modes;
}

} // namespace dovetail
