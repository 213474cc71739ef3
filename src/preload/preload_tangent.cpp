#include "preload/preload_tangent.hpp"

#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "solving for the preload";
constexpr double accuracy = 1e-12;            // of a solve, relative: Newton's steps are those of an exact one
constexpr PetscInt refinements = 3;           // iterations with factors of the stiffness at hand
constexpr PetscInt dofs_of_an_iteration = 50; // factors of n dofs cost as much as n / 50 iterations: measured
constexpr PetscInt times_worth = 2;           // of iterations with factors that are kept, which serve many solves
constexpr std::size_t most_in_a_row = 16;     // ranks: so a pivot is found without a message for every column

std::vector<std::vector<int>> contact_rows(const ReducedModel &model) {
  int size;
  MPI_Comm_size(model.comm, &size);
  std::vector<std::vector<int>> rows(size);
  for (int r = 0; r < size; ++r) {
    const Range points = share_of(model.points, r, size);
    rows[r].resize(3 * points.size());
    std::iota(rows[r].begin(), rows[r].end(), 3 * points.begin);
  }
  return rows;
}

} // namespace

BlockCyclic contact_grid(const ReducedModel &model) {
  std::vector<std::vector<int>> rows = contact_rows(model);
  const int in_a_row = rows.size() <= most_in_a_row ? 1 : 0;
  return {model.comm, static_cast<int>(model.contact_dofs()), std::move(rows), in_a_row};
}

PreloadTangent::PreloadTangent(const ReducedModel &model)
    : model_(model), grid_(contact_grid(model)), kept_(grid_), at_hand_(grid_) {
  int first = 0;
  for (const auto &rows : contact_rows(model)) {
    counts_.push_back(static_cast<int>(rows.size())), starts_.push_back(first);
    first += counts_.back();
  }
  stiffness_ =
      shell_matrix<&PreloadTangent::multiply>(model.comm, model.own_contact_dofs(), model.contact_dofs(), this, doing);
  check(MatCreateVecs(stiffness_, right_.out(), answer_.out()), doing);
  check(KSPCreate(model.comm, ksp_.out()), doing);
  check(KSPSetOptionsPrefix(ksp_, "preload_"), doing);
  check(KSPSetOperators(ksp_, stiffness_, stiffness_), doing);
  check(KSPSetType(ksp_, KSPGMRES), doing);
  check(KSPSetPCSide(ksp_, PC_RIGHT), doing);
  shell_preconditioner<&PreloadTangent::precondition>(ksp_, this, doing);
  check(KSPSetFromOptions(ksp_), doing);
}

std::vector<double> PreloadTangent::from_all(const double *own) const {
  std::vector<double> all(model_.contact_dofs());
  MPI_Allgatherv(own, static_cast<int>(model_.own_contact_dofs()), MPI_DOUBLE, all.data(), counts_.data(),
                 starts_.data(), MPI_DOUBLE, model_.comm);
  return all;
}

std::vector<double> PreloadTangent::structure_times(const double *x) const {
  const std::vector<double> all = from_all(x);
  std::vector<double> y(model_.own_contact_dofs());
  const PetscBLASInt n = static_cast<PetscBLASInt>(all.size()), own = static_cast<PetscBLASInt>(y.size()), stride = 1;
  const double once = 1, none = 0;
  if (own > 0) BLASgemv_("T", &n, &own, &once, model_.kxx.data(), &n, all.data(), &stride, &none, y.data(), &stride);
  return y;
}

void PreloadTangent::multiply(Vec x, Vec y) {
  const ReadValues from(x);
  const Values to(y);
  const std::vector<double> forces = structure_times(from);
  std::copy(forces.begin(), forces.end(), static_cast<double *>(to));
  for (std::size_t p = 0; p < slopes_.size(); ++p)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) to[3 * p + i] += slopes_[p][i][j] * from[3 * p + j];
}

void PreloadTangent::precondition(Vec r, Vec x) {
  std::vector<double> all = from_all(ReadValues(r));
  (at_hand_.good() ? at_hand_ : kept_).solve(all.data());
  std::copy_n(all.begin() + 3 * model_.own_points.begin, model_.own_contact_dofs(), static_cast<double *>(Values(x)));
}

bool PreloadTangent::factor(SpreadFactors &factors) {
  const std::size_t n = model_.contact_dofs();
  std::vector<double> line(n);
  ++factorisations_;
  return factors.factor([&](std::size_t i) {
    std::copy_n(&model_.kxx[i * n], n, line.begin());
    for (int j = 0; j < 3; ++j) line[3 * (model_.own_points.begin + i / 3) + j] += slopes_[i / 3][i % 3][j];
    return line.data();
  });
}

// Iterations that cost as much as factors.
PetscInt PreloadTangent::worth() const { return model_.contact_dofs() / dofs_of_an_iteration; }

void PreloadTangent::keep(const std::vector<Slope> &slopes) {
  if (worth() == 0) return;
  slopes_ = slopes;
  factor(kept_);
}

KSPConvergedReason PreloadTangent::iterate(PetscInt most) {
  check(KSPSetTolerances(ksp_, accuracy, 0, 1e30, most), doing);
  check(KSPGMRESSetRestart(ksp_, most), doing);
  const PetscErrorCode code = KSPSolve(ksp_, right_, answer_);
  courier_.rethrow();
  check(code, doing);
  KSPConvergedReason reason;
  check(KSPGetConvergedReason(ksp_, &reason), doing);
  return reason;
}

bool PreloadTangent::solve(const std::vector<Slope> &slopes, const std::vector<double> &b, std::vector<double> &x) {
  slopes_ = slopes;
  std::copy(b.begin(), b.end(), static_cast<double *>(Values(right_)));
  const PetscInt most = at_hand_.good() ? worth() : kept_.good() ? times_worth * worth() : 0;
  const bool near = most > 0 && iterate(most) > 0;
  // As well as it goes: Newton's method judges what comes of it.
  if (!near && (!factor(at_hand_) || iterate(refinements) == KSP_DIVERGED_NANORINF)) return false;
  const ReadValues found(answer_);
  x.assign(static_cast<const double *>(found), found + b.size());
  return true;
}

} // namespace dovetail
