// What recovery tries, for the response curve: RecoveryContext's.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "analyses/follower.hpp"
#include "problems/needed_harmonics.hpp"
#include "transient/steady_state.hpp"

namespace dovetail {
namespace {

constexpr double most_change = 0.1;    // by other harmonics, where 1 is the largest motion so far
constexpr double most_unknowns = 1500; // of a system whose harmonics are raised
constexpr int most_integrated = 300;   // dofs
constexpr int most_periods = 4000;     // little damping takes many
constexpr double first_skip = 0.01;    // of the sweep, left out when a curve is left again, twice as much each time

std::string ahead_in_words(const std::string &parameter, double part) { // of the sweep
  const long percent = std::lround(100 * part);
  return percent < 1 ? "the next " + parameter
                     : "a " + parameter + " " + std::to_string(percent) + " % of the sweep ahead";
}

} // namespace

bool Follower::interrupted() {
  const bool yes = observer_.interrupted && observer_.interrupted();
  if (yes) summary_.end = End::interrupted, summary_.why = "interrupted";
  return yes;
}

// False where nothing helps, or the user wants to stop, and then the curve stands where it stood.
bool Follower::recovers(Failure::Kind kind, const std::string &why, double from) {
  before_jump_ = here_.parameter;
  return recover(settings_.strategies, {kind, why, from}, *this);
}

// The curve is left where it had come farthest, for what lies ahead: the farther, the more often it was left before.
bool Follower::leave(const std::string &why) {
  const bool back = !stands_farthest();
  if (back) std::swap(here_, *farthest_);
  const double left = here_.parameter;
  const int times = progress_.times_left();
  const double skipped = times > 0 ? std::min(first_skip * std::pow(2, times), 1.0) : 0;
  const bool found = recovers(Failure::Kind::lost, why, left + direction_ * skipped * unit_);
  if (found) {
    farthest_.reset();
    progress_.left(left);
  } else if (back) {
    std::swap(here_, *farthest_);
  }
  if (!found && summary_.end != End::interrupted) summary_.why = why;
  return found;
}

// From rest, or from here_.y as it is.
bool Follower::first_point(double omega) {
  starting_ = true, how_.clear();
  bool found = curve_->solve_at(omega, here_);
  if (!found) {
    summary_.why = "no solution was found at the first " + parameter_name() + ": " + here_.newton.why + difference();
    found = recovers(Failure::Kind::no_start, summary_.why, omega);
    how_ = "Newton does not converge from rest; the first point comes from " + how_;
  }
  starting_ = false;
  return found;
}

bool Follower::begin_at(double from, double to) {
  const auto sweep = std::pair(settings_.from, settings_.to);
  settings_.from = from, settings_.to = to;
  direction_ = to < from ? -1 : 1;
  integrating_ = 0;
  check(VecSet(here_.y, 0), "beginning elsewhere");
  if (first_point(from)) return true;
  std::tie(settings_.from, settings_.to) = sweep;
  direction_ = settings_.to < settings_.from ? -1 : 1;
  return false;
}

bool Follower::solve_at(double omega) {
  check(VecCopy(here_.y, trial_.y), "predicting");
  bool found = curve_->solve_at(omega, trial_);
  if (!found) { // from rest
    check(VecSet(trial_.y, 0), "predicting");
    found = curve_->solve_at(omega, trial_);
  }
  if (found) std::swap(here_, trial_);
  return found;
}

// Work that integration may still take: where it has led on it may again.
double Follower::integration_left() const {
  return (2 + 2 * summary_.counts.integrations) * settings_.work * IntegrationSettings().work - integrating_;
}

bool Follower::integrate_at(double omega, double share) {
  if (system_->layout().dofs() > most_integrated || !system_->scaled().damping.acts_in_time() ||
      !(integration_left() > 0))
    return false;
  if (!system_->set(omega)) return false;
  IntegrationSettings settings{std::max(system_->harmonics(), needed_harmonics(omega))};
  settings.periods = most_periods;
  settings.work = std::min(settings.work, share * integration_left());
  std::vector<double> start; // rest, for a first point
  if (!starting_) start = all_coefficients(system_->layout(), here_.y);
  const SteadyState steady = steady_state(dense_model(*system_), system_->setting().omega, start, settings);
  integrating_ += steady.work;
  if (!steady.settled) return false;
  how_ = "time integration";
  set_coefficients(system_->layout(), steady.coefficients, trial_.y);
  if (!curve_->solve_at(omega, trial_)) return solve_finer(steady, omega);
  std::swap(here_, trial_);
  return true;
}

// Where a motion that integration finds is no solution for these harmonics, with more of them.
bool Follower::solve_finer(const SteadyState &steady, double omega) {
  const int needed = needed_harmonics(omega), H = system_->harmonics();
  for (int more = 2 * H; more < 2 * needed; more *= 2) {
    const int tried = std::min(more, needed);
    auto system = std::make_unique<HarmonicSystem>(*system_, tried, system_->samples());
    ResponseCurve curve(*system, newton_, unit_, settings_.adaptive, summary_.counts);
    CurvePoint s = curve.point();
    set_coefficients(system->layout(), steady.coefficients, s.y);
    if (curve.solve_at(omega, s)) {
      adopt(std::move(system));
      here_ = std::move(s);
      lent_at_ = omega, unchanged_ = 0;
      ++summary_.counts.harmonics;
      how_ += ", with " + std::to_string(tried) + " harmonics; the closed contact wants " + std::to_string(needed);
      return true;
    }
    if (!steady.opens) return false; // what is missing is not harmonics
  }
  return false;
}

// Fewer harmonics: from one to the next its motion is guess enough.
bool Follower::solve_by_simpler(double omega) {
  if (system_->harmonics() == 1) return false;
  std::vector<double> q = all_coefficients(system_->layout(), here_.y);
  for (int H = 1; H < system_->harmonics(); H = std::max(H + 1, static_cast<int>(std::lround(1.4 * H)))) {
    HarmonicSystem simpler(*system_, H, system_->samples());
    ResponseCurve curve(simpler, newton_, unit_, settings_.adaptive, summary_.counts);
    CurvePoint s = curve.point();
    set_coefficients(simpler.layout(), q, s.y);
    if (!curve.solve_at(omega, s)) return false;
    q = all_coefficients(simpler.layout(), s.y);
  }
  how_ = "fewer harmonics";
  set_coefficients(system_->layout(), q, trial_.y);
  const bool found = curve_->solve_at(omega, trial_);
  if (found) std::swap(here_, trial_);
  return found;
}

// By the rule that H Omega should reach twice the frequency of the closed contact; as far as size allows.
int Follower::needed_harmonics(double value) {
  const Layout &layout = system_->layout();
  if (layout.dofs() > most_integrated) return 0;
  if (!system_->set(value)) return 0;
  const double wanted = std::ceil(2 * closed_contact_frequency(dense_model(*system_)) / system_->setting().omega);
  return static_cast<int>(std::min(wanted, (most_unknowns / static_cast<double>(layout.dofs()) - 1) / 2));
}

void Follower::take_system(HarmonicSystem &system) {
  const double largest = metric().largest_motion();
  const std::vector<double> of_dofs = metric().largest_of_dofs();
  if (farthest_) { // where the branch may be left: no solution any more, but near one
    UniqueVec y = system.unknowns(), t = system.unknowns();
    pad(system_->layout(), farthest_->y, system.layout(), y);
    pad(system_->layout(), farthest_->t, system.layout(), t);
    farthest_->y = std::move(y), farthest_->t = std::move(t);
  }
  system_ = &system;
  response_ = std::make_unique<ResponseCurve>(system, newton_, unit_, settings_.adaptive, summary_.counts);
  take_curve(*response_);
  metric().restore(largest, of_dofs);
  meter_ = std::make_unique<AmplitudeMeter>(system.layout(), settings_.watched);
  if (large_stability_) begin_stability();
  if (estimator_) estimator_->match(system);
}

// In place of the one given, or of the last such one, which goes only then.
void Follower::adopt(std::unique_ptr<HarmonicSystem> system) {
  take_system(*system);
  std::swap(changed_, system);
}

// The same point and direction in another system; everything stays as it is if there is none. `most`: iterations, and
// no second try with a line search.
bool Follower::rebuild(std::unique_ptr<HarmonicSystem> system, int most) {
  ResponseCurve curve(*system, newton_, unit_, settings_.adaptive, summary_.counts);
  curve.metric().restore(metric().largest_motion(), metric().largest_of_dofs());
  CurvePoint there = curve.point();
  UniqueVec t = system->unknowns(), padded = system->unknowns();
  pad(system_->layout(), here_.y, system->layout(), there.y);
  pad(system_->layout(), here_.t, system->layout(), t);
  check(VecCopy(there.y, padded), "changing harmonics");
  const bool stay = summary_.counts.points == 0; // the first point lies where it was asked for
  bool found =
      !stay && (curve.solve_across(t, there, {false, most}) || (most == 0 && curve.solve_across(t, there, {true})));
  const auto passed = [&](double w) {
    return (w - here_.parameter) * (w - there.parameter) <= 0 && w != here_.parameter;
  };
  if (!found || passed(settings_.to) || std::any_of(settings_.at.begin(), settings_.at.end(), passed)) {
    check(VecCopy(padded, there.y), "changing harmonics"); // what is wanted there must not get lost
    if (found || stay) found = curve.solve_at(here_.parameter, there);
    if (curve.norm.product(there.t, t) < 0) turn(there);
  }
  if (!found) return false;
  check(VecAXPY(padded, -1, there.y), "changing harmonics");
  if (!stay && curve.norm.length(padded) > most_change) return false; // that is another branch
  adopt(std::move(system));
  here_ = std::move(there);
  begin_amplitude();
  control_.set(step_limits.after_jump);
  limit_step();
  return true;
}

void Follower::go_on(const Failure &failure, bool integrated) {
  const double next = here_.parameter, reached = farther(before_jump_) ? before_jump_ : farthest_->parameter;
  for (const double w : settings_.at)
    if ((w - reached) * (w - next) < 0) {
      ++summary_.counts.missed;
      notify(BranchEvent::Kind::missed, "this " + parameter_name() + " of " + at_key() + " is left out by a leap", w);
    }
  if (direction_ < 0) turn(here_);
  ++(integrated ? summary_.counts.integrations : summary_.counts.leaps);
  notify(integrated ? BranchEvent::Kind::integration : BranchEvent::Kind::leap,
         "the curve could not be followed here (" + failure.why + "): went on from the " +
             (integrated ? "steady state that time integration finds" : "solution") + " at " +
             ahead_in_words(parameter_name(), std::abs(next - before_jump_) / unit_) + "; the branch may have changed",
         next);
  land();
  if (next == settings_.to) end(End::arrived);
}

// here_ is a point that no step has led to: it is given, steps begin short, and what comes does not hang together with
// the points before.
void Follower::land() {
  begin_amplitude();
  verdict_ = judge(here_);
  report(here_, arclength_, verdict_ ? &*verdict_ : nullptr);
  curve_->norm.see(here_.y);
  measure_anew();
  retraced_.leave();
  retraced_.add(curve_->problem, here_.y, here_.t, curve_->norm.largest_motion());
  control_.set(step_limits.after_jump);
  limit_step();
}

// Which contact point did something else at the last iterate than at the last point, in words.
std::string Follower::difference() const {
  if (system_->adrift())
    return "; the body is held by its joint alone, and its contacts are open, or slip, all through the period: nothing "
           "holds its mean position, it walks or flies off, unless it is pressed on harder or something else holds it";
  static const std::vector<Activity> none;
  const std::vector<Activity> &then = here_.data ? data_of(here_).activity : none, &now = system_->activity();
  struct {
    double size;
    int rank;
  } most{0, system_->layout().rank};
  std::size_t which = 0;
  for (std::size_t p = 0; p < now.size() && p < then.size(); ++p) {
    const double size = std::abs(now[p].open - then[p].open) + std::abs(now[p].slip - then[p].slip);
    if (size > most.size) most.size = size, which = p;
  }
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, system_->layout().comm);
  if (most.size == 0) return "";
  char words[200] = "";
  if (most.rank == system_->layout().rank)
    std::snprintf(words, sizeof words,
                  "; contact point %d is open for %.3g %% of the period at the last point and for %.3g %% where Newton "
                  "stopped, slips for %.3g %% and %.3g %%",
                  static_cast<int>(system_->layout().own_points.begin + which) + 1, 100 * then[which].open,
                  100 * now[which].open, 100 * then[which].slip, 100 * now[which].slip);
  MPI_Bcast(words, sizeof words, MPI_CHAR, most.rank, system_->layout().comm);
  return words;
}

} // namespace dovetail
