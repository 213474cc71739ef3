#pragma once
// In which unit the case file gives frequencies: [continuation] unit. Inside, they are as the model counts: rad/s, or
// rad per its unit of time.
#include <cmath>
#include <cstdio>
#include <string>

#include "case/number_text.hpp"

namespace dovetail {

struct FrequencyUnit {
  bool hertz = false;
  double seconds = 1;          ///< the model's unit of time [s], once it is known,
  std::string omega = "rad/s"; ///< and the name of its excitation frequencies

  const char *name() const { return hertz ? "Hz" : omega.c_str(); }
  double radians() const { return hertz ? 2 * M_PI * seconds : 1; } ///< one of it, as the model counts

  /// The same frequencies, shown in Hz or not.
  FrequencyUnit in_hertz(bool wanted) const { return {wanted, seconds, omega}; }

  /// A frequency of the model as a number of this unit, with the digits that the user wrote.
  std::string number(double value) const {
    if (!hertz) return number_text(value);
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.15g", value / radians()); // without the last bit of the division
    return digits;
  }

  /// The same for messages: "3.2 rad/s", or "0.51 Hz = 3.2 rad/s".
  std::string text(double value, int digits = 9) const {
    char words[96];
    if (hertz)
      std::snprintf(words, sizeof words, "%.*g Hz = %.*g %s", digits, value / radians(), digits, value, omega.c_str());
    else
      std::snprintf(words, sizeof words, "%.*g %s", digits, value, omega.c_str());
    return words;
  }
};

} // namespace dovetail
