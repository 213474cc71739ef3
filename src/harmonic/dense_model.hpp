#pragma once
// The scaled equations of motion of the reduced model, whole and dense on every rank: what small models are integrated
// in time with, and their stability computed from. Every rank does the same work on it and gets the same numbers.
#include "harmonic/harmonic_system.hpp"

namespace dovetail {

/// M q'' + (b K + a M + C) q' + K q + g(q) = sum of the loads, scaled; q from the preload state: modes first, then t1,
/// t2, n of each contact point, as in the results. g acts on the contact dofs: g(x + x_p) - g(x_p).
struct DenseModel {
  int modes = 0, points = 0;
  std::vector<double> K, M;    ///< (n, n), n = modes + 3 points, row-major, symmetric
  std::vector<double> C;       ///< (n, n) viscous, besides what is proportional to K and M; or empty
  std::vector<LoadCase> loads; ///< by dof
  Damping damping;
  std::vector<ContactPoint> contact;  ///< (points)
  std::vector<Standstill> standstill; ///< (points)
  std::filesystem::path file;         ///< of the reduced model, for messages

  int dofs() const { return modes + 3 * points; }
  double viscous(std::size_t at) const { return damping.viscous(K[at], M[at]) + (C.empty() ? 0 : C[at]); }
};

/// At the parameter that the system was set to last. Collective; memory n^2 on every rank.
DenseModel dense_model(const HarmonicSystem &system);

/// All coefficients (n, 2H+1) of y on every rank, in that order, and back, from any number of harmonics. Collective.
std::vector<double> all_coefficients(const Layout &layout, Vec y);
void set_coefficients(const Layout &layout, const std::vector<double> &coefficients, Vec y);

/// z = y with other harmonics: dropped, or zero.
void pad(const Layout &from, Vec y, const Layout &to, Vec z);

} // namespace dovetail
