#include "continuation/curve.hpp"

#include <algorithm>
#include <cmath>

#include "harmonic/left_out_forces.hpp"

namespace dovetail {
namespace {

// Newton's method hardly comes back from corrections as long as that: so many steps,
constexpr double most_steps = 100;
constexpr double least_reach = 0.01; // and such a part of all unknowns

} // namespace

Curve::Curve(HarmonicSystem &system_, const NewtonSettings &newton, double omega_unit, bool weighted, Counts &counts)
    : system(system_), norm(system_.layout(), omega_unit, weighted), corrector_(system_, newton),
      omega_unit_(omega_unit), counts_(counts), row_(system_.unknowns()),
      e_omega_(system_.unknowns()), work_{system_.unknowns(), system_.unknowns(), system_.unknowns()} {
  const Layout &layout = system.layout();
  if (layout.owns_omega())
    check(VecSetValue(e_omega_, layout.omega_row(), 1, INSERT_VALUES), "setting up continuation");
  check(VecAssemblyBegin(e_omega_), "setting up continuation");
  check(VecAssemblyEnd(e_omega_), "setting up continuation");
}

Station Curve::station() const {
  Station s;
  s.y = system.unknowns(), s.t = system.unknowns();
  return s;
}

bool Curve::solve_across(Vec normal, Station &s, const StepEffort &effort) {
  double target;
  PetscReal reach = 0;
  if (effort.step > 0) {
    PetscReal size, unit;
    check(VecNorm(s.y, NORM_2, &size), "predicting");
    check(VecNorm(normal, NORM_2, &unit), "predicting");
    reach = std::max(most_steps * effort.step * unit / norm.length(normal), least_reach * size);
  }
  norm.weigh(normal, row_);
  check(VecDot(row_, s.y, &target), "predicting");
  s.newton = corrector_.solve(s.y, row_, target, {effort.line_search, effort.most, reach});
  return finish(s);
}

bool Curve::solve_at(double w, Station &s, double times) {
  set_omega(s.y, w);
  s.newton = corrector_.solve(s.y, e_omega_, w, {.times = times});
  if (!s.newton.converged && times >= 1) {
    count(s.newton);
    s.newton = corrector_.solve(s.y, e_omega_, w, {.line_search = true, .times = times});
  }
  if (!finish(s)) return false;
  set_omega(s.y, w); // to the last bit
  s.omega = w;
  return true;
}

void Curve::count(const Corrector::Outcome &newton) {
  counts_.newton += newton.newton, counts_.linear += newton.linear, counts_.inexact += newton.inexact;
}

void Curve::count(const Corrector::Direction &solve) {
  counts_.linear += solve.linear, counts_.inexact += solve.inexact;
}

bool Curve::finish(Station &s) {
  count(s.newton);
  solve_ = none;
  if (!s.newton.converged) return false;
  s.activity = system.activity(), s.error.reset();
  s.omega = system.omega(s.y);
  const auto direction = corrector_.tangent(s.t);
  count(direction);
  s.sign = direction.sign;
  if (!direction.found) {
    s.newton.converged = false, s.newton.why = "the bordered Jacobian is singular";
    return false;
  }
  check(VecScale(s.t, 1 / norm.length(s.t)), "computing a tangent");
  static long solves = 0;
  s.solve = solve_ = ++solves;
  return true;
}

double Curve::left_out(const Station &s) {
  const Vec r = work_[0], c = work_[1];
  const double motion = std::sqrt(swing_product(system.layout(), s.y, s.y)), own = left_out_forces(system, s.y, r);
  if (motion == 0) return 0;
  if (s.solve != solve_) {
    int sign;
    if (!tangent_at(s.y, s.t, c, sign)) return std::nan("");
    solve_ = s.solve;
  }
  const auto correction = corrector_.correct(r, c);
  count(correction);
  if (!correction.found) return std::nan("");
  // across the curve: what lies along it does not count
  const auto product = [&](Vec a, Vec b) {
    return swing_product(system.layout(), a, b) / (motion * motion) +
           system.omega(a) * system.omega(b) / (omega_unit_ * omega_unit_);
  };
  const double along = product(c, s.t), across = product(c, c) - along * along / product(s.t, s.t);
  return std::hypot(std::sqrt(std::max(0.0, across)),
                    system.layout().modes > 0 ? own / motion : 0); // without modes they have no scale
}

void Curve::bend(const Station &before, const Station &here, double step, Vec y) {
  const Vec more = work_[0];
  check(VecWAXPY(more, -1, before.y, here.y), "predicting");
  const double last = norm.length(more), square = step * step / last, cubic = square * (last + step) / last;
  if (!(last > 0)) return;
  // square (t - chord / last) + cubic (t + t_before - 2 chord / last), divided differences of the cubic
  check(
      VecAXPBYPCZ(more, square + cubic, cubic / norm.length(before.t), -(square + 2 * cubic) / last, here.t, before.t),
      "predicting");
  check(VecAXPY(more, -norm.product(more, here.t), here.t), "predicting");
  check(VecAXPY(y, 1, more), "predicting");
}

double Curve::off_middle(const Station &a, const Station &b) {
  constexpr const char *doing = "looking into a step";
  const Vec r = work_[0], c = work_[1], middle = work_[2];
  check(VecWAXPY(c, -1, a.y, b.y), doing);
  const double length = norm.length(c);
  check(VecWAXPY(middle, 0.5, c, a.y), doing);
  check(VecAXPBYPCZ(middle, length / 8, -length / 8, 1, a.t, b.t), doing);
  system.residual(middle, r);
  double *own;
  check(VecGetArray(r, &own), doing);
  if (system.layout().owns_omega()) own[system.layout().own_coefficients()] = 0; // along the step nothing is missing
  check(VecRestoreArray(r, &own), doing);
  const auto correction = corrector_.correct(r, c);
  count(correction);
  return correction.found ? norm.length(c) / length : std::nan("");
}

bool Curve::tangent_at(Vec y, Vec normal, Vec t, int &sign) {
  norm.weigh(normal, row_);
  solve_ = none;
  const auto direction = corrector_.tangent_at(y, row_, t);
  count(direction);
  sign = direction.sign;
  if (direction.found) check(VecScale(t, 1 / norm.length(t)), "computing a tangent");
  return direction.found;
}

void Curve::set_omega(Vec y, double w) const {
  const Layout &layout = system.layout();
  double *own;
  check(VecGetArray(y, &own), "setting Omega");
  if (layout.owns_omega()) own[layout.own_coefficients()] = w;
  check(VecRestoreArray(y, &own), "setting Omega");
}

double Curve::plane(Vec normal, Vec y) { return norm.product(normal, y); }

void turn(Station &s) {
  check(VecScale(s.t, -1), "turning a tangent");
  s.sign = -s.sign;
}

double angle(const ArcNorm &norm, Vec t, Vec u) { return std::acos(std::clamp(norm.product(t, u), -1.0, 1.0)); }

} // namespace dovetail
