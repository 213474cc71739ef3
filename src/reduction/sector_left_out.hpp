#pragma once
// What the modes kept of one index of a cyclic sector leave out: of the modes that the second level knows, and of those
// that the interior ones leave out, which are the same for all indices. Dense.
#include "reduction/sector_elastic.hpp"

namespace dovetail {

struct LeftOutIndex { ///< as LeftOutOf, whole
  std::vector<double> squares;
  std::vector<ComplexDense> loads;   ///< (r, 1)
  ComplexDense coupling, with_modes; ///< (3 N_x, r), (N_a, r)
};

/// Modes of K and M with the squares of their frequencies, M-normal, K-orthogonal.
struct ElasticModesOfIndex {
  std::vector<double> squares;
  ComplexDense shapes; ///< (n, count); or without the last rows, of interior modes left out, which are zero
};

/// Puts what moving contacts and loads ask of all other modes in place of the highest half of the modes, 16 at most.
/// Interior modes left out take no part. Returns how many there are.
int with_residuals(const ElasticIndex &elastic, ElasticModesOfIndex &modes);

/// What the modes leave out, of which the last `residuals` are such. `exact`: the others are as good as if nothing were
/// left out of the interior modes.
LeftOutIndex left_out(const ElasticIndex &elastic, ElasticModesOfIndex kept, int residuals, bool exact);

} // namespace dovetail
