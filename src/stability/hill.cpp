#include "stability/hill.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/hash.hpp"

namespace dovetail {
namespace {

constexpr double shift = 1e-3;    // where exponents are sought around, over Omega: J may be singular at 0
constexpr double further = 0.15;  // than the strip is wide: exponents that must be found
constexpr double accuracy = 1e-6; // of those: what they may be off, over Omega
constexpr int first_look = 16, between_looks = 8, most_steps = 120;

} // namespace

void Hill::assemble(Waves waves, int harmonics, double omega, const std::vector<double> &blocks) {
  const int n = model_.dofs(), w = wave_coefficients(waves, harmonics);
  waves_ = waves, omega_ = omega, width_ = w;
  J_.reset(n * w, n * w);
  for (int c = 0; c < n; ++c)
    for (int r = 0; r < n; ++r) {
      const double k = model_.K[static_cast<std::size_t>(r) * n + c], m = model_.M[static_cast<std::size_t>(r) * n + c];
      if (k == 0 && m == 0) continue;
      for (int i = 0; i < w; ++i) {
        const double turn = wave_number(waves, i) * omega, cross = turn * model_.damping * k;
        J_(r * w + i, c * w + i) = k - turn * turn * m;
        if (is_sine(waves, i)) J_(r * w + i, c * w + i - 1) = -cross, J_(r * w + i - 1, c * w + i) = cross;
      }
    }
  const double *next = blocks.data();
  for (int p = 0; p < model_.points; ++p)
    for (const BlockPlace place : block_places(model_.contact[p].law)) {
      const int row = (model_.modes + 3 * p + place.row) * w, column = (model_.modes + 3 * p + place.column) * w;
      for (int i = 0; i < w; ++i)
        for (int j = 0; j < w; ++j) J_(row + i, column + j) += *next++;
    }
}

void Hill::mass_times(const double *p, double *out) const {
  const int n = model_.dofs(), w = width_;
  std::fill_n(out, n * w, 0.0);
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      const double m = model_.M[static_cast<std::size_t>(r) * n + c];
      for (int i = 0; m != 0 && i < w; ++i) out[r * w + i] += m * p[c * w + i];
    }
}

void Hill::rate_times(const double *p, double *out) const {
  const int n = model_.dofs(), w = width_;
  std::fill_n(out, n * w, 0.0);
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      const std::size_t at = static_cast<std::size_t>(r) * n + c;
      const double damping = model_.damping * model_.K[at], mass = 2 * omega_ * model_.M[at];
      const double *from = p + c * w;
      double *to = out + r * w;
      for (int i = 0; damping != 0 && i < w; ++i) to[i] += damping * from[i];
      for (int i = 0; mass != 0 && i < w; ++i)
        if (is_sine(waves_, i)) {
          const double turn = mass * wave_number(waves_, i);
          to[i - 1] += turn * from[i], to[i] -= turn * from[i - 1];
        }
    }
}

// Q = J + a D + b M
Dense Hill::shifted(double a, double b) const {
  const int n = model_.dofs(), w = width_;
  Dense Q = J_;
  for (int c = 0; c < n; ++c)
    for (int r = 0; r < n; ++r) {
      const std::size_t at = static_cast<std::size_t>(r) * n + c;
      const double k = model_.K[at], m = model_.M[at];
      for (int i = 0; (k != 0 || m != 0) && i < w; ++i) {
        const double turn = 2 * omega_ * m * wave_number(waves_, i);
        Q(r * w + i, c * w + i) += a * model_.damping * k + b * m;
        if (is_sine(waves_, i)) Q(r * w + i - 1, c * w + i) += a * turn, Q(r * w + i, c * w + i - 1) -= a * turn;
      }
    }
  return Q;
}

// Arnoldi's iteration. With lambda = (shift + t) Omega and Q = J + lambda D + lambda^2 M at t = 0, the problem
// linearised in (p, r = t p) has the eigenvalues 1 / t of (p, r) -> (-Q^-1 (Omega D p + Omega^2 M (2 shift p + r)), p).
Hill::Exponents Hill::near_zero(double strip) {
  const int N = size(), most = std::min(2 * N, most_steps);
  const double scale = omega_ * omega_;
  Exponents out;
  if (!factors_.factor(shifted(shift * omega_, shift * shift * scale))) return out;
  std::vector<double> inertia(N), product(N), h(most + 1);
  basis_.reset(2 * N, most + 1), hessenberg_.reset(most + 1, most);
  const auto normalise = [&](double *v) {
    const double length = std::sqrt(std::inner_product(v, v + 2 * N, v, 0.0));
    for (int i = 0; length > 0 && i < 2 * N; ++i) v[i] /= length;
    return length;
  };
  double *start = basis_.column(0); // noise, the same everywhere
  for (int i = 0; i < 2 * N; ++i) start[i] = 0.5 + static_cast<double>(mix(i + 1)) / 18446744073709551616.0;
  normalise(start);
  for (int j = 0, look = first_look; j < most && !out.found; ++j) {
    const double *p = basis_.column(j), *r = p + N;
    double *next = basis_.column(j + 1);
    for (int i = 0; i < N; ++i) inertia[i] = 2 * shift * p[i] + r[i];
    rate_times(p, next), mass_times(inertia.data(), product.data());
    for (int i = 0; i < N; ++i) next[i] = -omega_ * next[i] - scale * product[i], next[N + i] = p[i];
    factors_.solve(next);
    for (int pass = 0; pass < 2; ++pass) {
      transposed_times(basis_, j + 1, next, h.data());
      subtract_columns(basis_, j + 1, h.data(), next);
      for (int i = 0; i <= j; ++i) hessenberg_(i, j) += h[i];
    }
    hessenberg_(j + 1, j) = normalise(next);
    if (j + 1 < look && j + 1 < most) continue;
    look += between_looks;
    look_at_ritz_values(j + 1, strip, out);
  }
  return out;
}

void Hill::look_at_ritz_values(int steps, double strip, Exponents &out) {
  Dense square(steps, steps), vectors;
  for (int c = 0; c < steps; ++c) std::copy_n(hessenberg_.column(c), std::min(steps, c + 2), square.column(c));
  const std::vector<std::complex<double>> inverse = eigenvalues(square, &vectors);
  out.steps = steps, out.found = !inverse.empty();
  out.values.clear();
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    // The residual is the last entry of the eigenvector times what the next basis vector was before its normalisation.
    const int other = inverse[i].imag() == 0 ? -1 : inverse[i].imag() > 0 ? 1 : -1;
    const double last = inverse[i].imag() == 0 ? std::abs(vectors(steps - 1, i))
                                               : std::hypot(vectors(steps - 1, i), vectors(steps - 1, i + other));
    const std::complex<double> t = 1.0 / inverse[i], s = shift + t;
    const double error = hessenberg_(steps, steps - 1) * last * std::norm(t); // |dt| = |d(1/t)| |t|^2
    if (std::abs(s) < strip + further && error > accuracy) out.found = false;
    if (error <= accuracy && std::abs(s.imag()) <= strip + accuracy) out.values.push_back(s);
  }
}

} // namespace dovetail
