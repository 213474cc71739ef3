#include "problems/watched_row.hpp"

#include <cstdlib>
#include <utility>

#include "contact/fourier.hpp"

namespace dovetail {

WatchedRow::WatchedRow(std::vector<std::vector<std::complex<double>>> by_index, const TravellingWave &wave)
    : by_index_(std::move(by_index)), wave_(wave) {
  for (const std::complex<double> value : by_index_[0]) of_mean_.push_back(value.real());
}

std::complex<double> WatchedRow::factor(PetscInt number, int harmonic) const {
  const int h = wave_.index(harmonic);
  const std::complex<double> value = by_index_[std::abs(h)][number];
  return h < 0 ? std::conj(value) : value;
}

// Amplitudes c - i s: f (c - i s) has the cosine Re f c + Im f s and the sine Re f s - Im f c.
void WatchedRow::add(PetscInt number, const double *c, int width, double *sum) const {
  if (by_index_.empty()) {
    for (int i = 0; i < width; ++i) sum[i] += of_mean_[number] * c[i];
    return;
  }
  sum[0] += of_mean_[number] * c[0];
  for (int k = 1; k <= width / 2; ++k) {
    const std::complex<double> f = factor(number, k);
    sum[cosine(k)] += f.real() * c[cosine(k)] + f.imag() * c[sine(k)];
    sum[sine(k)] += f.real() * c[sine(k)] - f.imag() * c[cosine(k)];
  }
}

void WatchedRow::add_transposed(PetscInt number, const double *sum, int width, double *c) const {
  if (by_index_.empty()) {
    for (int i = 0; i < width; ++i) c[i] += of_mean_[number] * sum[i];
    return;
  }
  c[0] += of_mean_[number] * sum[0];
  for (int k = 1; k <= width / 2; ++k) {
    const std::complex<double> f = factor(number, k);
    c[cosine(k)] += f.real() * sum[cosine(k)] - f.imag() * sum[sine(k)];
    c[sine(k)] += f.imag() * sum[cosine(k)] + f.real() * sum[sine(k)];
  }
}

void WatchedRow::scale(PetscInt number, double by) {
  of_mean_[number] *= by;
  for (auto &factors : by_index_) factors[number] *= by;
}

} // namespace dovetail
