// Harmonics to a tolerance: added before a point is accepted whose estimated error is larger, dropped where fewer do.
#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/follower.hpp"

namespace dovetail {
namespace {

constexpr int most_harmonics = 64;
constexpr double most_probed = 1e4;     // unknowns, to see whether still more harmonics help where some did not
constexpr double estimated_part = 0.5;  // of the linear solver's work on a point,
constexpr double estimated_dear = 0.1;  // or where the harmonics are many more than the case's,
constexpr double estimated_least = 3e7; // and more for the rest of it, some 1 ms;
constexpr double estimated_ahead = 3e8; // so much may be saved up
constexpr double most_part = 0.5;   // of the tolerance, for estimates may be half of the error where contacts are stiff
constexpr double aimed_part = 0.35; // by harmonics added,
constexpr double spare_part = 0.15; // and by those kept when some are dropped,
constexpr double least_saving = 0.8;   // unless hardly any would be
constexpr int least_stay = 4;          // points between a change and the next drop
constexpr int lent_for = 20;           // points, for harmonics that a rung of the ladder added, until out of reach,
constexpr double lent_within = 0.01;   // of the sweep, where they were taken: they stay;
constexpr int lent_again = 60;         // points more, where fewer led nowhere,
constexpr double lent_until = 3e-3;    // until as few promise to be as good as that,
constexpr double most_lent = 0.1;      // and are not far worse
constexpr int enough_added = 8;        // harmonics, to see whether they help
constexpr double most_left = 0.7;      // of the error, by harmonics that were worth it,
constexpr double most_left_then = 0.5; // or where they were not before, and are tried again: where the error is
constexpr double as_good = 1.5;        // error, in parts of the one that cannot be lowered
constexpr double worth_another = 2;    // so many times what it was then

// The fewest harmonics, `least` or more, with which the error would be below `wanted`: it goes with what is left out.
int harmonics_for(const ErrorEstimate &error, int H, int least, double wanted) {
  const int finer = static_cast<int>(error.content.size()) - 1;
  std::vector<double> tail(finer + 2); // size of the harmonics beyond h
  for (int k = finer; k > 0; --k) tail[k - 1] = std::hypot(tail[k], error.content[k]);
  if (!std::isfinite(error.harmonics)) return H;
  const double left_out = tail[H], beyond = left_out > 0 ? left_out * left_out / tail[H / 2] : 0, // as if doubling
      weight = error.harmonics > 0 ? error.harmonics / std::hypot(left_out, beyond) : 1;          // did the same again
  for (int h = least; h < finer; ++h)
    if (weight * std::hypot(tail[h], beyond) <= wanted) return h;
  return finer;
}

} // namespace

int Follower::least_harmonics() const { // those of the load
  return std::max(1, highest_harmonic(system_->loads()));
}

// Where contacts are stiff, twice the harmonics may cost ten times as much as the point: what estimates take is kept to
// a part of what the points take. None: no number. With a tolerance it is refined_for that asks.
const ErrorEstimate &Follower::affordable_error_of(CurvePoint &s) {
  static const ErrorEstimate none{std::nan(""), std::nan(""), std::nan(""), {}};
  const auto &error = data_of(s).error;
  if (settings_.tolerance > 0) return error ? *error : none;
  count_estimates(estimated_least);
  return error || estimating_ >= 0 ? error_of(s) : none;
}

// Up by what solves along the curve took, and `besides`, down by what estimates took. Between two steps nothing is left
// to count: a restart goes on from the same.
void Follower::count_estimates(double besides) {
  if (!estimator_) return;
  const double part = dear() ? estimated_dear : estimated_part, solved = curve_->take_work(),
               estimated = estimator_->take_work();
  if (std::isfinite(solved) && std::isfinite(estimated)) // else not counted, and every point is estimated
    estimating_ = std::min(estimating_ + part * solved + besides, estimated_ahead) - estimated;
}

const ErrorEstimate &Follower::error_of(CurvePoint &s) {
  auto &error = data_of(s).error;
  if (error) return *error;
  error = (*estimator_)(s.y, s.t);
  summary_.counts.inexact += estimator_->take_inexact();
  if (!system_->scaled().model.reduced.left_out.squares.empty()) error->modes = response_->left_out(s);
  return *error;
}

// More harmonics at here_, if the error at `s` asks for them; or back to what they were, if the last ones were added in
// vain. Where contacts are stiff, no number that can be had may be enough, and more may be worse than fewer. While
// harmonics stay, every other point is asked: errors change little from one to the next.
bool Follower::refined_for(CurvePoint &s) {
  if (settings_.tolerance <= 0 || unchanged_ % 2 == 1 || !(error_of(s).balance() > most_part * settings_.tolerance))
    return false;
  const int H = system_->harmonics();
  const double error = error_of(s).balance();
  if (unchanged_ > 0 || raised_.harmonics == 0) raised_ = {H, error}; // else further harmonics for the same step
  const double left = raised_.harmonics == coarse_.harmonics ? most_left_then : most_left;
  const bool in_vain = H >= raised_.harmonics + enough_added && error > left * raised_.error,
             more_to_be_had = H < most_harmonics && system_->layout().dofs() * (4 * H + 1) < most_probed;
  if (in_vain && !more_to_be_had) {
    coarse_ = std::exchange(raised_, {});
    return change_harmonics(coarse_.harmonics, error);
  }
  if (coarse_.harmonics == H && error < worth_another * coarse_.error) return false;
  const int wanted = std::min(harmonics_for(error_of(s), H, H + 1, aimed_part * settings_.tolerance), most_harmonics);
  if (wanted > H && change_harmonics(wanted, error)) return true;
  coarse_ = {H, error}; // then as few as are about as good
  const int fewer = harmonics_for(error_of(s), H, least_harmonics(), as_good * error);
  if (fewer > least_saving * H || !change_harmonics(fewer, error)) return false;
  coarse_.harmonics = fewer;
  return true;
}

// Without a tolerance, those go again that a rung of the ladder or a first point took beyond what the case has.
void Follower::spare_harmonics() {
  const bool aimed = settings_.tolerance > 0;
  const int H = system_->harmonics(), least = aimed ? least_harmonics() : asked_for_;
  if (++unchanged_ < (aimed ? least_stay : lent_for) || !data_of(here_).error || H <= least) return;
  if (!aimed && std::abs(here_.parameter - lent_at_) < lent_within * unit_) return;
  const double error = data_of(here_).error->balance();
  int fewer = harmonics_for(*data_of(here_).error, H, least, aimed ? spare_part * settings_.tolerance : lent_until);
  bool changed = false; // with so many fewer the motion may be no longer near, or as good
  for (; fewer <= least_saving * H && !changed; fewer = (fewer + H + 1) / 2) {
    changed = change_harmonics(fewer, error);
    if (aimed || !changed || error_of(here_).balance() < most_lent) continue;
    changed = false;
    if (!change_harmonics(H, data_of(here_).error->balance())) return;
  }
  if (changed) raised_ = {};
  if (!changed) unchanged_ = aimed ? 1 : -lent_again;
}

bool Follower::change_harmonics(int harmonics, double error) {
  const int before = system_->harmonics();
  const double step = control_.step();
  if (!rebuild(std::make_unique<HarmonicSystem>(*system_, harmonics, system_->samples()),
               settings_.tolerance > 0 || dear() ? step_limits.most_newton : 0))
    return false;
  control_.set(step);
  unchanged_ = 0;
  ++summary_.counts.adaptations;
  char text[120];
  std::snprintf(text, sizeof text, "%d harmonics from here on (estimated error with %d: %.1e)", harmonics, before,
                error);
  notify(BranchEvent::Kind::harmonics, text, here_.parameter);
  return true;
}

} // namespace dovetail
