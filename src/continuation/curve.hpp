#pragma once
// The solution curve of a problem: points on it, found by Newton's method, with oriented tangents.
#include <memory>
#include <optional>

#include "continuation/corrector.hpp"

namespace dovetail {

/// Iterations spent, those of failed steps included.
struct SolveCounts {
  long newton = 0, linear = 0;
  long inexact = 0; ///< linear solves that left more than was asked
};

/// A point of the curve and its tangent. Members are right only after a solve that converged.
struct CurvePoint {
  UniqueVec y, t;                  ///< [x; p]; tangent of weighted length 1, towards growing arc length
  int sign = 0;                    ///< of det [d residual / d y; t]: it stays the same along a curve; 0: unknown
  double parameter = 0;            ///< last entry of y
  Corrector::Outcome newton;       ///< of the solve that led here
  std::shared_ptr<PointData> data; ///< the problem's own
  long solve = 0;                  ///< number of the solve that led here, among those of all curves
};

/// What a solve across a tangent may take.
struct StepEffort {
  bool line_search = false;
  int most = 0;    ///< iterations, unless 0
  double step = 0; ///< length of the step that led to the guess, if a solution far beyond it is not wanted
  bool exact = false, steady = false; ///< see NewtonEffort
};

class Curve {
public:
  /// `unit`: change of the parameter that counts as much as the largest motion. `counts`: where iterations are added.
  Curve(Problem &problem, const NewtonSettings &newton, double unit, bool weighted, SolveCounts &counts);

  CurvePoint point() const; ///< with room for y and t

  /// Newton from the guess in s.y on the plane through it whose normal is `normal` (weighted). The tangent of s looks
  /// to the same side as `normal`. If it fails s.newton.why says so, and s.y is what it was. Collective.
  bool solve_across(Vec normal, CurvePoint &s, const StepEffort &effort = {});
  /// Newton from the guess in s.y at that value of the parameter, plainly, then with a line search. The tangent looks
  /// to growing values. Collective.
  bool solve_at(double value, CurvePoint &s);
  /// The same one way only.
  bool solve_at(double value, CurvePoint &s, const StepEffort &effort);

  /// The residual that rounding leaves near that value: Corrector::rounding behind one iteration from rest. Collective.
  double rounding(double value);

  /// From now on tangents as accurate as possible, or as usual: places are located by them.
  void precisely(bool yes) { corrector_.tangent_accuracy = yes ? Corrector::high_accuracy : Corrector::usual_accuracy; }

  /// Tangent and sign by the Jacobian at any y, to the side of `normal`. Collective.
  bool tangent_at(Vec y, Vec normal, Vec t, int &sign);

  /// c with [d residual / d y] c = r and border . c = 0 at s, roughly where the solver iterates: with the factors of
  /// the last solve if s is from that. False where it failed. Collective.
  bool correct(const CurvePoint &s, Vec r, Vec c);

  struct Off {
    double length, part; ///< weighted; of the motion there, without weights
  };
  /// How far the middle of the cubic from a to b that is drawn lies off the curve: roughly, by one correction with the
  /// factors of the last solve, which led to b or to a; NaN where that failed. Large where the step led to another
  /// piece of the curve, or across a loop of it. `middle` becomes what the correction finds. Collective.
  Off off_middle(const CurvePoint &a, const CurvePoint &b, Vec middle);

  double take_work() { return corrector_.take_work(); } ///< of the linear solver, see BorderedJacobian
  double memory() const { return corrector_.memory(); } ///< likewise
  void recall(double memory) {
    solve_.reset();
    corrector_.recall(memory);
  }

  /// Length in the plain norm. Of the same norm are the tangents of the cubics which draw the curve. Collective.
  double chord(Vec from, Vec to) const;
  /// Weighted product; differences of it are arc lengths along `normal`.
  double plane(Vec normal, Vec y) const { return norm.product(normal, y); }

private:
  std::unique_ptr<ArcLengthMetric> metric_;

public:
  Problem &problem;
  ArcLengthMetric &norm;

private:
  bool finish(CurvePoint &s);
  bool normalise(Vec t, Vec y);
  void count(const Corrector::Outcome &newton);
  void count(const Corrector::Direction &solve);

  Corrector corrector_;
  SolveCounts &counts_;
  UniqueVec row_, unit_, work_[2];
  std::optional<long> solve_; // of which the corrector holds factors
};

/// Other way round: the same point, the tangent turned.
void turn(CurvePoint &s);
/// Angle between two tangents of weighted length 1 [rad], also by their product.
double angle(const ArcLengthMetric &norm, Vec t, Vec u);
double angle_of(double product);

} // namespace dovetail
