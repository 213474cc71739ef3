#include "problems/track_jacobian.hpp"

#include <algorithm>

#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "solving with the Jacobian of a track";

} // namespace

TrackJacobian::TrackJacobian(PeakTrack &track)
    : track_(track), system_(track.peak().system()), border_(system_.layout()), response_(system_.matrix()) {
  for (UniqueVec *v : {&right_, &left_, &fixed_}) *v = system_.unknowns();
  set_parameter(fixed_, 1);
  matrix_ = shell_matrix<&TrackJacobian::multiply>(system_.layout().comm, border_.own(), border_.all(), this, doing);
  check(KSPCreate(system_.layout().comm, inner_.out()), doing);
  system_.set_up(inner_, response_);
}

void TrackJacobian::set_up(KSP ksp) {
  outer_ = ksp;
  shell_solver<&TrackJacobian::solve>(ksp, matrix_, this, doing);
}

void TrackJacobian::assemble(Vec y, Vec border) {
  const PetscInt own = system_.layout().own_coefficients();
  const auto take = [own](Vec v, std::vector<double> &part) {
    const ReadValues from(v);
    part.assign(from + 0, from + own);
  };
  track_.evaluate(y);
  const Vec at = track_.peak().y();
  by_omega_.reset();
  if (const Vec along = track_.condition().along()) {
    take(along, by_omega_.emplace());
    for (double &value : *by_omega_) value = -value;
  }
  const double by_parameter = track_.condition().derivative(track_.kind(), right_);
  border_.corner[0] = {parameter_of(right_), by_parameter};
  take(right_, border_.rows[0]), take(border, border_.rows[1]);
  border_.corner[1] = border_.last_of(ReadValues(border));
  system_.by_parameter(at, frequency_parameter(), right_);
  take(right_, border_.columns[0]);
  system_.by_parameter(at, track_.kind(), right_);
  take(right_, border_.columns[1]);
  system_.jacobian(at, fixed_, response_);
  check(KSPSetOperators(inner_, response_, response_), doing);
  eliminated_ = false;
}

void TrackJacobian::multiply(Vec x, Vec y) {
  const PetscInt own = system_.layout().own_coefficients();
  const ReadValues in(x);
  {
    const Values motion(right_);
    std::copy_n(in + 0, own, motion + 0);
    if (system_.layout().owns_omega()) motion[own] = 0;
  }
  check(MatMult(response_, right_, left_), doing);
  const ReadValues force(left_);
  const Values out(y);
  std::copy_n(force + 0, own, out + 0);
  border_.multiply(in, border_.last_of(in), out);
}

// Where Newton's method leaves it open, so does this: the response's own solver chooses, as over a frequency.
double TrackJacobian::asked() const {
  PetscReal asked;
  check(KSPGetTolerances(outer_, &asked, nullptr, nullptr, nullptr), doing);
  return asked;
}

// x = R_Y^-1 r, (own coefficients).
bool TrackJacobian::solve_response(const double *r, double *x) {
  const PetscInt own = system_.layout().own_coefficients();
  PetscReal size;
  KSPConvergedReason reason;
  {
    const Values right(right_);
    std::copy_n(r, own, right + 0);
    if (system_.layout().owns_omega()) right[own] = 0;
  }
  check(VecNorm(right_, NORM_INFINITY, &size), doing);
  if (size == 0) { // as of a tangent: the solve before goes on telling the determinant's sign
    std::fill_n(x, own, 0.0);
    return true;
  }
  check(KSPSetTolerances(inner_, asked(), PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), doing);
  check(KSPSolve(inner_, right_, left_), doing);
  check(KSPGetConvergedReason(inner_, &reason), doing);
  if (reason <= 0) system_.recover(inner_, response_);
  std::copy_n(ReadValues(left_) + 0, own, x);
  return reason > 0;
}

void TrackJacobian::solve(Vec r, Vec x) {
  const auto inverse = [this](const double *of, double *answer) { return solve_response(of, answer); };
  check(VecSet(x, NAN), doing); // where it fails
  const bool known = by_omega_ && asked() >= TrackCondition::roughly;
  eliminated_ = eliminated_ || border_.eliminate(inverse, known ? &*by_omega_ : nullptr);
  if (eliminated_ && !border_.solve(inverse, ReadValues(r), Values(x))) check(VecSet(x, NAN), doing);
}

int TrackJacobian::determinant_sign(KSP) { return system_.determinant_sign(inner_) * border_.sign(); }

std::string TrackJacobian::recover(KSP) { return system_.recover(inner_, response_); }

} // namespace dovetail
