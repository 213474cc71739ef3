#pragma once
// Newton (SNES) on the bordered system [residual; border . y - target] = 0, and tangents from the same matrix.
#include <vector>

#include "continuation/problem.hpp"
#include "support/error.hpp"

namespace dovetail {

struct NewtonSettings {
  double step_tolerance;     ///< eps_x: |dy| < eps_x |y|
  double residual_tolerance; ///< eps_f: |residual| < eps_f; both in scaled variables
  int max_iterations;
};

/// What a solve may take.
struct NewtonEffort {
  bool line_search = false;
  int most = 0;        ///< iterations, if that is fewer than the settings'; 0: those
  double reach = 0;    ///< longest correction, plain norm: beyond, nothing is wanted; 0: any
  bool exact = false;  ///< given up once a linear solve leaves more than was asked
  bool steady = false; ///< given up once the residual grows twice in succession
};

class Corrector {
public:
  Corrector(Problem &problem, const NewtonSettings &settings);

  struct Outcome {
    bool converged = false;
    int newton = 0, linear = 0; ///< iterations
    int inexact = 0;            ///< linear solves, see LinearEffort
    double residual = 0;        ///< norm, scaled
    std::string why;            ///< when not converged, in words
  };
  /// Newton from y, kept on the plane border . y = target. y is left alone unless it converges. Without a line search
  /// it is given up when it runs in a circle, as it does where pieces of the equations meet and no solution is near.
  /// Collective.
  Outcome solve(Vec y, Vec border, double target, const NewtonEffort &effort = {});

  struct Direction {
    bool found = false; ///< false: the bordered Jacobian is singular
    int sign = 0;       ///< of its determinant, +1 or -1; 0 where the solver does not tell
    int linear = 0;     ///< iterations, where the solver iterates
    int inexact = 0;    ///< linear solves, see LinearEffort
  };
  /// t with [d residual / d y] t = 0 and border . t = 1, where the last solve converged and with its border: one more
  /// solve with the factors of its last iteration, which lies within eps_x of the solution. The determinant of
  /// [d residual / d y; t] has the same sign as that with the border in place of t. Collective.
  Direction tangent(Vec t);
  /// c with [d residual / d y] c = r and border . c = 0, after tangent or for_corrections and by the same factors,
  /// roughly where the solver iterates. r's last entry is 0. Collective.
  Direction correct(Vec r, Vec c);
  /// The Jacobian at any y, with a border: corrections that follow are by it.
  void for_corrections(Vec y, Vec border);
  /// A tangent with the Jacobian at any y, on the curve or beside it, and a border.
  Direction tangent_at(Vec y, Vec border, Vec t);

  /// By how much the residual changes when the unknowns of the last iterate change by their last bits, norm: less is
  /// luck. Collective.
  double rounding();

  double take_work() { return jacobian_->take_work(); } ///< see BorderedJacobian
  double memory() const { return jacobian_->memory(); } ///< see BorderedJacobian
  void recall(double memory) { jacobian_->begin(memory, false); }

  /// Of tangents, relative, where the solver iterates.
  double tangent_accuracy = usual_accuracy;
  static constexpr double usual_accuracy = 1e-6, high_accuracy = 1e-10;

private:
  static PetscErrorCode residual(SNES, Vec y, Vec f, void *context);
  static PetscErrorCode jacobian(SNES, Vec y, Mat J, Mat, void *context);
  static PetscErrorCode converged(SNES, PetscInt it, PetscReal y, PetscReal dy, PetscReal f, SNESConvergedReason *,
                                  void *context);
  struct Iterate {
    double residual, correction; // norms
  };
  bool is_rounding(double residual);                                      // of the iterate at hand
  const char *why_give_up(PetscInt iterations, const Iterate &now) const; // null: there is hope
  bool grows(double residual) const;
  Outcome solve_once(Vec y, Vec border, double target, const NewtonEffort &effort, bool &lacked_memory);
  void assemble(Vec y, Vec border);
  Direction solve_again(Vec r, Vec x, double accuracy);

  Problem &problem_;
  NewtonSettings settings_;
  std::unique_ptr<BorderedJacobian> jacobian_;
  UniqueVec residual_, trial_, unit_;
  UniqueSNES snes_;
  Courier courier_;
  std::string usual_search_; // type of line search, basic unless an option says otherwise
  Vec border_ = nullptr;     // of the solve in progress
  double target_ = 0;
  NewtonEffort effort_;            // of the solve in progress
  LinearEffort spent_;             // likewise, so far
  std::vector<Iterate> iterates_;  // of the solve in progress
  const char *given_up_ = nullptr; // why it was, if it was
};

} // namespace dovetail
