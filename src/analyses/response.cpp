#include "analyses/response.hpp"

#include <utility>

#include "support/error.hpp"

namespace dovetail {

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
