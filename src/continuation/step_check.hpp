#pragma once
// Why a step is refused that Newton's method has found an end for: one list of checks, asked in turn.
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
  UniqueVec middle = {};                    ///< point of the curve about half way, where a check looks for it
  Curve::Off off = {0, 0};                  ///< by how much the cubic between the ends misses it; 0: not known
  std::optional<Located> branch_point = {}; ///< of another branch that crosses within the step, if a check finds one
};

/// Why a step is refused; nothing if the check finds no fault. Collective.
using StepCheck = std::optional<std::string> (*)(Trial &trial);

/// The tangent turns too far.
std::optional<std::string> check_angle(Trial &trial);
/// The solution lies far from the tangent, though the tangents agree: another piece of the curve.
std::optional<std::string> check_distance(Trial &trial);
/// The middle of the cubic between both ends does not lie on the curve.
std::optional<std::string> check_middle(Trial &trial);
/// The determinant's sign changes: a hairpin was jumped over, unless another branch crosses.
std::optional<std::string> check_orientation(Trial &trial);

/// The cheap ones first.
constexpr StepCheck step_checks[] = {check_angle, check_distance, check_middle, check_orientation};

/// What the first check says that refuses the step; nothing if none does.
std::optional<std::string> refused(Trial &trial);

} // namespace dovetail
