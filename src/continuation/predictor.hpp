#pragma once
// The guess with which a step begins: Newton's method corrects it on the plane across the tangent.
#include "continuation/curve.hpp"

namespace dovetail {

class Predictor {
public:
  virtual ~Predictor() = default;
  /// y becomes a guess of the point `step` ahead of `here`, on the plane across the tangent there.
  virtual void predict(const CurvePoint &here, double step, Vec y) const = 0;
};

/// Along the tangent: the guess misses by the square of the step.
class TangentPredictor : public Predictor {
public:
  void predict(const CurvePoint &here, double step, Vec y) const override;
};

/// As the step before was bent: by the cubic through both its ends with the tangents there. It misses by step^4.
class CubicPredictor : public Predictor {
public:
  CubicPredictor(const ArcLengthMetric &norm, const CurvePoint &before) : norm_(norm), before_(before) {}
  void predict(const CurvePoint &here, double step, Vec y) const override;

private:
  const ArcLengthMetric &norm_;
  const CurvePoint &before_; // where the step to `here` began
};

} // namespace dovetail
