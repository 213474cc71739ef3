#pragma once
// Damping that is not proportional to K and M: i (k Om C + eta S) in harmonic k. C is the sum of
//   - V diag(c) V^T, V = M phi_j, c_j = 2 zeta_j sqrt(lambda_j): ratios of modes of the stuck structure,
//   - diag(2 zeta_j w_j) on the modes of the reduction: ratios of fixed-interface modes,
//   - b times the springs of contacts that stick at the preload state,
//   - the model's viscous matrix;
// S is the model's structural matrix.
#include "contact/law.hpp"
#include "modal/linear_part.hpp"
#include "stuck/stuck_basis.hpp"

namespace dovetail {

class Dampers {
public:
  /// All but ratios of the stuck structure; scaled. Collective.
  Dampers(const ReducedModel &model, const std::vector<ContactPoint> &contact,
          const std::vector<Standstill> &standstill, const Damping &damping, const Layout &layout);
  /// Adds those of the modes of `basis`; `part` knows the mass. Collective.
  void take_ratios(LinearPart &part, const StuckBasis &basis, const std::vector<ModeRatio> &ratios);

  bool is_viscous() const { return viscous_.columns() > 0 || has_diagonal_ || !rates_.empty(); } ///< has C
  bool is_hysteretic() const { return hysteretic_.columns() > 0; }                               ///< has S

  /// out = C q, out = S q, (own coefficients) of any number of harmonics. Collective.
  void viscous_force(const double *q, int width, double *out) const;
  void hysteretic_force(const double *q, int width, double *out) const;

  struct Entry {
    PetscInt row, column; ///< of the harmonic system's dofs
    double viscous, hysteretic;
  };
  std::vector<Entry> entries() const; ///< own rows, whole. Collective.

  /// Phi^T C Phi and Phi^T S Phi, but for ratios of the stuck structure, which are diagonal there. Collective.
  void project(StuckBasis &basis) const;

private:
  void add_dense(const Slab<double> &rows, const double *q, int width, double *out) const;
  void add_local(const double *q, int width, double *out) const;
  Slab<double> own_rows(const DampingMatrix &matrix, const ReducedModel &model) const;

  Layout layout_;
  std::vector<double> rates_, shapes_; // (r) c, (own dofs, r) V
  bool has_diagonal_ = false;          // on every rank alike, also where one owns no dof
  std::vector<double> diagonal_;       // (own dofs)
  Slab<double> viscous_, hysteretic_;  // (own dofs, n) columns in the order of the results; or none
};

} // namespace dovetail
