#pragma once
// The periodic response to a load as a problem to be continued: harmonic balance over any of its parameters.
#include <optional>
#include <vector>

#include "continuation/problem.hpp"
#include "harmonic/harmonic_system.hpp"
#include "problems/estimator.hpp"

namespace dovetail {

/// What is known of a point of a response.
struct ResponseData : PointData {
  std::vector<Activity> activity;     ///< of the own contact points
  std::optional<ErrorEstimate> error; ///< once it has been asked for
};

class ForcedResponse : public Problem {
public:
  explicit ForcedResponse(HarmonicSystem &system)
      : system_(system), parameter_{system.parameter().kind().name, system.parameter().kind().unit} {}

  const Parameter &parameter() const override { return parameter_; }
  UniqueVec unknowns() const override { return system_.unknowns(); }
  void residual(Vec y, Vec f) override { system_.residual(y, f); }
  double residual_and_plane(Vec y, Vec f, Vec border) override { return system_.residual(y, f, border); }
  std::unique_ptr<BorderedJacobian> jacobian() override;
  std::unique_ptr<ArcLengthMetric> metric(double unit, bool weighted) const override;
  std::shared_ptr<PointData> describe() override;
  bool is_admissible(double value) const override { return value > 0 || !system_.parameter().kind().positive(); }
  bool is_smooth() const override { return system_.samples() == exactly; } ///< sampled contact forces make teeth
  /// By dofs and coefficients: alike for any sharing out and number of harmonics.
  std::vector<Projected> own_projected(const std::vector<Vec> &of) const override;

private:
  HarmonicSystem &system_;
  Parameter parameter_;
  mutable std::vector<double> directions_; // of the projections, made at the first
};

} // namespace dovetail
