#pragma once
// One contact point over one period: Fourier coefficients of its force and their exact derivative, from N samples.
#include <vector>

#include "contact/fourier.hpp"
#include "contact/law.hpp"

namespace dovetail {

/// The marched law (theory.md, section 5): twice round the period from w_p, the second round
/// kept. Holds scratch memory: one object per thread.
class SampledLaw {
public:
  SampledLaw(int harmonics, int samples);

  const Fourier &fourier() const { return fourier_; }

  /// X (3, 2H+1): motion measured from the standstill, rows t1, t2, n. G (3, 2H+1): coefficients of g(x + x_p) -
  /// g(x_p). dG, unless null: (3(2H+1), 3(2H+1)) row-major, d G / d X, overwritten. Returns open if the point lifts off
  /// at some instant, else slip if it slips in either direction, else stick.
  State evaluate(const ContactPoint &point, const Standstill &preload, const double *X, double *G, double *dG);

private:
  // What the sliders' position during a stick interval was last set by; derivatives of stick forces go through it.
  struct Anchor {
    enum class Kind { memory, slip, landing } kind = Kind::memory;
    int sample = 0; // of the slip, or the first one after landing
    int sign = 0;   // of the slip
  };
  struct Run { // samples [begin, end) of the second round in one state
    int begin, end;
    State state;
    Anchor anchor; // stick: what it hangs on; slip: its sign
  };

  void march(double kt, double mu_kn, double w);
  void differentiate(double kt, double mu_kn, double *dT_dxt, double *dT_dxn);
  void anchor_rows(const Anchor &anchor, double kt, double mu_kn);

  Fourier fourier_;
  std::vector<double> tangential_, closing_, force_; // (N): x_t, x_n - x_n0 (> 0 closed), force
  std::vector<Run> runs_;
  std::vector<double> stick_sums_, slip_sums_, run_sums_; // (2H+1, 2)
  std::vector<double> share_, by_xt_, by_xn_;             // (2H+1)
};

} // namespace dovetail
