#pragma once
// A curve of periodic motions over frequency, followed by arc length in time: each a fixed point of one period's flow.
// The way through where contacts are so stiff that harmonic balance would need hundreds of harmonics: what a point
// takes does not grow with them, some tens of periods for a small model.
#include <complex>

#include "support/dense.hpp"
#include "transient/period_map.hpp"

namespace dovetail {

class OrbitCurve {
public:
  /// Motions near those at `omega`. A change of frequency by `omega_unit` counts as much as a motion as large as the
  /// first one.
  OrbitCurve(DenseModel model, double omega, double omega_unit);
  OrbitCurve(const OrbitCurve &) = delete;
  OrbitCurve &operator=(const OrbitCurve &) = delete;

  /// At the periodic motion near the state q, v (n), w (points) at theta = 0; direction: sign of the way in frequency.
  /// False if Newton's method does not converge.
  bool begin(const std::vector<double> &q, const std::vector<double> &v, const std::vector<Memory> &w, int direction);

  /// To a next motion. False if no step converges, round corners neither; nothing has changed then.
  bool step();

  double omega() const { return z_.back() * unit_; }
  double rising() const { return t_.back(); } ///< > 0: frequency grows along the curve from here on
  int newton() const { return newton_; }      ///< iterations of the last call, those that failed included
  Motion motion(int instants);                ///< here
  /// That of the curve at a frequency between those of the last two motions; none where Newton fails.
  bool motion_at(double omega, int instants, Motion &motion);
  /// Multipliers of the motion here, by differences; 0 in the place of those of sliders that stick all the time, which
  /// are 1. Empty where LAPACK fails.
  std::vector<std::complex<double>> multipliers() const;

  std::vector<double> save() const;
  /// The same place, to the last bit; false for numbers that are not of such a curve.
  bool restore(const std::vector<double> &numbers);

private:
  Numbers motion_numbers(const Numbers &z) const;
  bool miss(const Numbers &z, bool freely, Numbers &r, Held &still);
  bool linearise(const Numbers &z);
  void border(const Numbers &row, Factors &out);
  Numbers tangent(const Factors &factors) const;
  bool correct(Numbers &z, const Numbers &row, Factors factors);
  bool arrive(const Numbers &t, double step, const Factors &factors, bool checked);
  bool hangs_together(const Factors &there);
  void stand();
  bool round_corner(double step);
  bool look(const Numbers &z, double omega, int instants, Motion &motion);
  double size(const Numbers &z) const; ///< of the motion, in the first one's
  void limit_step();

  DenseModel model_;
  Flow flow_;
  PeriodMap map_;
  double omega_begun_, unit_, scale_ = 1;
  Numbers z_, t_;    // numbers of the map over scale_, then omega / unit_; tangent of length 1
  Numbers before_;   // z_ before the last step
  Factors factors_;  // of the derivative here, bordered by t_,
  Dense derivative_; // without the border: (numbers, numbers + 1) of period map minus 1, as linearised last
  Dense here_;       // the same, here
  Held held_;        // sliders that stick all the time, as linearised last,
  Held held_here_;   // and here
  int sign_ = 0;     // of the bordered determinant: it stays the same along a curve
  double step_ = 0, largest_ = 1;
  int newton_ = 0;
  Numbers trial_, trial_tangent_; // a step that was tried
  double turned_ = 0;             // angle by which the curve turns in it [rad]
};

} // namespace dovetail
