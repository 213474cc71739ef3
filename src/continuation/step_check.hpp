#pragma once
// Why a step is refused that Newton's method has found an end for: one list of checks, asked in turn.
#include <array>
#include <optional>
#include <string>

#include "continuation/event_locator.hpp"
#include "continuation/step_control.hpp"

namespace dovetail {

/// A step whose end lies on the curve; not known yet whether on the same piece of it.
struct Trial {
  Curve &curve;
  const CurvePoint &from, &to;
  double step;
  StepMeasure measure;
  bool kink; ///< halvings show a kink, which may be taken as it is
  EventLocator locator;
  std::optional<Located> branch_point = {}; ///< of another branch that crosses within the step, if a check finds one
};

class StepCheck {
public:
  virtual ~StepCheck() = default;
  /// Why the step is refused; nothing if this check finds no fault. Collective.
  virtual std::optional<std::string> refuse(Trial &trial) const = 0;
};

/// The tangent turns too far.
class AngleCheck : public StepCheck {
public:
  std::optional<std::string> refuse(Trial &trial) const override;
};

/// The solution lies far from the tangent, though the tangents agree: another piece of the curve.
class DistanceCheck : public StepCheck {
public:
  std::optional<std::string> refuse(Trial &trial) const override;
};

/// The middle of the cubic between both ends does not lie on the curve.
class MiddleCheck : public StepCheck {
public:
  std::optional<std::string> refuse(Trial &trial) const override;
};

/// The determinant's sign changes: a hairpin was jumped over, unless another branch crosses.
class OrientationCheck : public StepCheck {
public:
  std::optional<std::string> refuse(Trial &trial) const override;
};

/// All of them, the cheap ones first.
std::array<const StepCheck *, 4> step_checks();

/// What the first check says that refuses the step; nothing if none does.
std::optional<std::string> refused(Trial &trial);

} // namespace dovetail
