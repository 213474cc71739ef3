#include "contact/fourier.hpp"

#include <algorithm>
#include <cmath>

namespace dovetail {
namespace {

struct Turn {
  double cosine, sine;
};

// cos and sin of k theta_j, from angles below one turn.
Turn turn(int k, int j, int samples) {
  const double angle = 2 * M_PI * static_cast<int>(static_cast<long>(k) * j % samples) / samples;
  return {std::cos(angle), std::sin(angle)};
}

} // namespace

Fourier::Fourier(int harmonics, int samples)
    : harmonics_(harmonics), samples_(samples), rows_(static_cast<std::size_t>(samples) * size()) {
  const int n = size();
  for (int j = 0; j < samples_; ++j) {
    double *row = &rows_[static_cast<std::size_t>(j) * n];
    row[0] = 0.5;
    for (int k = 1; k <= harmonics_; ++k) {
      const Turn at = turn(k, j, samples_);
      row[cosine(k)] = at.cosine;
      row[sine(k)] = at.sine;
    }
  }
}

MaskTable::MaskTable(int harmonics, int samples)
    : size_(coefficient_count(harmonics)), means_((static_cast<std::size_t>(samples) + 1) * 2 * size_) {
  for (int j = 0; j <= samples; ++j) {
    double *mean = &means_[static_cast<std::size_t>(j) * 2 * size_];
    mean[0] = static_cast<double>(j) / samples;
    for (int m = 1; m < size_; ++m) { // geometric series of q = exp(i m 2 pi / N), which is not 1 because m <= 2H < N
      const Turn at = turn(m, j, samples), q = turn(m, 1, samples);
      const double re = at.cosine - 1, im = at.sine, dre = q.cosine - 1, dim = q.sine;
      const double scale = 1 / (samples * (dre * dre + dim * dim));
      mean[m] = (re * dre + im * dim) * scale;
      mean[size_ + m] = (im * dre - re * dim) * scale;
    }
  }
}

void Fourier::synthesise(const double *coefficients, double *values) const {
  const int n = size();
  for (int j = 0; j < samples_; ++j) {
    const double *e = row(j);
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += e[i] * coefficients[i];
    values[j] = sum;
  }
}

void Fourier::analyse(const double *values, double *coefficients) const {
  const int n = size();
  std::fill_n(coefficients, n, 0.0);
  for (int j = 0; j < samples_; ++j) {
    const double *e = row(j);
    for (int i = 0; i < n; ++i) coefficients[i] += values[j] * e[i];
  }
  for (int i = 0; i < n; ++i) coefficients[i] *= 2.0 / samples_;
  coefficients[0] *= 2; // the synthesis row holds 1/2 for a0, the analysis 1
}

// At the instants mirrored about the half period sines change sign; about the quarter, cosines of odd and sines of even
// harmonics do. So four sums - cosines and sines, of even and of odd harmonics - serve four instants, or two if N is
// odd.
namespace {

constexpr int most_folded = 17; // samples analysed at a time

template <int Rows, class V>
inline void synthesise_rows(int harmonics, int samples, int folded, const double *turns, int width,
                            Part<const V> packed, Part<V> values) {
  for (int j = 0; j < folded; ++j, turns += width) {
    V cosines[2][Rows]{}, sines[2][Rows]{};
    for (int k = 0; k <= harmonics; k += 2)
      for (int parity = 0; parity < 2; ++parity) {
        const double c = turns[2 * (k + parity)], s = turns[2 * (k + parity) + 1];
        const Part<const V> x = packed + (k + parity) * 2 * Rows;
        for (int r = 0; r < Rows; ++r) {
          cosines[parity][r] += c * x[2 * r];
          sines[parity][r] += s * x[2 * r + 1];
        }
      }
    const int mirrored = (samples - j) % samples, half = samples / 2;
    for (int r = 0; r < Rows; ++r) {
      const Part<V> q = values + r * samples;
      const V even = cosines[0][r] + cosines[1][r], odd = sines[0][r] + sines[1][r];
      q[j] = even + odd;
      q[mirrored] = even - odd;
      if (samples % 2) continue;
      const V even_turned = cosines[0][r] - cosines[1][r], odd_turned = sines[0][r] - sines[1][r];
      q[half - j] = even_turned - odd_turned;
      q[half + j] = even_turned + odd_turned;
    }
  }
}

// Sums over the mirrored instants of folded samples [begin, end), for even harmonics and for odd ones.
template <int Rows, class V>
inline void fold_rows(int samples, int begin, int end, Part<const V> values, Part<V> even_sums, Part<V> odd_sums) {
  const int half = samples / 2;
  for (int j = begin; j < end; ++j) {
    const bool on_axis = j == 0 || 4 * j == samples; // its own mirror image, met twice
    const double weight = on_axis ? 0.5 : 1.0;
    const int mirrored = j ? samples - j : 0;
    for (int r = 0; r < Rows; ++r, even_sums = even_sums + 2, odd_sums = odd_sums + 2) {
      const Part<const V> q = values + r * samples;
      const V first = q[j], last = q[mirrored], even = weight * (first + last), odd = weight * (first - last);
      if (samples % 2) {
        even_sums[0] = odd_sums[0] = even, even_sums[1] = odd_sums[1] = odd;
        continue;
      }
      const V past = q[half + j], before = q[half - j];
      const V even_turned = weight * (past + before), odd_turned = weight * (past - before);
      even_sums[0] = even + even_turned, even_sums[1] = odd + odd_turned;
      odd_sums[0] = even - even_turned, odd_sums[1] = odd - odd_turned;
    }
  }
}

// Harmonics k and k + 2, of one parity, at a time, over a few samples that stay in the nearest cache.
template <int Rows, class V>
inline void analyse_rows(int harmonics, int samples, int folded, const double *turns, int width, Part<const V> values,
                         Part<V> sums, Part<V> packed) {
  const int parts = (folded + most_folded - 1) / most_folded, part = (folded + parts - 1) / parts;
  for (int i = 0; i < width * Rows; ++i) packed[i] = V{};
  for (int begin = 0; begin < folded; begin += part) {
    const int end = std::min(begin + part, folded);
    fold_rows<Rows, V>(samples, begin, end, values, sums, sums + 2 * Rows * most_folded);
    for (int k = 0; k <= harmonics; k += k % 2 ? 3 : 1) {
      Part<V> sum = sums + (k % 2) * 2 * Rows * most_folded;
      const double *t = turns + begin * width + 2 * k;
      const Part<V> near = packed + k * 2 * Rows, far = near + 4 * Rows;
      V near_sum[2 * Rows]{}, far_sum[2 * Rows]{};
      for (int j = begin; j < end; ++j, t += width, sum = sum + 2 * Rows)
        for (int r = 0; r < Rows; ++r) {
          near_sum[2 * r] += t[0] * sum[2 * r], near_sum[2 * r + 1] += t[1] * sum[2 * r + 1];
          far_sum[2 * r] += t[4] * sum[2 * r], far_sum[2 * r + 1] += t[5] * sum[2 * r + 1];
        }
      for (int r = 0; r < 2 * Rows; ++r) near[r] += near_sum[r], far[r] += far_sum[r];
    }
  }
}

template <int Width>
inline void synthesise_wide_parts(int rows, int harmonics, int samples, int folded, const double *turns, int width,
                                  const Lanes *packed, Lanes *values) {
  using V = typename Vector<Width>::Real;
  for (int part = 0; part < lane_count / Width; ++part) {
    const Part<const V> from(packed, part);
    const Part<V> to(values, part);
    if (rows == 1)
      synthesise_rows<1, V>(harmonics, samples, folded, turns, width, from, to);
    else
      synthesise_rows<3, V>(harmonics, samples, folded, turns, width, from, to);
  }
}

template <int Width>
inline void analyse_wide_parts(int rows, int harmonics, int samples, int folded, const double *turns, int width,
                               const Lanes *values, Lanes *sums, Lanes *packed) {
  using V = typename Vector<Width>::Real;
  for (int part = 0; part < lane_count / Width; ++part) {
    const Part<const V> from(values, part);
    const Part<V> room(sums, part), to(packed, part);
    if (rows == 1)
      analyse_rows<1, V>(harmonics, samples, folded, turns, width, from, room, to);
    else
      analyse_rows<3, V>(harmonics, samples, folded, turns, width, from, room, to);
  }
}

DOVETAIL_WIDE_PARTS(synthesise_wide,
                    (int rows, int harmonics, int samples, int folded, const double *turns, int width,
                     const Lanes *packed, Lanes *values),
                    (rows, harmonics, samples, folded, turns, width, packed, values))
DOVETAIL_WIDE_PARTS(analyse_wide,
                    (int rows, int harmonics, int samples, int folded, const double *turns, int width,
                     const Lanes *values, Lanes *sums, Lanes *packed),
                    (rows, harmonics, samples, folded, turns, width, values, sums, packed))

} // namespace

WideFourier::WideFourier(int harmonics, int samples)
    : harmonics_(harmonics), samples_(samples), folded_(samples % 2 ? (samples + 1) / 2 : samples / 4 + 1),
      width_(2 * (harmonics / 4 + 1) * 4), turns_(static_cast<std::size_t>(folded_) * width_), packed_(3 * width_),
      sums_(2 * most_folded * 6) {
  for (int j = 0; j < folded_; ++j)
    for (int k = 0; k <= harmonics_; ++k) {
      const Turn at = turn(k, j, samples_);
      turns_[static_cast<std::size_t>(j) * width_ + 2 * k] = at.cosine;
      turns_[static_cast<std::size_t>(j) * width_ + 2 * k + 1] = at.sine;
    }
}

void WideFourier::synthesise(int rows, const Lanes *coefficients, Lanes *values) {
  const int n = coefficient_count(harmonics_);
  std::fill(packed_.begin(), packed_.end(), Lanes{});
  for (int r = 0; r < rows; ++r, coefficients += n) {
    packed_[2 * r] = 0.5 * coefficients[0];
    for (int k = 1; k <= harmonics_; ++k) {
      packed_[(k * rows + r) * 2] = coefficients[cosine(k)];
      packed_[(k * rows + r) * 2 + 1] = coefficients[sine(k)];
    }
  }
  synthesise_wide(rows, harmonics_, samples_, folded_, turns_.data(), width_, packed_.data(), values);
}

void WideFourier::analyse(int rows, const Lanes *values, Lanes *coefficients) {
  analyse_wide(rows, harmonics_, samples_, folded_, turns_.data(), width_, values, sums_.data(), packed_.data());
  const double scale = 2.0 / samples_;
  for (int r = 0; r < rows; ++r, coefficients += coefficient_count(harmonics_)) {
    coefficients[0] = scale * packed_[2 * r];
    for (int k = 1; k <= harmonics_; ++k) {
      coefficients[cosine(k)] = scale * packed_[(k * rows + r) * 2];
      coefficients[sine(k)] = scale * packed_[(k * rows + r) * 2 + 1];
    }
  }
}

} // namespace dovetail
