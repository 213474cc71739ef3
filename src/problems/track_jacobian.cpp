#include "problems/track_jacobian.hpp"

#include <algorithm>

#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "solving with the Jacobian of a track";
constexpr double newton_accuracy = 1e-6; // relative, where Newton's method leaves it open

double dot(Vec a, Vec b) {
  double value;
  check(VecDot(a, b, &value), doing);
  return value;
}

} // namespace

TrackJacobian::TrackJacobian(PeakTrack &track)
    : track_(track), system_(track.peak().system()), response_(system_.matrix()) {
  const Layout &layout = system_.layout();
  for (auto *vectors : {&columns_, &rows_, &answers_})
    for (UniqueVec &v : *vectors) v = system_.unknowns();
  for (UniqueVec *v : {&right_, &left_, &fixed_}) *v = system_.unknowns();
  set_parameter(fixed_, 1);
  const PetscInt own = layout.own_coefficients() + (layout.owns_omega() ? width : 0);
  matrix_ = shell_matrix<&TrackJacobian::multiply>(layout.comm, own, layout.unknowns() + 1, this, doing);
  check(KSPCreate(layout.comm, inner_.out()), doing);
  system_.set_up(inner_, response_);
}

void TrackJacobian::set_up(KSP ksp) {
  outer_ = ksp;
  check(KSPSetOperators(ksp, matrix_, matrix_), doing);
  check(KSPSetType(ksp, KSPPREONLY), doing);
  shell_preconditioner<&TrackJacobian::solve>(ksp, this, doing);
}

void TrackJacobian::assemble(Vec y, Vec border) {
  track_.evaluate(y);
  const Vec at = track_.peak().y();
  const double by_parameter = track_.condition().derivative(track_.kind(), rows_[0]);
  system_.by_parameter(at, frequency_parameter(), columns_[0]);
  system_.by_parameter(at, track_.kind(), columns_[1]);
  corner_[0] = {parameter_of(rows_[0]), by_parameter};
  corner_[1] = last_of(border);
  take(border, rows_[1]);
  set_parameter(rows_[0], 0);
  system_.jacobian(at, fixed_, response_);
  check(KSPSetOperators(inner_, response_, response_), doing);
  eliminated_ = false;
}

TrackJacobian::Pair TrackJacobian::last_of(Vec v) const {
  const Layout &layout = system_.layout();
  Pair last{};
  const ReadValues own(v);
  if (layout.owns_omega()) std::copy_n(own + layout.own_coefficients(), width, last.begin());
  MPI_Bcast(last.data(), width, MPI_DOUBLE, layout.size - 1, layout.comm);
  return last;
}

void TrackJacobian::put(Vec response, Vec v) const {
  const ReadValues from(response);
  const Values to(v);
  std::copy_n(from + 0, system_.layout().own_coefficients(), to + 0);
}

void TrackJacobian::take(Vec v, Vec response) const {
  const ReadValues from(v);
  const Values to(response);
  std::copy_n(from + 0, system_.layout().own_coefficients(), to + 0);
  if (system_.layout().owns_omega()) to[system_.layout().own_coefficients()] = 0;
}

TrackJacobian::Pair TrackJacobian::along_rows(Vec response) const {
  return {dot(rows_[0], response), dot(rows_[1], response)};
}

void TrackJacobian::multiply(Vec x, Vec y) {
  const Pair last = last_of(x);
  take(x, right_);
  check(MatMult(response_, right_, left_), doing);
  for (int b = 0; b < width; ++b) check(VecAXPY(left_, last[b], columns_[b]), doing);
  put(left_, y);
  const Pair sums = along_rows(right_);
  const Values out(y);
  for (int a = 0; a < width && system_.layout().owns_omega(); ++a)
    out[system_.layout().own_coefficients() + a] = sums[a] + corner_[a][0] * last[0] + corner_[a][1] * last[1];
}

bool TrackJacobian::solve_response(Vec r, Vec x) {
  PetscReal asked;
  KSPConvergedReason reason;
  check(KSPGetTolerances(outer_, &asked, nullptr, nullptr, nullptr), doing);
  if (asked >= 0.5) asked = newton_accuracy;
  check(KSPSetTolerances(inner_, asked, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), doing);
  check(KSPSolve(inner_, r, x), doing);
  check(KSPGetConvergedReason(inner_, &reason), doing);
  if (reason <= 0) system_.recover(inner_, response_);
  return reason > 0;
}

bool TrackJacobian::eliminate() {
  Dense left(width, width);
  for (int b = 0; b < width; ++b) {
    if (!solve_response(columns_[b], answers_[b])) return false;
    const Pair sums = along_rows(answers_[b]);
    for (int a = 0; a < width; ++a) left(a, b) = corner_[a][b] - sums[a];
  }
  return eliminated_ = factors_.factor(left);
}

void TrackJacobian::solve(Vec r, Vec x) {
  check(VecSet(x, NAN), doing); // where it fails
  if (!eliminated_ && !eliminate()) return;
  Pair last = last_of(r);
  take(r, right_);
  if (!solve_response(right_, left_)) return;
  const Pair sums = along_rows(left_);
  for (int a = 0; a < width; ++a) last[a] -= sums[a];
  factors_.solve(last.data());
  for (int b = 0; b < width; ++b) check(VecAXPY(left_, -last[b], answers_[b]), doing);
  put(left_, x);
  const Values out(x);
  if (system_.layout().owns_omega()) std::copy_n(last.data(), width, out + system_.layout().own_coefficients());
}

int TrackJacobian::determinant_sign(KSP) { return system_.determinant_sign(inner_) * factors_.sign(); }

std::string TrackJacobian::recover(KSP) { return system_.recover(inner_, response_); }

} // namespace dovetail
