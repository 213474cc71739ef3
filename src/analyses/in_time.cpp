// Where harmonic balance winds, or has no solution with the harmonics that there may be: periodic motions followed in
// time, and shown by their coefficients.
#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/follower.hpp"
#include "stability/growth.hpp"

namespace dovetail {
namespace {

constexpr double balanced_again = 0.05; // of the sweep, until harmonic balance is tried again
constexpr double as_before = 0.05;      // by which harmonic balance may differ, of the motion, to go on with it
constexpr double accuracy = 2e-5;       // of growth, where multipliers near 1 are known to 1e-4
constexpr double close = 1e-6;          // arc length, for tangents

} // namespace

// here_ becomes that motion, with as many harmonics as the closed contact wants; the curve is followed in time from
// there.
bool Follower::begin_in_time(const DenseModel &model, const SteadyState &steady, double omega) {
  // where no contact opens there is no labyrinth, and what harmonic balance lacks is not harmonics
  if (system_->layout().dofs() > most_followed || !settings_.adaptive || !may(Strategy::in_time) || !steady.opens)
    return false;
  auto orbit = std::make_unique<OrbitCurve>(model, omega, unit_);
  const bool found = orbit->begin(steady.end, direction_);
  summary_.counts.newton += orbit->newton();
  if (!found) return false;
  orbit_ = std::move(orbit);
  const int H = std::max(asked_for_, ample_harmonics(omega, 1));
  if (H != system_->harmonics() ||
      !curve_->problem.is_smooth()) { // exactly: samples that do for the case's harmonics do not for these
    adopt(std::make_unique<HarmonicSystem>(*system_, H, exactly));
  }
  show(orbit_->here(), here_);
  cluster_.forget();
  balanced_at_ = omega;
  return true;
}

bool Follower::first_in_time(double omega) {
  if (system_->layout().dofs() > most_followed || !may(Strategy::in_time) || interrupted()) return false;
  IntegrationSettings settings{system_->harmonics()};
  settings.periods = most_periods;
  const DenseModel model = dense_model(*system_);
  const SteadyState steady = steady_state(model, omega, {}, settings);
  return steady.settled && begin_in_time(model, steady, omega);
}

// s as a point of the results; what is missing in its harmonics is its error.
void Follower::show(OrbitCurve::PlacePtr place, CurvePoint &s) {
  constexpr const char *doing = "showing a motion";
  const int H = system_->harmonics(), instants = instants_for(H);
  const Motion motion = orbit_->motion(*place, instants);
  const std::vector<double> coefficients = coefficients_of(motion, H);
  std::vector<double> slope = coefficients_of(orbit_->motion(*place, instants, close), H);
  for (std::size_t i = 0; i < slope.size(); ++i) slope[i] = (slope[i] - coefficients[i]) / close;
  set_coefficients(system_->layout(), coefficients, s.y), set_coefficients(system_->layout(), slope, s.t);
  s.parameter = orbit_->omega(*place), s.sign = 0;
  set_parameter(s.y, s.parameter), set_parameter(s.t, orbit_->rate(*place));
  check(VecScale(s.t, 1 / curve_->norm.length(s.t)), doing);
  const UniqueVec r = system_->unknowns();
  system_->residual(s.y, r);
  s.newton = {};
  s.newton.converged = true, s.newton.newton = orbit_->newton();
  check(VecNorm(r, NORM_2, &s.newton.residual), doing);
  s.data = curve_->problem.describe();
  ResponseData &data = data_of(s);
  double whole = 0, shown = 0; // mean squares without the means
  const std::size_t width = coefficients.size() / motion.dofs;
  for (int i = 0; i < motion.dofs; ++i) {
    const double mean = coefficients[i * width] / 2;
    for (int j = 0; j < motion.instants; ++j) whole += std::pow(motion.at(j)[i] - mean, 2) / motion.instants;
    for (std::size_t k = 1; k < width; ++k) shown += std::pow(coefficients[i * width + k], 2) / 2;
  }
  const double missing = whole > 0 ? std::sqrt(std::max(0.0, 1 - shown / whole)) : 0;
  const bool modes_known = system_->scaled().model.reduced.left_out.squares.empty(); // nothing to tell of them
  data.error = ErrorEstimate{missing, 0, modes_known ? 0 : std::nan(""), {}};
  data.motion = std::move(place);
}

// One that was searched, if it was found.
bool Follower::show_if(OrbitCurve::PlacePtr place, CurvePoint &s) {
  summary_.counts.newton += orbit_->newton();
  progress_.spare(orbit_->newton()), cluster_.spare(orbit_->newton()); // that is no winding
  if (!place) {
    s.newton = {};
    s.newton.newton = orbit_->newton(), s.newton.why = "no periodic motion was found in time";
    return false;
  }
  show(std::move(place), s);
  return true;
}

// One step in time, with what lies within.
Follower::Outcome Follower::advance_in_time() {
  const bool found = orbit_->step();
  summary_.counts.newton += orbit_->newton();
  if (!found) return end(End::stalled, "no step along the periodic motions in time converges");
  show(orbit_->here(), trial_);
  check(VecWAXPY(predicted_, -1, here_.y, trial_.y), "measuring a step");
  const double way = orbit_->way(), plain = plain_length(predicted_) / way;
  const Outcome go = pass(here_.t, way, plain, orbit_->cornered());
  if (go == Outcome::refused) return end(End::stalled, refusal_);
  if (go == Outcome::ended) return go;
  if (farther(here_.parameter)) note(farthest_, here_);
  curve_->norm.see(here_.y);
  if (std::abs(here_.parameter - balanced_at_) > balanced_again * unit_) back_to_harmonics();
  return Outcome::on;
}

// On by harmonic balance, with the case's harmonics and samples, if that has nearly the same solution here.
bool Follower::back_to_harmonics() {
  balanced_at_ = here_.parameter;
  auto system = std::make_unique<HarmonicSystem>(*system_, asked_for_, asked_samples_);
  ResponseCurve curve(*system, newton_, unit_, settings_.adaptive, summary_.counts);
  CurvePoint there = curve.point();
  UniqueVec motion = system->unknowns();
  pad(system_->layout(), here_.y, system->layout(), there.y);
  check(VecCopy(there.y, motion), "going back to harmonic balance");
  if (!curve.solve_at(here_.parameter, there, impatient_newton)) return false;
  check(VecAXPY(motion, -1, there.y), "going back to harmonic balance");
  const Layout &layout = system->layout();
  if (!(swing_product(layout, motion, motion) < as_before * as_before * swing_product(layout, there.y, there.y)))
    return false;
  const bool falls = !orbit_->here()->rises();
  orbit_.reset();
  adopt(std::move(system));
  here_ = std::move(there);
  if (falls) turn(here_);
  notify(BranchEvent::Kind::harmonics,
         "from here on by harmonic balance again, with " + std::to_string(asked_for_) + " harmonics", here_.parameter);
  begin_amplitude();
  verdict_ = judge(here_);
  stand_anew();
  return true;
}

std::optional<Stability> Follower::judge(const CurvePoint &s) {
  if (!stability_ && !large_stability_) return std::nullopt;
  if (orbit_) return conclude_alone(largest_of(orbit_->multipliers(*data_of(s).motion)), accuracy);
  return stability_ ? stability_->judge(all_coefficients(system_->layout(), s.y), s.parameter)
                    : large_stability_->judge(s.y);
}

} // namespace dovetail
