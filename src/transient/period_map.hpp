#pragma once
// One period of the motion as a map of numbers: a periodic motion is a fixed point of it.
#include "transient/flow.hpp"

namespace dovetail {

using Numbers = std::vector<double>;
using Held = std::vector<std::array<bool, 2>>; ///< by contact point and slider

double dot(const Numbers &a, const Numbers &b);
double norm(const Numbers &a);
void add(Numbers &y, double factor, const Numbers &x);

/// The numbers: eta, eta' and sliders from their standstill, each such that its square is an energy.
/// Sliders that hardly move in it are held when it is differentiated: often they have slipped until they just do not
/// slip any more, and the map has a corner there, beyond which friction only takes more energy.
class PeriodMap {
public:
  /// Weights of the numbers by the flow's frequency now; `periods`: how many may be integrated.
  PeriodMap(Flow &flow, long periods);

  std::size_t size() const { return weights_.size(); }
  long used() const { return used_; }

  Numbers numbers(const Flow::State &state) const;
  Flow::State state(Numbers y, const Held &held) const;

  /// The numbers a period later, and which sliders hardly moved. False where the motion runs away, or no periods are
  /// left.
  bool next(const Numbers &y, Numbers &out, Held &still);
  /// The same with sliders held.
  bool next_held(const Numbers &y, Numbers &out, const Held &held);

  /// The same, which takes as long as several periods, with the derivative of `out` by the numbers and,
  /// times `turning`, by omega: (size, size + 1). It is exact but for round-off; where a contact grazes, it is that of
  /// one side.
  bool next_with_derivative(const Numbers &y, const Held &held, double turning, Numbers &out, Dense &derivative);

  bool is_held(std::size_t i, const Held &held) const;
  /// Size of the motion, without the sliders, which may stand far away.
  double motion_size(const Numbers &y) const { return norm({y.begin(), y.begin() + motion_numbers()}); }
  int motion_numbers() const { return 2 * flow_.modes().count; }

private:
  bool march(Flow::State &at, Numbers &out);
  std::vector<Memory> memories(const Numbers &y) const;

  Flow &flow_;
  long left_, used_ = 0;
  Numbers weights_;
  Motion motion_;
};

} // namespace dovetail
