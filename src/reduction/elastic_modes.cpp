#include "reduction/elastic_modes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "reduction/mode_solver.hpp"
#include "support/error.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr double most_backward_error = 1e-8; // |K v - w^2 M v| over (|K| + w^2 |M|) |v|

struct Checks {                  // of one mode
  double residual = 0, size = 0; // squares of || K v - w^2 M v || and || v ||
  double stiffness = 0;          // v^T diag(K) v: what the entries of v would meet one by one
  double mass = 0;               // v^T M v
};

std::vector<Checks> checks_of(MPI_Comm comm, Mat K, Mat M, const Tall &shapes, const std::vector<double> &squares) {
  const Tall Kv = multiply(K, shapes), Mv = multiply(M, shapes);
  UniqueVec diagonal;
  check(MatCreateVecs(K, diagonal.out(), nullptr), "checking modes");
  check(MatGetDiagonal(K, diagonal), "checking modes");
  const ReadValues d(diagonal);
  std::vector<Checks> all(shapes.columns);
  for (PetscInt j = 0; j < shapes.columns; ++j)
    for (PetscInt i = 0; i < shapes.rows; ++i) {
      const double v = shapes.column(j)[i], off = Kv.column(j)[i] - squares[j] * Mv.column(j)[i];
      all[j].residual += off * off, all[j].size += v * v, all[j].stiffness += d[i] * v * v;
      all[j].mass += v * Mv.column(j)[i];
    }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(4 * all.size()), MPI_DOUBLE, MPI_SUM, comm);
  return all;
}

} // namespace

void fix_sign(MPI_Comm comm, const std::vector<long> &names, double *v) {
  const std::size_t n = names.size();
  double largest = 0;
  for (std::size_t i = 0; i < n; ++i) largest = std::max(largest, std::abs(v[i]));
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm);
  const long none = std::numeric_limits<long>::max();
  long first = none;
  double sign = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (std::abs(v[i]) > (1 - 1e-6) * largest && names[i] < first) first = names[i], sign = v[i] < 0 ? -1 : 1;
  long lowest = first;
  MPI_Allreduce(MPI_IN_PLACE, &lowest, 1, MPI_LONG, MPI_MIN, comm);
  if (first != lowest) sign = 0;
  MPI_Allreduce(MPI_IN_PLACE, &sign, 1, MPI_DOUBLE, MPI_SUM, comm);
  if (sign < 0)
    for (std::size_t i = 0; i < n; ++i) v[i] = -v[i];
}

ElasticModes elastic_modes(const ClampedSolver &solver, Mat K, Mat M, const std::vector<long> &names, PetscInt count,
                           const std::string &model_name) {
  MPI_Comm comm;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K), &comm), "computing modes");
  const PetscInt wanted = std::max<PetscInt>(count, 1); // with none asked for, one is computed for the test below
  ElasticModes modes = lowest_pairs(solver, K, M, names, wanted, model_name);
  PetscReal k_norm, m_norm;
  check(MatNorm(K, NORM_INFINITY, &k_norm), "checking modes");
  check(MatNorm(M, NORM_INFINITY, &m_norm), "checking modes");
  const auto checks = checks_of(comm, K, M, modes.shapes, modes.squares);
  for (PetscInt j = 0; j < wanted; ++j) {
    const double square = modes.squares[j];
    // A motion without strain has nothing but round-off left; even a slender blade of a million dofs stays above 1e-11.
    if (!(square > 0) || square * checks[j].mass < 1e-12 * checks[j].stiffness)
      throw InputError(model_name + ": a rigid-body motion is left in K_ee: with the contact dofs held, mode " +
                       std::to_string(j + 1) + " has no stiffness (w^2 = " + std::to_string(square) +
                       "). Constraints are missing, or a part is not connected.");
    const double error = std::sqrt(checks[j].residual / checks[j].size) / (k_norm + square * m_norm);
    if (!(error < most_backward_error)) {
      char text[100];
      std::snprintf(text, sizeof text, "while computing modes: mode %d has a backward error of %.1e, not below %.0e",
                    static_cast<int>(j + 1), error, most_backward_error);
      throw ComputeError(std::string(text) + "; are stiffness or mass of some parts many orders apart?");
    }
    double *v = modes.shapes.column(j);
    for (PetscInt i = 0; i < modes.shapes.rows; ++i) v[i] /= std::sqrt(checks[j].mass);
    fix_sign(comm, names, v);
  }
  modes.squares.resize(count);
  modes.shapes.drop_columns_from(count);
  return modes;
}

PetscInt modes_below(Mat K, Mat M, double square) {
  UniqueMat shifted, factor;
  MatFactorInfo info;
  PetscInt error, negative;
  check(MatDuplicate(K, MAT_COPY_VALUES, shifted.out()), "counting modes");
  check(MatAXPY(shifted, -square, M, UNKNOWN_NONZERO_PATTERN), "counting modes");
  check(MatSetOption(shifted, MAT_SYMMETRIC, PETSC_TRUE), "counting modes");
  check(MatSetOption(shifted, MAT_SPD, PETSC_FALSE), "counting modes"); // else MUMPS takes no negative pivot for one
  check(MatSetOptionsPrefixFactor(shifted, "count_"), "counting modes");
  check(MatGetFactor(shifted, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factor.out()), "counting modes");
  check(MatMumpsSetIcntl(factor, 13, 1), "counting modes"); // the root on one rank: elsewhere signs are not counted
  check(MatMumpsSetIcntl(factor, 14, 60), "counting modes");
  check(MatFactorInfoInitialize(&info), "counting modes");
  check(MatCholeskyFactorSymbolic(factor, shifted, nullptr, &info), "counting modes");
  check(MatCholeskyFactorNumeric(factor, shifted, &info), "counting modes");
  check(MatMumpsGetInfog(factor, 1, &error), "counting modes");
  if (error < 0)
    throw ComputeError("while counting modes (reduction.check_modes): MUMPS error " + std::to_string(error));
  check(MatMumpsGetInfog(factor, 12, &negative), "counting modes");
  return negative;
}

void check_none_missed(Mat K, Mat M, const std::vector<double> &squares) {
  const double below = squares.back() * (1 - 1e-4); // clear of the last one, and of those equal to it
  const auto found = std::count_if(squares.begin(), squares.end(), [&](double square) { return square < below; });
  if (const PetscInt all = modes_below(K, M, below); all != found)
    throw ComputeError("while computing modes: " + std::to_string(all) + " modes lie below " +
                       std::to_string(std::sqrt(below) / (2 * M_PI)) + " Hz, but " + std::to_string(found) +
                       " were found there; ask for a few more in reduction.modes");
}

} // namespace dovetail
