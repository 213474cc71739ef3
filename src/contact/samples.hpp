#pragma once
// Numbers of samples per period, as the contact laws are given them.
#include "contact/contact_point.hpp"

namespace dovetail {

/// In place of a number: exactly, but for cones, which are sampled so often.
constexpr int exactly_with_cones(int samples) { return -samples; }

constexpr bool takes_no_samples(int samples) { return samples <= exactly; } ///< of laws that have a closed form

constexpr int samples_of_cones(int samples, int harmonics) {
  return samples == exactly ? enough_samples(harmonics) : samples < 0 ? -samples : samples;
}

} // namespace dovetail
