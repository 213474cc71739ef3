#include "analyses/harmonics_control.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "continuation/step_control.hpp"

namespace dovetail {
namespace {

constexpr int most_harmonics = 64;
constexpr double most_probed = 1e4; // unknowns, to see whether still more harmonics help where some did not
constexpr double most_part = 0.5;   // of the tolerance, for estimates may be half of the error where contacts are stiff
constexpr double aimed_part = 0.35; // by harmonics added,
constexpr double spare_part = 0.15; // and by those kept when some are dropped,
constexpr double least_saving = 0.8;   // unless hardly any would be
constexpr int least_stay = 4;          // points between a change and the next drop
constexpr int lent_for = 20;           // points, for harmonics that recovery added, until out of reach,
constexpr double lent_within = 0.01;   // of the range, where they were taken: they stay;
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

HarmonicsControl::HarmonicsControl(const Response &response, ErrorWatch &errors, double tolerance, double unit,
                                   Change change)
    : response_(response), errors_(errors), tolerance_(tolerance), unit_(unit), change_(std::move(change)) {}

int HarmonicsControl::least() const { // without a tolerance the case's, else those of the load
  return tolerance_ > 0 ? std::max(1, highest_harmonic(response_.system().loads())) : response_.asked_for();
}

// Where contacts are stiff, no number that can be had may be enough, and more may be worse than fewer. While harmonics
// stay, every other point is asked: errors change little from one to the next.
bool HarmonicsControl::refine(CurvePoint &s) {
  if (tolerance_ <= 0 || unchanged_ % 2 == 1) return false;
  const double error = errors_.of(s).balance();
  if (!(error > most_part * tolerance_)) return false;
  const int H = response_.system().harmonics();
  if (unchanged_ > 0 || raised_.harmonics == 0) raised_ = {H, error}; // else further harmonics for the same step
  const double left = raised_.harmonics == coarse_.harmonics ? most_left_then : most_left;
  const bool in_vain = H >= raised_.harmonics + enough_added && error > left * raised_.error,
             more_to_be_had = H < most_harmonics && response_.layout().dofs() * (4 * H + 1) < most_probed;
  if (in_vain && !more_to_be_had) {
    coarse_ = std::exchange(raised_, {});
    return change(coarse_.harmonics, error);
  }
  if (coarse_.harmonics == H && error < worth_another * coarse_.error) return false;
  const int wanted = std::min(harmonics_for(errors_.of(s), H, H + 1, aimed_part * tolerance_), most_harmonics);
  return (wanted > H && change(wanted, error)) || fewer_are_as_good(error, s);
}

// No more harmonics can be had: as few as are about as good.
bool HarmonicsControl::fewer_are_as_good(double error, CurvePoint &s) {
  const int H = response_.system().harmonics(), fewer = harmonics_for(errors_.of(s), H, least(), as_good * error);
  coarse_ = {H, error};
  if (fewer > least_saving * H || !change(fewer, error)) return false;
  coarse_.harmonics = fewer;
  return true;
}

bool HarmonicsControl::may_spare(const CurvePoint &here) {
  const bool aimed = tolerance_ > 0;
  if (++unchanged_ < (aimed ? least_stay : lent_for) || !data_of(here).error ||
      response_.system().harmonics() <= least())
    return false;
  return aimed || !(std::abs(here.parameter - lent_at_) < lent_within * unit_);
}

void HarmonicsControl::spare(CurvePoint &here) {
  if (!may_spare(here)) return;
  const bool aimed = tolerance_ > 0;
  const int H = response_.system().harmonics();
  const double error = data_of(here).error->balance();
  int fewer = harmonics_for(*data_of(here).error, H, least(), aimed ? spare_part * tolerance_ : lent_until);
  bool changed = false; // with so many fewer the motion may be no longer near, or as good
  for (; fewer <= least_saving * H && !changed; fewer = (fewer + H + 1) / 2) {
    changed = change(fewer, error);
    if (aimed || !changed || errors_.of(here).balance() < most_lent) continue;
    changed = false;
    if (!change(H, data_of(here).error->balance())) return;
  }
  if (changed)
    raised_ = {};
  else
    unchanged_ = aimed ? 1 : -lent_again;
}

bool HarmonicsControl::change(int harmonics, double error) {
  const bool hurried = tolerance_ > 0 || response_.iterations_are_expensive();
  if (!change_(harmonics, hurried ? step_limits.most_newton : 0, error)) return false;
  unchanged_ = 0;
  return true;
}

void HarmonicsControl::archive(Archive &archive) {
  archive.field("lent_at", lent_at_);
  archive.field("unchanged", unchanged_);
  archive.field("raised_harmonics", raised_.harmonics);
  archive.field("raised_error", raised_.error);
  archive.field("coarse_harmonics", coarse_.harmonics);
  archive.field("coarse_error", coarse_.error);
}

} // namespace dovetail
