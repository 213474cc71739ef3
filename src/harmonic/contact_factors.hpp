#pragma once
// The bordered Jacobian factored in the modes of the stuck structure (docs/points.md). There it is diagonal, D, but for
// the contact points that do not stick all round, whose part Delta = dG - K_t (1 + i k Om xi) has few rows:
//     (D + Phi_c^T Delta Phi_c)^-1 = D^-1 - D^-1 Phi_c^T Delta (I + F Delta)^-1 Phi_c D^-1,   F = Phi_c D^-1 Phi_c^T.
// I + F Delta is dense, 2H+1 rows for each direction in which the law of such a point acts, and factored by LAPACK: in
// double precision, or where it is large in single. Of the points that stick only the damping is not that of the basis;
// its diagonal in the modes is in D, the rest, small, is not: what is solved with is exact if none sticks, and close
// otherwise. Every rank factors and solves the same.
#include <cstdint>
#include <vector>

#include "harmonic/linear_part.hpp"
#include "harmonic/rough_factors.hpp"
#include "harmonic/stuck_basis.hpp"

namespace dovetail {

class ContactFactors {
public:
  /// `basis` must outlive this.
  ContactFactors(const StuckBasis &basis, const Layout &layout);

  /// Looks at which points move at the Jacobian to come, or takes all of them to. Collective.
  void look_at(const ContactForces &contact, bool all);
  PetscInt size() const { return static_cast<PetscInt>(all_moving_.size()) * layout_.width; } ///< of I + F Delta
  double work() const;          ///< to factor, in operations in single precision that take as long
  double work_to_solve() const; ///< once, likewise

  /// After look_at. `precisely`: large ones too are factored in double precision. False: singular, or no number.
  /// Collective.
  bool factor(const JacobianParts &parts, bool precisely = false);
  void forget() { sign_ = 0; }
  bool factored() const { return sign_ != 0; }
  bool of_all() const { return points_ == layout_.points; }     ///< points
  bool exact() const { return of_all() && rough_.size() == 0; } ///< what was factored, if it is the Jacobian still
  /// x = inverse times r, (own unknowns) both. Collective.
  void solve(const double *r, double *x);
  int determinant_sign() const { return sign_; } ///< of what was factored

private:
  void gather_rows();
  void weigh();
  void fill();
  void decompose(bool precisely);
  void gather_deltas(const JacobianParts &parts);
  void to_modes(const double *own, std::vector<double> &y) const;
  void solve_in_modes(std::vector<double> &y);

  const StuckBasis &basis_;
  Layout layout_;
  std::size_t n_;                    // modes of the basis
  std::vector<int> moving_;          // own contact dofs of points that do not stick, where their laws act
  std::vector<PetscInt> all_moving_; // those of all ranks, by number
  std::vector<int> shares_;          // how many of them each rank owns
  std::vector<PetscInt> factored_;   // those that were factored, from here on `rows`,
  PetscInt points_ = 0;              // and of how many points they are
  std::vector<double> rows_;         // (rows, n) their Phi_c
  double omega_ = 0, damping_ = 0;
  std::vector<double> own_, other_; // (n, H+1) D^-1 = [own, -other; other, own] of a mode and harmonic
  std::vector<double> flexible_;    // (rows, rows) F of one harmonic, its part in phase, then out of phase
  std::vector<double> scaled_;      // (rows, n)
  std::vector<double> matrix_;      // (size, size) I + F Delta, row-major, then its factors
  struct Block {                    // of Delta, between two of them that are of one point
    std::size_t row, column;
    bool acts; // not zero
  };
  std::vector<Block> blocks_;
  std::vector<double> delta_;        // (blocks, 2H+1, 2H+1)
  std::vector<double> written_;      // all blocks of one point
  RoughFactors rough_;               // the same in single precision, in its place if there are any
  std::vector<PetscBLASInt> pivots_; // (size)
  std::vector<double> b_, c_;        // (n, 2H+1) the inverse times the border's column; its row
  std::vector<double> y_, motion_, force_;
  std::vector<float> rough_motion_;
  double schur_ = 1;
  int sign_ = 0;
};

} // namespace dovetail
