#include "stuck/joint_shapes.hpp"

#include <petscsys.h>
// needs the one above
#include <petscblaslapack.h>

#include <cmath>
#include <random>

#include "support/hermitian.hpp"

namespace dovetail {
namespace {

constexpr PetscBLASInt most = 24;
constexpr double least_energy = 0.1;
constexpr int iterations = 8; // of all shapes together: energies that differ by a third are told apart to 1e-3

void orthonormalise(std::vector<double> &X, PetscBLASInt n, PetscBLASInt count) {
  PetscBLASInt info, room = 64 * count;
  std::vector<double> tau(count), work(room);
  LAPACKgeqrf_(&n, &count, X.data(), &n, tau.data(), work.data(), &room, &info);
  LAPACKorgqr_(&n, &count, &count, X.data(), &n, tau.data(), work.data(), &room, &info);
}

ComplexDense identity(int n) {
  ComplexDense one(n, n);
  for (int j = 0; j < n; ++j) one(j, j) = 1;
  return one;
}

std::vector<double> real_joint_shapes(const StuckBasis &basis, const Layout &layout) {
  const std::size_t own_modes = layout.own_modes.size();
  PetscBLASInt n = static_cast<PetscBLASInt>(layout.dofs()), count = std::min(most, n), room = 64 * count, info;
  const double one = 1, zero = 0;
  std::vector<double> X(static_cast<std::size_t>(n) * count), Y(X.size()), motion(basis.springs.size() * count),
      scale(n), among(static_cast<std::size_t>(count) * count), energy(count), work(room);
  for (PetscBLASInt j = 0; j < n; ++j) scale[j] = 1 / std::sqrt(std::max(basis.lambda[j], 1e-12 * basis.lambda[n - 1]));
  std::mt19937 chance; // the same on every rank
  for (double &x : X) x = chance() - 0x1p31;
  const auto scaled = [&](std::vector<double> &V) {
    for (std::size_t i = 0; i < V.size(); ++i) V[i] *= scale[i % n];
  };
  for (int turn = 0; turn <= iterations; ++turn) { // Y = Lambda^-1/2 Phi_c^T K_t Phi_c Lambda^-1/2 X
    orthonormalise(X, n, count);
    Y = X, scaled(Y);
    const std::vector<double> scaled_X = Y;
    std::fill(Y.begin(), Y.end(), 0.0);
    basis.each_part(own_modes, [&](const double *of, std::size_t stride, std::size_t first, std::size_t many) {
      const PetscBLASInt rows = static_cast<PetscBLASInt>(many), lead = static_cast<PetscBLASInt>(stride);
      BLASgemm_("T", "N", &rows, &count, &n, &one, of, &lead, scaled_X.data(), &n, &zero, motion.data(), &rows);
      for (std::size_t i = 0; i < many * count; ++i) motion[i] *= basis.springs[first + i % many];
      BLASgemm_("N", "N", &n, &count, &rows, &one, of, &lead, motion.data(), &rows, &one, Y.data(), &n);
    });
    MPI_Allreduce(MPI_IN_PLACE, Y.data(), static_cast<int>(Y.size()), MPI_DOUBLE, MPI_SUM, layout.comm);
    scaled(Y);
    if (turn < iterations) X.swap(Y);
  }
  BLASgemm_("T", "N", &count, &count, &n, &one, X.data(), &n, Y.data(), &n, &zero, among.data(), &count);
  LAPACKsyev_("V", "L", &count, among.data(), &count, energy.data(), work.data(), &room, &info);
  PetscBLASInt found = 0; // from the last one back
  while (info == 0 && found < count && energy[count - 1 - found] > least_energy) ++found;
  std::vector<double> shapes(static_cast<std::size_t>(n) * found);
  for (PetscBLASInt k = 0; k < found; ++k)
    for (PetscBLASInt i = 0; i < count; ++i)
      for (PetscBLASInt j = 0; j < n; ++j)
        shapes[static_cast<std::size_t>(k) * n + j] +=
            among[(count - 1 - k) * count + i] * X[static_cast<std::size_t>(i) * n + j] * scale[j];
  return shapes;
}

// The same in complex numbers.
std::vector<double> complex_joint_shapes(const StuckBasis &basis, const Layout &layout) {
  const std::size_t own_modes = layout.own_modes.size(), rows = basis.springs.size();
  const int n = static_cast<int>(layout.dofs()), count = std::min(static_cast<int>(most), n);
  ComplexDense A(static_cast<int>(rows), n), X(n, count), Y; // A = K_t^1/2 Phi_c Lambda^-1/2
  std::vector<double> scale(n);
  for (int j = 0; j < n; ++j) scale[j] = 1 / std::sqrt(std::max(basis.lambda[j], 1e-12 * basis.lambda[n - 1]));
  for (std::size_t i = 0; i < rows; ++i)
    for (int j = 0; j < n; ++j) {
      const double *of = basis.exact.row(own_modes + i);
      A(static_cast<int>(i), j) = std::sqrt(basis.springs[i]) * scale[j] * std::complex<double>(of[j], of[n + j]);
    }
  std::mt19937 chance; // the same on every rank
  for (auto &x : X.values) x = {chance() - 0x1p31, chance() - 0x1p31};
  for (int turn = 0; turn <= iterations; ++turn) {
    X = orthonormal(std::move(X));
    Y = adjoint_product(A, product(A, X));
    MPI_Allreduce(MPI_IN_PLACE, Y.values.data(), static_cast<int>(Y.values.size()), MPI_C_DOUBLE_COMPLEX, MPI_SUM,
                  layout.comm);
    if (turn < iterations) std::swap(X, Y);
  }
  const HermitianModes among = all_modes(adjoint_product(X, Y), identity(count));
  const ComplexDense best = product(X, among.shapes);
  std::vector<double> shapes;
  for (int k = count - 1; k >= 0 && among.squares[k] > least_energy; --k)
    for (const bool real : {true, false})
      for (int j = 0; j < n; ++j) shapes.push_back(scale[j] * (real ? best(j, k).real() : best(j, k).imag()));
  return shapes;
}

} // namespace

std::vector<double> joint_shapes(const StuckBasis &basis, const Layout &layout) {
  const bool complex = basis.phi.columns() > static_cast<std::size_t>(layout.dofs());
  return complex ? complex_joint_shapes(basis, layout) : real_joint_shapes(basis, layout);
}

} // namespace dovetail
