#pragma once
// In which unit the case file gives frequencies: [continuation] unit. The program itself knows rad/s only.
#include <cmath>
#include <cstdio>
#include <string>

#include "case/number_text.hpp"

namespace dovetail {

struct FrequencyUnit {
  bool hertz = false;

  const char *name() const { return hertz ? "Hz" : "rad/s"; }
  double radians() const { return hertz ? 2 * M_PI : 1; } ///< one of it [rad/s]

  /// omega [rad/s] as a number of this unit, with the digits that the user wrote.
  std::string number(double omega) const {
    if (!hertz) return number_text(omega);
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.15g", omega / radians()); // without the last bit of the division
    return digits;
  }

  /// omega [rad/s] for messages: "3.2 rad/s", or "0.51 Hz = 3.2 rad/s".
  std::string text(double omega, int digits = 9) const {
    char words[80];
    if (hertz)
      std::snprintf(words, sizeof words, "%.*g Hz = %.*g rad/s", digits, omega / radians(), digits, omega);
    else
      std::snprintf(words, sizeof words, "%.*g rad/s", digits, omega);
    return words;
  }
};

} // namespace dovetail
