#include "stability/complex_waves.hpp"

#include <cmath>

#include "contact/fourier.hpp"
#include "contact/law_traits.hpp"

namespace dovetail {
namespace {

using Complex = std::complex<double>;

Complex turned(Complex a, double theta) { return std::exp(Complex(0, 1) * a * theta); }

class Block {
public:
  Block(const ComplexWaves &waves, Complex *values) : waves_(waves), n_(waves.count()), values_(values) {}

  void add_spring(double k) {
    for (int i = 0; i < n_; ++i) values_[i * (n_ + 1)] += k;
  }

  // A product with a mask, whose mean times exp(i m theta) is cosine + i sine of m.
  void add_mask(const MaskMeans &mask, double factor) {
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < n_; ++j) {
        const int m = waves_.numbers[j] - waves_.numbers[i];
        const double sine = m < 0 ? -mask.sine[-m] : mask.sine[m];
        values_[i * n_ + j] += factor * Complex(mask.cosine[std::abs(m)], sine);
      }
  }

  // -v while it holds, where v = by x at the beginning.
  void add_hold(const ContactHistory::Hold &hold, double by) {
    for (int i = 0; by != 0 && i < n_; ++i) {
      const Complex a(waves_.turns(i), -waves_.growth);
      const Complex share = a == 0.0 ? (hold.end - hold.begin) / (2 * M_PI)
                                     : (turned(-a, hold.end) - turned(-a, hold.begin)) / (Complex(0, -2 * M_PI) * a);
      for (int j = 0; j < n_; ++j) {
        const Complex then = turned(Complex(waves_.turns(j), -waves_.growth), hold.begin);
        values_[i * n_ + j] -= share * by * then;
      }
    }
  }

  // A derivative by real coefficients [a0, a1, b1, ...]; that of k and -k together is that of one harmonic.
  void add_real(const double *block, int width) {
    const auto to_real = [](int k, int place) -> Complex { // derivative of a coefficient by wave k
      const int sign = k < 0 ? -1 : 1;
      if ((place + 1) / 2 != std::abs(k)) return 0;
      return place == 0 ? Complex(2) : place % 2 == 1 ? Complex(1) : Complex(0, sign);
    };
    const auto places = [](int k) {
      return k == 0 ? std::pair(0, 0) : std::pair(cosine(std::abs(k)), sine(std::abs(k)));
    };
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < n_; ++j) {
        const auto [r0, r1] = places(waves_.numbers[i]);
        const auto [c0, c1] = places(waves_.numbers[j]);
        for (int r = r0; r <= r1; ++r)
          for (int c = c0; c <= c1; ++c) // half the conjugate leads back
            values_[i * n_ + j] += (r == 0 ? 0.25 : 0.5) * std::conj(to_real(waves_.numbers[i], r)) *
                                   block[r * width + c] * to_real(waves_.numbers[j], c);
      }
  }

private:
  const ComplexWaves &waves_;
  int n_;
  Complex *values_;
};

} // namespace

ComplexWaves::ComplexWaves(double of, int harmonics, double grown) : part(of), growth(grown) {
  constexpr double beyond = 0.25 + 1e-9;
  for (int k = -harmonics - 1; k <= harmonics; ++k)
    if (std::abs(k + part) <= harmonics + beyond) numbers.push_back(k);
}

std::vector<Complex> answers(const ComplexWaves &waves, const ContactReading &reading,
                             const std::vector<ContactPoint> &contact) {
  const std::size_t size = static_cast<std::size_t>(waves.count()) * waves.count();
  std::size_t all = 0;
  for (const ContactPoint &point : contact) all += block_places(point.law).size();
  std::vector<Complex> blocks(all * size);
  Complex *next = blocks.data();
  for (std::size_t p = 0; p < contact.size(); ++p) {
    const ContactPoint &point = contact[p];
    const Linearisation &linear = reading.linear(static_cast<int>(p));
    const bool springs = linear.springs_only || !may_open(point.law);
    const double *dense = linear.dense.empty() || springs ? nullptr : linear.dense.data();
    for (const BlockPlace place : block_places(point.law)) {
      Block block(waves, next);
      next += size;
      const int d = place.row;
      const bool own = place.column == d;
      if (springs) {
        if (own) block.add_spring(d == 2 ? point.kn : point.kt[d]);
      } else if (shares_slider(point.law)) {
        const int width = coefficient_count(reading.harmonics());
        if (dense) block.add_real(dense, width), dense += width * width; // else open
      } else if (d == 2) {
        block.add_mask(linear.closed, point.kn);
      } else {
        block.add_mask(own ? linear.stick[d] : linear.slip[d], own ? point.kt[d] : point.mu[d] * point.kn);
        for (const ContactHistory::Hold &hold : reading.history().holds)
          if (hold.slider == static_cast<int>(2 * p) + d) block.add_hold(hold, own ? hold.by_t : hold.by_n);
      }
    }
  }
  return blocks;
}

} // namespace dovetail
