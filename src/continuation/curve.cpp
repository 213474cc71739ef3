#include "continuation/curve.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

// Newton's method hardly comes back from corrections as long as that: so many steps,
constexpr double most_steps = 100;
constexpr double least_reach = 0.01; // and such a part of all unknowns

} // namespace

Curve::Curve(Problem &problem_, const NewtonSettings &newton, double unit, bool weighted, SolveCounts &counts)
    : metric_(problem_.metric(unit, weighted)), problem(problem_), norm(*metric_), corrector_(problem_, newton),
      counts_(counts), row_(problem_.unknowns()),
      unit_(problem_.unknowns()), work_{problem_.unknowns(), problem_.unknowns()} {
  set_parameter(unit_, 1);
}

CurvePoint Curve::point() const {
  CurvePoint s;
  for (UniqueVec *v : {&s.y, &s.t}) { // to lay out a new one would take a message
    check(VecDuplicate(row_, v->out()), "creating a point");
    check(VecSet(*v, 0), "creating a point");
  }
  return s;
}

bool Curve::solve_across(Vec normal, CurvePoint &s, const StepEffort &effort) {
  constexpr const char *doing = "predicting";
  PetscScalar target, square, size, unit;
  norm.weigh(normal, row_);
  check(VecDotBegin(row_, s.y, &target), doing); // by one message
  check(VecDotBegin(row_, normal, &square), doing);
  check(VecDotBegin(s.y, s.y, &size), doing); // no VecNorm, whose value PETSc remembers and scales: see plain_length
  check(VecDotBegin(normal, normal, &unit), doing);
  check(VecDotEnd(row_, s.y, &target), doing);
  check(VecDotEnd(row_, normal, &square), doing);
  check(VecDotEnd(s.y, s.y, &size), doing);
  check(VecDotEnd(normal, normal, &unit), doing);
  const double reach =
      effort.step > 0 ? std::max(most_steps * effort.step * std::sqrt(unit / square), least_reach * std::sqrt(size))
                      : 0;
  s.newton = corrector_.solve(s.y, row_, target, {effort.line_search, effort.most, reach, effort.exact, effort.steady});
  return finish(s);
}

bool Curve::solve_at(double value, CurvePoint &s) {
  return solve_at(value, s, {}) || solve_at(value, s, {.line_search = true});
}

bool Curve::solve_at(double value, CurvePoint &s, const StepEffort &effort) {
  set_parameter(s.y, value);
  s.newton = corrector_.solve(s.y, unit_, value, {effort.line_search, effort.most, 0, effort.exact, effort.steady});
  if (!finish(s)) return false;
  set_parameter(s.y, value); // to the last bit
  s.parameter = value;
  return true;
}

double Curve::rounding(double value) {
  CurvePoint s = point();
  solve_at(value, s, {.most = 1});
  return corrector_.rounding();
}

void Curve::count(const Corrector::Outcome &newton) {
  counts_.newton += newton.newton, counts_.linear += newton.linear, counts_.inexact += newton.inexact;
}

void Curve::count(const Corrector::Direction &solve) {
  counts_.linear += solve.linear, counts_.inexact += solve.inexact;
}

bool Curve::finish(CurvePoint &s) {
  count(s.newton);
  solve_.reset();
  if (!s.newton.converged) return false;
  s.data = problem.describe();
  const auto direction = corrector_.tangent(s.t);
  count(direction);
  s.sign = direction.sign;
  if (!direction.found || !normalise(s.t, s.y)) {
    s.newton.converged = false, s.newton.why = "the bordered Jacobian is singular";
    return false;
  }
  s.parameter = parameter_of(s.y);
  static long solves;
  s.solve = ++solves;
  solve_ = s.solve;
  return true;
}

bool Curve::correct(const CurvePoint &s, Vec r, Vec c) {
  if (s.solve != solve_) {
    norm.weigh(s.t, row_);
    corrector_.for_corrections(s.y, row_);
    solve_ = s.solve;
  }
  const auto correction = corrector_.correct(r, c);
  count(correction);
  return correction.found;
}

Curve::Off Curve::off_middle(const CurvePoint &a, const CurvePoint &b, Vec middle) {
  constexpr const char *doing = "looking into a step";
  const Vec r = work_[0], c = work_[1];
  check(VecCopy(a.y, middle), doing);
  check(VecAXPBY(middle, 0.5, 0.5, b.y), doing);
  if (problem.is_drawn_by_cubics()) {
    const double eighth = chord(a.y, b.y) / 8;
    check(VecAXPBYPCZ(middle, eighth / plain_length(a.t), -eighth / plain_length(b.t), 1, a.t, b.t), doing);
  } else { // then the one by arc length
    check(VecWAXPY(c, -1, a.y, b.y), doing);
    const double eighth = norm.length(c) / 8;
    check(VecAXPBYPCZ(middle, eighth, -eighth, 1, a.t, b.t), doing);
  }
  problem.residual(middle, r);
  set_parameter(r, 0); // along the step nothing is missing
  if (!correct(b.solve == solve_ ? b : a, r, c)) return {std::nan(""), std::nan("")};
  check(VecAXPY(middle, -1, c), doing);
  const std::vector<double> squares = norm.products({{c, c}}, {c, middle});
  return {std::sqrt(squares[0]), std::sqrt(squares[1] / squares[2])};
}

double Curve::chord(Vec from, Vec to) const {
  PetscReal length;
  check(VecWAXPY(work_[1], -1, from, to), "measuring a chord");
  check(VecNorm(work_[1], NORM_2, &length), "measuring a chord");
  return length;
}

bool Curve::tangent_at(Vec y, Vec normal, Vec t, int &sign) {
  norm.weigh(normal, row_);
  solve_.reset();
  const auto direction = corrector_.tangent_at(y, row_, t);
  count(direction);
  sign = direction.sign;
  return direction.found && normalise(t, y);
}

// To length 1; false where it has none. All ranks know the parameter of both then, and the tangent's plain length.
bool Curve::normalise(Vec t, Vec y) {
  constexpr const char *doing = "computing a tangent";
  UniqueVec weighed;
  check(VecDuplicate(t, weighed.out()), doing);
  PetscScalar square, plain, rate, parameter;
  norm.weigh(t, weighed);
  check(VecDotBegin(weighed, t, &square), doing); // by one message
  check(VecDotBegin(t, t, &plain), doing);
  check(VecDotBegin(unit_, t, &rate), doing);
  check(VecDotBegin(unit_, y, &parameter), doing);
  check(VecDotEnd(weighed, t, &square), doing);
  check(VecDotEnd(t, t, &plain), doing);
  check(VecDotEnd(unit_, t, &rate), doing);
  check(VecDotEnd(unit_, y, &parameter), doing);
  if (!(std::isfinite(square) && square > 0)) return false;
  note_plain_length(t, std::sqrt(plain)), note_parameter(t, rate), note_parameter(y, parameter);
  scale_known(t, 1 / std::sqrt(square));
  return true;
}

void turn(CurvePoint &s) {
  check(VecScale(s.t, -1), "turning a tangent");
  s.sign = -s.sign;
}

double angle_of(double product) { return std::acos(std::clamp(product, -1.0, 1.0)); }

double angle(const ArcLengthMetric &norm, Vec t, Vec u) { return angle_of(norm.product(t, u)); }

} // namespace dovetail
