#pragma once
// The contact forces as one writes them first, to compare with: one point after the other, one sample after the other,
// the derivative of every sample carried along in full, and the Jacobian as a dense product.
#include <algorithm>
#include <vector>

#include "contact/fourier.hpp"
#include "contact/law.hpp"

extern "C" void dgemm_(const char *, const char *, const int *, const int *, const int *, const double *,
                       const double *, const int *, const double *, const int *, const double *, double *, const int *);

namespace dovetail {

/// Law coulomb for one point, from N samples; the same numbers as SampledLaw to round-off.
class NaiveLaw {
public:
  NaiveLaw(int harmonics, int samples)
      : fourier_(harmonics, samples), n_(fourier_.size()), N_(samples), analysis_(n_ * N_), x_(3 * N_), force_(N_),
        slope_(3 * n_ * N_), dw_(3 * n_) {
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < N_; ++j) analysis_[i * N_ + j] = (i == 0 ? 2.0 : 2 * fourier_.row(j)[i]) / N_;
  }

  /// X, G (3, 2H+1); J (3 (2H+1), 3 (2H+1)), unless null.
  void evaluate(const ContactPoint &point, const Standstill &standstill, const double *X, double *G, double *J) {
    for (int d = 0; d < 3; ++d) {
      fourier_.synthesise(X + d * n_, &x_[d * N_]);
      for (int j = 0; j < N_; ++j) x_[d * N_ + j] += standstill.x[d] - (d == 2 ? point.gap : 0);
    }
    for (int d = 0; d < 3; ++d) {
      if (d < 2)
        march(point, d, standstill.w[d], J != nullptr);
      else
        press(point.kn, J != nullptr);
      fourier_.analyse(force_.data(), G + d * n_);
      G[d * n_] -= 2 * standstill.force[d];
      if (!J) continue;
      const int columns = 3 * n_;
      const double one = 1, zero = 0;
      dgemm_("N", "N", &columns, &n_, &N_, &one, slope_.data(), &columns, analysis_.data(), &N_, &zero,
             J + d * n_ * columns, &columns); // row-major: J = analysis * slope
    }
  }

private:
  double *slope_at(int j) { return &slope_[static_cast<std::size_t>(j) * 3 * n_]; }
  void clear_slope(int j) { std::fill_n(slope_at(j), 3 * n_, 0.0); }

  void press(double kn, bool derivative) {
    for (int j = 0; j < N_; ++j) {
      const double p = x_[2 * N_ + j];
      force_[j] = pressed(kn, p);
      if (!derivative) continue;
      clear_slope(j);
      for (int i = 0; p > 0 && i < n_; ++i) slope_at(j)[2 * n_ + i] = kn * fourier_.row(j)[i];
    }
  }

  // The slider w and its derivative, twice round the period.
  void march(const ContactPoint &point, int d, double w, bool derivative) {
    const double kt = point.kt[d], mu_kn = point.mu[d] * point.kn, *x = &x_[d * N_], *p = &x_[2 * N_];
    std::fill(dw_.begin(), dw_.end(), 0.0);
    for (int step = 0; step < 2 * N_; ++step) {
      const int j = step % N_, before = j ? j - 1 : N_ - 1;
      force_[j] = 0;
      if (derivative) clear_slope(j);
      if (p[j] <= 0) continue;
      if (p[before] <= 0 && step > 0) w = land(d, x, p, before, j, derivative);
      const double trial = kt * (x[j] - w), bound = mu_kn * p[j];
      const int side = slips(trial, bound);
      force_[j] = side ? side * bound : trial;
      if (derivative) differentiate(d, kt, side * mu_kn, side, j);
      if (side) w = x[j] - force_[j] / kt;
    }
  }

  double land(int d, const double *x, const double *p, int before, int now, bool derivative) {
    const double fall = p[before] - p[now], part = p[before] / fall, moved = x[now] - x[before];
    const double *e0 = fourier_.row(before), *e1 = fourier_.row(now);
    if (derivative) {
      std::fill(dw_.begin(), dw_.end(), 0.0);
      for (int i = 0; i < n_; ++i) {
        dw_[d * n_ + i] = e0[i] + part * (e1[i] - e0[i]);
        dw_[2 * n_ + i] = moved * (p[before] * e1[i] - p[now] * e0[i]) / (fall * fall);
      }
    }
    return x[before] + part * moved;
  }

  void differentiate(int d, double kt, double side_mu_kn, int side, int j) {
    double *slope = slope_at(j);
    const double *e = fourier_.row(j);
    if (side == 0) {
      for (int i = 0; i < 3 * n_; ++i) slope[i] = -kt * dw_[i];
      for (int i = 0; i < n_; ++i) slope[d * n_ + i] += kt * e[i];
      return;
    }
    for (int i = 0; i < n_; ++i) slope[2 * n_ + i] = side_mu_kn * e[i];
    for (int i = 0; i < 3 * n_; ++i) dw_[i] = -slope[i] / kt;
    for (int i = 0; i < n_; ++i) dw_[d * n_ + i] += e[i];
  }

  Fourier fourier_;
  int n_, N_;
  std::vector<double> analysis_; // (2H+1, N)
  std::vector<double> x_;        // (3, N) motion, the normal one from the lift-off displacement
  std::vector<double> force_;    // (N) of one direction
  std::vector<double> slope_;    // (N, 3 (2H+1)) its derivative
  std::vector<double> dw_;       // (3 (2H+1)) derivative of the slider
};

} // namespace dovetail
