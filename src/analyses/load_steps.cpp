#include "analyses/load_steps.hpp"

#include <algorithm>
#include <utility>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "raising the load";
constexpr double first_part = 1.0 / 32; // of the load, tried first
constexpr int most_tries = 40;          // steps, and steps that failed
constexpr int few_newton = 5;           // iterations: a step that took no more may be doubled
constexpr double longest = 1;           // step, in parts of the largest motion so far

} // namespace

// Each guess lies on the tangent: at first that of the joint as it is at rest.
bool solve_by_load_steps(const Response &response, const HarmonicSystem &system, double value, Vec y) {
  const std::unique_ptr<HarmonicSystem> loaded = response.with(system.harmonics());
  if (!loaded->set(value)) return false;
  const Setting whole = loaded->setting();
  loaded->vary({*parameter_named("force"), whole, system.parameter().changes_joint()}, system.preload());
  ResponseCurve curve = response.curve_of(*loaded, whole.load);
  CurvePoint here = curve.point(), next = curve.point();
  const UniqueVec along = loaded->unknowns();
  set_parameter(along, 1);
  if (!curve.tangent_at(here.y, along, here.t, here.sign)) return false;
  const auto across = [&](double step) {
    StepEffort effort = hurried;
    effort.step = step;
    return curve.solve_across(here.t, next, effort) && next.parameter < whole.load;
  };
  double step = first_part * whole.load / parameter_of(here.t);
  for (int tries = 0; tries < most_tries; ++tries) {
    const double rest = (whole.load - here.parameter) / parameter_of(here.t);
    const bool last = rest > 0 && step >= rest;
    check(VecWAXPY(next.y, last ? rest : step, here.t, here.y), doing);
    if (!(last ? curve.solve_at(whole.load, next, hurried) : across(step))) {
      step /= 2;
      continue;
    }
    if (last) {
      check(VecCopy(next.y, y), doing);
      return true;
    }
    std::swap(here, next);
    curve.norm.see(here.y);
    const double length = curve.norm.length(here.t); // 1, before the metric saw it
    check(VecScale(here.t, 1 / length), doing);
    step = std::min(length * (here.newton.newton <= few_newton ? 2 * step : step), longest);
  }
  return false;
}

} // namespace dovetail
