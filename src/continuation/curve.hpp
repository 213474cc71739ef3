#pragma once
// The solution curve of one harmonic system: points on it, found by Newton, with oriented tangents.
#include <optional>

#include "continuation/arc_norm.hpp"
#include "continuation/branch_state.hpp"
#include "continuation/corrector.hpp"
#include "continuation/estimator.hpp"
#include "transient/orbit_curve.hpp"

namespace dovetail {

/// A point of the curve and its tangent. Members are right only after a solve that converged.
struct Station {
  UniqueVec y, t;                     ///< [X; Omega]; tangent of weighted length 1, towards growing arc length
  int sign = 0;                       ///< of det [d residual / d y; t]: it stays the same along a curve; 0: unknown
  double omega = 0;                   ///< last entry of y
  Corrector::Outcome newton;          ///< of the solve that led here
  std::vector<Activity> activity;     ///< of the own contact points
  std::optional<ErrorEstimate> error; ///< once it has been asked for
  OrbitCurve::PlacePtr motion;        ///< that y and t show, where the curve is followed in time
  long solve = 0;                     ///< number of the solve that led here, among those of all curves
};

/// What a solve across a tangent may take.
struct StepEffort {
  bool line_search = false;
  int most = 0;    ///< iterations, unless 0
  double step = 0; ///< length of the step that led to the guess, if a solution far beyond it is not wanted
};

class Curve {
public:
  /// `omega_unit`: what counts as much as the largest motion in the norm. `counts`: where iterations are added.
  Curve(HarmonicSystem &system, const NewtonSettings &newton, double omega_unit, bool weighted, Counts &counts);

  Station station() const; ///< with room for y and t

  /// Newton from the guess in s.y on the plane through it whose normal is `normal` (weighted). The tangent of s looks
  /// to the same side as `normal`. If it fails s.newton.why says so, and s.y is what it was. Collective.
  bool solve_across(Vec normal, Station &s, const StepEffort &effort = {});
  /// Newton from the guess in s.y at the frequency w, plainly, then with a line search, each with `times` the settings'
  /// iterations; plainly only, if that is less than 1. The tangent looks to growing frequencies. Collective.
  bool solve_at(double w, Station &s, double times = 1);

  /// From now on tangents as accurate as possible, or as usual: places are located by them.
  void precisely(bool yes) { corrector_.tangent_accuracy = yes ? Corrector::high_accuracy : Corrector::usual_accuracy; }

  /// Tangent and sign by the Jacobian at any y, to the side of `normal`. Collective.
  bool tangent_at(Vec y, Vec normal, Vec t, int &sign);

  /// Estimated distance to the curve that modes left out of the reduced model would lead to, as ErrorEstimate has it;
  /// NaN where the linear solver failed. With the factors of the last solve, if s is from that. Collective.
  double left_out(const Station &s);

  /// Bends a guess y = here + step t, which the tangent gives, as the step before was bent: by the cubic through both
  /// its ends with the tangents there, without what leaves the plane across t. The error goes with step^4, not step^2.
  void bend(const Station &before, const Station &here, double step, Vec y);

  /// How far the middle of the cubic from a to b lies off the curve, over the length of the step: roughly, by one
  /// correction with the factors of the last solve, which led to b; NaN where that failed. Large where the step led to
  /// another piece of the curve, or across a loop of it. Collective.
  double off_middle(const Station &a, const Station &b);

  double take_work() { return corrector_.take_work(); } ///< of the linear solver, see linear_part.hpp
  double memory() const { return corrector_.memory(); } ///< of the linear solver, see linear_part.hpp
  void recall(double memory) { corrector_.recall(memory); }

  void set_omega(Vec y, double w) const;
  double plane(Vec normal, Vec y); ///< weighted product; differences of it are arc lengths along `normal`

  HarmonicSystem &system;
  ArcNorm norm;

private:
  bool finish(Station &s);
  void count(const Corrector::Outcome &newton);
  void count(const Corrector::Direction &solve);

  Corrector corrector_;
  double omega_unit_;
  Counts &counts_;
  UniqueVec row_, e_omega_, work_[3];
  static constexpr long none = -1;
  long solve_ = none; // of which the corrector holds factors
};

/// Other way round: the same point, the tangent turned.
void turn(Station &s);
/// Angle between two tangents of weighted length 1 [rad].
double angle(const ArcNorm &norm, Vec t, Vec u);

} // namespace dovetail
