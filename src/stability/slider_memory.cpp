#include "stability/slider_memory.hpp"

#include <cmath>
#include <complex>

#include "support/dense.hpp"

namespace dovetail {

// Over the stick, s from 0 to 1, v = sum of c_j phi_j, phi_j = sqrt(2j+1) P_j(2s-1), with every phi_i tested:
//   integral of phi_i (dv/ds + L lambda / Omega v) ds + phi_i(0) (v(0) - v_0) = 0,
// L its length [rad]. That is discontinuous Galerkin: exact for lambda = 0, and it dies out for all Re lambda > 0.
SliderMemory::SliderMemory(const std::vector<ContactHistory::Hold> &holds, Waves waves, int harmonics, int first)
    : width_(wave_coefficients(waves, harmonics)) {
  for (const ContactHistory::Hold &hold : holds) {
    if (hold.by_t == 0) continue;
    const int point = first + hold.slider / 2 * 3 * width_;
    const double length = hold.end - hold.begin, middle = (hold.begin + hold.end) / 2;
    Stick stick{point + hold.slider % 2 * width_, point + 2 * width_, hold.by_n / hold.by_t, {}, {}, {}, {}};
    for (int i = 0; i < width_; ++i) {
      const double a = wave_number(waves, i), angle = a * hold.begin;
      stick.value.push_back(a == 0 ? 0.5 : is_sine(waves, i) ? std::sin(angle) : std::cos(angle));
    }
    Dense A(terms, terms);
    std::complex<double> turned(hold.by_t * length / M_PI); // by i^j
    for (int j = 0; j < terms; ++j, turned *= std::complex<double>(0, 1)) {
      const double norm = std::sqrt(2 * j + 1);
      for (int i = 0; i < width_; ++i) {
        const double a = wave_number(waves, i);
        const std::complex<double> z = turned * norm * std::sph_bessel(j, a * length / 2) * std::polar(1.0, a * middle);
        stick.share.push_back(is_sine(waves, i) ? z.imag() : z.real());
      }
      for (int i = 0; i < terms; ++i) A(i, j) = norm * std::sqrt(2 * i + 1) * (i < j || (i + j) % 2 == 0 ? 1 : -1);
      A(j, j) += exponent_shift * length;
      stick.beginning.push_back(j % 2 == 0 ? norm : -norm);
    }
    Factors factors;
    factors.factor(A);
    factors.solve(stick.beginning.data());
    stick.decay.resize(terms * terms);
    for (int j = 0; j < terms; ++j) {
      stick.decay[j * (terms + 1)] = length;
      factors.solve(&stick.decay[j * terms]);
    }
    sticks_.push_back(std::move(stick));
  }
}

// out = decay (c t)
void SliderMemory::remember(const Stick &stick, const double *ct, double *out) const {
  std::fill_n(out, terms, 0.0);
  for (int j = 0; j < terms; ++j)
    for (int i = 0; i < terms; ++i) out[i] += stick.decay[j * terms + i] * ct[j];
}

void SliderMemory::push(const double *ct, double *force) const {
  double remembered[terms];
  for (const Stick &stick : sticks_) {
    remember(stick, ct, remembered);
    for (int j = 0; j < terms; ++j)
      for (int i = 0; i < width_; ++i) force[stick.t + i] -= stick.share[j * width_ + i] * remembered[j];
    ct += terms;
  }
}

void SliderMemory::follow(const double *ct, const double *p, double *c) const {
  for (const Stick &stick : sticks_) {
    double set = 0;
    for (int i = 0; i < width_; ++i) set += stick.value[i] * (p[stick.t + i] + stick.by_n * p[stick.n + i]);
    remember(stick, ct, c);
    for (int j = 0; j < terms; ++j) c[j] = stick.beginning[j] * set - c[j];
    ct += terms, c += terms;
  }
}

} // namespace dovetail
