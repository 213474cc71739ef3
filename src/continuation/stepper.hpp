#pragma once
// Steps along a curve: predict, correct, check, halve; round a kink where halving leads nowhere. Where the cubic
// between the ends of a step does not draw the curve, points in between are found first. What a step is worth, and what
// else is done with it, says the class that derives from this.
#include <optional>
#include <string>
#include <vector>

#include "continuation/curve.hpp"
#include "continuation/event_locator.hpp"
#include "continuation/kink_turn.hpp"
#include "continuation/step_control.hpp"

namespace dovetail {

class Stepper {
public:
  virtual ~Stepper() = default;
  Stepper(const Stepper &) = delete;
  Stepper &operator=(const Stepper &) = delete;

  enum class Outcome { on, refused, ended, refined }; ///< refined: the problem was, and the step is to be tried again

protected:
  /// `unit`: of the parameter, as for the curve. `newton_tolerance`: relative, of y.
  Stepper(const StepControl &control, double unit, double newton_tolerance)
      : control_(control), unit_(unit), newton_tolerance_(newton_tolerance) {}

  /// One accepted step along the curve, or what no_step() says.
  Outcome advance();
  /// From here on along that curve, whose points the stepper then makes anew.
  void take_curve(Curve &curve);
  /// Length of the next step by what limits it here, where it was measured anew.
  void limit_step();
  /// here_ was not led to by a step: the next guess follows the tangent alone, and leads where none has been.
  void forget_steps() { before_.reset(), ahead_.clear(); }
  /// here_.t to length 1 by the metric as it is now.
  void measure_anew();
  /// Copies a point without what belongs to its solve.
  void note(std::optional<CurvePoint> &place, const CurvePoint &s) const;
  void archive_steps(Archive &archive);
  EventLocator locator() { return {*curve_, here_, trial_, newton_tolerance_}; }

  // What the owner of the curve does, in the order of a step.
  /// Refines the problem at here_ if trial_ asks for it: true if it did.
  virtual bool refine(CurvePoint & /*trial*/) { return false; }
  /// Takes the step from here_ to trial_, with all that lies within, by swapping them; or refuses it.
  virtual Outcome pass(Vec normal, double step, bool at_kink) = 0;
  /// After that: the curve's metric sees here_. `way`: from there back to where the step began.
  virtual Outcome settle(Vec way);
  /// A step along the tangent was taken, and the next one's length chosen.
  virtual void stepped() {}
  /// Whether trial_, which lies that far from where the tangent points, is the curve's all the same although a check
  /// refuses it: behind a jump too small to matter.
  virtual bool takes_jump(double /*apart*/) { return false; }
  /// Such a step was taken.
  virtual void jumped() {}
  /// A step was refused, and is halved.
  virtual void halved(const std::string & /*why*/) {}
  /// The curve was followed round a kink that turns it by that angle [rad] at that value of the parameter.
  virtual void turned_kink(double /*angle*/, double /*parameter*/) {}
  /// No step converges, however short. The default ends.
  virtual Outcome no_step() { return Outcome::ended; }
  virtual bool iterations_are_expensive() const { return false; }

  Curve *curve_ = nullptr;
  CurvePoint here_, trial_;          // last accepted point; the one being tried
  std::optional<CurvePoint> before_; // where the smooth step to here_ began
  std::vector<CurvePoint> ahead_;    // ends of steps that pieces of are taken first, the nearest last
  UniqueVec predicted_;
  StepControl control_;
  const double unit_, newton_tolerance_;
  std::string refusal_;                 // why the last step was refused
  std::optional<Located> branch_point_; // within the step being tried

private:
  Outcome try_step(double step);
  Outcome take_trial(double step);
  Outcome refine_drawing(double whole);
  bool solve_trial(double step);
  bool belongs(double step, const StepMeasure &measure, bool kink);
  double length_to(const CurvePoint &point) const;
  Outcome accept_step(Vec normal, double step, bool at_kink = false);
  bool round_kink(double step, Outcome &outcome);

  Halvings halvings_;
  double speed_ = 0, motion_ = 0; // when measured anew: motions of the tangent and of the point, without weights
  double curvature_ = 0;          // at the last smooth step: angle per arc length
  Curve::Off off_{0, 0};          // by how much the cubic to trial_ misses the curve; 0: not known
  UniqueVec middle_;              // where that was found
};

} // namespace dovetail
