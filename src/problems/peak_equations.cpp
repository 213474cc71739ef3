#include "problems/peak_equations.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "continuation/problem.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "differentiating a peak";
constexpr int most_corrections = 12;    // of a motion at one frequency; from a point of the curve one or two are enough
constexpr int most_moves = 12;          // of the frequency
constexpr double exact = 1e-11;         // relative change of the last correction
constexpr double least_gain = 0.1;      // of a solve that goes on: one by factors gains all its digits
constexpr double still = 1e-10;         // of the frequency, when it is the peak's
constexpr double farthest = 0.02;       // of the frequency: a peak beyond is another one
constexpr double part_of_motion = 1e-6; // for central differences along a motion: half the digits
constexpr double part_of_omega =
    1e-3; // along the frequency, of which the equations are a quadratic: no error of its own

double dot(Vec a, Vec b) {
  double value;
  check(VecDot(a, b, &value), doing);
  return value;
}

WatchedRow row_of(PetscInt dof, const Layout &layout) {
  std::vector<double> factors(layout.dofs(), 0.0);
  if (dof >= 0) factors[dof] = 1;
  return factors;
}

} // namespace

PeakEquations::PeakEquations(const HarmonicSystem &like, const Watched &watched)
    : system_(std::make_unique<HarmonicSystem>(like, like.harmonics(), exactly)), fixed_(system_->unknowns()),
      plain_(solver(false)), transposed_(solver(true)),
      row_(watched.row ? *watched.row : row_of(watched.dof, system_->layout())) {
  for (UniqueVec *v : {&y_, &f_, &correction_, &along_, &gradient_, &adjoint_, &turned_, &at_})
    *v = system_->unknowns();
  set_parameter(fixed_, 1);
}

PeakEquations::Solver PeakEquations::solver(bool transposed) const {
  Solver made{system_->matrix(transposed), {}};
  check(KSPCreate(system_->layout().comm, made.ksp.out()), doing);
  system_->set_up(made.ksp, made.matrix);
  return made;
}

void PeakEquations::set(const PathParameter &parameter, double value, const std::shared_ptr<VariedPreload> &preload) {
  if (value_ == value) return;
  system_->vary(ResponseParameter().beside(parameter, value), preload);
  value_ = value;
}

void PeakEquations::take(Vec y) { check(VecCopy(y, y_), doing); }

double PeakEquations::amplitude() const { return std::sqrt(dot(gradient_, y_)); } // a quadratic's

bool PeakEquations::solve() {
  for (int i = 0; i < most_corrections; ++i) {
    PetscReal size, change;
    system_->residual(y_, f_);
    set_parameter(f_, 0);
    factor(fixed_, false);
    if (!solve(f_, at_, false)) return false;
    check(VecAXPY(y_, -1, at_), doing);
    check(VecNorm(y_, NORM_2, &size), doing);
    check(VecNorm(at_, NORM_2, &change), doing);
    if (!std::isfinite(change)) return false;
    if (change <= exact * size) return true;
  }
  return false;
}

// c by both: it is off by the product of what they are off by.
bool PeakEquations::differentiate(double accuracy) {
  for (const bool transposed : {false, true}) factor(fixed_, transposed);
  const auto solved = [&, on = std::exchange(differentiated_, false)](Vec r, Vec x, bool transposed) {
    return on ? solve_on(r, x, transposed, accuracy) : solve(r, x, transposed, accuracy);
  };
  set_parameter(along_, 1), set_parameter(adjoint_, -c_); // as they were solved for
  if (!solved(fixed_, along_, false)) return false;       // [dY/dOmega; 1]
  check(VecSet(gradient_, 0), doing);
  watch(y_, gradient_);
  if (!solved(gradient_, adjoint_, true)) return false; // [lambda; -c]
  differentiated_ = true;
  set_parameter(adjoint_, 0);
  check(MatMult(plain_.matrix, along_, f_), doing); // [R_Y dY/dOmega + R_Omega; 1]
  c_ = dot(adjoint_, f_) - dot(gradient_, along_);
  PetscReal size, rate;
  check(VecNorm(y_, NORM_2, &size), doing);
  check(VecNorm(along_, NORM_2, &rate), doing);
  step_ = part_of_motion * size / rate;
  set_parameter(along_, 0);
  return true;
}

void PeakEquations::turn() {
  system_->differentiate_twice(y_, along_, step_, adjoint_, turned_); // [c_Y; c_Omega]
  check(VecSet(f_, 0), doing);
  watch(along_, f_);
  check(VecAXPY(turned_, -1, f_), doing);
}

double PeakEquations::omega_by_damping() {
  const double turn = part_of_omega * omega();
  double sum = 0;
  for (const double side : {1.0, -1.0}) {
    check(VecCopy(y_, at_), doing);
    set_parameter(at_, omega() + side * turn);
    sum += side * system_->weighed_damping(at_, adjoint_) / (2 * turn);
  }
  return sum;
}

// lambda . dR_p/dY dY/dOmega
double PeakEquations::by_parameter(const PathParameter &parameter) {
  double sum = 0;
  for (const double side : {1.0, -1.0}) {
    check(VecWAXPY(at_, side * step_, along_, y_), doing);
    system_->by_parameter(at_, parameter, f_);
    sum += side * dot(adjoint_, f_) / (2 * step_);
  }
  return sum + (parameter.changes_damping ? omega_by_damping() : 0);
}

double PeakEquations::slope() const { return system_->parameter_in(turned_) + dot(turned_, along_); }

std::vector<double> PeakEquations::solver_memory() const {
  return {system_->solver_memory(plain_.matrix), system_->solver_memory(transposed_.matrix)};
}

void PeakEquations::begin_solves(const std::vector<double> &memory) {
  system_->begin_solves(plain_.matrix, memory.at(0)), system_->begin_solves(transposed_.matrix, memory.at(1));
  differentiated_ = false;
}

void PeakEquations::move(double by) {
  const double next = omega() + by;
  check(VecAXPY(y_, by, along_), doing);
  set_parameter(y_, next);
}

bool PeakEquations::climb() {
  const double begin = omega();
  for (int i = 0; i < most_moves; ++i) {
    if (!solve() || !differentiate()) return false;
    turn();
    if (slope() <= 0) return false;
    const double by = -c_ / slope();
    if (std::abs(by) <= still * begin) return true;
    if (std::abs(omega() + by - begin) > farthest * begin) return false;
    move(by);
  }
  return false;
}

void PeakEquations::factor(Vec border, bool transposed) {
  const Solver &by = transposed ? transposed_ : plain_;
  transposed ? system_->transposed_jacobian(y_, border, by.matrix) : system_->jacobian(y_, border, by.matrix);
  check(KSPSetOperators(by.ksp, by.matrix, by.matrix), doing);
}

// From x on, where that leaves less than all of the right-hand side.
bool PeakEquations::solve_on(Vec right, Vec x, bool transposed, double accuracy) {
  PetscReal whole, left;
  check(VecNorm(right, NORM_2, &whole), doing);
  check(MatMult(transposed ? transposed_.matrix : plain_.matrix, x, f_), doing);
  check(VecAYPX(f_, -1, right), doing);
  check(VecNorm(f_, NORM_2, &left), doing);
  if (!(left < whole)) return solve(right, x, transposed, accuracy);
  if (!solve(f_, correction_, transposed, std::min(accuracy * whole / left, least_gain))) return false;
  check(VecAXPY(x, 1, correction_), doing);
  return true;
}

bool PeakEquations::solve(Vec right, Vec x, bool transposed, double accuracy) {
  const Solver &by = transposed ? transposed_ : plain_;
  KSPConvergedReason reason;
  check(KSPSetTolerances(by.ksp, accuracy, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), doing);
  check(KSPSolve(by.ksp, right, x), doing);
  check(KSPGetConvergedReason(by.ksp, &reason), doing);
  if (reason <= 0) system_->recover(by.ksp, by.matrix);
  return reason > 0;
}

// out += H v, where 2 A = v . H v.
void PeakEquations::watch(Vec v, Vec out) const {
  const Layout &layout = system_->layout();
  const int n = layout.width;
  const double *from;
  double *to;
  std::vector<double> motion(n, 0.0); // of what is watched, without its mean
  check(VecGetArrayRead(v, &from), doing);
  check(VecGetArray(out, &to), doing);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) row_.add(layout.number(d), from + d * n, n, motion.data());
  motion[0] = 0;
  MPI_Allreduce(MPI_IN_PLACE, motion.data(), n, MPI_DOUBLE, MPI_SUM, layout.comm);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) row_.add_transposed(layout.number(d), motion.data(), n, to + d * n);
  check(VecRestoreArray(out, &to), doing);
  check(VecRestoreArrayRead(v, &from), doing);
}

} // namespace dovetail
