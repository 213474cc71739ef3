#pragma once
// Round a kink of the curve, as where a contact lifts off, lands or begins to slip: to the leg on which it goes on.
#include <functional>

#include "continuation/curve.hpp"

namespace dovetail {

class KinkTurn {
public:
  /// A leg that begins near the last point; `trial` is the point on it.
  struct Leg {
    Vec normal;    ///< the way to trial is measured on planes across it
    double way;    ///< to trial
    double step;   ///< along the leg, with which it was met
    double turned; ///< angle between the legs [rad]
    bool at_kink;  ///< else it is the same leg, only hard to meet across its tangent
  };
  using Take = std::function<bool(const Leg &)>; ///< false: the leg is refused, and others are tried

  /// From `here`, with room for a point of the other leg. `curvature`: of the curve up to here, angle per arc length.
  /// `expensive`: Newton's iterations are, and far along a leg there are many.
  KinkTurn(Curve &curve, const CurvePoint &here, CurvePoint &trial, double curvature, bool expensive, Take take);

  /// Where halving has led to `step`, too short to go on. True if a leg was taken. Collective.
  bool turn(double step);

private:
  bool try_legs(double step, bool by_sign);
  bool go_round(Vec t, double step, bool by_sign);
  bool is_beside(double turned);
  bool back_to_kink(CurvePoint &kink);

  Curve &curve_;
  const CurvePoint &here_;
  CurvePoint &trial_;
  double curvature_;
  bool expensive_;
  Take take_;
  UniqueVec way_; // room for differences
};

} // namespace dovetail
