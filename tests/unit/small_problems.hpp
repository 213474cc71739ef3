#pragma once
// Problems of a few unknowns, each rank by itself, and a walk along their curves.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "continuation/stepper.hpp"
#include "support/dense.hpp"
#include "support/error.hpp"
#include "support/mumps.hpp"

namespace dovetail::testing {

/// n equations in y = [x; p]: f (n), and J (n rows of n + 1) by rows.
struct Equations {
  int unknowns; ///< n
  std::function<void(const double *y, double *f)> f;
  std::function<void(const double *y, double *J)> derivative;
};

class SmallJacobian : public BorderedJacobian {
public:
  explicit SmallJacobian(const Equations &equations) : equations_(equations), size_(equations.unknowns + 1) {
    check(MatCreateSeqAIJ(PETSC_COMM_SELF, size_, size_, size_, nullptr, matrix_.out()), "");
  }
  Mat matrix() const override { return matrix_; }
  void set_up(KSP ksp) override { factor_by_lu(ksp, matrix_); }
  void assemble(Vec y, Vec border) override {
    std::vector<double> J(size_ * size_);
    const double *at, *last;
    check(VecGetArrayRead(y, &at), "");
    check(VecGetArrayRead(border, &last), "");
    equations_.derivative(at, J.data());
    std::copy_n(last, size_, J.end() - size_);
    check(VecRestoreArrayRead(border, &last), "");
    check(VecRestoreArrayRead(y, &at), "");
    Dense whole(size_, size_);
    for (int i = 0; i < size_; ++i)
      for (int j = 0; j < size_; ++j) {
        whole(i, j) = J[i * size_ + j];
        check(MatSetValue(matrix_, i, j, J[i * size_ + j], INSERT_VALUES), "");
      }
    check(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY), "");
    check(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY), "");
    factors_.factor(whole);
  }
  int determinant_sign(KSP) override { return factors_.sign(); }
  std::string recover(KSP ksp) override { return recover_lu(ksp, matrix_); }

protected:
  const Equations &equations_;
  int size_;
  UniqueMat matrix_;
  Factors factors_;
};

class SmallProblem : public Problem {
public:
  explicit SmallProblem(Equations equations) : equations_(std::move(equations)) {}
  const Parameter &parameter() const override { return parameter_; }
  UniqueVec unknowns() const override {
    UniqueVec y;
    check(VecCreateSeq(PETSC_COMM_SELF, equations_.unknowns + 1, y.out()), "");
    check(VecSet(y, 0), "");
    return y;
  }
  void residual(Vec y, Vec f) override {
    const double *at;
    double *out;
    check(VecGetArrayRead(y, &at), "");
    check(VecGetArray(f, &out), "");
    equations_.f(at, out);
    check(VecRestoreArray(f, &out), "");
    check(VecRestoreArrayRead(y, &at), "");
  }
  std::unique_ptr<BorderedJacobian> jacobian() override { return std::make_unique<SmallJacobian>(equations_); }

protected:
  Equations equations_;

private:
  Parameter parameter_{"p", "-"};
};

inline std::vector<double> values(Vec y) {
  const double *at;
  PetscInt size;
  check(VecGetSize(y, &size), "");
  check(VecGetArrayRead(y, &at), "");
  std::vector<double> out(at, at + size);
  check(VecRestoreArrayRead(y, &at), "");
  return out;
}

/// One equation f(x, p) = 0 with its derivatives.
inline Equations one(const std::function<double(double x, double p)> &f,
                     const std::function<double(double, double)> &by_x,
                     const std::function<double(double, double)> &by_p) {
  return {1, [f](const double *y, double *out) { out[0] = f(y[0], y[1]); },
          [by_x, by_p](const double *y, double *J) { J[0] = by_x(y[0], y[1]), J[1] = by_p(y[0], y[1]); }};
}

inline Equations circle() {
  return one([](double x, double p) { return x * x + p * p - 1; }, [](double x, double) { return 2 * x; },
             [](double, double p) { return 2 * p; });
}

/// p = -slope |x|: two straight legs that meet in a kink at 0.
inline Equations hairpin(double slope) {
  return one([slope](double x, double p) { return p + slope * std::abs(x); },
             [slope](double x, double) { return x < 0 ? -slope : slope; }, [](double, double) { return 1.0; });
}

/// x (p - x^2) = 0: two branches that cross at 0.
inline Equations pitchfork() {
  return one([](double x, double p) { return x * (p - x * x); }, [](double x, double p) { return p - 3 * x * x; },
             [](double x, double) { return x; });
}

/// On the plane across the tangent of `here`, from a guess `step` along it.
inline CurvePoint across(Curve &curve, const CurvePoint &here, double step) {
  CurvePoint s = curve.point();
  check(VecWAXPY(s.y, step, here.t, here.y), "");
  EXPECT_TRUE(curve.solve_across(here.t, s)) << s.newton.why;
  return s;
}

/// Points of a small curve.
struct SmallCurve {
  SmallCurve(Equations equations, double range) : problem(std::move(equations)), unit(range) {}

  SmallProblem problem;
  double unit;
  SolveCounts counts;
  Curve curve{problem, {1e-11, 1e-12, 30}, unit, true, counts};

  /// The solution near (x, p) at that p, with its tangent towards growing p.
  CurvePoint at(double x, double p) {
    CurvePoint s = curve.point();
    check(VecSetValue(s.y, 0, x, INSERT_VALUES), "");
    check(VecAssemblyBegin(s.y), "");
    check(VecAssemblyEnd(s.y), "");
    EXPECT_TRUE(curve.solve_at(p, s)) << s.newton.why;
    return s;
  }
  CurvePoint on(const CurvePoint &here, double step) { return across(curve, here, step); }
};

/// Steps along a curve, with what happened on the way.
class Walk : private SmallProblem, public Stepper {
public:
  /// `range`: of the parameter, which counts as much as the largest motion. `between`: as in StepControl.
  Walk(Equations equations, double range, double between = 1e-3)
      : SmallProblem(std::move(equations)), Stepper({true, 0.01, between}, range, tight.step_tolerance),
        own_(*this, tight, range, true, counts) {
    take_curve(own_);
  }

  /// From the solution near x at that value of the parameter, towards growing ones or back.
  void begin(const std::vector<double> &x, double parameter, int sense) {
    for (std::size_t i = 0; i < x.size(); ++i)
      check(VecSetValue(here_.y, static_cast<PetscInt>(i), x[i], INSERT_VALUES), "");
    check(VecAssemblyBegin(here_.y), "");
    check(VecAssemblyEnd(here_.y), "");
    ASSERT_TRUE(own_.solve_at(parameter, here_)) << here_.newton.why;
    if (sense < 0) turn(here_);
    own_.norm.see(here_.y);
    measure_anew();
    limit_step();
    points = {values(here_.y)}, tangents = {values(here_.t)};
  }
  /// As long as `more` says so of the point where it stands, and at most so many steps. False: no step led on.
  bool go(const std::function<bool(const std::vector<double> &)> &more, int most = 2000) {
    for (int i = 0; i < most && more(points.back()); ++i)
      if (advance() != Outcome::on) return false;
    return true;
  }

  static constexpr NewtonSettings tight{1e-11, 1e-12, 30};
  SolveCounts counts;
  std::vector<std::vector<double>> points, tangents; ///< [x; p]
  std::vector<std::vector<double>> folds, branch_points;
  std::vector<double> kinks; ///< angles [rad]
  bool may_resonate = true;

protected:
  bool resonates() const override { return may_resonate; }
  Outcome pass(Vec normal, double step, bool at_kink) override {
    const double rate = parameter_of(here_.t), next = parameter_of(trial_.t);
    if (rate * next < 0 && !at_kink) {
      const auto found = locator().between(normal, {0, here_.y, rate}, {step, trial_.y, next},
                                           [](CurvePoint &s) { return parameter_of(s.t); });
      if (found) folds.push_back(values(found->at.y));
    }
    if (branch_point_) branch_points.push_back(values(branch_point_->at.y));
    std::swap(here_, trial_);
    points.push_back(values(here_.y)), tangents.push_back(values(here_.t));
    return Outcome::on;
  }
  void turned_kink(double angle, double) override { kinks.push_back(angle); }

  Curve own_;
};

} // namespace dovetail::testing
