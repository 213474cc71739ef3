#pragma once
// Stability of periodic motions of a distributed model, by Hill's method alone (hill.hpp, wave_system.hpp): the
// exponents near the imaginary axis.
#include "contact/cone_law.hpp"
#include "harmonic/harmonic_system.hpp"
#include "stability/contact_reading.hpp"
#include "stability/stability.hpp"

namespace dovetail {

class LargeStabilityTest {
public:
  /// `system` must outlive it, and stay as it is.
  explicit LargeStabilityTest(const HarmonicSystem &system);

  /// y = [X; parameter] of the system, with the joint that it was set to last. Uncertain where an exponent is 0 to its
  /// accuracy, or is not found. One rigid displacement that nothing resists is enough for that. Two factorisations of
  /// matrices of the size of the Jacobian, one after the other. Collective.
  Stability judge(Vec y);

private:
  const HarmonicSystem &system_;
  DenseModel own_; // the own contact points, without structure
  ContactReading reading_;
};

} // namespace dovetail
