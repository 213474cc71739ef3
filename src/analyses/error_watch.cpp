#include "analyses/error_watch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dovetail {
namespace {

constexpr double estimated_part = 0.5;  // of the linear solver's work on a point,
constexpr double estimated_dear = 0.1;  // or where the harmonics are many more than the case's,
constexpr double estimated_least = 3e7; // and more for the rest of it, some 1 ms;
constexpr double estimated_ahead = 3e8; // so much may be saved up

} // namespace

ErrorWatch::ErrorWatch(const Response &response, const NewtonSettings &newton, const BranchSettings &settings,
                       double unit, SolveCounts &counts)
    : response_(response), to_tolerance_(settings.tolerance > 0), counts_(counts) {
  if (settings.estimates) estimator_ = std::make_unique<Estimator>(response.system(), unit, newton.residual_tolerance);
}

const ErrorEstimate &ErrorWatch::of(CurvePoint &s) {
  auto &error = data_of(s).error;
  if (error) return *error;
  error = (*estimator_)(s.y, s.t);
  counts_.inexact += estimator_->take_inexact();
  return *error;
}

const ErrorEstimate &ErrorWatch::with_modes(CurvePoint &s) {
  of(s);
  ErrorEstimate &error = *data_of(s).error;
  if (!response_.system().scaled().model.reduced.left_out.squares.empty() && !std::exchange(error.has_modes, true)) {
    solved_ += response_.curve().take_work();
    error.modes = response_.curve().left_out(s);
    left_out_ += response_.curve().take_work();
  }
  count_work(0); // now: a restarted run would not know of it
  return error;
}

// Where contacts are stiff, twice the harmonics may cost ten times as much as the point: what estimates take is kept to
// a part of what the points take.
const ErrorEstimate &ErrorWatch::affordable(CurvePoint &s) {
  static const ErrorEstimate none{std::nan(""), std::nan(""), std::nan(""), false, {}};
  const bool known = data_of(s).error.has_value();
  if (!to_tolerance_) count_work(estimated_least);
  return known || (!to_tolerance_ && affordable_work_ >= 0) ? with_modes(s) : none;
}

// Up by what solves along the curve took, and `besides`, down by what estimates took.
void ErrorWatch::count_work(double besides) {
  if (!estimator_) return;
  const double part = response_.iterations_are_expensive() ? estimated_dear : estimated_part,
               solved = std::exchange(solved_, 0.0) + response_.curve().take_work(),
               estimated = std::exchange(left_out_, 0.0) + estimator_->take_work();
  if (std::isfinite(solved) && std::isfinite(estimated)) // else not counted, and every point is estimated
    affordable_work_ = std::min(affordable_work_ + part * solved + besides, estimated_ahead) - estimated;
}

} // namespace dovetail
