#pragma once
// How arc length is measured. Adaptive runs weigh the motion by the largest met so far and Omega by the sweep, so that
// neither rules: one half of the square is that of the whole motion, the other the mean over the dofs of each one's
// own, so that one dof that moves far does not hide what the others do. The original's fixed step uses the plain norm
// of the scaled unknowns.
#include <vector>

#include "continuation/problem.hpp"
#include "harmonic/layout.hpp"

namespace dovetail {

class ResponseMetric : public ArcLengthMetric {
public:
  ResponseMetric(const Layout &layout, double omega_unit, bool weighted);

  void see(Vec y) override;
  void weigh(Vec t, Vec row) const override;
  double product(Vec a, Vec b) const override;
  double motion(Vec y) const override;
  double largest_motion() const override { return motion_; }
  /// Length of t without the mean values of the motion. Collective.
  double swing(Vec t) const;

  /// The largest motion seen of each own dof.
  const std::vector<double> &largest_of_dofs() const { return dofs_; }
  void restore(double motion, std::vector<double> dofs); ///< Collective.

private:
  void choose_weights();

  MPI_Comm comm_;
  int width_;
  PetscInt own_coefficients_;
  bool owns_omega_, weighted_;
  double omega_;                // unit of frequency
  double motion_ = 0;           // largest seen, plain norm
  std::vector<double> dofs_;    // (own dofs) largest seen of each
  std::vector<double> weights_; // (own dofs) of the squares
};

} // namespace dovetail
