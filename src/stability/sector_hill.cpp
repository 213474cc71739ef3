#include "stability/sector_hill.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "support/hash.hpp"

namespace dovetail {
namespace {

using Complex = std::complex<double>;

constexpr double further = 0.15;  // than the strip is wide: exponents that must be found
constexpr double accuracy = 1e-6; // of those: what they may be off, over Omega
constexpr int first_look = 24, between_looks = 12, most_steps = 160;

double norm(const Complex *v, int n) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += std::norm(v[i]);
  return std::sqrt(sum);
}

} // namespace

void SectorHill::assemble(int shift, const ComplexWaves &waves, double omega, const std::vector<Complex> &blocks,
                          const std::vector<ContactPoint> &contact) {
  shift_ = shift, waves_ = &waves, omega_ = omega, blocks_ = &blocks, contact_ = &contact;
}

SectorHill::Entry SectorHill::entry(int wave, int r, int c) const {
  const int h = equations_.index(waves_->numbers[wave], shift_), modes = equations_.modes;
  const HermitianPencil &of = (*equations_.of_index)[std::abs(h)];
  Complex k = of.K(r, c), m = of.M(r, c);
  if (h < 0) k = std::conj(k), m = std::conj(m);
  Complex viscous = equations_.damping.stiffness * k + equations_.damping.mass * m;
  if (!equations_.C.empty() && r >= modes && c >= modes)
    viscous += equations_.C[(r - modes) * 3 * equations_.points + c - modes];
  return {k, m, viscous};
}

// The modes are coupled with one another by nothing: they are eliminated wave by wave.
bool SectorHill::factor() {
  const int modes = equations_.modes, rows = 3 * equations_.points, w = waves_->count();
  ComplexDense S(rows * w, rows * w);
  const Complex *next = blocks_->data();
  for (int p = 0; p < equations_.points; ++p)
    for (const BlockPlace place : block_places((*contact_)[p].law))
      for (int i = 0; i < w; ++i)
        for (int j = 0; j < w; ++j) S((3 * p + place.row) * w + i, (3 * p + place.column) * w + j) += *next++;
  pivots_.clear(), row_.clear(), column_.clear();
  for (int i = 0; i < w; ++i) {
    const Complex s = turn(i);
    const std::size_t first = row_.size();
    for (int a = 0; a < modes; ++a) {
      pivots_.push_back(1.0 / dynamic(s, entry(i, a, a)));
      if (!std::isfinite(std::abs(pivots_.back()))) return false;
      for (int c = 0; c < rows; ++c) {
        row_.push_back(dynamic(s, entry(i, a, modes + c)));
        column_.push_back(dynamic(s, entry(i, modes + c, a)));
      }
    }
    for (int c = 0; c < rows; ++c)
      for (int r = 0; r < rows; ++r) {
        Complex z = dynamic(s, entry(i, modes + r, modes + c));
        for (int a = 0; a < modes; ++a)
          z -= column_[first + a * rows + r] * pivots_[i * modes + a] * row_[first + a * rows + c];
        S(r * w + i, c * w + i) += z;
      }
  }
  return schur_.factor(std::move(S));
}

void SectorHill::solve(Complex *b) const {
  const int modes = equations_.modes, rows = 3 * equations_.points, w = waves_->count();
  Complex *contact = b + modes * w;
  for (int i = 0; i < w; ++i)
    for (int a = 0; a < modes; ++a) {
      const Complex z = pivots_[i * modes + a] * b[a * w + i];
      const Complex *column = &column_[(static_cast<std::size_t>(i) * modes + a) * rows];
      for (int r = 0; r < rows; ++r) contact[r * w + i] -= column[r] * z;
    }
  schur_.solve(contact);
  for (int i = 0; i < w; ++i)
    for (int a = 0; a < modes; ++a) {
      const Complex *row = &row_[(static_cast<std::size_t>(i) * modes + a) * rows];
      for (int c = 0; c < rows; ++c) b[a * w + i] -= row[c] * contact[c * w + i];
      b[a * w + i] *= pivots_[i * modes + a];
    }
}

// With lambda = (i part + shift + t) Omega and Q = the equations at t = 0, the problem linearised in (p, r = t p) has
// the eigenvalues 1 / t of (p, r) -> (-Q^-1 (Omega D p + Omega^2 M (2 shift p + r)), p), D = C + 2 i (k + part) Omega
// M.
void SectorHill::apply(const Complex *x, Complex *next) const {
  const int n = equations_.dofs(), w = waves_->count(), N = n * w;
  const double scale = omega_ * omega_;
  std::fill_n(next, N, Complex(0));
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      if (r != c && r < equations_.modes && c < equations_.modes) continue;
      const Complex *p = x + c * w, *q = x + N + c * w;
      for (int i = 0; i < w; ++i) {
        const Entry of = entry(i, r, c);
        const Complex twice = 2 * scale * Complex(shift_of_search, waves_->turns(i));
        next[r * w + i] -= (omega_ * of.c + twice * of.m) * p[i] + scale * of.m * q[i];
      }
    }
  solve(next);
  std::copy_n(x, N, next + N);
}

// The index whose waves move the most mass.
int SectorHill::diameter_of(const Complex *p) const {
  const int n = equations_.dofs(), w = waves_->count();
  std::vector<double> moved(equations_.sectors / 2 + 1);
  for (int i = 0; i < w; ++i)
    for (int r = 0; r < n; ++r)
      for (int c = 0; c < n; ++c)
        moved[std::abs(equations_.index(waves_->numbers[i], shift_))] +=
            (std::conj(p[r * w + i]) * entry(i, r, c).m * p[c * w + i]).real();
  return static_cast<int>(std::max_element(moved.begin(), moved.end()) - moved.begin());
}

SectorHill::Exponents SectorHill::near_zero(double strip) {
  const int N = equations_.dofs() * waves_->count(), most = std::min(2 * N, most_steps);
  Exponents out;
  if (!factor()) return out;
  ComplexDense basis(2 * N, most + 1), hessenberg(most + 1, most), vectors;
  std::vector<Complex> h(most + 1);
  const auto normalise = [&](Complex *v) {
    const double length = norm(v, 2 * N);
    for (int i = 0; length > 0 && i < 2 * N; ++i) v[i] /= length;
    return length;
  };
  for (int i = 0; i < 2 * N; ++i) { // noise, the same everywhere
    const auto noise = [](std::uint64_t name) { return static_cast<double>(mix(name)) / 18446744073709551616.0 - 0.5; };
    basis(i, 0) = Complex(noise(2 * i + 1), noise(2 * i + 2));
  }
  normalise(basis.column(0));
  for (int j = 0, look = first_look; j < most && !out.found; ++j) {
    Complex *next = basis.column(j + 1);
    apply(basis.column(j), next);
    for (int pass = 0; pass < 2; ++pass) {
      adjoint_times(basis, j + 1, next, h.data());
      subtract_columns(basis, j + 1, h.data(), next);
      for (int i = 0; i <= j; ++i) hessenberg(i, j) += h[i];
    }
    hessenberg(j + 1, j) = normalise(next);
    const int steps = j + 1;
    if (steps < look && steps < most) continue;
    look += between_looks;
    const std::vector<Complex> inverse = eigenvalues(hessenberg.block(0, 0, steps, steps), vectors);
    out.found = !inverse.empty();
    out.values.clear();
    int fastest = -1;
    double growth = 0;
    for (int i = 0; i < static_cast<int>(inverse.size()); ++i) {
      const Complex t = 1.0 / inverse[i], s = shift_of_search + t;
      const double error = std::abs(hessenberg(steps, j) * vectors(j, i)) * std::norm(t); // |dt| = |d(1/t)| |t|^2
      if (std::abs(s) < strip + further && error > accuracy) out.found = false;
      if (!(error <= accuracy && std::abs(s.imag()) <= strip + accuracy)) continue;
      if (fastest < 0 || s.real() > growth) fastest = i, growth = s.real();
      out.values.push_back(s);
    }
    if (!out.found || fastest < 0) continue;
    std::vector<Complex> p(N);
    for (int c = 0; c < steps; ++c)
      for (int i = 0; i < N; ++i) p[i] += basis(i, c) * vectors(c, fastest);
    out.diameter = diameter_of(p.data());
  }
  return out;
}

} // namespace dovetail
