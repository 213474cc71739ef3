#pragma once
// Small changes of a motion as sums of waves, and what the contact points answer to them.
#include <vector>

#include "contact/linearisation.hpp"
#include "stability/contact_history.hpp"

namespace dovetail {

/// Coefficients [a0, a1, b1, ...] of the waves 0..H like those of the motion (fourier.hpp), or, for changes p with
/// p(t + T) = -p(t), [a, b] of the waves 1/2, 3/2, ..., H - 1/2 in turn.
enum class Waves { whole, half };

constexpr double exponent_shift = 1e-3; ///< where exponents are sought around, over Omega: J may be singular at 0

constexpr int wave_coefficients(Waves waves, int harmonics) {
  return waves == Waves::whole ? 2 * harmonics + 1 : 2 * harmonics;
}
/// Waves per period of coefficient i, and whether it is a sine.
constexpr double wave_number(Waves waves, int i) { return waves == Waves::whole ? (i + 1) / 2 : i / 2 + 0.5; }
constexpr bool is_sine(Waves waves, int i) { return waves == Waves::whole ? i > 0 && i % 2 == 0 : i % 2 == 1; }

/// d G / d X of contact point `number` by such coefficients, in the blocks of block_places, row-major as
/// Linearisation::write gives them for whole waves. There is one difference: a slider that only came to rest where the
/// motion just does not move it (shakedown) answers as if it never moved. The masks of `linear` must have means up to
/// m = 2H at least. Points of law cone: only if always stuck or always open. `lag`: growth over Omega of the change
/// that sliders remember.
void write_waves(Waves waves, int harmonics, const ContactPoint &point, const Linearisation &linear,
                 const ContactHistory &history, int number, double lag, double *blocks);

} // namespace dovetail
