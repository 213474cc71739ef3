#pragma once
// A period of motion, looked at.
#include <vector>

namespace dovetail {

/// Motion at equal steps of a period, beginning at theta = 0.
struct Motion {
  int instants = 0, dofs = 0;
  std::vector<double> q, v; ///< (instants, dofs), dofs as in DenseModel; v = dq/dt

  const double *at(int instant) const { return &q[static_cast<std::size_t>(instant) * dofs]; }
  const double *rate_at(int instant) const { return &v[static_cast<std::size_t>(instant) * dofs]; }
};

/// Largest difference at the instants that both have, each dof relative to half its own range in `now`; ranges below
/// 1e-4 of the largest mode's or contact dof's count as that large. `instants` of one divide those of the other.
double difference(const Motion &now, const Motion &before, int modes);

/// (dofs) largest |q - mean|; where the motion turns between two instants, that of the cubic through both. `step`:
/// time between them.
std::vector<double> amplitudes(const Motion &motion, double step);

/// A power of 2 that shows them.
int instants_for(int harmonics);

/// (dofs, 2H+1); more than 2H instants.
std::vector<double> coefficients_of(const Motion &motion, int harmonics);

} // namespace dovetail
