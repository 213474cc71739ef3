// On to the solution at a frequency ahead, or at the other end of the sweep, where the curve does not lead.
#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/follower.hpp"
#include "transient/steady_state.hpp"

namespace dovetail {
namespace {

std::string ahead_in_words(double part) { // of the sweep
  const long percent = std::lround(100 * part);
  return percent < 1 ? "the next frequency" : "a frequency " + std::to_string(percent) + " % of the sweep ahead";
}

} // namespace

// Iterations are: harmonics were raised to many more than the case has.
bool Follower::dear() const { return settings_.tolerance == 0 && system_->harmonics() > 2 * asked_for_; }

Strategy Follower::strategy_of(Way way) {
  switch (way) {
  case Way::newton:
    return Strategy::jump;
  case Way::integration:
    return Strategy::integration;
  case Way::anew:
    return Strategy::restart;
  default:
    return Strategy::multistart;
  }
}

bool Follower::integrates(Way way) { return way == Way::integration || way == Way::scattered; }

// The branch is lost at that frequency: what is left of the sweep, from its end back to there.
bool Follower::from_other_end(const std::string &why, double lost, bool briefly) {
  if (!may(Strategy::other_end) || interrupted() || !settings_.both_ends) return false;
  const int H = orbit_ ? asked_for_ : system_->harmonics(); // in time there may be hundreds
  if (briefly && end_in_vain_ == H) return false;
  settings_.both_ends = briefly; // if it is tried with all that there is, once
  HarmonicSystem *const before = system_;
  std::unique_ptr<HarmonicSystem> other;
  CurvePoint here;
  std::optional<CurvePoint> farthest;
  if (H != before->harmonics()) {
    here = std::move(here_), farthest.swap(farthest_);
    other = std::make_unique<HarmonicSystem>(*before, H, asked_samples_);
    take_system(*other);
    std::swap(changed_, other);
  }
  CurvePoint first = curve_->point();
  UniqueVec rest = system_->unknowns();
  std::string how;
  if (!first_point(settings_.to, rest, first, how, briefly ? Effort::brief : Effort::full)) {
    if (briefly && !interrupted()) end_in_vain_ = H;
    if (H != before->harmonics()) {
      take_system(*before);
      std::swap(changed_, other);
      here_ = std::move(here), farthest.swap(farthest_);
    }
    return false;
  }
  turned_round_ = true;
  orbit_.reset();
  here_ = std::move(first);
  settings_.both_ends = false;
  settings_.from = std::exchange(settings_.to, lost);
  direction_ = -direction_;
  if (direction_ < 0) turn(here_);
  ++summary_.counts.leaps;
  notify(BranchEvent::Kind::leap,
         "the curve could not be followed to the end (" + why +
             "): from here on the rest of the sweep, from its other end back to where it was lost; the branch may be "
             "another one",
         here_.parameter);
  cluster_.forget(), farthest_.reset(), drift_.forget(), progress_.forget();
  progress_.begin(here_.parameter, summary_.counts.newton, direction_);
  cluster_.begin(here_.parameter, summary_.counts.newton);
  begin_amplitude();
  verdict_ = judge(here_);
  report(here_, arclength_, verdict_ ? &*verdict_ : nullptr);
  stand_anew();
  return true;
}

// After a leap: steps begin short, and what comes does not hang together with the points before.
void Follower::stand_anew() {
  curve_->norm.see(here_.y);
  measure_anew();
  drop_anchors();
  retraced_.leave();
  retraced_.add(curve_->problem, here_.y, here_.t, curve_->norm.largest_motion());
  control_.set(step_limits.after_jump);
  limit_step();
}

// Work that the ways on may still take: where integration has led on it may again.
double Follower::integration_left() const {
  return (2 + 2 * summary_.counts.integrations) * settings_.work * brief_work - integrating_;
}

// here_ becomes a solution at that frequency. `share`: of the work left for integration.
bool Follower::arrive_at(double omega, Way way, const DenseModel &model, double share) {
  check(VecCopy(here_.y, trial_.y), "predicting");
  const Layout &layout = system_->layout();
  const bool amply = progress_.times_stayed() > 0 || dear(),
             large = layout.dofs() * layout.width * least_patience > most_wound,
             in_time = amply || orbit_ || (progress_.times_left() > 0 && large);
  SteadyState steady;
  if (integrates(way)) {
    IntegrationSettings settings{
        std::max(system_->harmonics(), amply ? ample_harmonics(omega) : needed_harmonics(omega))};
    settings.periods = most_periods;
    settings.work = way == Way::scattered ? brief_work / 2 : std::min(brief_work, share * integration_left());
    steady = steady_state(model, omega, all_coefficients(system_->layout(), here_.y), settings);
    if (way == Way::integration) integrating_ += steady.work;
    if (!steady.settled) return false;
    if (in_time && begin_in_time(model, steady, omega)) return true;
    if (orbit_) return false; // another frequency rather than hundreds of harmonics again
    set_coefficients(system_->layout(), steady.coefficients, trial_.y);
  }
  UniqueVec rest = system_->unknowns();
  std::string how;
  const bool found = way == Way::anew || way == Way::sown
                         ? first_point(omega, rest, trial_, how, way == Way::sown ? Effort::patient : Effort::full)
                         : curve_->solve_at(omega, trial_, dear() ? impatient_newton : 1);
  if (found)
    std::swap(here_, trial_);
  else if (!integrates(way) || !solve_finer(steady.coefficients, omega,
                                            !steady.opens ? Resort::once
                                            : amply       ? Resort::ample
                                                          : Resort::usual))
    return integrates(way) && !in_time && begin_in_time(model, steady, omega);
  return true;
}

// Frequencies of the sweep after `from`, so far ahead as `most`, of the sweep; where it is sown or scattered, to its
// end. Others each time that the curve has wound on at the same place.
std::vector<double> Follower::aims(Way way, double from, double most) const {
  static const std::vector<double> parts[] = {
      {1e-4, 1e-3, 1e-2, 5e-2}, {1e-3, 1e-2, 5e-2, 0.2, 0.4}, {1e-2, 5e-2, 0.2, 0.4, 0.7, 1}};
  std::vector<double> out;
  if (way >= Way::sown) {
    const double shift = std::fmod(other_places * progress_.times_stayed(), 1.0);
    for (int i = 1; i < seeds; ++i) out.push_back(from + std::pow((i - shift) / seeds, 2) * (settings_.to - from));
    if (!turned_round_) out.push_back(settings_.to); // else the branch was lost there
    return out;
  }
  for (const double part : parts[static_cast<int>(way)]) {
    if (part > most) break;
    out.push_back(from + direction_ * part * std::pow(nearer, progress_.times_stayed()) * unit_);
    if ((out.back() - settings_.to) * direction_ < 0) continue;
    out.back() = settings_.to;
    break;
  }
  return out;
}

// On to the solution at a next frequency of the sweep after `from`, which arc length does not lead to, and say so. So
// far ahead as `most`, of the sweep.
bool Follower::leap(Way way, double from, double most) {
  const bool integrate = integrates(way), small = system_->layout().dofs() <= most_integrated;
  if (!may(strategy_of(way)) || (integrate && !system_->scaled().damping.acts_in_time())) return false;
  int &count = integrate ? summary_.counts.integrations : summary_.counts.leaps;
  if (count >= (integrate ? most_integrations : most_leaps) || (way != Way::newton && !small)) return false;
  if ((way == Way::integration || way == Way::anew) && !(integration_left() > 0)) return false;
  if (!integrate && orbit_) return false;       // with hundreds of harmonics
  if (way == Way::anew && dear()) return false; // takes long, and was in vain
  const std::string reason = refusal_;
  const double before = here_.parameter,
               reached = farther(before) ? before : farthest_->parameter; // frequencies of `at` up to there were met
  DenseModel model;
  if (integrate) model = dense_model(*system_);
  const auto between = [](double w, double a, double b) { return (w - a) * (w - b) < 0; };
  std::vector<double> targets; // before each aim the nearest frequency of `at` up to there
  for (const double next : aims(way, from, most)) {
    double nearest = next;
    for (const double w : settings_.at)
      if (between(w, targets.empty() ? reached : targets.back(), nearest)) nearest = w;
    if (nearest != next) targets.push_back(nearest);
    targets.push_back(next);
  }
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const double next = targets[i];
    if (way >= Way::sown && interrupted()) break;
    if (!arrive_at(next, way, model, 1.0 / static_cast<double>(targets.size() - i))) continue;
    for (const double w : settings_.at)
      if (between(w, reached, next)) {
        ++summary_.counts.missed;
        notify(BranchEvent::Kind::missed, "this frequency of continuation.at is left out by a leap", w);
      }
    if (direction_ < 0 && !orbit_) turn(here_);
    ++count;
    notify(integrate ? BranchEvent::Kind::integration : BranchEvent::Kind::leap,
           "the curve could not be followed here (" + reason + "): went on from the " +
               (integrate ? "steady state that time integration finds" : "solution") + " at " +
               ahead_in_words(std::abs(next - before) / unit_) + (orbit_ ? ", in time" : "") +
               "; the branch may have changed",
           here_.parameter);
    begin_amplitude();
    verdict_ = judge(here_);
    report(here_, arclength_, verdict_ ? &*verdict_ : nullptr);
    if (next == settings_.to) {
      end(End::arrived);
      return true;
    }
    stand_anew();
    return true;
  }
  refusal_ = reason;
  return false;
}

} // namespace dovetail
