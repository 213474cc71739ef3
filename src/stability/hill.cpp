#include "stability/hill.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/hash.hpp"

namespace dovetail {
namespace {

constexpr double shift = exponent_shift;
constexpr double further = 0.15;  // than the strip is wide: exponents that must be found
constexpr double accuracy = 1e-6; // of those: what they may be off, over Omega
using Complex = std::complex<double>;

constexpr int first_look = 16, between_looks = 8, most_steps = 120;

// Waves are counted by their sines, the mean by itself.
constexpr int first_wave(Waves waves) { return waves == Waves::whole ? 0 : 1; }

// to += z from for one wave: z = a + i b takes (cos, sin) to (a cos + b sin, a sin - b cos).
void add_wave(Complex z, const double *from, int i, double *to) {
  to[i] += z.real() * from[i];
  if (i == 0) return;
  to[i] -= z.imag() * from[i - 1];
  to[i - 1] += z.real() * from[i - 1] + z.imag() * from[i];
}

} // namespace

void Hill::assemble(Waves waves, int harmonics, double omega, std::vector<double> blocks,
                    const std::vector<ContactHistory::Hold> &holds) {
  waves_ = waves, omega_ = omega, width_ = wave_coefficients(waves, harmonics);
  blocks_ = std::move(blocks);
  memory_ = SliderMemory(holds, waves, harmonics, model_.modes * width_);
}

template <class Take> void Hill::for_each_block(Take take) const {
  const double *next = blocks_.data();
  for (int p = 0; p < model_.points; ++p)
    for (const BlockPlace place : block_places(model_.contact[p].law)) {
      take((3 * p + place.row) * width_, (3 * p + place.column) * width_, next);
      next += static_cast<std::size_t>(width_) * width_;
    }
}

void Hill::stiffness_times(const double *p, double *out) const {
  const int n = model_.dofs(), w = width_, contact = model_.modes * w;
  std::fill_n(out, n * w, 0.0);
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c)
      for (int i = first_wave(waves_); i < w; i += 2) add_wave(dynamic(0, i, r, c), p + c * w, i, out + r * w);
  for_each_block([&](int row, int column, const double *block) {
    for (int i = 0; i < w; ++i)
      for (int j = 0; j < w; ++j) out[contact + row + i] += block[i * w + j] * p[contact + column + j];
  });
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
      const double damping = model_.viscous(at), mass = 2 * omega_ * model_.M[at];
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

// J + lambda D + lambda^2 M of the structure alone, rows r and columns c, for the wave whose sine is coefficient i:
// a number, since all of its parts turn cosine and sine like complex numbers; real for the mean, i = 0.
Complex Hill::dynamic(double lambda, int i, int r, int c) const {
  const std::size_t at = static_cast<std::size_t>(r) * model_.dofs() + c;
  const double k = model_.K[at], m = model_.M[at], viscous = model_.viscous(at), turn = wave_number(waves_, i) * omega_;
  return {k - turn * turn * m + lambda * (viscous + lambda * m), turn * (viscous + 2 * lambda * m)};
}

// Modes that are coupled with one another by nothing are eliminated wave by wave, and the contact dofs are left.
bool Hill::factor(double lambda) {
  const int modes = eliminated(), rows = model_.dofs() - modes, w = width_, contact = (model_.modes - modes) * w;
  Dense S(rows * w, rows * w);
  for_each_block([&](int row, int column, const double *block) {
    for (int i = 0; i < w; ++i)
      for (int j = 0; j < w; ++j) S(contact + row + i, contact + column + j) += block[i * w + j];
  });
  inverse_.clear(), coupling_.clear();
  for (int i = first_wave(waves_); i < w; i += 2) {
    const std::size_t done = inverse_.size();
    for (int a = 0; a < modes; ++a) {
      inverse_.push_back(1.0 / dynamic(lambda, i, a, a));
      if (!std::isfinite(std::abs(inverse_.back()))) return false;
      for (int c = 0; c < rows; ++c) coupling_.push_back(dynamic(lambda, i, a, modes + c));
    }
    for (int c = 0; c < rows; ++c)
      for (int r = 0; r < rows; ++r) {
        Complex z = dynamic(lambda, i, modes + r, modes + c);
        for (int a = 0; a < modes; ++a) {
          const Complex *of_mode = &coupling_[(done + a) * rows];
          z -= of_mode[r] * inverse_[done + a] * of_mode[c];
        }
        S(r * w + i, c * w + i) += z.real();
        if (i == 0) continue;
        S(r * w + i - 1, c * w + i - 1) += z.real();
        S(r * w + i - 1, c * w + i) += z.imag(), S(r * w + i, c * w + i - 1) -= z.imag();
      }
  }
  return schur_.factor(S);
}

void Hill::solve(double *b) const {
  const int modes = eliminated(), rows = model_.dofs() - modes, w = width_;
  double *contact = b + modes * w;
  const Complex *inverse = inverse_.data(), *coupling = coupling_.data();
  for (int i = first_wave(waves_); i < w; i += 2)
    for (int a = 0; a < modes; ++a, ++inverse)
      for (int c = 0; c < rows; ++c) add_wave(-*coupling++ * *inverse, b + a * w, i, contact + c * w);
  schur_.solve(contact);
  inverse = inverse_.data(), coupling = coupling_.data();
  std::vector<double> solved(modes * w);
  for (int i = first_wave(waves_); i < w; i += 2)
    for (int a = 0; a < modes; ++a, ++inverse) {
      for (int c = 0; c < rows; ++c) add_wave(-*coupling++, contact + c * w, i, b + a * w);
      add_wave(*inverse, b + a * w, i, &solved[a * w]);
    }
  std::copy(solved.begin(), solved.end(), b);
}

// Arnoldi's iteration. With lambda = (shift + t) Omega and Q = J + lambda D + lambda^2 M at t = 0, the problem
// linearised in (p, r = t p) has the eigenvalues 1 / t of (p, r) -> (-Q^-1 (Omega D p + Omega^2 M (2 shift p + r)), p).
// What sliders remember comes after that.
Hill::Exponents Hill::near_zero(double strip) {
  const int N = size(), all = 2 * N + memory_.size(), most = std::min(all, most_steps);
  const double scale = omega_ * omega_;
  Exponents out;
  if (!factor(shift * omega_)) return out;
  std::vector<double> inertia(N), product(N), h(most + 1);
  basis_.reset(all, most + 1), hessenberg_.reset(most + 1, most);
  const auto normalise = [&](double *v) {
    const double length = std::sqrt(std::inner_product(v, v + all, v, 0.0));
    for (int i = 0; length > 0 && i < all; ++i) v[i] /= length;
    return length;
  };
  double *start = basis_.column(0); // noise, the same everywhere
  for (int i = 0; i < 2 * N; ++i) start[i] = 0.5 + static_cast<double>(mix(i + 1)) / 18446744073709551616.0;
  normalise(start);
  for (int j = 0, look = first_look; j < most && !out.found; ++j) {
    const double *p = basis_.column(j), *r = p + N, *c = r + N;
    double *next = basis_.column(j + 1);
    for (int i = 0; i < N; ++i) inertia[i] = 2 * shift * p[i] + r[i];
    rate_times(p, next), mass_times(inertia.data(), product.data());
    for (int i = 0; i < N; ++i) next[i] = -omega_ * next[i] - scale * product[i], next[N + i] = p[i];
    memory_.push(c, next);
    solve(next);
    memory_.follow(c, next, next + 2 * N);
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
  const std::vector<Complex> inverse = eigenvalues(square, &vectors);
  out.steps = steps, out.found = !inverse.empty();
  out.values.clear();
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    // The residual is the last entry of the eigenvector times what the next basis vector was before its normalisation.
    const int other = inverse[i].imag() == 0 ? -1 : inverse[i].imag() > 0 ? 1 : -1;
    const double last = inverse[i].imag() == 0 ? std::abs(vectors(steps - 1, i))
                                               : std::hypot(vectors(steps - 1, i), vectors(steps - 1, i + other));
    const Complex t = 1.0 / inverse[i], s = shift + t;
    const double error = hessenberg_(steps, steps - 1) * last * std::norm(t); // |dt| = |d(1/t)| |t|^2
    if (std::abs(s) < strip + further && error > accuracy) out.found = false;
    if (error <= accuracy && std::abs(s.imag()) <= strip + accuracy) out.values.push_back(s);
  }
}

} // namespace dovetail
