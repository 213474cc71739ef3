#include "modal/modal_solver.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "modal/dampers.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "solving in the stuck modes";
constexpr PetscInt small_size = 150;       // unknowns of the contacts that are factored whatever they do
constexpr double factored_accuracy = 1e-8; // of factors that are exact, unrefined
constexpr int never = 1 << 20;             // iterations of a method that fails
constexpr int most_refinements = 12;       // iterations with factors of the same Jacobian,
constexpr int most_with_dampers = 100;     // where these leave out what is not diagonal of dampers,
constexpr double worth_again = 0.5;        // of a factorisation,
constexpr double most_again = 40;          // and of an earlier one
constexpr double least_tried = 10;         // iterations in the modes, at least, before factors are made instead
constexpr double least_open = 40;          // iterations that the stuck structure's modes take where contacts are open
constexpr double usual_reuse = 2;          // Jacobians solved with one set of factors
constexpr double least_gain = 0.5;         // of what is left, by a round of refinement
constexpr double rounding = 1e-12;         // of a product in double precision, by the forces that cancel in it
constexpr double sure = 1e-6;              // accuracy that GMRES in double precision is trusted with, unmeasured
constexpr double spare = 0.1;              // of what a round may leave: norms differ
constexpr double most_expected = 2;        // times those that factors are worth, where few motions are known to help
constexpr double cached = 3e5;             // entries of the contacts' derivative by a direction, in the cache
constexpr double fading = 0.95;            // of what is expected in the modes, with every Jacobian factored

} // namespace

ModalSolver::ModalSolver(std::shared_ptr<const StuckBases> bases, std::shared_ptr<const StuckBases> open,
                         const Layout &layout)
    : bases_(std::move(bases)), open_(std::move(open)), layout_(layout), in_modes_(*bases_, layout),
      factors_(*bases_, layout) {
  if (open_) windows_.emplace(*open_, layout);
  for (UniqueVec *v : {&remainder_, &correction_})
    check(VecCreateMPI(layout_.comm, layout_.own_unknowns(), layout_.unknowns(), v->out()), doing);
  matrix_ = shell_matrix<&ModalSolver::multiply>(layout_.comm, layout_.own_unknowns(), layout_.unknowns(), this, doing);
  check(KSPCreate(layout_.comm, ksp_.out()), doing);
  check(KSPSetOptionsPrefix(ksp_, "hb_factors_"), doing);
  check(KSPSetOperators(ksp_, matrix_, matrix_), doing);
  check(KSPSetType(ksp_, KSPGMRES), doing);
  check(KSPSetPCSide(ksp_, PC_RIGHT), doing); // what is left is judged as Newton's residual is
  check(KSPSetComputeEigenvalues(ksp_, PETSC_TRUE), doing);
  shell_preconditioner<&ModalSolver::apply_factors>(ksp_, this, doing);
  check(KSPSetFromOptions(ksp_), doing);
  check(PetscOptionsGetInt(nullptr, "hb_factors_", "-most", &most_factored_, nullptr), doing);
}

void ModalSolver::fill(const JacobianParts &parts, LinearPart &linear) {
  contact_ = parts.contact, linear_ = &linear;
  structure_ = parts.structure;
  held_.clear();
  if (parts.held) held_.assign(parts.held, parts.held + 3 * layout_.own_points.size());
  column_.assign(parts.column, parts.column + layout_.own_coefficients());
  border_.assign(parts.border, parts.border + layout_.own_unknowns());
  stale_ = true;
}

void ModalSolver::multiply(Vec x, Vec y) {
  const int n = layout_.width;
  const PetscInt count = layout_.own_coefficients(), contact = layout_.own_point_offset(0);
  const ReadValues in(x);
  const Values out(y);
  std::vector<double> sums{layout_.owns_omega() ? in[count] : 0,
                           std::inner_product(border_.begin(), border_.end(), static_cast<const double *>(in), 0.0)};
  stiff_.resize(count), heavy_.resize(count), force_.resize(count - contact);
  linear_->multiply_and_share(in, stiff_.data(), heavy_.data(), sums, layout_.comm);
  const double last = sums[0];
  contact_->multiply(in + contact, force_.data());
  damped_.clear(), lossy_.clear();
  if (const Dampers *dampers = linear_->dampers()) {
    if (dampers->is_viscous()) damped_.resize(count), dampers->viscous_force(in, n, damped_.data());
    if (dampers->is_hysteretic()) lossy_.resize(count), dampers->hysteretic_force(in, n, lossy_.data());
  }
  forces_square_ = 0;
  for (PetscInt i = 0; i < count; ++i) {
    const int place = static_cast<int>(i % n), k = (place + 1) / 2;
    const auto across = [&](const std::vector<double> &of) {
      return place == 0 ? 0 : place % 2 ? of[i + 1] : -of[i - 1];
    };
    const double inertia = structure_.inertia(k) * heavy_[i];
    out[i] = stiff_[i] - inertia + structure_.loss(k) * across(stiff_) + structure_.drag(k) * across(heavy_) +
             column_[i] * last;
    if (!damped_.empty()) out[i] += structure_.turn(k) * across(damped_);
    if (!lossy_.empty()) out[i] += structure_.hysteresis(k) * across(lossy_);
    if (i >= contact) out[i] += force_[i - contact];
    if (i >= contact && place == 0 && !held_.empty()) out[i] += held_[(i - contact) / n] * in[i];
    forces_square_ += stiff_[i] * stiff_[i] + inertia * inertia;
  }
  if (layout_.owns_omega()) out[count] = sums[1];
}

// remainder_ = r less the product with x. Its norm, and the norm that the rounding of the product may have.
std::array<double, 2> ModalSolver::left_by(Vec x, Vec r) {
  multiply(x, remainder_);
  check(VecAYPX(remainder_, -1, r), doing);
  const ReadValues left(remainder_);
  double squares[] = {std::inner_product(left + 0, left + layout_.own_unknowns(), left + 0, 0.0), forces_square_};
  MPI_Allreduce(MPI_IN_PLACE, squares, 2, MPI_DOUBLE, MPI_SUM, layout_.comm);
  return {std::sqrt(squares[0]), rounding * std::sqrt(squares[1])};
}

void ModalSolver::set_up(KSP ksp, Mat J) {
  outer_ = ksp;
  shell_solver<&ModalSolver::solve>(ksp, J, this, doing);
}

JacobianParts ModalSolver::parts() const {
  return {structure_, *contact_, held_.empty() ? nullptr : held_.data(), column_.data(), border_.data()};
}

bool ModalSolver::may_factor() const { return !bases_->mean().near && chosen_->size() < most_factored_; }

// In a basis that is nearly of modes: no more than a round can gain, by the mass beside its diagonal.
double ModalSolver::worth_asking() const {
  const StuckBasis &basis = bases_->mean();
  return basis.near ? std::clamp(structure_.inertia(layout_.width / 2) / basis.lambda.back(), 1e-4, 0.1) : 0;
}

double ModalSolver::work_in_modes() const {
  const double entries = static_cast<double>(factors_.size()) * padded<float>(layout_.width);
  return in_modes_.work() + (entries > cached ? 40 : 15) * entries;
}

double ModalSolver::work_to_solve() const {
  const double c = 3.0 * layout_.points, n = static_cast<double>(layout_.dofs());
  return chosen_->work_to_solve() + (bases_->wave.sectors > 0 ? 16 : 8) * c * (n + c) * layout_.width + 2e5;
}

double ModalSolver::memory() const {
  const double expected = taken_ > 0 ? taken_ : expected_;
  return of_all_ ? -expected : expected;
}

void ModalSolver::begin(double memory, bool for_one) {
  for_one_ = for_one;
  expected_ = std::abs(memory), of_all_ = memory < 0, taken_ = 0;
  factors_.forget(), in_modes_.begin(for_one);
  failed_again_ = false;
  chosen_ = &factors_;
}

void ModalSolver::choose(Vec r) {
  if (taken_ > 0) expected_ = std::exchange(taken_, 0);
  const double reuse = for_one_ ? 1 : usual_reuse;
  const bool small = reuse > 1 && 3 * layout_.points * layout_.width <= small_size; // in double precision: the same on
  const auto told = std::exchange(all_moving_, std::nullopt);                       // all ranks
  factors_.look_at(*contact_, of_all_ || small, told);
  fresh_ = false;
  chosen_ = &factors_;
  double work = factors_.work() / reuse;
  const double worth = std::min(factors_.work(), std::max(expected_, least_open) * work_in_modes());
  const bool by_windows = !small && take_windows(worth);
  if (by_windows) work = windows_->work();
  const double as_long = (work + work_to_solve()) / work_in_modes(); // in iterations
  if (in_modes_.corrected()) expected_ = std::min(expected_, most_expected * as_long);
  by_factors_ = may_factor() && (small || by_windows || as_long < expected_);
  if (failed_again_) factors_.forget();
  if (by_factors_ && !chosen_->factored()) by_factors_ = factor();
  if (by_factors_)
    expected_ *= fading;
  else
    in_modes_.take(parts(), r);
}

bool ModalSolver::take_windows(double worth) {
  const bool take =
      windows_ && held_.empty() && !contact_->is_transposed() && windows_->look_at(contact_->forces(), worth);
  if (take) chosen_ = &*windows_;
  return take;
}

bool ModalSolver::factor(bool precisely) {
  work_ += chosen_->work();
  return fresh_ = chosen_->factor(parts(), precisely);
}

// What damps the springs of points that stick is not always small.
bool ModalSolver::factor_all() {
  factors_.look_at(*contact_, true);
  of_all_ = may_factor() && factor();
  if (!of_all_) factors_.look_at(*contact_, false);
  return of_all_ || factor();
}

void ModalSolver::solve(Vec r, Vec x) {
  PetscReal asked;
  check(KSPGetTolerances(outer_, &asked, nullptr, nullptr, nullptr), doing);
  if (asked >= 0.5) asked = in_modes_.usual_accuracy();
  if (!solve_some_way(r, x, asked)) ++effort_.inexact;
}

bool ModalSolver::solve_some_way(Vec r, Vec x, double asked) {
  if (std::exchange(stale_, false)) choose(r);
  if (!by_factors_) {
    if (solve_in_modes(r, x, asked)) return true;
    taken_ = never;
    take_windows(factors_.work());
    by_factors_ = may_factor() && factor();
  }
  if (!by_factors_) return false;
  if (solve_with_factors(r, x, asked)) return true;
  if (!fresh_) {
    failed_again_ = true;
    by_factors_ = factor();
    if (!by_factors_) return false;
    if (solve_with_factors(r, x, asked)) return true;
  }
  if (chosen_ != &factors_) {
    chosen_ = &factors_;
    by_factors_ = may_factor() && factor();
    if (!by_factors_) return false;
    if (solve_with_factors(r, x, asked)) return true;
  }
  if (!factors_.of_all() && factor_all() && solve_with_factors(r, x, asked)) return true;
  return chosen_->size() > 0 && factor(true) && solve_with_factors(r, x, asked);
}

void ModalSolver::apply_factors(Vec r, Vec x) { chosen_->solve(ReadValues(r), Values(x)); }

// `round`: solves to an accuracy, and is sure of it or not; `sign`: what it met. Where it is not sure, what is left is
// measured in double precision, in the norm of Newton's residual, and solved for again.
template <class Round, class Sign>
bool ModalSolver::refine(Vec r, Vec x, double asked, const Round &round, const Sign &sign) {
  first_sign_.reset();
  Solved last = round(r, x, asked);
  if (last != Solved::roughly) return last == Solved::surely;
  PetscReal whole, before = PETSC_INFINITY;
  check(VecNorm(r, NORM_2, &whole), doing);
  for (; last != Solved::never; check(VecAXPY(x, 1, correction_), doing)) {
    const auto [left, rounded] = left_by(x, r);
    if (left <= std::max(asked * whole, rounded)) return true;
    if (!(left <= least_gain * before)) return false;
    before = left;
    if (!first_sign_) first_sign_ = sign(); // the rounds to come are short and meet few eigenvalues
    last = round(remainder_, correction_, std::clamp(spare * asked * whole / left, ModalKrylov::best_accuracy, spare));
  }
  return false;
}

int ModalSolver::factors_sign() {
  return chosen_->determinant_sign() * (fresh_ && bases_->mean().dampers_are_diagonal() ? 1 : sign_of_met(ksp_));
}

bool ModalSolver::solve_with_factors(Vec r, Vec x, double asked) {
  first_sign_.reset();
  if (fresh_ && chosen_->exact() && asked >= factored_accuracy) {
    ++effort_.iterations, work_ += work_to_solve();
    apply_factors(r, x);
    return true;
  }
  const double worth = !bases_->mean().dampers_are_diagonal() ? most_with_dampers
                       : fresh_                               ? most_refinements
                                : std::clamp(worth_again * chosen_->work() / work_to_solve(), 2.0, most_again);
  const auto round = [&](Vec from, Vec to, double accuracy) {
    PetscInt count;
    KSPConvergedReason reason;
    check(KSPSetTolerances(ksp_, accuracy, 0, 1e30, static_cast<PetscInt>(worth)), doing);
    check(KSPSolve(ksp_, from, to), doing);
    check(KSPGetIterationNumber(ksp_, &count), doing);
    check(KSPGetConvergedReason(ksp_, &reason), doing);
    effort_.iterations += static_cast<int>(count), work_ += count * work_to_solve();
    if (reason <= 0) return Solved::never;
    return accuracy >= sure ? Solved::surely : Solved::roughly;
  };
  return refine(r, x, asked, round, [&] { return factors_sign(); });
}

bool ModalSolver::solve_in_modes(Vec r, Vec x, double asked) {
  const double most_tried = chosen_ == &factors_ && !for_one_ ? 2 : 0.5;
  const int most = static_cast<int>(may_factor() ? std::max(least_tried, most_tried * chosen_->work() / work_in_modes())
                                                 : ModalKrylov::most_iterations);
  const auto round = [&](Vec from, Vec to, double accuracy) {
    const bool good = in_modes_.solve(from, to, std::max(accuracy, worth_asking()), most);
    effort_.iterations += in_modes_.iterations(), taken_ += in_modes_.iterations();
    work_ += in_modes_.iterations() * work_in_modes();
    if (!good) return Solved::never;
    return in_modes_.left() <= 2 * accuracy && !bases_->mean().near ? Solved::surely : Solved::roughly;
  };
  return refine(r, x, asked, round, [&] { return in_modes_.sign(); });
}

int ModalSolver::determinant_sign() {
  if (!may_factor()) return 0;
  int sign = first_sign_ ? *first_sign_ : !by_factors_ ? in_modes_.sign() : factors_sign();
  const bool confirmed = (fresh_ && chosen_->tells_sign()) || (sign != 0 && !bases_->mean().dampers_are_diagonal());
  if (!confirmed && (sign == 0 || (sign_ != 0 && sign != sign_))) {
    fresh_ = chosen_->factor(parts(), true); // not counted as work: a run that is restarted does not know sign_
    sign = fresh_ ? chosen_->determinant_sign() : 0;
  }
  return sign_ = sign;
}

} // namespace dovetail
