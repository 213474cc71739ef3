#include "stuck/sector_pencil.hpp"

#include "support/gathered.hpp"

namespace dovetail {

using Complex = std::complex<double>;

HermitianPencil pencil(const ReducedModel &model, const SectorIndex &index, const std::vector<double> &springs,
                       int root) {
  const PetscInt na = model.modes, nc = model.contact_dofs(), first = 3 * model.own_points.begin;
  std::vector<Complex> stiffness = index.kxx;
  for (std::size_t i = 0; i < springs.size(); ++i) stiffness[i * nc + first + i] += springs[i];
  const auto whole = [&](const std::vector<Complex> &own) {
    return gathered(model.comm, MPI_C_DOUBLE_COMPLEX, own, root);
  };
  const std::vector<Complex> kxx = whole(stiffness), mxx = whole(index.mxx), mxa = whole(index.mxa);
  int rank;
  MPI_Comm_rank(model.comm, &rank);
  if (rank != root) return {};
  HermitianPencil made{ComplexDense(na + nc, na + nc), ComplexDense(na + nc, na + nc)};
  for (PetscInt j = 0; j < na; ++j) made.K(j, j) = index.kaa[j], made.M(j, j) = 1;
  for (PetscInt i = 0; i < nc; ++i) {
    for (PetscInt j = 0; j < nc; ++j)
      made.K(na + i, na + j) = kxx[std::size_t(i) * nc + j], made.M(na + i, na + j) = mxx[std::size_t(i) * nc + j];
    for (PetscInt j = 0; j < na; ++j) {
      made.M(na + i, j) = mxa[std::size_t(i) * na + j];
      made.M(j, na + i) = std::conj(mxa[std::size_t(i) * na + j]);
    }
  }
  return made;
}

} // namespace dovetail
