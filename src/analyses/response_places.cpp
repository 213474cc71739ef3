// What is told of the places within a step: one row of the results for each, and the words that go with it.
#include <algorithm>
#include <utility>

#include "analyses/response_stepper.hpp"

namespace dovetail {

void ResponseStepper::give(CurvePoint &s, double arclength, const Stability *stability, bool located) {
  const ErrorEstimate *error = !errors.asked() ? nullptr : located ? &errors.with_modes(s) : &errors.affordable(s);
  report_.point({s.y, response.system(), s.parameter, arclength, s.newton, data_of(s).activity, stability, error,
                 amplitude_.error, range.progress(s.parameter), located, 0, s.t});
}

ResponseStepper::Outcome ResponseStepper::tell(std::vector<Place> &places, const std::vector<double> &lengths,
                                               bool at_kink) {
  const auto folds = std::count_if(places.begin(), places.end(), [](auto &p) { return p.kind == Place::Kind::fold; });
  bool higher = (response.system().parameter_in(trial_.t) > 0) == (folds % 2 == 1); // after the first of them
  for (std::size_t i = 0; i < places.size(); ++i) {
    Place &place = places[i];
    const double value = place.at.parameter;
    const std::optional<Stability> stability = stability_.judge(place.at);
    give(place.at, arclength_ + lengths[i], stability ? &*stability : nullptr, true);
    if (place.kind == Place::Kind::fold) {
      tell_fold(place, higher, at_kink);
      higher = !higher;
    } else if (tell(place) == Outcome::ended) {
      return Outcome::ended;
    }
    if (report_.ends_at(most_points_)) {
      here_.parameter = value;
      return Outcome::ended;
    }
  }
  return Outcome::on;
}

void ResponseStepper::tell_fold(Place &place, bool higher, bool at_kink) {
  const CurvePoint &s = place.at;
  report_.event(report_.counts.folds, BranchEvent::Kind::fold,
                std::string("turning point: the curve goes on towards ") + (higher ? "higher" : "lower") +
                    " values of the " + response.parameter_name(),
                s.parameter, place.amplitude);
  progress.cluster.folded(s.parameter);
  if (!at_kink && farthest.is_behind(s.parameter)) farthest.point = std::move(place.at);
}

ResponseStepper::Outcome ResponseStepper::tell(const Place &place) {
  using Kind = Place::Kind;
  const double value = place.at.parameter;
  const auto end_there = [&](End how, const std::string &why = "") {
    here_.parameter = value;
    return report_.end(how, why);
  };
  switch (place.kind) {
  case Kind::peak:
    largest_ = std::max(largest_, place.amplitude);
    report_.event(report_.counts.peaks, BranchEvent::Kind::peak, "peak", value, place.amplitude);
    if (report_.counts.peaks != most_peaks_) break;
    return end_there(End::peaks, "stopped after peak " + std::to_string(most_peaks_));
  case Kind::branch:
    report_.event(report_.counts.branch_points, BranchEvent::Kind::branch, "another branch of solutions crosses here",
                  value, place.amplitude);
    break;
  case Kind::stability:
    stability_.tell(report_, value, place.amplitude);
    break;
  case Kind::limit:
    return end_there(End::amplitude, "stopped at continuation.stop_at_amplitude");
  case Kind::last:
    return end_there(End::arrived);
  default:
    break;
  }
  return Outcome::on;
}

} // namespace dovetail
