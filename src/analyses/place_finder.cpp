#include "analyses/place_finder.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "continuation/step_control.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr double uneven = 0.25; // part of the parameter's rate that is missing in the mean over a step
constexpr int pieces = 4;       // of a step that may hide turning points
constexpr int looked_at = 4;    // parts of a step whose ends tell of maxima on the cubic that it is drawn by
constexpr double still = 1e-12; // rate of the parameter, of its range: a curve at one value has no turning points

Place place_at(const Curve &curve, const CurvePoint &s, Place::Kind kind, double along) {
  Place place{located_at(curve, s, along), kind};
  if (!s.data) return place;
  auto data = std::make_shared<ResponseData>(data_of(s));
  data->error.reset();
  place.at.data = std::move(data);
  return place;
}

std::optional<Place> placed(std::optional<Located> found, Place::Kind kind) {
  if (!found) return std::nullopt;
  return Place{std::move(*found), kind};
}

bool in_order(const Place &a, const Place &b) { return a.along < b.along; }

} // namespace

Places PlaceFinder::find(std::optional<Located> crossing) {
  find_folds();
  find_peaks();
  find_limit();
  if (crossing) keep(Place{std::move(*crossing), Place::Kind::branch});
  std::sort(found_.list.begin(), found_.list.end(), in_order);
  find_wanted();
  if (!found_.complete) return std::move(found_); // the step will be another one
  if (stability_.asked()) find_stability_change();
  std::sort(found_.list.begin(), found_.list.end(), in_order);
  for (const auto &tell : untold_) tell();
  return std::move(found_);
}

bool PlaceFinder::keep(std::optional<Place> place) {
  if (!place) return false;
  place->amplitude = response_.amplitude(place->at).value;
  found_.list.push_back(std::move(*place));
  return true;
}

void PlaceFinder::tell_later(int &count, BranchEvent::Kind kind, const std::string &text, double parameter,
                             double amplitude) {
  untold_.push_back(
      [this, kind, text, parameter, amplitude, &count] { report_.event(count, kind, text, parameter, amplitude); });
}

// values: of f at both ends.
std::optional<Place> PlaceFinder::locate(Place::Kind kind, std::array<double, 2> values, const Measured &f) {
  return placed(locator_.within(span_.normal, span_.step, values, f), kind);
}

// What cannot be located in a kink is the one of both ends that lies `beyond`, farther on or higher. values: of f
// there.
Place PlaceFinder::in_kink(Place::Kind kind, bool beyond, std::array<double, 2> values, const Measured &f) {
  const long before = report_.counts.newton;
  std::optional<Located> place = locator_.in_kink(span_.step, values, f);
  found_.newton_at_kinks += report_.counts.newton - before;
  if (place) return {std::move(*place), kind};
  return beyond ? place_at(response_.curve(), span_.trial, kind, span_.step)
                : place_at(response_.curve(), span_.here, kind, 0);
}

// Two corners closer than a step may have two turning points between them that its ends do not show: then the parameter
// gains less than by a rate that changes steadily from one end to the other, and points in between are asked.
bool PlaceFinder::hides_folds(double rate, double next) const {
  const double gained = (span_.trial.parameter - span_.here.parameter) / span_.step,
               missing = ((rate + next) / 2 - gained) * (rate > 0 ? 1 : -1);
  return rate * next > 0 && missing > uneven * std::max(std::abs(rate), std::abs(next));
}

std::vector<std::pair<double, CurvePoint>> PlaceFinder::points_between() {
  std::vector<std::pair<double, CurvePoint>> between;
  for (int i = 1; i < pieces; ++i) {
    CurvePoint s = response_.curve().point();
    check(VecAXPBYPCZ(s.y, 1 - double(i) / pieces, double(i) / pieces, 0, span_.here.y, span_.trial.y),
          "looking for turning points");
    if (response_.curve().solve_across(span_.normal, s, {false, step_limits.most_newton}))
      between.emplace_back(i * span_.step / pieces, std::move(s));
  }
  return between;
}

// Of those that cannot be located it is told that they are there.
void PlaceFinder::find_folds() {
  const Measured rate_of = [&](CurvePoint &s) { return response_.system().parameter_in(s.t); };
  const auto rate_in = [&](const CurvePoint &s) { return response_.system().parameter_in(s.t); };
  const double rate = rate_in(span_.here), next = rate_in(span_.trial);
  if (std::max(std::abs(rate), std::abs(next)) <= still / range_.unit) return;
  if (span_.at_kink) {
    const bool rises = (span_.trial.parameter - span_.here.parameter) * rate > 0;
    if (rate * next < 0) keep(in_kink(Place::Kind::fold, rises, {rate, next}, rate_of));
    return;
  }
  std::vector<std::pair<double, CurvePoint>> between;
  if (hides_folds(rate, next)) between = points_between();
  std::vector<Bound> bounds{{0, span_.here.y, rate, span_.here.t}};
  for (auto &[along, s] : between) bounds.push_back({along, s.y, rate_of(s), s.t});
  bounds.push_back({span_.step, span_.trial.y, next, span_.trial.t});
  for (std::size_t i = 1; i < bounds.size(); ++i) {
    if (bounds[i - 1].value * bounds[i].value >= 0) continue;
    if (!keep(placed(locator_.between(span_.normal, bounds[i - 1], bounds[i], rate_of), Place::Kind::fold)))
      ++found_.unlocated_folds;
  }
  for (int i = 0; i < found_.unlocated_folds; ++i)
    tell_later(report_.counts.folds, BranchEvent::Kind::fold, "turning point, not located", span_.here.parameter);
}

// Of the step's cubic, with its derivative for a tangent.
CurvePoint PlaceFinder::on_cubic(int part) {
  const double s = double(part) / looked_at, left = 1 - s, chord = response_.curve().chord(span_.here.y, span_.trial.y),
               from = chord / plain_length(span_.here.t), to = chord / plain_length(span_.trial.t);
  CurvePoint at = response_.curve().point();
  check(VecWAXPY(at.t, -1, span_.here.y, span_.trial.y), "looking for maxima");
  check(VecWAXPY(at.y, s * s * (3 - 2 * s), at.t, span_.here.y), "looking for maxima");
  check(VecAXPBYPCZ(at.y, from * s * left * left, -to * s * s * left, 1, span_.here.t, span_.trial.t),
        "looking for maxima");
  check(VecAXPBYPCZ(at.t, from * left * (1 - 3 * s), to * s * (3 * s - 2), 6 * s * left, span_.here.t, span_.trial.t),
        "looking for maxima");
  return at;
}

// Of the amplitude: at both ends, and on the cubic of a smooth curve in between.
std::vector<double> PlaceFinder::slopes_within() {
  std::vector<double> slopes{span_.amplitude.slope};
  for (int part = 1; part < looked_at && response_.curve().problem.is_smooth(); ++part)
    slopes.push_back(response_.amplitude(on_cubic(part)).slope);
  slopes.push_back(span_.next.slope);
  return slopes;
}

std::optional<std::pair<double, CurvePoint>> PlaceFinder::on_curve(int part) {
  ResponseCurve &curve = response_.curve();
  CurvePoint s = on_cubic(part);
  if (!curve.solve_across(span_.normal, s, {false, step_limits.most_newton})) return std::nullopt;
  const double along = curve.plane(span_.normal, s.y) - curve.plane(span_.normal, span_.here.y);
  return std::pair{along, std::move(s)};
}

// Where the cubic has a maximum that the ends of the step do not show, if the curve has one.
bool PlaceFinder::find_peak_in(int part, const Measured &slope) {
  Bound a{0, span_.here.y, span_.amplitude.slope, span_.here.t},
      b{span_.step, span_.trial.y, span_.next.slope, span_.trial.t};
  std::optional<std::pair<double, CurvePoint>> from, to;
  const auto bound = [&](auto &on, int at, Bound &end) {
    if (at == 0 || at == looked_at) return true;
    if (!(on = on_curve(at))) return false;
    end = {on->first, on->second.y, slope(on->second), on->second.t};
    return true;
  };
  return bound(from, part, a) && bound(to, part + 1, b) && a.along < b.along && a.value > 0 && b.value < 0 &&
         keep(placed(locator_.between(span_.normal, a, b, slope), Place::Kind::peak));
}

// What is watched may be the motion of whatever moves most: one may pass its maximum, and another take over and rise.
void PlaceFinder::find_peaks() {
  const Amplitude &now = span_.amplitude, &next = span_.next;
  const Measured slope = [&](CurvePoint &s) { return response_.amplitude(s).slope; };
  const bool shown = now.slope > 0 && next.slope < 0;
  if (span_.at_kink) {
    if (shown) keep(in_kink(Place::Kind::peak, next.value > now.value, {now.slope, next.slope}, slope));
    return;
  }
  const std::vector<double> slopes = slopes_within();
  std::vector<int> maxima;
  for (std::size_t i = 1; i < slopes.size(); ++i)
    if (slopes[i - 1] > 0 && slopes[i] < 0) maxima.push_back(static_cast<int>(i) - 1);
  bool found = false;
  if (!shown || maxima.size() > 1)
    for (const int part : maxima) found = find_peak_in(part, slope) || found;
  if (shown && !found && !keep(locate(Place::Kind::peak, {now.slope, next.slope}, slope)))
    tell_later(report_.counts.peaks, BranchEvent::Kind::peak, "maximum, not located", span_.here.parameter, now.value);
}

// Also where the amplitude is below it again at the end of the step.
void PlaceFinder::find_limit() {
  const double now = span_.amplitude.value;
  if (!(limit_ > 0 && now < limit_)) return;
  const Measured above = [&](CurvePoint &s) { return response_.amplitude(s).value - limit_; };
  const auto keep_before = [&](const CurvePoint &end, double along, double value) {
    const Bound from{0, span_.here.y, now - limit_, span_.here.t}, to{along, end.y, value - limit_, end.t};
    if (!keep(placed(locator_.between(span_.normal, from, to, above), Place::Kind::limit)))
      keep(place_at(response_.curve(), end, Place::Kind::limit, along));
  };
  for (const Place &place : found_.list)
    if (place.kind == Place::Kind::peak && place.amplitude >= limit_ && !span_.at_kink)
      return keep_before(located_at(response_.curve(), place.at, place.along).at, place.along, place.amplitude);
  if (span_.next.value >= limit_) keep_before(span_.trial, span_.step, span_.next.value);
}

// At a turning point, if there is one since the last point that was certain, else by bisection where the largest
// exponent passes zero, unless uncertain points lie between.
void PlaceFinder::find_stability_change() {
  for (const Place &place : found_.list)
    if (place.kind == Place::Kind::fold) stability_.folded({place.at.parameter, place.amplitude});
  const auto change = stability_.go_to(span_.trial);
  if (!change) return;
  std::optional<Place> place;
  if (!change->fold && span_.at_kink)
    place = place_at(response_.curve(), span_.trial, Place::Kind::stability, span_.step);
  else if (!change->fold && change->growth_before)
    place = locate(Place::Kind::stability, {*change->growth_before, stability_.verdict()->growth},
                   [&](CurvePoint &s) { return stability_.judge(s)->growth; });
  if (place)
    found_.list.push_back(std::move(*place));
  else if (change->fold)
    stability_.tell(report_, change->fold->parameter, change->fold->amplitude);
  else
    stability_.tell(report_, span_.here.parameter, span_.amplitude.value);
}

// Within each piece between turning points the parameter is monotone.
void PlaceFinder::find_wanted() {
  std::vector<PieceEnd> ends{{span_.here, 0}};
  for (const Place &place : found_.list)
    if (place.kind == Place::Kind::fold) ends.push_back({place.at, place.along});
  ends.push_back({span_.trial, span_.step});
  std::vector<Place> wanted;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    if (!find_wanted(ends[i - 1], ends[i], wanted)) return;
    if (!wanted.empty() && wanted.back().kind == Place::Kind::last) break;
  }
  for (Place &place : wanted) found_.list.push_back(std::move(place));
  std::sort(found_.list.begin(), found_.list.end(), in_order);
}

// Solutions exactly at the values wanted, and at the end of the range.
bool PlaceFinder::find_wanted(const PieceEnd &from, const PieceEnd &to, std::vector<Place> &wanted) {
  using Kind = Place::Kind;
  const CurvePoint &a = from.at, &b = to.at;
  const bool ends = range_.ends_between(a.parameter, b.parameter);
  for (const double value : range_.passed(a.parameter, b.parameter)) {
    Place place{{0, response_.curve().point()}, ends && value == range_.to ? Kind::last : Kind::wanted};
    if (solve_wanted(a, b, value, place)) {
      if (span_.at_kink)
        place.along = from.along + (value - a.parameter) / (b.parameter - a.parameter) * (to.along - from.along);
      place.amplitude = response_.amplitude(place.at).value;
      wanted.push_back(std::move(place));
    } else if (place.kind == Kind::last) {
      found_.complete = false;
      found_.why_incomplete = "no solution exactly at the end of the sweep: " + place.at.newton.why;
      return false;
    } else {
      tell_later(report_.counts.missed, BranchEvent::Kind::missed,
                 "no solution at this " + response_.parameter_name() + " of " + response_.at_key() + ": " +
                     place.at.newton.why,
                 value);
    }
  }
  return true;
}

bool PlaceFinder::solve_wanted(const CurvePoint &a, const CurvePoint &b, double value, Place &place) {
  const double part = (value - a.parameter) / (b.parameter - a.parameter);
  check(VecWAXPY(place.at.y, -1, a.y, b.y), "interpolating");
  check(VecAYPX(place.at.y, part, a.y), "interpolating");
  ResponseCurve &curve = response_.curve();
  if (!curve.solve_at(value, place.at)) return false;
  if (b.parameter < a.parameter) turn(place.at);
  place.along = curve.plane(span_.normal, place.at.y) - curve.plane(span_.normal, span_.here.y);
  return true;
}

} // namespace dovetail
