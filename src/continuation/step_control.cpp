#include "continuation/step_control.hpp"

#include <algorithm>
#include <cmath>

namespace dovetail {
namespace {

constexpr double alike_ratio = 0.75; // of successive angles, half of it of corrections: beyond, they do not shrink
constexpr double aimed_off = 0.5;    // of what the cubic may miss the curve by, which goes with step^4
constexpr int lengths_per_octave = 8;
constexpr double rounding = 1e-9; // so that one of these lengths stays what it is

} // namespace

bool StepMeasure::lies_too_far() const { return std::atan(correction) > angle + aims_of(smooth).astray; }

bool Halvings::add(const StepMeasure &now) {
  const bool alike = last_.may_be_kink() && now.angle > alike_ratio * last_.angle &&
                     now.correction < 2 * alike_ratio * last_.correction;
  alike_ = alike ? alike_ + 1 : 0;
  last_ = now;
  return alike_ >= 2;
}

void StepControl::after(double step, double turned, int newton, double off, bool smooth) {
  if (!adaptive_) return;
  const StepAims &aims = aims_of(smooth);
  const double by_newton = std::pow(2.0, (aims.newton - newton) / 2.0), by_angle = aims.angle / turned,
               by_off = std::pow(aimed_off * between_ / off, 0.25);
  step_ = step * std::clamp(std::min({by_newton, by_angle, by_off}), 1 / aims.most_growth, aims.most_growth);
}

void StepControl::limit(const Rates &rates, bool smooth) {
  if (!adaptive_) return;
  const StepAims &aims = aims_of(smooth);
  step_ = std::min(step_, aims.longest);
  if (rates.parameter > 0) step_ = std::min(step_, aims.parameter / rates.parameter);
  if (rates.motion > 0) step_ = std::min(step_, std::max(aims.motion * rates.size / rates.motion, step_limits.careful));
  step_ = std::max(step_, 10 * shortest_);
  if (smooth) step_ = std::exp2(std::floor(lengths_per_octave * std::log2(step_) + rounding) / lengths_per_octave);
}

void StepControl::archive(Archive &archive) { archive.field("step", step_); }

} // namespace dovetail
