#pragma once
// The stiffness of the joint in its preload, K_xx with the slopes of the contact laws, which is dense, and solves with
// it.
#include <array>
#include <vector>

#include "reduction/reduced_model.hpp"
#include "support/block_cyclic.hpp"
#include "support/error.hpp"
#include "support/handle.hpp"

namespace dovetail {

/// For matrices of all contact dofs, by the rows of the own ones.
BlockCyclic contact_grid(const ReducedModel &model);

/// Factors of another stiffness make GMRES quick while few points are in another state; where they do not, the
/// stiffness at hand is factored. Vectors are of the own contact dofs. All that is called here is collective.
class PreloadTangent {
public:
  using Slope = std::array<std::array<double, 3>, 3>; ///< d force / d x of a point [N/m]

  explicit PreloadTangent(const ReducedModel &model); ///< which must outlive it

  std::vector<double> structure_times(const double *x) const; ///< K_xx x
  /// Factors of this stiffness serve for good, where they are worth it.
  void keep(const std::vector<Slope> &slopes);
  /// Factors of the stiffnesses at hand do not serve any more: what is solved after this does not depend on what was
  /// before.
  void forget() { at_hand_.of.drop(); }
  /// x = (K_xx + slopes)^-1 b. False, and x without meaning, where that is singular.
  bool solve(const std::vector<Slope> &slopes, const std::vector<double> &b, std::vector<double> &x);
  int factorisations() const { return factorisations_; } ///< so far

  template <class Work> PetscErrorCode run(Work &&work) { return courier_.run(work); } ///< for PETSc

private:
  struct Factored {
    SpreadFactors of; // M = K_xx + slopes
    std::vector<Slope> slopes;
  };
  void multiply_changed(Vec forces, Vec out);
  std::vector<double> motion(const double *forces) const; // M^-1 forces
  bool factor(Factored &factors);
  const Factored &factors() const; // what solves go by
  PetscInt worth() const;
  KSPConvergedReason iterate(PetscInt most);
  std::vector<double> from_all(const double *own) const;

  const ReducedModel &model_;
  std::vector<int> counts_, starts_; // of the contact dofs of each rank
  const BlockCyclic grid_;
  Factored kept_, at_hand_;
  int factorisations_ = 0;
  std::vector<Slope> slopes_;
  UniqueMat changed_;
  UniqueVec right_, answer_;
  UniqueKSP ksp_;
  Courier courier_;
};

} // namespace dovetail
