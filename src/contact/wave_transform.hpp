#pragma once
// Many harmonics sampled all round the period at once, by fast Fourier transforms (FFTW).
#include <memory>
#include <type_traits>

#include <fftw3.h>

namespace dovetail {

class WaveTransform {
public:
  /// samples > 2 harmonics
  WaveTransform(int harmonics, int samples);

  /// f and f' at the instants 2 pi j / samples, (samples) each, from coefficients [a0, a1, b1, ...].
  void sample(const double *coefficients, double *value, double *slope);

private:
  struct Free {
    void operator()(void *at) const { fftw_free(at); }
    void operator()(fftw_plan plan) const { fftw_destroy_plan(plan); }
  };
  int harmonics_, samples_;
  std::unique_ptr<fftw_complex[], Free> waves_; // (2, samples / 2 + 1)
  std::unique_ptr<double[], Free> values_;      // (2, samples)
  std::unique_ptr<std::remove_pointer_t<fftw_plan>, Free> plan_;
};

} // namespace dovetail
