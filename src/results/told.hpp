#pragma once
// Unknowns and numbers in words, with the units of the model.
#include <string>

#include "results/point_record.hpp"
#include "support/units.hpp"

namespace dovetail {

struct Told {
  Units units;
  std::string watch;  ///< of the case: the name of an unknown or a node, or empty
  PetscInt modes = 0; ///< N_a

  std::string name(int unknown) const { return name_of_unknown(unknown, modes, watch); }
  const std::string &unit(int unknown) const { return unknown >= 0 && unknown < modes ? units.modal : units.length; }
  /// Such as "x3.n: 1.2e-06 m".
  std::string amplitude(int unknown, double amplitude) const;
};

} // namespace dovetail
