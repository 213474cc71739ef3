#include "contact/fourier.hpp"

#include <algorithm>
#include <cmath>

namespace dovetail {

Fourier::Fourier(int harmonics, int samples)
    : harmonics_(harmonics), samples_(samples), rows_(static_cast<std::size_t>(samples) * size()), turn_(2 * samples) {
  for (int r = 0; r < samples_; ++r) {
    const double angle = 2 * M_PI * r / samples_;
    turn_[2 * r] = std::cos(angle);
    turn_[2 * r + 1] = std::sin(angle);
  }
  for (int j = 0; j < samples_; ++j) {
    double *row = &rows_[static_cast<std::size_t>(j) * size()];
    row[0] = 0.5;
    for (int k = 1; k <= harmonics_; ++k) {
      const int r = static_cast<int>(static_cast<long>(k) * j % samples_);
      row[cosine(k)] = turn_[2 * r];
      row[sine(k)] = turn_[2 * r + 1];
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

void Fourier::add_sums(int a, int b, double weight, double *sums) const {
  sums[0] += weight * (b - a);
  const int last = 2 * harmonics_;
  const auto turn = [&](int m, int j) { return &turn_[2 * (static_cast<long>(m) * j % samples_)]; };
  for (int m = 1; m <= last; ++m) { // geometric series; exp(i m 2 pi / N) != 1 because m <= 2H < N
    const double *qa = turn(m, a), *qb = turn(m, b), *q = turn(m, 1);
    const double re = qb[0] - qa[0], im = qb[1] - qa[1], dre = q[0] - 1, dim = q[1];
    const double scale = weight / (dre * dre + dim * dim);
    sums[2 * m] += (re * dre + im * dim) * scale;
    sums[2 * m + 1] += (im * dre - re * dim) * scale;
  }
}

void Fourier::indicator(const double *sums, double *coefficients) const {
  const double scale = 2.0 / samples_;
  coefficients[0] = scale * sums[0];
  for (int k = 1; k <= harmonics_; ++k) {
    coefficients[cosine(k)] = scale * sums[2 * k];
    coefficients[sine(k)] = scale * sums[2 * k + 1];
  }
}

void Fourier::add_gram(const double *sums, double weight, double *block, int stride) const {
  const double scale = weight / samples_; // 2/N of the analysis times 1/2 of the product formulas
  const auto c = [&](int m) { return scale * sums[2 * std::abs(m)]; };
  const auto s = [&](int m) { return m < 0 ? -scale * sums[-2 * m + 1] : scale * sums[2 * m + 1]; };
  block[0] += c(0);
  for (int k = 1; k <= harmonics_; ++k) {
    block[cosine(k)] += 2 * c(k);
    block[sine(k)] += 2 * s(k);
    block[cosine(k) * stride] += c(k);
    block[sine(k) * stride] += s(k);
  }
  for (int k = 1; k <= harmonics_; ++k) {
    double *row_c = block + cosine(k) * stride, *row_s = block + sine(k) * stride;
    for (int l = 1; l <= harmonics_; ++l) {
      row_c[cosine(l)] += c(k - l) + c(k + l);
      row_c[sine(l)] += s(k + l) - s(k - l);
      row_s[cosine(l)] += s(k + l) + s(k - l);
      row_s[sine(l)] += c(k - l) - c(k + l);
    }
  }
}

} // namespace dovetail
