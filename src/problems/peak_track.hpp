#pragma once
// Peaks of response curves (eqs D, E) as a problem to be continued: y = [Y; Omega; p], R(Y; Omega, p) = 0 and a
// condition.
#include "continuation/problem.hpp"
#include "problems/response_metric.hpp"
#include "problems/track_conditions.hpp"

namespace dovetail {

/// That of a response in [Y; Omega], and p by its unit.
class TrackMetric : public ArcLengthMetric {
public:
  TrackMetric(const Layout &layout, double omega_unit, double unit, bool weighted)
      : response_(layout, omega_unit, weighted), unit_(weighted ? unit : 1) {}

  std::vector<double> products(const std::vector<Pair> &pairs, const std::vector<Vec> &moving,
                               const std::vector<Vec> &known) const override;
  void weigh(Vec t, Vec row) const override;
  double largest_motion() const override { return response_.largest_motion(); }
  void see(Vec y) override { response_.see(y); }
  ResponseMetric &response() { return response_; } ///< what was seen

private:
  ResponseMetric response_;
  double unit_;
};

class PeakTrack : public Problem {
public:
  /// Over that parameter of the peak's equations, which need `preload` where it changes the joint. `omega_unit`: change
  /// of frequency that counts as much as the largest motion. Collective.
  PeakTrack(PeakEquations &peak, const PathParameter &kind, std::shared_ptr<VariedPreload> preload,
            TrackCondition &condition, double omega_unit);

  const Parameter &parameter() const override { return parameter_; }
  UniqueVec unknowns() const override;
  void residual(Vec y, Vec f) override;
  std::unique_ptr<BorderedJacobian> jacobian() override;
  std::unique_ptr<ArcLengthMetric> metric(double unit, bool weighted) const override; ///< TrackMetric
  std::shared_ptr<PointData> describe() override;                                     ///< ResponseData
  bool is_admissible(double value) const override { return value > 0 || !kind_.positive(); }

  bool resonates() const override { return false; } ///< the resonance goes along

  PeakEquations &peak() { return peak_; }
  double omega_of(Vec y) const; ///< Collective.
  /// The peak's equations take [Y; Omega] of y, and its p.
  void take(Vec y);
  /// [Y; Omega] of the peak's equations, and p, into y.
  void give(double p, Vec y) const;
  const PathParameter &kind() const { return kind_; }
  TrackCondition &condition() const { return condition_; }
  /// The condition's value at y, which the peak's equations take. Collective.
  double evaluate(Vec y);

private:
  PetscInt own_unknowns() const { return peak_.system().layout().own_unknowns(); } // without p
  void hand_over(Vec y);

  PeakEquations &peak_;
  const PathParameter &kind_;
  std::shared_ptr<VariedPreload> preload_;
  TrackCondition &condition_;
  double omega_unit_;
  Parameter parameter_;
  UniqueVec inner_, f_;    // [Y; Omega] and its residual
  UniqueVec known_;        // y at which the condition was evaluated last, and
  double known_value_ = 0; // what it is there
};

} // namespace dovetail
