#include "continuation/predictor.hpp"

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "predicting";

} // namespace

void TangentPredictor::predict(const CurvePoint &here, double step, Vec y) const {
  check(VecWAXPY(y, step, here.t, here.y), doing);
}

void CubicPredictor::predict(const CurvePoint &here, double step, Vec y) const {
  TangentPredictor().predict(here, step, y);
  UniqueVec more;
  check(VecDuplicate(y, more.out()), doing);
  check(VecWAXPY(more, -1, before_.y, here.y), doing);
  const double last = norm_.length(more), square = step * step / last, cubic = square * (last + step) / last;
  if (!(last > 0)) return;
  // square (t - chord / last) + cubic (t + t_before - 2 chord / last), divided differences of the cubic
  check(VecAXPBYPCZ(more, square + cubic, cubic / norm_.length(before_.t), -(square + 2 * cubic) / last, here.t,
                    before_.t),
        doing);
  check(VecAXPY(more, -norm_.product(more, here.t), here.t), doing); // back onto the plane
  check(VecAXPY(y, 1, more), doing);
}

} // namespace dovetail
