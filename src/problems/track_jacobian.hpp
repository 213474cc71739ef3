#pragma once
// The Jacobian of a track in [Y; Omega; p]: [R_Y R_Omega R_p; condition; border], solved with by elimination. R_Y is
// regular at a peak.
#include <optional>

#include "problems/border.hpp"
#include "problems/peak_track.hpp"

namespace dovetail {

class TrackJacobian : public BorderedJacobian {
public:
  explicit TrackJacobian(PeakTrack &track);

  Mat matrix() const override { return matrix_; }
  void set_up(KSP ksp) override;
  void assemble(Vec y, Vec border) override;
  int determinant_sign(KSP ksp) override;
  std::string recover(KSP ksp) override;
  LinearEffort take_effort(int solves) override { return system_.take_effort(response_, solves); }
  double take_work() override { return system_.take_solver_work(response_); }
  double memory() const override { return system_.solver_memory(response_); }
  void begin(double memory, bool for_one) override { system_.begin_solves(response_, memory, for_one); }

  template <class Work> PetscErrorCode run(Work &&work) { return courier_.run(work); }

private:
  void multiply(Vec x, Vec y);
  void solve(Vec r, Vec x);
  double asked() const; // accuracy
  bool solve_response(const double *r, double *x);

  PeakTrack &track_;
  HarmonicSystem &system_;
  Border<2> border_;            // Omega and p; the condition and the plane that a step ends on
  UniqueMat matrix_, response_; // the whole; [R_Y R_Omega; 0 1]
  UniqueKSP inner_;
  UniqueVec right_, left_, fixed_;
  std::optional<std::vector<double>> by_omega_; // (own coefficients) R_Y^-1 R_Omega, where the condition knows it
  bool eliminated_ = false;
  KSP outer_ = nullptr;
  Courier courier_;
};

} // namespace dovetail
