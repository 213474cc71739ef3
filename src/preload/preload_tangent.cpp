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
    : model_(model), grid_(contact_grid(model)), kept_{SpreadFactors(grid_), {}}, at_hand_{SpreadFactors(grid_), {}} {
  int first = 0;
  for (const auto &rows : contact_rows(model)) {
    counts_.push_back(static_cast<int>(rows.size())), starts_.push_back(first);
    first += counts_.back();
  }
  changed_ = shell_matrix<&PreloadTangent::multiply_changed>(model.comm, model.own_contact_dofs(), model.contact_dofs(),
                                                             this, doing);
  check(MatCreateVecs(changed_, right_.out(), answer_.out()), doing);
  check(KSPCreate(model.comm, ksp_.out()), doing);
  check(KSPSetOptionsPrefix(ksp_, "preload_"), doing);
  check(KSPSetOperators(ksp_, changed_, changed_), doing);
  check(KSPSetType(ksp_, KSPGMRES), doing);
  PC none;
  check(KSPGetPC(ksp_, &none), doing);
  check(PCSetType(none, PCNONE), doing);
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

// The stiffness is 1 + (slopes - those factored) M^-1, times M: forces of M are what GMRES looks for.
void PreloadTangent::multiply_changed(Vec forces, Vec out) {
  const std::vector<Slope> &factored = factors().slopes;
  const std::vector<double> x = motion(ReadValues(forces));
  check(VecCopy(forces, out), doing);
  const Values to(out);
  for (std::size_t p = 0; p < slopes_.size(); ++p)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) to[3 * p + i] += (slopes_[p][i][j] - factored[p][i][j]) * x[3 * p + j];
}

std::vector<double> PreloadTangent::motion(const double *forces) const {
  std::vector<double> all = from_all(forces);
  factors().of.solve(all.data());
  const auto own = all.begin() + 3 * model_.own_points.begin;
  return {own, own + model_.own_contact_dofs()};
}

bool PreloadTangent::factor(Factored &factors) {
  const std::size_t n = model_.contact_dofs();
  std::vector<double> line(n);
  ++factorisations_;
  factors.slopes = slopes_;
  return factors.of.factor([&](std::size_t i) {
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

const PreloadTangent::Factored &PreloadTangent::factors() const { return at_hand_.of.good() ? at_hand_ : kept_; }

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
  const PetscInt most = at_hand_.of.good() ? worth() : kept_.of.good() ? times_worth * worth() : 0;
  if (most == 0 || !(iterate(most) > 0)) { // as well as it goes: Newton's method judges what comes of it
    if (!factor(at_hand_)) return false;
    check(VecCopy(right_, answer_), doing);
  }
  x = motion(ReadValues(answer_));
  int finite = std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
  MPI_Allreduce(MPI_IN_PLACE, &finite, 1, MPI_INT, MPI_MIN, model_.comm);
  return finite;
}

} // namespace dovetail
