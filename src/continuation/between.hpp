#pragma once
// What the points of a curve do not show: how far the amplitude between two of them may be off the cubic through their
// amplitudes and slopes.
#include "support/archive.hpp"

namespace dovetail {

struct Amplitude {
  double value = 0; ///< of what is watched
  double slope = 0; ///< its derivative along the tangent given
};

class BetweenPoints {
public:
  /// What came before does not count any more. `here`: the slope by arc length.
  void begin(const Amplitude &here);
  /// A further point, `step` of arc length after the last. Returns an estimate for the piece between the two, relative
  /// to the largest amplitude so far: NaN while fewer than three points are known.
  ///
  /// The last point but one and this one have a cubic, too, which the point between them is off by e. Of a smooth curve
  /// the error is e h2^2 / (16 h1^2). Where the fourth derivative e / (h1 h2)^2 is unlike the one before, or the slope
  /// is off by more than that, there is a kink, or a bend that is not resolved: there the slope jumps by J beyond its
  /// trend, and the error is J h2 / 8 if the kink is in the middle of the step, 0.3 to 1.2 of that elsewhere.
  double add(double step, const Amplitude &next);

  void archive(Archive &archive); ///< all that is remembered

private:
  Amplitude before_, here_;                // the last two points
  double step_ = 0;                        // between them
  double fourth_ = 0;                      // e / (h1 h2)^2 up to here_
  double bend_before_ = 0, bend_here_ = 0; // change of slope by arc length, along the last two steps
  double largest_ = 0;                     // amplitude
  int known_ = 0;                          // points
};

} // namespace dovetail
