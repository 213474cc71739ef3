#pragma once
// What the modes that the reduced model leaves out would do to a periodic motion.
#include <vector>

#include "harmonic/harmonic_system.hpp"

namespace dovetail {

/// The modes left out, each driven by the contacts and by the load, at the value of the parameter that y has.
class LeftOutModes {
public:
  LeftOutModes(HarmonicSystem &system, Vec y);

  /// Their motion (r, 2H+1), without means, under the motion y of the others and a load of that factor: linear in
  /// both. Collective.
  std::vector<double> motion(Vec y, double load) const;
  /// `residual` becomes what such a motion adds to that of the others. Collective.
  void forces(const std::vector<double> &motion, Vec residual) const;

private:
  const double *mass(PetscInt own_dof) const; // (r) that it has in common with them

  const HarmonicSystem &system_;
  const LeftOut &left_;
  PetscInt count_;
};

} // namespace dovetail
