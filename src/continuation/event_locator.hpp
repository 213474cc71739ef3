#pragma once
// Where within a step something happens: found by solving on planes in between.
#include <array>
#include <functional>
#include <optional>

#include "continuation/curve.hpp"

namespace dovetail {

/// A point of the curve within a step.
struct Located {
  double along; ///< way from the last point: on planes across the step, in kinks such a part of it
  CurvePoint at;
};

/// What is measured at a point; it happens where that passes zero.
using Measured = std::function<double(CurvePoint &)>;

/// Of what is searched.
struct Bound {
  double along;
  Vec y;
  double value;
  Vec t = nullptr; ///< the tangent there, by which guesses lie on a cubic
};

class EventLocator {
public:
  /// Within the step from `here` to `trial`. `newton_tolerance`: relative, of y: nothing is located better.
  EventLocator(Curve &curve, const CurvePoint &here, const CurvePoint &trial, double newton_tolerance)
      : curve_(curve), here_(here), trial_(trial), tolerance_(newton_tolerance) {}

  /// Where f passes zero, on planes across `normal`: by interpolation, or halving, for f may jump at a kink of the
  /// curve. Nothing if Newton's method fails in between. Collective.
  std::optional<Located> between(Vec normal, const Bound &from, const Bound &to, const Measured &f) const;
  /// The same within the whole step, of that length. values: of f at both ends.
  std::optional<Located> within(Vec normal, double step, std::array<double, 2> values, const Measured &f) const;
  /// In a kink between here and trial, on planes across the direction between both tangents: planes across either leg
  /// may miss the other one. values: of f at both ends.
  std::optional<Located> in_kink(double step, std::array<double, 2> values, const Measured &f) const;
  /// The determinant changes its sign within the step. Either another branch crosses the curve there, or two legs of a
  /// hairpin face each other and the step went across: then the way back from trial misses here by as much.
  bool leads_back(double step, double missed) const;
  /// Where another branch crosses: as good as bisection gets, for close to it Newton may land on the other branch.
  /// Nothing where points in between are not on a straight curve, or those on both sides too far apart: trial is on
  /// another branch.
  std::optional<Located> branch_point(double step) const;

private:
  Curve &curve_;
  const CurvePoint &here_, &trial_;
  double tolerance_;
};

/// Of the lines along two tangents.
struct Meeting {
  double ahead, back, miss; ///< lengths from here and back from the other to where they are closest, how close
};
Meeting meeting(const Curve &curve, const CurvePoint &here, const CurvePoint &other);

/// That point, with its solve's report and data.
Located located_at(const Curve &curve, const CurvePoint &s, double along);

} // namespace dovetail
