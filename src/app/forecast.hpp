#pragma once
// Sizes of a run and memory of its harmonic balance, known before it starts.
#include <iosfwd>
#include <string>

#include "case/case.hpp"
#include "reduction/reduced_model.hpp"

namespace dovetail {

struct Forecast {
  PetscInt dofs = 0;   ///< of the full model; 0 when the reduced one is given
  double nonzeros = 0; ///< stored entries of its K
  PetscInt modes = 0, points = 0;
  double unknowns = 0;         ///< (N_a + 3 N_x)(2H+1) + 1
  double jacobian_entries = 0; ///< of the assembled form
  double solve_gib = 0;        ///< of the harmonic balance, over all ranks; of peaks: of their two matrices
};

Forecast forecast(const ModelHeader &header, const Case &study);
Forecast forecast(const ReducedHeader &header, const Case &study);
void describe(std::ostream &out, const Forecast &sizes);

/// Throws ComputeError where a matrix that is factored as a whole would not fit into memory: `who` does that, and
/// `less` is what takes less, in words. Collective.
void check_memory(MPI_Comm comm, const Forecast &sizes, const std::string &who, const std::string &less);

} // namespace dovetail
