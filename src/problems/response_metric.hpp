#pragma once
// How arc length is measured. Adaptive runs weigh the motion by the largest met so far and Omega by the sweep, so that
// neither rules: one half of the square is that of the whole motion, the other the mean over the dofs of each one's
// own, so that one dof that moves far does not hide what the others do. The original's fixed step uses the plain norm
// of the scaled unknowns.
#include <array>
#include <vector>

#include "continuation/problem.hpp"
#include "stuck/layout.hpp"

namespace dovetail {

class ResponseMetric : public ArcLengthMetric {
public:
  ResponseMetric(const Layout &layout, double omega_unit, bool weighted);

  void see(Vec y) override;
  void weigh(Vec t, Vec row) const override;
  std::vector<double> products(const std::vector<Pair> &pairs, const std::vector<Vec> &moving,
                               const std::vector<Vec> &known) const override;
  double largest_motion() const override { return motion_; }
  struct Lengths {
    double whole, swing; ///< the latter without the mean values of the motion
  };
  /// see(), and the lengths of a way as it was measured before; `sums` become those over all ranks, by the same
  /// message. Collective.
  Lengths see(Vec y, Vec way, std::vector<Problem::Projected> &sums);

  /// The largest motion seen of each own dof.
  const std::vector<double> &largest_of_dofs() const { return dofs_; }
  void restore(double motion, std::vector<double> dofs); ///< Collective.

private:
  void choose_weights(double largest);
  double largest_of_own() const;
  void note(Vec y);
  double square(Vec y) const; // of the own motion, plain
  std::array<double, 2> squares_of(Vec way) const;
  double square_of_unit() const { return weighted_ ? omega_ * omega_ : 1; }

  MPI_Comm comm_;
  int width_;
  PetscInt own_coefficients_, all_dofs_;
  bool owns_omega_, weighted_;
  double omega_;                // unit of frequency
  double motion_ = 0;           // largest seen, plain norm
  std::vector<double> dofs_;    // (own dofs) largest seen of each
  std::vector<double> weights_; // (own dofs) of the squares
};

} // namespace dovetail
