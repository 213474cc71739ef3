#pragma once
// The finite-element model as it comes from file: K, M, F, P of eq (1), rows distributed over the ranks.
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "model/cyclic_sector.hpp"
#include "support/handle.hpp"

namespace dovetail {

struct ForcePattern {
  std::string name; ///< "force" of the dataset /force, else of its dataset in the group /forces
  UniqueVec values; ///< (n,)
};

struct FullModel {
  MPI_Comm comm = MPI_COMM_NULL;
  std::filesystem::path file;
  std::string units = "SI";                          ///< a label, passed on to the results
  PetscInt dofs = 0;                                 ///< n
  UniqueMat K, M;                                    ///< (n, n) AIJ, symmetric [N/m], [kg]
  UniqueMat C, K_structural;                         ///< likewise, viscous [N s/m], hysteretic [N/m]; or none
  std::vector<ForcePattern> forces;                  ///< F_j [N], each with a name
  UniqueVec preload;                                 ///< (n,) P [N]
  std::vector<std::array<PetscInt, 3>> contact_dofs; ///< (N_x): t1, t2, n of each contact point; on every rank
  CyclicSector cyclic;                               ///< in place of contact_dofs, if the model is such a sector
  UniqueMat change;                                  ///< T, if all this is in unknowns q of a sector, u = T q; or none
  std::vector<PetscInt> moved;                       ///< then: own dofs u whose motion is wanted later, ascending
  ContactSettings contact;                           ///< what the model file says of the contact law
  std::uint64_t hash = 0; ///< of everything the reduction depends on; the same on any number of ranks
};

struct ModelHeader {
  PetscInt dofs = 0, points = 0;
  double nonzeros = 0; ///< stored entries of K
  ContactSettings contact;
  std::vector<std::string> forces; ///< names of the patterns
  bool has_c = false, has_structural = false;
  std::string units = "SI";
  int sectors = 0; ///< of the cyclic structure whose sector the model is; 0: it is none
};

/// The dofs, ascending, whose motion gives that of the sets and nodes wished for; `all` is left to the caller. Each
/// rank on its own. InputError.
std::vector<PetscInt> motion_dofs(const std::filesystem::path &file, const MotionWish &wish);

/// The motion of the node or node set that is watched, as a sum over dofs of the model.
struct NodeMotion {
  std::vector<PetscInt> dofs; ///< ascending
  std::vector<double> factors;
};

/// Of a set of several nodes the mean; nodes held in the direction count as zero. Each rank on its own. InputError.
NodeMotion node_motion(const std::filesystem::path &file, const Watch &watch);

/// Sizes and contact parameters only, for checks and forecasts. Each rank on its own.
ModelHeader read_model_header(const std::filesystem::path &file);

/// Reads and checks a model file (docs/reference/files.md, "Model file"); each rank reads its own rows. Collective.
/// InputError.
FullModel read_full_model(MPI_Comm comm, const std::filesystem::path &file);

} // namespace dovetail
