#pragma once
// Units of a model from its label, such as "SI" or "t, mm, s, N". Nothing is converted: they are names of numbers. The
// same in Python: python/dovetail/units.py; both are tested by tests/units.txt.
#include <string>

namespace dovetail {

/// Names of units, empty where the label is not understood; angles are in rad, frequencies in Hz all the same.
struct Units {
  std::string length, mass, time, force, energy, stress;
  std::string modal;           ///< of modal unknowns, such as "m √kg"
  std::string omega = "rad/s"; ///< of the excitation frequency; so where nothing is known
  double seconds = 1;          ///< length of the unit of time [s]

  bool known() const { return !length.empty(); }
  /// Frequency [Hz] of an excitation frequency in units of the model.
  double hertz(double value) const;
  /// What stands in place of a unit of the SI, such as "N/m"; "-" and "" as they are.
  std::string instead_of(const std::string &unit) const;
};

/// Of a label: names of units in any order, or "SI". Three of length, mass, time and force are enough. Nothing where it
/// is not understood, or does not fit together.
Units units_of(const std::string &label);

/// " mm", or nothing.
inline std::string behind_number(const std::string &unit) { return unit.empty() ? "" : " " + unit; }

} // namespace dovetail
