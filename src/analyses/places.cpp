// What lies within a step: frequencies wanted exactly, turning points, maxima, changes of stability, the end.
#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/follower.hpp"

namespace dovetail {
namespace {

constexpr double uneven = 0.25; // part of the frequency's rate that is missing in the mean over a step
constexpr int pieces = 4;       // of a step that may hide turning points

std::string in_words(Stability::Kind kind) {
  switch (kind) {
  case Stability::Kind::jump:
    return "a multiplier passes +1: the motion jumps";
  case Stability::Kind::period_doubling:
    return "a multiplier passes -1: the period doubles";
  case Stability::Kind::second_frequency:
    return "a pair of multipliers leaves the unit circle: a second frequency appears";
  default:
    return "";
  }
}

} // namespace

// Turning points within the step; none in the place of one that cannot be located. Two corners closer than a step may
// have two between them that its ends do not show: then the frequency gained is less than by a rate that changes
// steadily from one end to the other, and points in between are asked.
std::vector<std::optional<Follower::Place>> Follower::find_folds(Vec normal, double step, bool at_corner) {
  const auto rate_of = [&](CurvePoint &s) { return system_->parameter_in(s.t); };
  const double rate = rate_of(here_), next = rate_of(trial_), largest = std::max(std::abs(rate), std::abs(next)),
               missing = ((rate + next) / 2 - (trial_.parameter - here_.parameter) / step) * (rate > 0 ? 1 : -1);
  std::vector<std::optional<Place>> folds;
  if (largest <= 1e-12 / unit_) return folds; // a sweep at one frequency has none
  if (at_corner) {
    const bool rises = (trial_.parameter - here_.parameter) * rate > 0;
    if (rate * next < 0) folds.push_back(corner_place(Place::Kind::fold, step, rises, {rate, next}, rate_of));
    return folds;
  }
  std::vector<std::pair<double, CurvePoint>> between;
  for (int i = 1; i < pieces && rate * next > 0 && missing > uneven * largest; ++i) {
    CurvePoint s = curve_->point();
    check(VecAXPBYPCZ(s.y, 1 - double(i) / pieces, double(i) / pieces, 0, here_.y, trial_.y),
          "looking for turning points");
    if (curve_->solve_across(normal, s, {false, step_limits.most_newton}))
      between.emplace_back(i * step / pieces, std::move(s));
  }
  std::vector<Bound> bounds{{0, here_.y, rate}};
  for (auto &[along, s] : between) bounds.push_back({along, s.y, rate_of(s)});
  bounds.push_back({step, trial_.y, next});
  for (std::size_t i = 1; i < bounds.size(); ++i)
    if (bounds[i - 1].value * bounds[i].value < 0)
      folds.push_back(locate(Place::Kind::fold, normal, bounds[i - 1], bounds[i], rate_of));
  return folds;
}

std::optional<Follower::Place> Follower::locate(Place::Kind kind, Vec normal, Bound from, Bound to, const Measured &f) {
  std::optional<Located> found = locator().between(normal, from, to, f);
  if (!found) return std::nullopt;
  return Place{std::move(*found), kind};
}

Follower::Place Follower::place_at(const CurvePoint &s, Place::Kind kind, double along) {
  Place place{located_at(*curve_, s, along), kind};
  if (!s.data) return place;
  auto data = std::make_shared<ResponseData>(data_of(s));
  data->error.reset();
  place.at.data = std::move(data);
  return place;
}

// What cannot be located in a corner is the one of both ends that lies
// `beyond`, farther on or higher. values: of f there.
Follower::Place Follower::corner_place(Place::Kind kind, double step, bool beyond, std::array<double, 2> values,
                                       const Measured &f) {
  const long before = summary_.counts.newton;
  std::optional<Located> place = locator().in_kink(step, values, f);
  const long took = summary_.counts.newton - before;
  progress_.spare(took), cluster_.spare(took); // that is no winding
  if (place) return {std::move(*place), kind};
  return beyond ? place_at(trial_, kind, step) : place_at(here_, kind, 0);
}

// False if the step ends the sweep, but no solution is found exactly there.
bool Follower::find_places(Vec normal, double step, bool at_corner, const Amplitude &next, std::vector<Place> &found) {
  using Kind = Place::Kind;
  const auto located = [&](Kind kind, double from, double to, bool rises, const Measured &f) {
    if (!at_corner) return locate(kind, normal, {0, here_.y, from}, {step, trial_.y, to}, f);
    return std::optional(corner_place(kind, step, rises, {from, to}, f));
  };
  const auto keep = [&](std::optional<Place> place) {
    if (!place) return false;
    place->amplitude = (*meter_)(place->at.y, place->at.t).value;
    found.push_back(std::move(*place));
    return true;
  };
  for (auto &fold : find_folds(normal, step, at_corner))
    if (!keep(std::move(fold)))
      ++summary_.counts.folds, cluster_.folded(here_.parameter),
          notify(BranchEvent::Kind::fold, "turning point, not located", here_.parameter);
  if (amplitude_.slope > 0 && next.slope < 0 &&
      !keep(located(Kind::peak, amplitude_.slope, next.slope, next.value > amplitude_.value,
                    [&](CurvePoint &s) { return (*meter_)(s.y, s.t).slope; })))
    ++summary_.counts.peaks, notify(BranchEvent::Kind::peak, "maximum, not located", here_.parameter, amplitude_.value);
  if (const double limit = settings_.stop_at_amplitude; limit > 0 && amplitude_.value < limit && next.value >= limit)
    keep(locate(Kind::limit, normal, {0, here_.y, amplitude_.value - limit}, {step, trial_.y, next.value - limit},
                [&](CurvePoint &s) { return (*meter_)(s.y, s.t).value - limit; })) ||
        keep(place_at(trial_, Kind::limit, step));
  if (branch_point_) keep(Place{std::move(*std::exchange(branch_point_, std::nullopt)), Kind::branch});
  if (settings_.stability) find_stability_change(normal, step, at_corner, found);

  // Within each piece between turning points the frequency is monotone.
  const auto in_order = [](const Place &a, const Place &b) { return a.along < b.along; };
  std::sort(found.begin(), found.end(), in_order);
  std::vector<PieceEnd> ends{{here_, 0}};
  for (const Place &place : found)
    if (place.kind == Kind::fold) ends.push_back({place.at, place.along});
  ends.push_back({trial_, step});
  std::vector<Place> wanted;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    if (!find_wanted(normal, ends[i - 1], ends[i], at_corner, wanted)) return false;
    if (!wanted.empty() && wanted.back().kind == Kind::last) break;
  }
  for (Place &place : wanted) found.push_back(std::move(place));
  std::sort(found.begin(), found.end(), in_order);
  return true;
}

// Solutions exactly at the frequencies of `at`, and at the end of the sweep, between two stations.
bool Follower::find_wanted(Vec normal, const PieceEnd &from, const PieceEnd &to, bool at_corner,
                           std::vector<Place> &found) {
  using Kind = Place::Kind;
  const CurvePoint &a = from.at, &b = to.at;
  const auto between = [&](double w) { return (w - a.parameter) * (w - b.parameter) < 0; };
  const bool ends = (settings_.to - a.parameter) * (settings_.to - b.parameter) <= 0 && a.parameter != b.parameter;
  std::vector<double> passed;
  for (const double w : settings_.at)
    if (between(w) && (!ends || (w - settings_.to) * (a.parameter - settings_.to) > 0)) passed.push_back(w);
  std::sort(passed.begin(), passed.end());
  if (b.parameter < a.parameter) std::reverse(passed.begin(), passed.end());
  if (ends) passed.push_back(settings_.to);
  for (const double w : passed) {
    Place place{{0, curve_->point()}, ends && w == settings_.to ? Kind::last : Kind::wanted};
    if (solve_wanted(normal, a, b, w, place)) {
      if (at_corner) // no plane tells where on which leg
        place.along = from.along + (w - a.parameter) / (b.parameter - a.parameter) * (to.along - from.along);
      place.amplitude = (*meter_)(place.at.y, place.at.t).value;
      found.push_back(std::move(place));
    } else if (place.kind == Kind::last) {
      refusal_ = "no solution exactly at the end of the sweep: " + place.at.newton.why;
      return false;
    } else {
      ++summary_.counts.missed;
      notify(BranchEvent::Kind::missed,
             "no solution at this " + parameter_name() + " of " + at_key() + ": " + place.at.newton.why, w);
    }
  }
  return true;
}

bool Follower::solve_wanted(Vec normal, const CurvePoint &a, const CurvePoint &b, double w, Place &place) {
  const double part = (w - a.parameter) / (b.parameter - a.parameter);
  check(VecWAXPY(place.at.y, -1, a.y, b.y), "interpolating");
  check(VecAYPX(place.at.y, part, a.y), "interpolating");
  if (!curve_->solve_at(w, place.at)) return false;
  if (b.parameter < a.parameter) turn(place.at);
  place.along = curve_->plane(normal, place.at.y) - curve_->plane(normal, here_.y);
  return true;
}

std::optional<Stability> Follower::judge(const CurvePoint &s) {
  if (!stability_ && !large_stability_) return std::nullopt;
  system_->set(s.parameter);
  const PathParameter &kind = system_->parameter().kind();
  if (stability_ && (kind.changes_joint || kind.changes_damping)) begin_stability(); // of the model there
  if (stability_) return stability_->judge(all_coefficients(system_->layout(), s.y), system_->setting().omega);
  return large_stability_->judge(s.y);
}

void Follower::begin_stability() {
  if (judged_densely(system_->layout().dofs()))
    stability_ = std::make_unique<StabilityTest>(dense_model(*system_));
  else
    large_stability_ = std::make_unique<LargeStabilityTest>(*system_);
}

void Follower::tell_stability(double omega, double amplitude) {
  ++summary_.counts.stability_changes;
  notify(BranchEvent::Kind::stability,
         last_verdict_ == 1 ? "stable from here on" : "unstable from here on: " + in_words(verdict_->kind), omega,
         amplitude);
}

// Judges trial_. Where it differs from the last point that was certain: at a turning point, if there is one between
// them, else by bisection where the largest exponent passes zero, unless uncertain points lie between.
void Follower::find_stability_change(Vec normal, double step, bool at_corner, std::vector<Place> &found) {
  using Verdict = Stability::Verdict;
  const auto before = verdict_;
  verdict_ = judge(trial_);
  for (const Place &place : found)
    if (place.kind == Place::Kind::fold) fold_since_ = {place.at.parameter, place.amplitude};
  if (verdict_->verdict == Verdict::uncertain) return;
  const int now = verdict_->verdict == Verdict::stable, then = std::exchange(last_verdict_, now);
  const auto fold = std::exchange(fold_since_, std::nullopt);
  if (then < 0 || then == now) return;
  std::optional<Place> place;
  if (!fold && at_corner)
    place = place_at(trial_, Place::Kind::stability, step);
  else if (!fold && before && before->verdict != Verdict::uncertain)
    place = locate(Place::Kind::stability, normal, {0, here_.y, before->growth}, {step, trial_.y, verdict_->growth},
                   [&](CurvePoint &s) { return judge(s)->growth; });
  if (place)
    found.push_back(std::move(*place));
  else
    tell_stability(fold ? fold->omega : here_.parameter, fold ? fold->amplitude : amplitude_.value);
}

// One row of the results for each place, and the words that go with it.
Follower::Outcome Follower::report_places(std::vector<Place> &found, double plain, bool at_corner) {
  using Kind = Place::Kind;
  const auto folds = std::count_if(found.begin(), found.end(), [](const Place &p) { return p.kind == Kind::fold; });
  bool higher = (system_->parameter_in(trial_.t) > 0) == (folds % 2 == 1); // after the first of them
  for (Place &place : found) {
    CurvePoint &s = place.at;
    const std::optional<Stability> stability = judge(s);
    report(s, arclength_ + place.along * plain, stability ? &*stability : nullptr, true);
    switch (place.kind) {
    case Kind::fold:
      ++summary_.counts.folds;
      notify(BranchEvent::Kind::fold,
             std::string("turning point: the curve goes on towards ") + (higher ? "higher" : "lower") +
                 " values of the " + parameter_name(),
             s.parameter, place.amplitude);
      higher = !higher;
      cluster_.folded(s.parameter);
      if (!at_corner && summary_.counts.points < settings_.max_points && farther(s.parameter))
        farthest_ = std::move(place.at);
      break;
    case Kind::peak:
      ++summary_.counts.peaks;
      notify(BranchEvent::Kind::peak, "peak", s.parameter, place.amplitude);
      if (summary_.counts.peaks == settings_.stop_after_peaks) {
        here_.parameter = s.parameter;
        return end(End::peaks, "stopped after peak " + std::to_string(summary_.counts.peaks));
      }
      break;
    case Kind::branch:
      ++summary_.counts.branch_points;
      notify(BranchEvent::Kind::branch, "another branch of solutions crosses here", s.parameter, place.amplitude);
      break;
    case Kind::stability:
      tell_stability(s.parameter, place.amplitude);
      break;
    case Kind::limit:
      here_.parameter = s.parameter;
      return end(End::amplitude, "stopped at continuation.stop_at_amplitude");
    case Kind::last:
      here_.parameter = s.parameter;
      return end(End::arrived);
    case Kind::wanted:
      break;
    }
    // In corners it stands at ends of steps only.
    if (at_corner || summary_.counts.points < settings_.max_points) continue;
    arclength_ += place.along * plain; // stand here, so that a restart goes on from here
    std::swap(here_, place.at);
    begin_amplitude();
    verdict_ = stability;
    return Outcome::ended;
  }
  return Outcome::on;
}

} // namespace dovetail
