#include "stability/growth.hpp"

#include <algorithm>
#include <cmath>

namespace dovetail {
namespace {

using Kind = Stability::Kind;
using Verdict = Stability::Verdict;
using Complex = std::complex<double>;

constexpr double neutral = 1e-9;       // growth that is round-off
constexpr double no_nearer = -0.3;     // Hill's method has found every exponent that grows faster
constexpr double sampled_error = 0.15; // of multipliers from a sampled derivative, without sliders as states

bool smaller(Complex a, Complex b) { return std::abs(a) < std::abs(b); }

Stability of(const Growth &growth, Verdict verdict) {
  return {verdict, verdict != Verdict::stable && growth.positive() ? growth.kind : Kind::none,
          std::exp(2 * M_PI * growth.value), growth.value};
}

} // namespace

bool Growth::positive() const { return value > neutral; }
bool Growth::negative() const { return value < -neutral; }

Growth largest_of(const std::vector<Complex> &multipliers) {
  const auto most = std::max_element(multipliers.begin(), multipliers.end(), smaller);
  if (most == multipliers.end()) return {};
  const Kind kind = most->imag() != 0 ? Kind::second_frequency : most->real() > 0 ? Kind::jump : Kind::period_doubling;
  return {std::log(std::max(std::abs(*most), 1e-300)) / (2 * M_PI), kind};
}

Growth largest_of(std::vector<Complex> exponents, Waves waves, int indifferent) {
  std::sort(exponents.begin(), exponents.end(), smaller);
  Growth out{no_nearer};
  for (std::size_t i = indifferent; i < exponents.size(); ++i) {
    const Complex s = exponents[i];
    if (!(s.real() > out.value)) continue;
    const bool at_half = std::abs(std::abs(s.imag()) - 0.5) < 1e-5; // whole waves may be asked so far
    const bool opposite = (waves == Waves::half) != at_half, real = s.imag() == 0 || at_half;
    out = {s.real(), !real ? Kind::second_frequency : opposite ? Kind::period_doubling : Kind::jump};
  }
  return out;
}

Growth larger(const Growth &a, const Growth &b) {
  if (!a.known() || !b.known()) return {};
  return a.value > b.value ? a : b;
}

Stability conclude(const Growth &by_monodromy, const Growth &by_hill, bool trust_monodromy) {
  if (!by_monodromy.known() && !by_hill.known()) return {};
  const bool first = by_monodromy.known() && (trust_monodromy || !by_hill.known());
  const Growth &trusted = first ? by_monodromy : by_hill, &other = first ? by_hill : by_monodromy;
  const bool alone = !by_hill.known() && trust_monodromy;
  Verdict verdict = Verdict::uncertain;
  if (trusted.negative() && (alone || other.negative())) verdict = Verdict::stable;
  if (trusted.positive() && (alone || other.positive())) verdict = Verdict::unstable;
  Stability out = of(trusted, verdict);
  if (verdict == Verdict::uncertain && other.positive() && !trusted.positive()) out.kind = other.kind;
  return out;
}

Stability conclude_sampled(const Growth &by_hill) {
  if (!by_hill.known()) return {};
  const double multiplier = std::exp(2 * M_PI * by_hill.value);
  return of(by_hill, multiplier < 1 - sampled_error   ? Verdict::stable
                     : multiplier > 1 + sampled_error ? Verdict::unstable
                                                      : Verdict::uncertain);
}

Stability conclude_alone(const Growth &by_hill, double accuracy) {
  if (!by_hill.known()) return {};
  return of(by_hill, by_hill.value < -accuracy  ? Verdict::stable
                     : by_hill.value > accuracy ? Verdict::unstable
                                                : Verdict::uncertain);
}

} // namespace dovetail
