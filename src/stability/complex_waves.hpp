#pragma once
// Small changes of a motion as sums of complex waves, and what the contact points answer to them. A wave k of the kind
// `part` is exp(i (k + part) theta): changes grow and turn near exp(i part theta) then.
#include <complex>
#include <vector>

#include "contact/linearisation.hpp"
#include "stability/contact_reading.hpp"

namespace dovetail {

struct ComplexWaves {
  double part;              ///< turns per period besides
  double growth;            ///< over Omega, of what sliders remember since they were set
  std::vector<int> numbers; ///< k, rising

  /// All waves with up to `harmonics` (and a quarter) per period.
  ComplexWaves(double part, int harmonics, double growth = 0);
  int count() const { return static_cast<int>(numbers.size()); }
  double turns(int i) const { return numbers[i] + part; } ///< of wave i, per period
};

/// d G / d X by the coefficients of such waves, for the motion that `reading` has read, which knows masks up to the
/// waves' largest difference: blocks of all points one after the other in the order of block_places, (count, count)
/// each, row-major. What a slider remembers of the instant at which it was set has turned by `part` and grown since.
/// Where the reading is sampled, part 0 alone.
std::vector<std::complex<double>> answers(const ComplexWaves &waves, const ContactReading &reading,
                                          const std::vector<ContactPoint> &contact);

} // namespace dovetail
