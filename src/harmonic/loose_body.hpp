#pragma once
// A body held by its joint alone: K_xx lets it move as a whole. While its contacts are open, or slip, all through the
// period, nothing holds its mean position, and the Jacobian is singular.
#include <vector>

#include "stuck/layout.hpp"

namespace dovetail {

class LooseBody {
public:
  LooseBody() = default;
  /// K_xx (own rows, all columns), scaled. Collective.
  LooseBody(const ReducedModel &model, const Layout &layout);

  int motions() const { return motions_; } ///< rigid motions that only the joint holds

  /// True if one of them is held by nothing. `mean_stiffness` (own contact dofs): by which the joint's mean force
  /// follows its mean displacement; `springs`: of the joint closed and stuck. Collective.
  bool adrift(const std::vector<double> &mean_stiffness, const std::vector<double> &springs) const;
  /// The same in two steps: what all ranks add up, and the judgement of the sum.
  std::vector<double> held(const std::vector<double> &mean_stiffness, const std::vector<double> &springs) const;
  bool adrift(const double *held) const;

private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  int motions_ = 0;
  std::vector<double> rigid_; // (motions, own contact dofs), orthonormal over all ranks
};

} // namespace dovetail
