#pragma once
// Is a travelling wave on a cyclic structure stable, against changes of every nodal diameter?
#include "harmonic/harmonic_system.hpp"
#include "stability/sector_hill.hpp"
#include "stability/stability.hpp"

namespace dovetail {

class SectorStabilityTest {
public:
  /// Of a sector that keeps its indices (ScaledModel), at the joint and the damping that it was set to last. Keeps the
  /// matrices only by their place in `system`, which must outlive it. Collective.
  explicit SectorStabilityTest(const HarmonicSystem &system);

  /// coefficients (n, 2H+1), scaled, as all_coefficients gives them; of any H. Ranks share the nodal diameters.
  /// Collective.
  Stability judge(const std::vector<double> &coefficients, double omega);

private:
  struct Task {
    int shift, strip;
  };

  std::vector<Task> tasks(bool sampled) const;

  MPI_Comm comm_;
  SectorEquations equations_;
  DenseModel points_; // the contact points, without structure
};

} // namespace dovetail
