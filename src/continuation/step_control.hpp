#pragma once
// How long the next step is, and what a trial step shows; step_check.hpp refuses it. Lengths are in the weighted norm,
// where 1 is the largest motion so far or the whole range of the parameter.
#include "support/archive.hpp"

namespace dovetail {

/// What the length of a step aims at; it never exceeds the first two.
struct StepAims {
  double longest, parameter; ///< arc; part of the range: a resonance narrower than this could be stepped over
  double angle, most_angle;  ///< between tangents, aimed at and refused beyond [rad]
  double astray;             ///< by which a step may point away from the tangent more than the curve turns [rad]
  double motion;             ///< of the motion at hand, which after a resonance is far below the largest
  int newton;                ///< iterations
  double most_growth;        ///< of the length, or shrinking, from one step to the next
};
/// The middle of a step along a smooth curve is looked at, so that it may be long; kinks may be too close to be
/// followed one by one.
constexpr StepAims smooth_aims{1, 0.1, 0.8, 1.05, 0.1, 0.5, 6, 4}, rough_aims{0.1, 0.01, 0.25, 0.64, 0.8, 0.25, 4, 2};
inline const StepAims &aims_of(bool smooth) { return smooth ? smooth_aims : rough_aims; }

/// The numbers that rule steps, with what they are for.
struct StepLimits {
  double shortest = 1e-7;
  double careful = 1e-3;      ///< first step from a point that no step led to; and where the motion passes zero
  double kink_angle = 0.64;   ///< between tangents, beyond which it may be a kink that keeps them apart [rad]
  double most_correction = 2; ///< distance from predicted to converged point, in steps, where a kink may be
  double most_off = 0.05;     ///< of a step, by which the curve may miss its middle; smooth ones: 1e-3 and less;
                              ///< and of the way round a kink, by which the tangents' lines may miss each other
  double most_hidden = 0.01; ///< of the motion at the middle, by which it may be missed: at a resonance it is much more
  double most_of_middle = 0.75; ///< of a step, that its middle lies behind its begin
  int most_newton = 8;          ///< iterations of a step, for shorter ones converge in fewer
  double straight = 0.3;        ///< angle [rad] and correction [steps] up to which a curve runs on smoothly
  double kink_step = 2e-3;      ///< shorter steps that fail may be at a kink of the curve
  double close_to_kink = 1e-4;  ///< so near, both sides of a kink are tried, with the settings' iterations
  int most_refinements = 8;     ///< of the problem, for one step
};
constexpr StepLimits step_limits{};

/// What a trial step shows.
struct StepMeasure {
  double angle = 0, correction = 0; ///< between the tangents [rad]; from the predicted point [steps]
  bool smooth = true;               ///< the curve
  bool turns_too_far() const { return angle > aims_of(smooth).most_angle; }
  /// Where the step points elsewhere although the tangents agree, it led to another piece of the curve.
  bool lies_too_far() const;
  bool may_be_kink() const { return angle > step_limits.kink_angle || lies_too_far(); }
  bool straight() const { return angle < step_limits.straight && correction < step_limits.straight; }
};

/// What successive halvings of a step tell. Halving makes angle and correction of a smooth curve 1/2 and 1/4 as large;
/// at a kink the angle stays and the correction halves, at a jump to another branch both stay.
class Halvings {
public:
  /// True if this step and the one before it show a kink that may be taken as it is.
  bool add(const StepMeasure &now);

private:
  StepMeasure last_;
  int alike_ = 0;
};

/// How fast a curve goes along its tangent.
struct Rates {
  double parameter; ///< of its range, per arc length; 0: nothing resonates over it
  double motion;    ///< plain size of the tangent's x
  double size;      ///< plain size of x
};

class StepControl {
public:
  /// `adaptive` false: `first` throughout. `between`: by how much the cubic between two points may miss the curve.
  StepControl(bool adaptive, double first, double between, double shortest = step_limits.shortest)
      : adaptive_(adaptive), step_(first), between_(between), shortest_(adaptive ? shortest : shortest * first) {}

  double step() const { return step_; }
  bool adaptive() const { return adaptive_; }
  double between() const { return between_; }
  double shortest() const { return shortest_; }

  /// A length from outside: `limited` follows.
  void set(double step) { step_ = step; }
  /// After an accepted step of that length, along which the tangent turned [rad]. `off`: by how much its cubic misses
  /// the curve; 0: not known.
  void after(double step, double turned, int newton, double off, bool smooth);
  /// Not longer than the limits allow. `smooth`: of few lengths, for tangents are known to six digits only.
  void limit(const Rates &rates, bool smooth);

  void archive(Archive &archive);

private:
  bool adaptive_;
  double step_, between_, shortest_;
};

} // namespace dovetail
