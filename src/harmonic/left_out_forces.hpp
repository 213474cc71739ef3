#pragma once
// What the modes that the reduced model leaves out would do to a periodic motion.
#include <vector>

#include "harmonic/harmonic_system.hpp"

namespace dovetail {

/// The modes left out, each driven by the contacts and by the load, at the value of the parameter that y has. Of a
/// sector, in every harmonic those of its index.
class LeftOutModes {
public:
  LeftOutModes(HarmonicSystem &system, Vec y);

  /// Their motion (2H+1, r), without means, under the motion y of the others and a load of that factor: linear in
  /// both. Collective.
  std::vector<double> motion(Vec y, double load) const;
  /// `residual` becomes what such a motion adds to that of the others. Collective.
  void forces(const std::vector<double> &motion, Vec residual) const;

private:
  struct OfHarmonic {
    const std::vector<double> *squares;
    const LeftOut *real;                            // of a structure, and of index 0
    const LeftOutOf<std::complex<double>> *complex; // of others
    double sign;                                    // of the imaginary part, by the sign of the index
  };
  struct Masses { // (r) that an own dof has in common with them: one of the two
    const double *real;
    const std::complex<double> *complex;
  };
  OfHarmonic of(int k) const;
  Masses masses(const OfHarmonic &left, PetscInt d) const;

  const HarmonicSystem &system_;
  PetscInt count_ = 0; // the most of any index
};

} // namespace dovetail
