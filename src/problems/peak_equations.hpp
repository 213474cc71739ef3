#pragma once
// What makes a point of a response curve a maximum of the watched amplitude, with the derivatives of that:
//     R = 0,   J^T lambda = dA/dY,   c = lambda . R_Omega = -dA/dOmega,   2 A = amplitude^2.   (eq D)
// c's derivatives take the second one of the equations in one direction only, by differences of J^T lambda.
#include "harmonic/harmonic_system.hpp"
#include "problems/amplitude.hpp"

namespace dovetail {

class PeakEquations {
public:
  /// Equations like those, with exact forces, over the frequency. Collective, like all that follows.
  PeakEquations(const HarmonicSystem &like, const Watched &watched);

  HarmonicSystem &system() { return *system_; }
  /// From here on that parameter of a path has that value; `preload`: of the model, where it changes the joint.
  void set(const PathParameter &parameter, double value, const std::shared_ptr<VariedPreload> &preload);
  Vec y() const { return y_; } ///< [Y; Omega] at hand
  void take(Vec y);            ///< The point at hand is a copy of that.
  double omega() const { return system_->parameter_in(y_); }
  double amplitude() const; ///< sqrt(sum over k >= 1 of a_k^2 + b_k^2) of what is watched, by differentiate()

  /// Newton's method at the frequency at hand. False where it does not converge.
  bool solve();
  /// dY/dOmega and the adjoint to that relative accuracy, and c to its square. False where a solve fails. Goes on from
  /// what it found at the point before.
  bool differentiate(double accuracy = finest);
  /// After that: c's own derivatives by Y and Omega.
  void turn();
  /// After differentiate(): c's derivative by a parameter.
  double by_parameter(const PathParameter &parameter);
  double c() const { return c_; }
  Vec along() const { return along_; }       ///< [dY/dOmega; 0]
  Vec gradient() const { return gradient_; } ///< [dA/dY; 0]
  Vec turned() const { return turned_; }     ///< [c_Y; c_Omega]
  double slope() const;                      ///< dc/dOmega along the curve; positive at a maximum

  static constexpr double finest = 1e-10; ///< relative accuracy of solves that iterate

  /// What the solvers have learned, a number each, and a beginning with nothing but that: see LinearPart::memory().
  std::vector<double> solver_memory() const;
  void begin_solves(const std::vector<double> &memory);

  /// To another frequency, along the curve.
  void move(double by);
  /// From a point near it to the maximum. False where no smooth maximum is near: it lies in a corner, or is none.
  bool climb();

protected:
  void factor(Vec border, bool transposed); // for solves at the point at hand
  double omega_by_damping(); // lambda . d R_Omega / d factor on damping: no other parameter is in R_Omega
  bool solve(Vec right, Vec x, bool transposed, double accuracy = finest);

  std::unique_ptr<HarmonicSystem> system_;
  UniqueVec y_, along_, gradient_, adjoint_, turned_, at_;
  UniqueVec fixed_; // border that holds Omega: the last unit vector
  double step_ = 0; // for differences along dY/dOmega

private:
  bool solve_on(Vec right, Vec x, bool transposed, double accuracy);
  void watch(Vec v, Vec out) const;

  struct Solver {
    UniqueMat matrix;
    UniqueKSP ksp;
  };
  Solver solver(bool transposed) const;

  Solver plain_, transposed_;
  WatchedRow row_; // what is watched, by q
  UniqueVec f_, correction_;
  double c_ = 0;
  bool differentiated_ = false; // somewhere near: dY/dOmega and the adjoint are good beginnings
  std::optional<double> value_; // of the parameter, see set()
};

} // namespace dovetail
