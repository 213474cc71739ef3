#pragma once
// What the modes kept of one index of a cyclic sector leave out: of the modes that the second level knows, and of those
// that the interior ones leave out, which are the same for all indices. Dense.
#include "reduction/reduced_model.hpp"
#include "support/hermitian.hpp"

namespace dovetail {

/// What moves with x held: interior modes, s, and interior modes left out, n in all. K is diag(squares, S, beyond).
struct ElasticIndex {
  const std::vector<double> &squares, &beyond;
  ComplexDense S;                  ///< stiffness of s
  ComplexDense M;                  ///< (n, n)
  ComplexDense carried;            ///< (n, 3 N_x) M_ee Psi + M_ex
  std::vector<ComplexDense> loads; ///< (n, 1) of the load patterns
};

struct LeftOutIndex { ///< as LeftOutOf, whole
  std::vector<double> squares;
  std::vector<ComplexDense> loads;   ///< (r, 1)
  ComplexDense coupling, with_modes; ///< (3 N_x, r), (N_a, r)
};

/// `kept`: (n, N_a) modes, with the squares of their frequencies; `exact`: as good as if nothing were left out of the
/// interior ones.
LeftOutIndex left_out(const ElasticIndex &elastic, ComplexDense kept, std::vector<double> squares, bool exact);

} // namespace dovetail
