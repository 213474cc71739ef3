#include "analyses/response.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr double beside = 0.9;  // a frequency, where a resonance at the other is none any more
constexpr double stalled = 1e4; // tolerances: a residual that stays farther up does so for other reasons

} // namespace

Response::Response(HarmonicSystem &given, const NewtonSettings &newton, const BranchSettings &settings, double unit,
                   SolveCounts &counts)
    : newton_(newton), unit_(unit), weighted_(settings.adaptive), to_tolerance_(settings.tolerance > 0),
      watched_(settings.watched), asked_for_(given.harmonics()), counts_(counts) {
  follow(given);
}

void Response::follow(HarmonicSystem &system) {
  system_ = &system;
  curve_ = std::make_unique<ResponseCurve>(system, newton_, unit_, weighted_, counts_);
  meter_ = std::make_unique<AmplitudeMeter>(system.layout(), watched_);
}

std::string Response::lost_to_rounding(double value, double residual) const {
  if (!is_sweep() || !(residual < stalled * newton_.residual_tolerance)) return "";
  const double rounding = std::min(curve_->rounding(value), curve_->rounding(beside * value)); // one may be a resonance
  if (!(rounding > newton_.residual_tolerance)) return "";
  char words[400];
  std::snprintf(words, sizeof words,
                "; rounding errors alone leave a residual of %.1g, more than newton.residual_tolerance = %.1g allows: "
                "something in the model is so stiff that its forces cancel. Make rigid links softer, a thousand to a "
                "million times as stiff as what they join",
                rounding, newton_.residual_tolerance);
  return words;
}

std::unique_ptr<HarmonicSystem> Response::with(int harmonics) const {
  return std::make_unique<HarmonicSystem>(*system_, harmonics, system_->samples());
}

ResponseCurve Response::curve_of(HarmonicSystem &system, double unit) const {
  return {system, newton_, unit, weighted_, counts_};
}

std::unique_ptr<HarmonicSystem> Response::exchange(std::unique_ptr<HarmonicSystem> system) {
  const double largest = metric().largest_motion();
  const std::vector<double> of_dofs = metric().largest_of_dofs();
  follow(*system);
  metric().restore(largest, of_dofs);
  std::swap(own_, system);
  return system;
}

} // namespace dovetail
