#pragma once
// What a curve is followed over, how far, and how its values are shown.
#include "case/frequency_unit.hpp"
#include "contact/path_parameter.hpp"
#include "support/units.hpp"

namespace dovetail {

/// What a nonlinear mode is followed over.
inline const PathParameter &modal_amplitude() {
  static const PathParameter parameter{"modal amplitude", "m kg^1/2", PathParameter::Scale::none, false, nullptr};
  return parameter;
}

struct CurveRange {
  const PathParameter *parameter = &frequency_parameter();
  double from = 0, to = 0; ///< frequencies [rad/s], factors, an offset of the gap [m], or modal amplitudes
  const char *key = "continuation.omega"; ///< that gives it
  FrequencyUnit unit;
  bool of_peaks = false; ///< the frequency is that of the peak, another one at every value

  bool is_sweep() const { return parameter == &frequency_parameter(); } ///< over the frequency
  double shown(double value) const { return is_sweep() ? value / unit.radians() : value; }
  std::string heading(const Units &units) const {
    if (is_sweep()) return unit.hertz ? "frequency [Hz]" : "Omega [" + unit.omega + "]";
    return std::string(parameter->name) + " [" + units.instead_of(parameter->unit) + "]";
  }
  const char *at_key() const {
    return is_sweep() ? "continuation.at" : parameter == &modal_amplitude() ? "mode.at" : "path.at";
  }
  /// For messages, behind "at": "3.2 rad/s", or "friction 0.5".
  std::string text(double value, int digits = 9) const {
    if (is_sweep()) return unit.text(value, digits);
    char number[40];
    std::snprintf(number, sizeof number, "%.*g", digits, value);
    return std::string(parameter->name) + " " + number;
  }
};

} // namespace dovetail
