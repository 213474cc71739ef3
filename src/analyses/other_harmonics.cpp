#include "analyses/other_harmonics.hpp"

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "changing harmonics";
constexpr double most_change = 0.1; // by other harmonics, where 1 is the largest motion so far

} // namespace

UniqueVec padded(const Layout &layout, Vec y, const HarmonicSystem &system) {
  UniqueVec out = system.unknowns();
  pad(layout, y, system.layout(), out);
  return out;
}

std::optional<CurvePoint> in_other_harmonics(const Response &response, HarmonicSystem &system, const SweepRange &range,
                                             const CurvePoint &here, const MoveLimits &limits) {
  ResponseCurve curve = response.curve_of(system);
  curve.metric().restore(response.metric().largest_motion(), response.metric().largest_of_dofs());
  CurvePoint there = curve.point();
  const UniqueVec guess = padded(response.layout(), here.y, system), t = padded(response.layout(), here.t, system);
  check(VecCopy(guess, there.y), doing);
  const auto across = [&] {
    return curve.solve_across(t, there, {false, limits.most_newton}) ||
           (limits.most_newton == 0 && curve.solve_across(t, there, {true}));
  };
  bool found = !limits.same_parameter && across();
  if (!found || range.passes(here.parameter, there.parameter)) { // what is wanted there must not get lost
    check(VecCopy(guess, there.y), doing);
    if (found || limits.same_parameter) found = curve.solve_at(here.parameter, there);
    if (curve.norm.product(there.t, t) < 0) turn(there);
  }
  if (!found) return std::nullopt;
  check(VecAXPY(guess, -1, there.y), doing);
  if (!limits.same_parameter && curve.norm.length(guess) > most_change) return std::nullopt;
  return there;
}

} // namespace dovetail
