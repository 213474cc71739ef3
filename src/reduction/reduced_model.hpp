#pragma once
// The Craig-Bampton model (docs/theory/equations.md, section 3). Contact rows live on the rank that owns the contact
// point.
#include <complex>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "reduction/memory_plan.hpp"
#include "support/partition.hpp"
#include "support/stage.hpp"

namespace dovetail {

/// Modes beyond the N_a lowest, as good as a few right-hand sides tell: what is left out of the model, for estimates of
/// what that does. Nothing in it if that is not known, or if nothing is left out.
template <class Number> struct LeftOutOf {
  std::vector<double> squares;            ///< (r) squares of their frequencies, ascending [rad^2/s^2]; on every rank
  std::vector<std::vector<Number>> loads; ///< (L, r) like F_a of each load pattern; on every rank
  std::vector<Number> coupling;           ///< (3 own, r) row-major, like M_xa
  std::vector<Number> with_modes;         ///< (N_a, r) row-major: their mass in common with the N_a; on every rank
};
using LeftOut = LeftOutOf<double>;

/// F_a,j and F_x,j of one load pattern, eqs (17) and (18).
struct LoadPattern {
  std::string name = force_pattern;
  std::vector<double> fa; ///< (N_a); on every rank
  std::vector<double> fx; ///< (3 own)
};

/// A damping matrix besides K and M, by blocks as the mass.
struct DampingMatrix {
  bool given = false;
  std::vector<double> aa; ///< (N_a, N_a) row-major; on every rank
  std::vector<double> xa; ///< (3 own, N_a)
  std::vector<double> xx; ///< (3 own, 3 N_x)
};

/// A sector of a cyclic structure in motions of index h > 0, each sector exp(-2 pi i h / N) times the one before it:
/// what stands in place of the real matrices. Hermitian; those of -h are the conjugates.
struct SectorIndex {
  struct Load {                           // T_h^H F of a load pattern
    std::vector<std::complex<double>> fa; ///< (N_a); on every rank
    std::vector<std::complex<double>> fx; ///< (3 own)
  };
  std::vector<double> kaa;               ///< (N_a) squares of the fixed-interface frequencies; on every rank
  std::vector<std::complex<double>> mxa; ///< (3 own, N_a) M_xa = M_ax^H
  std::vector<std::complex<double>> mxx; ///< (3 own, 3 N_x)
  std::vector<std::complex<double>> kxx; ///< (3 own, 3 N_x)
  std::vector<Load> loads;               ///< (L) as those of the model
  LeftOutOf<std::complex<double>> left_out;
};

struct ReducedModel {
  MPI_Comm comm = MPI_COMM_NULL;
  std::filesystem::path file;  ///< it was read from, or reduced from; for messages
  std::string units = "SI";    ///< a label, passed on to the results
  std::string fingerprint;     ///< of all numbers below: fingerprint_of()
  bool as_written = true;      ///< read with the fingerprint that its file carries, or its file has none
  PetscInt modes = 0;          ///< N_a
  PetscInt points = 0;         ///< N_x
  Range own_modes, own_points; ///< this rank's share

  std::vector<double> kaa; ///< (N_a) squares of the fixed-interface frequencies [rad^2/s^2]; on every rank
  // Own rows, row-major, in the order t1, t2, n of each own point:
  std::vector<double> mxa; ///< (3 own, N_a) M_xa = M_ax^T
  std::vector<double> mxx; ///< (3 own, 3 N_x)
  std::vector<double> kxx; ///< (3 own, 3 N_x)
  std::vector<double> r;   ///< (3 own) R of eq (2)

  DampingMatrix viscous;    ///< C [N s/m], of modes [1/s]
  DampingMatrix structural; ///< what damping.structural is of, in place of K [N/m]

  std::vector<LoadPattern> loads = {{}}; ///< (L)
  /// Number of the pattern of that name. InputError if there is none.
  std::size_t load(const std::string &name) const;

  int sectors = 0; ///< N of a cyclic structure, of which this is a sector in index 0; 0: of no such one
  std::vector<SectorIndex> indices; ///< (N / 2) of h = 1 .. N / 2

  std::vector<double> watched; ///< (N_a + 3 N_x) the motion of the node watched, on every rank; empty: none is
  /// Of a cyclic sector in its place, by index h = 0 .. N / 2.
  std::vector<std::vector<std::complex<double>>> watched_by_index;
  LeftOut left_out;
  std::filesystem::path stuck_file; ///< where the modes of the stuck structure may be kept; empty: nowhere

  PetscInt contact_dofs() const { return 3 * points; }
  PetscInt own_contact_dofs() const { return 3 * own_points.size(); }
};

/// What is wrong, and what to do, where the mass of a reduced model from `file` is not positive definite.
std::string mass_not_positive(const std::filesystem::path &file);

/// What the elastic displacements are recovered with: x_e = x_e0 + Phi a + Psi (x + x_p). Rows of the elastic dofs
/// whose motion is wanted.
struct Recovery {
  std::vector<long> elastic_dofs; ///< (own) their numbers in the full model
  std::vector<double> xe0;        ///< (own) [m]
  std::vector<double> phi;        ///< (own, N_a) row-major
  std::vector<double> psi;        ///< (own, 3 N_x) row-major
  struct OfIndex {
    std::vector<std::complex<double>> phi, psi; ///< likewise
  };
  std::vector<OfIndex> indices; ///< (N / 2) of a cyclic sector in h = 1 .. N / 2
};

struct Reduction {
  ReducedModel model;
  Recovery recovery;
  double backward_error =
      0; ///< of the first column of Psi: || K_ee psi + k_ec || / (|| K_ee || || psi || + || k_ec ||)
};

/// Which modes are kept beside the constraint modes.
enum class ModeKind {
  eigen,   ///< the lowest fixed-interface modes: Craig-Bampton
  residual ///< fewer of them, and residuals of the rest: with_residuals()
};

struct ReductionSettings {
  ModeKind kind = ModeKind::eigen;
  PetscInt modes = 0;       ///< N_a
  bool check_modes = false; ///< count the modes below the last one by a factorisation of its own
  std::vector<char> wanted; ///< (own elastic dofs) 1 where the motion is wanted later
};

/// Eqs (2), (5), (15)-(18) with one factorisation of K_ee, in stages 2c to 2f. Collective. InputError: K_ee not
/// positive definite, a rigid body left in it. ComputeError: a mode was missed.
Reduction craig_bampton(ClampedStructure &&parts, const ReductionSettings &settings, const MemoryPlan &plan,
                        Stages &stages);

/// What a reduced file was computed from and is checked against.
struct Source {
  std::filesystem::path file;
  std::uint64_t hash = 0; ///< FullModel::hash
  std::string units;
  PetscInt modes = 0;
  ModeKind kind = ModeKind::eigen;
  bool modes_counted = false; ///< none missed below the last one: made sure of
  std::string motion;         ///< which rows of Phi and Psi are kept, in words or as a number made of them
  std::string ordering;
  std::vector<std::array<PetscInt, 3>> contact_dofs;
  std::vector<double> area = {}; ///< (N_x) of the contact points [m^2], or empty
  PetscInt interior_modes = 0;   ///< of a cyclic sector: those that its indices share
  bool exact_modes = false;      ///< likewise: that do not depend on how many these are
};

/// A number made of all numbers of a reduced model, the same on any number of ranks. Collective.
std::string fingerprint_of(const ReducedModel &model);

/// Writes the reduced file of docs/reference/files.md. Collective.
void write_reduced(const std::filesystem::path &file, const Source &source, const Reduction &reduction);

/// Reads a reduced file; each rank its own rows. Collective. InputError.
ReducedModel read_reduced(MPI_Comm comm, const std::filesystem::path &file);

/// The sum of some dofs of the full model, each with a factor, by the reduced unknowns: (N_a + 3 N_x). From a reduced
/// file that keeps their motion. Each rank on its own. InputError.
std::vector<double> recovered_row(const std::filesystem::path &file, const std::vector<PetscInt> &dofs,
                                  const std::vector<double> &factors);
/// The same of a sector of so many, in each index h = 0 .. N / 2.
std::vector<std::vector<std::complex<double>>> recovered_rows(const std::filesystem::path &file, int sectors,
                                                              const std::vector<PetscInt> &dofs,
                                                              const std::vector<double> &factors);

/// What a reduced file holds of modes, contact points and load patterns. Each rank on its own. InputError.
struct ReducedHeader {
  PetscInt modes = 0, points = 0;
  std::vector<std::string> loads; ///< names of the patterns
  bool has_c = false, has_structural = false;
  std::vector<double> area = {}; ///< (N_x) of the contact points [m^2], or empty
  std::string units = "SI";
  int sectors = 0; ///< of a cyclic structure, of which this is one; 0: of no such one
};
ReducedHeader read_reduced_header(const std::filesystem::path &file);

/// Throws InputError if `file` exists and Dovetail did not make it: it will not be overwritten. Each rank on its own.
void check_replaceable(const std::filesystem::path &file);

/// True if `file` was made by Dovetail from just this. Collective.
bool matches(MPI_Comm comm, const std::filesystem::path &file, const Source &source);

} // namespace dovetail
