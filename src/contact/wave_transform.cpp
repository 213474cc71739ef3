#include "contact/wave_transform.hpp"

#include <algorithm>
#include <new>

#include "contact/fourier.hpp"

namespace dovetail {

WaveTransform::WaveTransform(int harmonics, int samples)
    : harmonics_(harmonics), samples_(samples), waves_(fftw_alloc_complex(2 * (samples / 2 + 1))),
      values_(fftw_alloc_real(2 * samples)),
      plan_(fftw_plan_many_dft_c2r(1, &samples, 2, waves_.get(), nullptr, 1, samples / 2 + 1, values_.get(), nullptr, 1,
                                   samples, FFTW_ESTIMATE)) {
  if (!waves_ || !values_ || !plan_) throw std::bad_alloc();
}

void WaveTransform::sample(const double *coefficients, double *value, double *slope) {
  fftw_complex *f = waves_.get(), *df = f + samples_ / 2 + 1; // f = sum of f_k exp(i k theta) over k of either sign
  std::fill_n(&f[0][0], 2 * 2 * (samples_ / 2 + 1), 0.0);     // FFTW has written over them
  f[0][0] = coefficients[0] / 2;
  for (int k = 1; k <= harmonics_; ++k) {
    const double a = coefficients[cosine(k)] / 2, b = coefficients[sine(k)] / 2;
    f[k][0] = a, f[k][1] = -b;
    df[k][0] = k * b, df[k][1] = k * a;
  }
  fftw_execute(plan_.get());
  std::copy_n(values_.get(), samples_, value), std::copy_n(values_.get() + samples_, samples_, slope);
}

} // namespace dovetail
