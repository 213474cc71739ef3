#pragma once
// A curve of periodic motions over frequency, followed by arc length in time: each a fixed point of one period's flow.
// The way through where contacts are so stiff that harmonic balance would need hundreds of harmonics: what a point
// takes does not grow with them: some periods for corrections, and one with its derivative.
#include <complex>
#include <memory>

#include "support/archive.hpp"
#include "support/dense.hpp"
#include "transient/period_map.hpp"

namespace dovetail {

class OrbitCurve {
public:
  /// A motion of the curve.
  struct Place {
    Numbers z;        ///< of the map over the size of the first motion, then omega / omega_unit
    Numbers t;        ///< tangent of length 1, towards growing arc length
    Dense derivative; ///< by z: (numbers, numbers + 1) of period map minus 1; empty where it was not needed
    Held held;        ///< sliders that stick all the time, as it was linearised
    bool rises() const { return t.back() > 0; } ///< frequency grows from here on
  };

  /// Motions near those at `omega`. A change of frequency by `omega_unit` counts as much as a motion as large as the
  /// first one. longest_step: where the largest motion so far is 1.
  OrbitCurve(DenseModel model, double omega, double omega_unit, double longest_step = 0.1);
  OrbitCurve(const OrbitCurve &) = delete;
  OrbitCurve &operator=(const OrbitCurve &) = delete;

  /// At the periodic motion nearby; direction: sign of the way in frequency. False if Newton's method does not
  /// converge.
  bool begin(const MotionState &nearby, int direction);
  /// To a next motion. False if no step converges, round corners neither; nothing has changed then.
  bool step();

  using PlacePtr = std::shared_ptr<const Place>;
  PlacePtr here() const { return here_; }
  int newton() const { return newton_; } ///< iterations of the last call that searched a motion, failures included

  // Within the last step. None where Newton fails.
  double way() const;                       ///< length of its chord
  double along(const Place &place) const;   ///< on the chord
  bool cornered() const { return corner_; } ///< it led round a corner
  /// On the plane across the chord, `along` it.
  PlacePtr between(double along);
  PlacePtr at(double omega, Numbers guess, bool rises); ///< guess: numbers as Place::z
  /// The corner, but for the square of the step: where the tangents at both ends meet.
  PlacePtr corner();

  double omega(const Place &place) const { return place.z.back() * unit_; }
  double rate(const Place &place) const { return place.t.back() * unit_; } ///< of frequency, by arc length
  MotionState motion_state(const Place &place) const;
  /// From that motion, or the one so far along the tangent, which is periodic but for the square of that.
  Motion motion(const Place &place, int instants, double aside = 0);
  /// 0 in the place of those of sliders that stick all the time, which are 1. Empty where LAPACK fails,
  /// or the motion runs away.
  std::vector<std::complex<double>> multipliers(const Place &place);

  void save(Archive &archive) const;
  /// The same place, to the last bit; false for what is not of such a curve.
  bool restore(Archive &archive);

private:
  Numbers motion_numbers(const Numbers &z) const;
  void set_out(const Numbers &z);
  bool miss(const Numbers &z, bool freely, Numbers &r, Held &still);
  bool linearise(const Numbers &z);
  void take(const Place &place);
  void border(const Numbers &row, Factors &out);
  Numbers tangent(const Factors &factors) const;
  bool correct(Numbers &z, const Numbers &row, Factors factors, double tolerance);
  enum class Checks { none, sense, all };
  bool arrive(const Numbers &t, double step, const Factors &factors, Checks checks);
  bool hangs_together(const Factors &there);
  void stand(Numbers z, Numbers t);
  bool behind(const Numbers &z) const;
  bool round_corner(double step);
  Numbers cubic(double part) const;
  PlacePtr find(Numbers z, const Numbers &row, double tolerance);
  double size(const Numbers &z) const; ///< of the motion, in the first one's
  void limit_step();

  DenseModel model_;
  Flow flow_;
  PeriodMap map_;
  double omega_begun_, unit_, longest_, scale_ = 1;
  PlacePtr here_, before_; // before_: where the last step began,
  Numbers came_;           // and its direction, of length 1
  Factors factors_;        // of the derivative here, bordered by the tangent
  Dense derivative_;       // as linearised last, and
  Held held_;              // likewise
  int sign_ = 0;           // of the bordered determinant: it stays the same along a curve
  double step_ = 0, largest_ = 1;
  bool corner_ = false;
  int newton_ = 0;
  Numbers trial_, trial_tangent_; // a step that was tried
  double turned_ = 0;             // angle by which the curve turns in it [rad]
};

} // namespace dovetail
