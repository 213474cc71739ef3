#pragma once
// The Jacobian of a track in [Y; Omega; p]: [R_Y R_Omega R_p; condition; border], solved with by elimination. R_Y is
// regular at a peak.
#include "problems/peak_track.hpp"
#include "support/dense.hpp"

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
  void begin(double memory) override { system_.begin_solves(response_, memory); }

  template <class Work> PetscErrorCode run(Work &&work) { return courier_.run(work); }

private:
  static constexpr int width = 2; // of Omega and p
  using Pair = std::array<double, width>;

  void multiply(Vec x, Vec y);
  void solve(Vec r, Vec x);
  bool eliminate();
  bool solve_response(Vec r, Vec x);
  Pair last_of(Vec v) const;            // Omega and p, on every rank
  void put(Vec response, Vec v) const;  // all before Omega
  void take(Vec v, Vec response) const; // likewise; Omega is 0
  Pair along_rows(Vec response) const;  // condition and border, without what they say of Omega and p

  PeakTrack &track_;
  HarmonicSystem &system_;
  UniqueMat matrix_, response_; // the whole; [R_Y R_Omega; 0 1]
  UniqueKSP inner_;
  std::array<UniqueVec, width> columns_, rows_, answers_; // of the response; answers_ are R_Y^-1 columns_
  std::array<Pair, width> corner_;                        // by rows
  UniqueVec right_, left_, fixed_;
  Factors factors_; // of what is left for Omega and p
  bool eliminated_ = false;
  KSP outer_ = nullptr;
  Courier courier_;
};

} // namespace dovetail
