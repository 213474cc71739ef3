#pragma once
// The Jacobian of a nonlinear mode by products, solved with by FGMRES (docs/theory/nonlinear-modes.md). Without its
// border it is singular. Its preconditioner is the Jacobian of a motion with more damping, solved with in the modes of
// the stuck structure as in a forced response, and bordered by elimination.
#include "problems/mode_border.hpp"

namespace dovetail {

class ModeKrylov : public BorderedJacobian {
public:
  /// `system`: of the mode, in the modal form. Collective.
  ModeKrylov(NonlinearMode &mode, HarmonicSystem &system);

  Mat matrix() const override { return matrix_; }
  void set_up(KSP ksp) override;
  void assemble(Vec y, Vec plane) override;
  std::string recover(KSP) override { return "the Jacobian is singular, or no number"; }
  LinearEffort take_effort(int solves) override;
  double take_work() override { return system_.take_solver_work(damped_); }
  double memory() const override { return system_.solver_memory(damped_); }
  void begin(double memory, bool for_one) override { system_.begin_solves(damped_, memory, for_one); }

  template <class Work> PetscErrorCode run(Work &&work) { return courier_.run(work); }

private:
  void multiply(Vec x, Vec y);
  void solve(Vec r, Vec x);        // by krylov_
  void precondition(Vec r, Vec x); // with damped_ and the border
  bool solve_damped(const double *r, double *x);

  NonlinearMode &mode_;
  HarmonicSystem &system_;
  const Layout &layout_;
  ModeBorder border_;
  UniqueMat matrix_, exact_, damped_; // the whole; its part by the motion, for products; the same with more damping
  UniqueKSP krylov_, in_modes_;
  UniqueVec right_, answer_; // [X; one unknown more], of the harmonic system
  KSP outer_ = nullptr;
  double alpha_ = 1;
  bool eliminated_ = false;
  std::vector<double> none_, last_; // a border that couples nothing
  LinearEffort effort_;
  Courier courier_;
};

} // namespace dovetail
