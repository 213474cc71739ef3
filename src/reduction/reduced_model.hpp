#pragma once
// The Craig-Bampton model (theory.md, section 3). Contact rows live on the rank that owns the contact point.
#include <cstdint>
#include <vector>

#include "model/full_model.hpp"
#include "support/partition.hpp"

namespace dovetail {

struct ReducedModel {
  MPI_Comm comm = MPI_COMM_NULL;
  std::string units = "SI";    ///< a label, passed on to the results
  PetscInt modes = 0;          ///< N_a
  PetscInt points = 0;         ///< N_x
  Range own_modes, own_points; ///< this rank's share

  std::vector<double> kaa; ///< (N_a) squares of the fixed-interface frequencies [rad^2/s^2]; on every rank
  std::vector<double> fa;  ///< (N_a) F_a; on every rank
  // Own rows, row-major, in the order t1, t2, n of each own point:
  std::vector<double> mxa; ///< (3 own, N_a) M_xa = M_ax^T
  std::vector<double> mxx; ///< (3 own, 3 N_x)
  std::vector<double> kxx; ///< (3 own, 3 N_x)
  std::vector<double> fx;  ///< (3 own) F_x
  std::vector<double> r;   ///< (3 own) R of eq (2)

  PetscInt contact_dofs() const { return 3 * points; }
  PetscInt own_contact_dofs() const { return 3 * own_points.size(); }
};

/// What the elastic displacements are recovered with: x_e = x_e0 + Phi a + Psi (x + x_p). Rows of elastic dofs.
struct Recovery {
  PetscInt elastic = 0;           ///< n_e
  Range own;                      ///< this rank's elastic rows, counted in the order of the model's dofs
  std::vector<long> elastic_dofs; ///< (own) their numbers in the full model
  std::vector<double> xe0;        ///< (own) [m]
  std::vector<double> phi;        ///< (own, N_a) row-major
  std::vector<double> psi;        ///< (own, 3 N_x) row-major
};

struct Reduction {
  ReducedModel model;
  Recovery recovery;
  std::string ordering; ///< fill-reducing ordering MUMPS used
};

/// Eqs (2), (5), (15)-(18) with one factorisation of K_ee. Collective.
/// InputError: N_a > n_e, K_ee not positive definite, a rigid body left in it.
Reduction craig_bampton(const FullModel &model, PetscInt modes);

/// Writes the reduced file of docs/files.md, with the hash of what it was computed from. Collective.
void write_reduced(const std::filesystem::path &file, const FullModel &source, const Reduction &reduction);

/// Reads a reduced file; each rank its own rows. Collective. InputError.
ReducedModel read_reduced(MPI_Comm comm, const std::filesystem::path &file);

/// Number of modes and contact points in a reduced file. Each rank on its own. InputError.
struct ReducedHeader {
  PetscInt modes = 0, points = 0;
};
ReducedHeader read_reduced_header(const std::filesystem::path &file);

/// Throws InputError if `file` exists and Dovetail did not make it: it will not be overwritten. Each rank on its own.
void check_replaceable(const std::filesystem::path &file);

/// True if `file` was made by Dovetail from just this model with this many modes. Collective.
bool matches(const std::filesystem::path &file, const FullModel &source, PetscInt modes);

} // namespace dovetail
