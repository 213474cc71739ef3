#pragma once
// Where each unknown of the harmonic-balance system lives. Per rank: its modes, then t1, t2, n of its contact points,
// 2H+1 Fourier coefficients each; Omega is the very last unknown, on the last rank.
#include "contact/fourier.hpp"
#include "reduction/reduced_model.hpp"

namespace dovetail {

class Layout {
public:
  Layout(const ReducedModel &model, int harmonics)
      : comm(model.comm), width(coefficient_count(harmonics)), modes(model.modes), points(model.points),
        own_modes(model.own_modes), own_points(model.own_points) {
    MPI_Comm_rank(comm, &rank);
    MPI_Comm_size(comm, &size);
  }

  MPI_Comm comm;
  int rank = 0, size = 1;
  int width; ///< 2H+1
  PetscInt modes, points;
  Range own_modes, own_points;

  PetscInt dofs() const { return modes + 3 * points; } ///< of the reduced model
  PetscInt own_dofs() const { return own_modes.size() + 3 * own_points.size(); }
  PetscInt first_dof() const { return own_modes.begin + 3 * own_points.begin; } ///< number of the first own one
  /// Number of a mode's or a contact dof's (3 point + direction) row; its coefficients are unknowns row * width + i.
  PetscInt mode_row(PetscInt mode) const {
    return mode + 3 * share_of(points, modes > 0 ? owner_of(modes, mode, size) : 0, size).begin;
  }
  PetscInt contact_row(PetscInt dof) const { return dof + share_of(modes, owner_of(points, dof / 3, size), size).end; }
  /// Place of an own contact point's first coefficient among the own unknowns.
  PetscInt own_point_offset(PetscInt local_point) const { return (own_modes.size() + 3 * local_point) * width; }

  /// Number of own dof d in the order of the results: modes, then t1, t2, n of each contact point.
  PetscInt number(PetscInt d) const {
    return d < own_modes.size() ? own_modes.begin + d : modes + 3 * own_points.begin + d - own_modes.size();
  }

  bool owns_omega() const { return rank == size - 1; }
  PetscInt own_coefficients() const { return own_dofs() * width; }
  PetscInt own_unknowns() const { return own_coefficients() + (owns_omega() ? 1 : 0); }
  PetscInt unknowns() const { return dofs() * width + 1; } ///< with Omega
  PetscInt omega_row() const { return unknowns() - 1; }
};

} // namespace dovetail
