#pragma once
// The equation that picks one point of every response curve, so that the points of many curves make a track.
#include "problems/peak_equations.hpp"
#include "support/archive.hpp"

namespace dovetail {

class TrackCondition {
public:
  virtual ~TrackCondition() = default;
  /// Zero where the condition holds, without dimension; NaN where it cannot be told. At the point that the equations
  /// have taken. Collective.
  virtual double value() = 0;
  /// After that: its derivative by [Y; Omega] into `row`; returned: by the parameter. Collective.
  virtual double derivative(const PathParameter &parameter, Vec row) = 0;
  /// [dY/dOmega; 0] there, where the condition knows it, to `roughly`; else null.
  virtual Vec along() const { return nullptr; }
  static constexpr double roughly = 1e-6; ///< relative
  /// What it remembers of the points before. Collective.
  virtual void archive(Archive &) {}
};

/// The maximum of the amplitude: d ln A / d ln Omega = 0.
class Extremum : public TrackCondition {
public:
  explicit Extremum(PeakEquations &peak) : peak_(peak) {}
  double value() override;
  double derivative(const PathParameter &parameter, Vec row) override;
  Vec along() const override { return peak_.along(); }

private:
  PeakEquations &peak_;
  double log_slope_ = 0; // of A by Omega
};

/// A quarter of a period between load and motion: what the load's lowest harmonic works on has no part in phase with
/// it.
class PhaseResonance : public TrackCondition {
public:
  explicit PhaseResonance(PeakEquations &peak);
  double value() override;
  double derivative(const PathParameter &parameter, Vec row) override;

private:
  PeakEquations &peak_;
  UniqueVec row_;
};

/// Eq (E): the corner of the response where a slider just begins to slip: a maximum may stay there, with no zero of its
/// slope.
class Grazing : public TrackCondition {
public:
  /// `own_point`: the contact point whose graze that is, or -1 where another rank owns it.
  Grazing(PeakEquations &peak, int own_point, const Graze &graze);
  double value() override;
  double derivative(const PathParameter &parameter, Vec row) override;
  void archive(Archive &archive) override;

private:
  PeakEquations &peak_;
  int own_point_;
  Graze graze_;
  double size_;
};

} // namespace dovetail
