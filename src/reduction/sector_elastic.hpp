#pragma once
// The first level of a sector's reduction, whole, and what of an index moves with x held. Dense.
#include "reduction/reduced_model.hpp"
#include "reduction/sector_coordinates.hpp"

namespace dovetail {

/// The model of dofs b, on every rank.
struct FirstLevel {
  PetscInt modes = 0, held = 0;
  std::vector<double> squares, mass, stiffness, coupling; // (modes), (held, held) twice, (held, modes) row-major
  std::vector<std::vector<double>> fa, fx;                // of the load patterns
  std::vector<double> r;
  LeftOut beyond; // of the interior modes
};

/// Collective.
FirstLevel first_level(ReducedModel &&model);

/// What moves with x held: interior modes, s, and interior modes left out, n in all. K is diag(squares, S, beyond).
struct ElasticIndex {
  std::vector<double> squares, beyond;
  ComplexDense S;                  ///< stiffness of s
  ComplexDense M;                  ///< (n, n)
  ComplexDense carried;            ///< (n, 3 N_x) M_ee Psi + M_ex
  std::vector<ComplexDense> loads; ///< (n, 1) of the load patterns
};

/// `K`, `M`: E^H S E and E^H M_bb E; `psi`: of s by x.
ElasticIndex elastic_index(const SectorCoordinates &E, const FirstLevel &first, const ComplexDense &K,
                           const ComplexDense &M, const ComplexDense &psi);

} // namespace dovetail
