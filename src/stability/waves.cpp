#include "stability/waves.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "contact/law_traits.hpp"

namespace dovetail {
namespace {

// Coefficients of functions of theta, and their values, as far as one block needs them.
class Block {
public:
  Block(Waves waves, int harmonics, double *values)
      : waves_(waves), size_(wave_coefficients(waves, harmonics)), values_(values) {
    std::fill_n(values, size_ * size_, 0.0);
  }

  void add_spring(double k) {
    for (int i = 0; i < size_; ++i) values_[i * (size_ + 1)] += k;
  }

  // factor * analysis of mask * synthesis: products of two waves are waves of their sum and difference, whole ones.
  void add_gram(const MaskMeans &mask, double factor) {
    for (int i = 0; i < size_; ++i)
      for (int j = 0; j < size_; ++j) {
        const double a = wave_number(waves_, i), b = wave_number(waves_, j);
        const int together = static_cast<int>(a + b), apart = static_cast<int>(b - a), m = std::abs(apart);
        const double c0 = mask.cosine[m], s0 = apart < 0 ? -mask.sine[m] : mask.sine[m]; // sin of b - a
        const double c1 = mask.cosine[together], s1 = mask.sine[together];
        const bool row_sine = is_sine(waves_, i), column_sine = is_sine(waves_, j);
        const double mean = row_sine ? (column_sine ? c0 - c1 : s1 - s0) : (column_sine ? s1 + s0 : c0 + c1);
        values_[i * size_ + j] += factor * (b == 0 ? 0.5 : 1) * mean;
      }
  }

  // -v while it holds, where v = by x at the beginning
  void add_hold(const std::vector<double> &share, const std::vector<double> &value, double by) {
    for (int i = 0; by != 0 && i < size_; ++i)
      for (int j = 0; j < size_; ++j) values_[i * size_ + j] -= share[i] * by * value[j];
  }

private:
  Waves waves_;
  int size_;
  double *values_;
};

// Coefficients of the function that is exp(-lag (theta - begin)) while a slider is held and 0 elsewhere, and what a
// change of coefficients is at the beginning.
void describe(const ContactHistory::Hold &hold, Waves waves, double lag, std::vector<double> &share,
              std::vector<double> &value) {
  const double length = hold.end - hold.begin;
  for (std::size_t i = 0; i < share.size(); ++i) {
    const double a = wave_number(waves, i);
    const std::complex<double> turn(-lag, a), at = std::polar(1.0, a * hold.begin);
    const std::complex<double> z = turn == 0.0 ? length : at * (std::exp(turn * length) - 1.0) / turn;
    share[i] = (is_sine(waves, i) ? z.imag() : z.real()) / M_PI;
    value[i] = a == 0 ? 0.5 : is_sine(waves, i) ? at.imag() : at.real();
  }
}

} // namespace

void write_waves(Waves waves, int harmonics, const ContactPoint &point, const Linearisation &linear,
                 const ContactHistory &history, int number, double lag, double *blocks) {
  const int n = wave_coefficients(waves, harmonics), size = n * n;
  const bool springs = linear.springs_only || !may_open(point.law), friction = has_friction(point.law);
  if (shares_slider(point.law)) { // always stuck, or always open
    for (const BlockPlace place : block_places(point.law)) {
      Block block(waves, harmonics, blocks);
      if (springs && place.row == place.column) block.add_spring(place.row == 2 ? point.kn : point.kt[place.row]);
      blocks += size;
    }
    return;
  }
  std::vector<double> share(n), value(n);
  Block normal(waves, harmonics, blocks + (friction ? 4 * size : 0));
  if (springs)
    normal.add_spring(point.kn);
  else
    normal.add_gram(linear.closed, point.kn);
  for (int d = 0; friction && d < 2; ++d) {
    Block by_t(waves, harmonics, blocks + 2 * d * size), by_n(waves, harmonics, blocks + (2 * d + 1) * size);
    if (springs) {
      by_t.add_spring(point.kt[d]);
      continue;
    }
    by_t.add_gram(linear.stick[d], point.kt[d]);
    by_n.add_gram(linear.slip[d], point.mu[d] * point.kn);
    for (const ContactHistory::Hold &hold : history.holds) {
      if (hold.slider != 2 * number + d) continue;
      describe(hold, waves, lag, share, value);
      by_t.add_hold(share, value, hold.by_t), by_n.add_hold(share, value, hold.by_n);
    }
  }
}

} // namespace dovetail
