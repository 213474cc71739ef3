// What is tried when no step along the tangent converges, cheapest first. Every rung that helps is counted and told.
#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/follower.hpp"
#include "problems/needed_harmonics.hpp"

namespace dovetail {
namespace {

constexpr double most_change = 0.1;    // by other harmonics or samples, where 1 is the largest motion so far
constexpr double most_unknowns = 1500; // of a system whose harmonics are raised; of its contacts, as a last resort,
constexpr double most_ample = 4000;    // or if they are ample

} // namespace

// The next rung that leads anywhere.
Follower::Outcome Follower::climb() {
  const std::string reason = refusal_, where = difference();
  if (settings_.strategies.none()) return end(End::stalled, reason + where);
  if (better_sampling() || more_harmonics() || leap(Way::newton, here_.parameter) ||
      leap(Way::integration, here_.parameter) || leap(Way::anew, here_.parameter))
    return ended_ ? Outcome::ended : Outcome::on;
  return interrupted() ? end(End::interrupted, "interrupted") : end(End::stalled, reason + where);
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
  drop_anchors();
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
  if (curve.norm.length(padded) > most_change) return false; // that is another branch
  adopt(std::move(system));
  here_ = std::move(there);
  begin_amplitude();
  control_.set(step_limits.after_jump);
  limit_step();
  return true;
}

bool Follower::better_sampling() {
  if (system_->samples() == exactly || !may(Strategy::sampling)) return false;
  const std::string reason = refusal_;
  if (!rebuild(std::make_unique<HarmonicSystem>(*system_, system_->harmonics(), exactly))) return false;
  ++summary_.counts.samplings;
  notify(BranchEvent::Kind::sampling,
         "no step converges (" + reason + "): contact forces exactly, without samples, from here on", here_.parameter);
  return true;
}

// By the rule that H Omega should reach twice the frequency of the closed contact; as far as size allows.
int Follower::needed_harmonics(double omega, Resort resort) const {
  const Layout &layout = system_->layout();
  if (layout.dofs() > most_integrated) return 0;
  const double wanted = std::ceil(2 * closed_contact_frequency(dense_model(*system_)) / omega);
  const PetscInt dofs = layout.dofs() - (resort == Resort::last ? layout.modes : 0);
  return static_cast<int>(std::min(wanted, (most_unknowns / dofs - 1) / 2));
}

// So many that Newton's method arrives from the motion that time integration finds.
int Follower::ample_harmonics(double omega, double parts) const {
  const double wanted = std::ceil(2 * parts * closed_contact_frequency(dense_model(*system_)) / omega);
  return static_cast<int>(std::min(wanted, (most_ample / (3.0 * system_->layout().points) - 1) / 2));
}

bool Follower::more_harmonics() {
  if (!may(Strategy::harmonics)) return false;
  const int H = system_->harmonics(), needed = needed_harmonics(here_.parameter);
  if (std::exchange(in_vain_, H) == H) return false;
  const std::string reason = refusal_;
  for (const int more : {2 * H, needed}) {
    if (more <= H || more > std::max(needed, 1)) continue;
    if (!rebuild(std::make_unique<HarmonicSystem>(*system_, more, system_->samples()))) continue;
    lent_from_ = H + 1, lent_at_ = here_.parameter, unchanged_ = 0;
    ++summary_.counts.harmonics;
    notify(BranchEvent::Kind::harmonics,
           "no step converges (" + reason + "): " + std::to_string(more) +
               " harmonics from here on; the closed contact at " + "this frequency wants " + std::to_string(needed),
           here_.parameter);
    return true;
  }
  return false;
}

// Where a motion that time integration finds is no solution for these harmonics, with more of them: here_, in a system
// that has them. `q`: coefficients of any number of harmonics.
bool Follower::solve_finer(const std::vector<double> &q, double omega, Resort resort) {
  const int H = system_->harmonics(), needed = needed_harmonics(omega, resort);
  const bool last = resort == Resort::last;
  const double growth = last ? 1.4 : 2;
  std::vector<std::pair<int, double>> tries; // with so many, and so many times newton.max_iterations
  for (double more = growth * H; resort != Resort::ample && more < growth * needed; more *= growth)
    if (tries.empty() || resort != Resort::once)
      tries.emplace_back(std::min(static_cast<int>(more), needed), last ? patient_newton : 1);
  for (const double parts : {enough_parts, ample_parts})
    if (const int more = ample_harmonics(omega, parts); (last || resort == Resort::ample) && more > H)
      if (tries.empty() || more > tries.back().first) tries.emplace_back(more, impatient_newton);
  for (const auto &[more, times] : tries) {
    auto system = std::make_unique<HarmonicSystem>(*system_, more, system_->samples());
    ResponseCurve curve(*system, newton_, unit_, settings_.adaptive, summary_.counts);
    CurvePoint s = curve.point();
    set_coefficients(system->layout(), q, s.y);
    if (!curve.solve_at(omega, s, times)) continue;
    adopt(std::move(system));
    here_ = std::move(s);
    lent_at_ = omega, unchanged_ = 0;
    ++summary_.counts.harmonics;
    return true;
  }
  return false;
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
