#pragma once
// The equations of the contact preload (eq 7), and Newton's method on them.
#include <vector>

#include "contact/law.hpp"
#include "reduction/reduced_model.hpp"
#include "support/error.hpp"
#include "support/handle.hpp"

namespace dovetail {

/// load * R + K_xx x + g(x) = 0. All that is called here is collective.
class PreloadProblem {
public:
  /// Both must outlive it. `contact` may change between two solves.
  PreloadProblem(const ReducedModel &model, const std::vector<ContactPoint> &contact);

  UniqueVec unknown() const; ///< x (3 own each), unset
  /// From x by plain Newton; else from the joint held closed and stuck: at once, loaded in steps, with friction
  /// lowered in steps. False where nothing helps, and then x is what it was. `note` receives a line in words when
  /// more than plain Newton was needed.
  bool find(Vec x, double load, std::string &note);
  /// dx = -(K_xx + dg/dx)^-1 change, at x.
  void follow(Vec x, Vec change, Vec dx);

private:
  bool solve(Vec x, double load, bool stuck);
  bool load_in_steps(Vec x, double load);
  bool lower_friction(Vec x, double load);
  static PetscErrorCode converged(SNES, PetscInt, PetscReal, PetscReal, PetscReal f, SNESConvergedReason *reason,
                                  void *context);
  static PetscErrorCode residual(SNES, Vec x, Vec f, void *context);
  static PetscErrorCode jacobian(SNES, Vec x, Mat J, Mat, void *context);
  StaticForce law(std::size_t p, const double *x) const;

  const ReducedModel &model_;
  const std::vector<ContactPoint> &contact_;
  UniqueMat stiffness_, jacobian_;
  UniqueVec residual_;
  UniqueSNES snes_;
  Courier courier_;
  double load_ = 1, force_ = 1, before_ = 0; // force_: those at work; before_: residual of the iteration before
  double friction_ = 1;                      // a factor on that of all points
  bool stuck_ = false;                       // the laws are replaced by their springs, closed and sticking
};

} // namespace dovetail
