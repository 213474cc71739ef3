#include "transient/motion.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <utility>

#include "contact/fourier.hpp"

namespace dovetail {
namespace {

std::vector<double> sizes(const Motion &motion, int modes) {
  std::vector<double> low(motion.at(0), motion.at(0) + motion.dofs), size = low;
  for (int j = 1; j < motion.instants; ++j)
    for (int i = 0; i < motion.dofs; ++i)
      low[i] = std::min(low[i], motion.at(j)[i]), size[i] = std::max(size[i], motion.at(j)[i]);
  for (int i = 0; i < motion.dofs; ++i) size[i] = (size[i] - low[i]) / 2;
  for (const auto &[first, last] : {std::pair{0, modes}, {modes, motion.dofs}}) {
    const double most = first < last ? *std::max_element(&size[first], &size[last - 1] + 1) : 0;
    for (int i = first; i < last; ++i) size[i] = std::max({size[i], 1e-4 * most, std::numeric_limits<double>::min()});
  }
  return size;
}

} // namespace

double difference(const Motion &now, const Motion &before, int modes) {
  const std::vector<double> size = sizes(now, modes);
  const int common = std::min(now.instants, before.instants);
  double most = 0;
  for (int j = 0; j < common; ++j) {
    const double *a = now.at(j * (now.instants / common)), *b = before.at(j * (before.instants / common));
    for (int i = 0; i < now.dofs; ++i) most = std::max(most, std::abs(a[i] - b[i]) / size[i]);
  }
  return most;
}

std::vector<double> amplitudes(const Motion &motion, double step) {
  const int N = motion.instants;
  std::vector<double> out(motion.dofs);
  for (int i = 0; i < motion.dofs; ++i) {
    double mean = 0;
    for (int j = 0; j < N; ++j) mean += motion.at(j)[i] / N;
    for (int j = 0; j < N; ++j) {
      const int next = (j + 1) % N;
      const double a = motion.at(j)[i] - mean, b = motion.at(next)[i] - mean, u = step * motion.rate_at(j)[i],
                   v = step * motion.rate_at(next)[i];
      out[i] = std::max(out[i], std::abs(a));
      if (u * v >= 0) continue;
      const double c2 = 3 * (b - a) - 2 * u - v, c3 = u + v - 2 * (b - a); // a + u t + c2 t^2 + c3 t^3
      const double root = std::sqrt(std::max(0.0, c2 * c2 - 3 * c3 * u)), t = -u / (c2 + (u > 0 ? -root : root));
      if (t > 0 && t < 1) out[i] = std::max(out[i], std::abs(a + t * (u + t * (c2 + t * c3))));
    }
  }
  return out;
}

int instants_for(int harmonics) {
  int instants = 1024;
  while (instants < 16 * harmonics) instants *= 2;
  return instants;
}

std::vector<double> coefficients_of(const Motion &motion, int harmonics) {
  const int N = motion.instants, waves = N / 2 + 1;
  const std::unique_ptr<fftw_complex[], void (*)(void *)> f(
      fftw_alloc_complex(static_cast<std::size_t>(motion.dofs) * waves), fftw_free);
  const fftw_plan plan =
      fftw_plan_many_dft_r2c(1, &N, motion.dofs, const_cast<double *>(motion.q.data()), nullptr, motion.dofs, 1,
                             f.get(), nullptr, 1, waves, FFTW_ESTIMATE | FFTW_PRESERVE_INPUT);
  if (!f || !plan) throw std::bad_alloc();
  fftw_execute(plan);
  fftw_destroy_plan(plan);
  const std::size_t width = coefficient_count(harmonics);
  std::vector<double> out(motion.dofs * width);
  for (int i = 0; i < motion.dofs; ++i)
    for (int k = 0; k <= harmonics; ++k) { // sum of q_j exp(-i k theta_j)
      const fftw_complex &wave = f[static_cast<std::size_t>(i) * waves + k];
      out[i * width + cosine(k)] = 2 * wave[0] / N;
      if (k > 0) out[i * width + sine(k)] = -2 * wave[1] / N;
    }
  return out;
}

} // namespace dovetail
