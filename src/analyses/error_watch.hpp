#pragma once
// Estimated errors of points, as far as they can be afforded.
#include <memory>

#include "analyses/response.hpp"
#include "problems/estimator.hpp"

namespace dovetail {

class ErrorWatch {
public:
  /// `counts`: of linear solves that left more than was asked.
  ErrorWatch(const Response &response, const NewtonSettings &newton, const BranchSettings &settings, double unit,
             SolveCounts &counts);
  /// From now on for points of the response as it is now.
  void match() {
    if (estimator_) estimator_->match(response_.system());
  }

  bool asked() const { return estimator_ != nullptr; }
  /// Estimated where that has not been done, but for the modes left out. Collective.
  const ErrorEstimate &of(CurvePoint &s);
  /// All of it. Collective.
  const ErrorEstimate &with_modes(CurvePoint &s);
  /// The same where work for it is left; else no number. Collective.
  const ErrorEstimate &affordable(CurvePoint &s);
  /// Between two steps nothing is left to count: a restart goes on from the same.
  void count_work(double besides = 0);

  void archive(Archive &archive) { archive.field("estimating", affordable_work_); }

private:
  const Response &response_;
  const bool to_tolerance_; // then the harmonics' control says which points are estimated
  SolveCounts &counts_;
  std::unique_ptr<Estimator> estimator_;
  double affordable_work_ = 0;
  double solved_ = 0, left_out_ = 0; // work since it was counted last: along the curve, and for modes left out
};

} // namespace dovetail
