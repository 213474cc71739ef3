// Where harmonic balance winds, or has no solution with the harmonics that there may be: periodic motions followed in
// time, and shown by their coefficients.
#include <algorithm>
#include <cmath>
#include <utility>

#include "continuation/follower.hpp"
#include "stability/growth.hpp"

namespace dovetail {
namespace {

constexpr PetscInt most_followed = 48; // dofs: a step takes some three periods for each
constexpr double as_before = 0.05;     // by which harmonic balance may differ, of the motion, to go on with it
constexpr double accuracy = 2e-5;      // of growth, where multipliers near 1 are known to 1e-4
constexpr int least_instants = 1024;

// Where no contact opens there is no labyrinth, and what harmonic balance lacks is not harmonics.
bool opens(const DenseModel &model, const Motion &motion) {
  for (int p = 0; p < model.points; ++p) {
    const double play = model.standstill[p].x[2] - model.contact[p].gap;
    for (int j = 0; j < motion.instants && model.contact[p].law != Law::bilateral; ++j)
      if (motion.at(j)[model.modes + 3 * p + 2] + play < 0) return true;
  }
  return false;
}

} // namespace

int Follower::instants() const {
  int instants = least_instants;
  while (instants < 16 * system_->harmonics()) instants *= 2;
  return instants;
}

// here_ becomes that motion, with as many harmonics as the closed contact wants; the curve is followed in time from
// there.
bool Follower::begin_in_time(const DenseModel &model, const SteadyState &steady, double omega) {
  if (system_->layout().dofs() > most_followed || !settings_.adaptive || settings_.steps_only) return false;
  auto orbit = std::make_unique<OrbitCurve>(model, omega, omega_unit_);
  const bool found = orbit->begin(steady.q, steady.v, steady.w, direction_);
  summary_.counts.newton += orbit->newton();
  if (!found || !opens(model, orbit->motion(instants()))) return false;
  orbit_ = std::move(orbit);
  const int H = std::max(asked_for_, ample_harmonics(omega, 1));
  if (H != system_->harmonics() || !exact()) { // exactly: samples that do for the case's harmonics do not for these
    adopt(std::make_unique<HarmonicSystem>(*system_, H, exactly));
  }
  show(orbit_->motion(instants()), omega, here_);
  bends_.clear(), crowded_.clear();
  balanced_at_ = omega;
  return true;
}

bool Follower::first_in_time(double omega) {
  if (system_->layout().dofs() > most_followed || interrupted()) return false;
  IntegrationSettings settings{system_->harmonics()};
  settings.periods = most_periods;
  const DenseModel model = dense_model(*system_);
  const SteadyState steady = steady_state(model, omega, {}, settings);
  return steady.settled && begin_in_time(model, steady, omega);
}

// s as a point of the results; what is missing in its harmonics is its error.
void Follower::show(const Motion &motion, double omega, Station &s) {
  constexpr const char *doing = "showing a motion";
  const std::vector<double> coefficients = coefficients_of(motion, system_->harmonics());
  set_coefficients(system_->layout(), coefficients, s.y);
  check(VecSet(s.t, 0), doing);
  curve_->set_omega(s.y, omega), curve_->set_omega(s.t, orbit_->rising() < 0 ? -1 : 1);
  s.omega = omega, s.sign = 0;
  const UniqueVec r = system_->unknowns();
  system_->residual(s.y, r);
  s.newton = {};
  s.newton.converged = true, s.newton.newton = orbit_->newton();
  check(VecNorm(r, NORM_2, &s.newton.residual), doing);
  s.activity = system_->activity();
  double whole = 0, shown = 0; // mean squares without the means
  const std::size_t width = coefficients.size() / motion.dofs;
  for (int i = 0; i < motion.dofs; ++i) {
    const double mean = coefficients[i * width] / 2;
    for (int j = 0; j < motion.instants; ++j) whole += std::pow(motion.at(j)[i] - mean, 2) / motion.instants;
    for (std::size_t k = 1; k < width; ++k) shown += std::pow(coefficients[i * width + k], 2) / 2;
  }
  const double missing = whole > 0 ? std::sqrt(std::max(0.0, 1 - shown / whole)) : 0;
  const bool modes_known = system_->scaled().model.reduced.left_out.squares.empty(); // nothing to tell of them
  s.error = ErrorEstimate{missing, 0, modes_known ? 0 : std::nan(""), {}};
}

// One step in time, with the frequencies that are wanted within.
Follower::Go Follower::advance_in_time() {
  const double before = here_.omega;
  const bool found = orbit_->step();
  summary_.counts.newton += orbit_->newton();
  if (!found) return end(End::stalled, "no step along the periodic motions in time converges");
  const double now = orbit_->omega();
  const int newton = orbit_->newton();
  const bool was_outside = beyond_start(before) > 0, outside = beyond_start(now) > 0;
  const auto passed = [&](double w) {
    return !(was_outside && outside) && (w - before) * (w - now) <= 0 && w != before;
  };
  std::vector<double> wanted;
  std::copy_if(settings_.at.begin(), settings_.at.end(), std::back_inserter(wanted), passed);
  if (passed(settings_.to)) wanted.push_back(settings_.to);
  std::sort(wanted.begin(), wanted.end());
  if (now < before) std::reverse(wanted.begin(), wanted.end());
  for (const double w : wanted) {
    Motion motion;
    const bool met = orbit_->motion_at(w, instants(), motion);
    summary_.counts.newton += orbit_->newton();
    if (!met) {
      if (w == settings_.to) return end(End::stalled, "the end of the sweep was passed and not met");
      ++summary_.counts.missed;
      notify(BranchEvent::Kind::missed, "at this frequency of continuation.at no periodic motion was found", w);
      continue;
    }
    show(motion, w, trial_);
    report(trial_, arclength_, nullptr, true);
    if (w != settings_.to) continue;
    here_.omega = w;
    return end(End::arrived);
  }
  show(orbit_->motion(instants()), now, trial_);
  trial_.newton.newton = newton;
  check(VecWAXPY(predicted_, -1, here_.y, trial_.y), "measuring a step");
  arclength_ += plain_length(predicted_);
  std::swap(here_, trial_);
  if (farther(now)) note(farthest_, here_);
  curve_->norm.see(here_.y);
  begin_amplitude();
  verdict_ = judge(here_);
  if (verdict_ && verdict_->verdict != Stability::Verdict::uncertain)
    last_verdict_ = verdict_->verdict == Stability::Verdict::stable;
  if (!outside) {
    report(here_, arclength_, verdict_ ? &*verdict_ : nullptr);
  } else if (!was_outside) {
    notify(BranchEvent::Kind::outside,
           "the curve leaves the sweep at its beginning: points beyond are not stored, the next is where it comes back",
           before);
  } else if (beyond_start(now) > most_beyond * std::min(omega_unit_, settings_.from)) {
    return end(End::turned_back, "the branch turned back, left the sweep at its beginning and did not come back");
  }
  if (settings_.stop_at_amplitude > 0 && amplitude_.value >= settings_.stop_at_amplitude)
    return end(End::amplitude, "stopped at continuation.stop_at_amplitude");
  if (std::abs(now - balanced_at_) > enough_ahead * omega_unit_) back_to_harmonics();
  return Go::on;
}

// On by harmonic balance, with the case's harmonics and samples, if that has nearly the same solution here.
bool Follower::back_to_harmonics() {
  balanced_at_ = here_.omega;
  auto system = std::make_unique<HarmonicSystem>(*system_, asked_for_, asked_samples_);
  Curve curve(*system, newton_, omega_unit_, settings_.adaptive, summary_.counts);
  Station there = curve.station();
  UniqueVec motion = system->unknowns();
  pad(system_->layout(), here_.y, system->layout(), there.y);
  check(VecCopy(there.y, motion), "going back to harmonic balance");
  if (!curve.solve_at(here_.omega, there, impatient_newton)) return false;
  check(VecAXPY(motion, -1, there.y), "going back to harmonic balance");
  const Layout &layout = system->layout();
  if (!(swing_product(layout, motion, motion) < as_before * as_before * swing_product(layout, there.y, there.y)))
    return false;
  const bool falls = orbit_->rising() < 0;
  orbit_.reset();
  adopt(std::move(system));
  here_ = std::move(there);
  if (falls) turn(here_);
  notify(BranchEvent::Kind::harmonics,
         "from here on by harmonic balance again, with " + std::to_string(asked_for_) + " harmonics", here_.omega);
  begin_amplitude();
  verdict_ = judge(here_);
  stand_anew();
  return true;
}

std::optional<Stability> Follower::judge(const Station &s) {
  if (!stability_ && !large_stability_) return std::nullopt;
  if (orbit_) return conclude_alone(largest_of(orbit_->multipliers()), accuracy);
  return stability_ ? stability_->judge(all_coefficients(system_->layout(), s.y), s.omega)
                    : large_stability_->judge(s.y);
}

} // namespace dovetail
