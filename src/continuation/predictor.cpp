#include "continuation/predictor.hpp"

#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "predicting";

} // namespace

void TangentPredictor::predict(const CurvePoint &here, double step, Vec y) const {
  const double rate = parameter_of(here.t);
  check(VecWAXPY(y, step, here.t, here.y), doing);
  note_parameter(y, here.parameter + step * rate);
}

void CubicPredictor::predict(const CurvePoint &here, double step, Vec y) const {
  TangentPredictor().predict(here, step, y);
  UniqueVec more;
  check(VecDuplicate(y, more.out()), doing);
  check(VecWAXPY(more, -1, before_.y, here.y), doing);
  const std::vector<double> products = norm_.products(
      {{more, more}, {before_.t, before_.t}, {more, here.t}, {here.t, here.t}, {before_.t, here.t}}, {}, {before_.t});
  const double last = std::sqrt(products[0]), square = step * step / last, cubic = square * (last + step) / last,
               of_before = cubic / std::sqrt(products[1]), of_chord = -(square + 2 * cubic) / last;
  if (!(last > 0)) return;
  // square (t - chord / last) + cubic (t + t_before - 2 chord / last), divided differences of the cubic
  check(VecAXPBYPCZ(more, square + cubic, of_before, of_chord, here.t, before_.t), doing);
  const double along = of_chord * products[2] + (square + cubic) * products[3] + of_before * products[4];
  check(VecAXPY(more, -along, here.t), doing); // back onto the plane
  const double rate = parameter_of(here.t), guess = here.parameter + (step + square + cubic - along) * rate +
                                                    of_before * parameter_of(before_.t) +
                                                    of_chord * (here.parameter - before_.parameter);
  check(VecAXPY(y, 1, more), doing);
  note_parameter(y, guess);
}

} // namespace dovetail
