#include "continuation/step_check.hpp"

#include <cmath>

namespace dovetail {

std::optional<std::string> check_angle(Trial &trial) {
  if (trial.kink || !trial.measure.turns_too_far()) return std::nullopt;
  return "the curve turns too far within one step";
}

std::optional<std::string> check_distance(Trial &trial) {
  if (trial.kink || !trial.measure.lies_too_far()) return std::nullopt;
  return "the solution lies too far from the predicted one";
}

std::optional<std::string> check_middle(Trial &trial) {
  if (trial.kink || !trial.curve.problem.is_smooth() || trial.step <= step_limits.close_to_kink) return std::nullopt;
  check(VecDuplicate(trial.to.y, trial.middle.out()), "looking into a step"); // a new one would take a message
  const Curve::Off off = trial.curve.off_middle(trial.from, trial.to, trial.middle);
  if (std::isfinite(off.length)) trial.off = off;
  if (!(off.length > step_limits.most_off * trial.step)) return std::nullopt;
  return "the curve does not run smoothly from one end of the step to the other";
}

std::optional<std::string> check_orientation(Trial &trial) {
  if (trial.to.sign * trial.from.sign >= 0) return std::nullopt;
  if (trial.measure.straight() && trial.locator.leads_back(trial.step, trial.measure.correction * trial.step)) {
    trial.branch_point = trial.locator.branch_point(trial.step);
    if (trial.branch_point) return std::nullopt;
    return "the step leads to another branch";
  }
  if (trial.kink && trial.step <= step_limits.close_to_kink) return std::nullopt;
  return "the curve turns round within one step";
}

std::optional<std::string> refused(Trial &trial) {
  for (const StepCheck check : step_checks)
    if (auto why = check(trial)) return why;
  return std::nullopt;
}

} // namespace dovetail
