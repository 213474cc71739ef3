#pragma once
// Steps along the response curve: what is done with each, and where the curve stands. response_stepper.cpp: steps;
// response_places.cpp: what is told of a step; response_state.cpp: what is saved and restored.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analyses/branch_report.hpp"
#include "analyses/harmonics_control.hpp"
#include "analyses/place_finder.hpp"
#include "analyses/sweep_monitors.hpp"
#include "continuation/stepper.hpp"

namespace dovetail {

class SavedVectors;

class ResponseStepper : public Stepper {
public:
  ResponseStepper(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings,
                  BranchReport &report);

  Response response;
  SweepRange range; ///< may be changed until the first point
  SweepMonitors progress;
  Farthest<CurvePoint> farthest{range};
  ErrorWatch errors;

  /// Outcome::refused where no step converges, however short: why() says why.
  using Stepper::advance;
  const std::string &why() const { return refusal_; }

  /// The last point. Whatever stands there instead is for stand_on.
  CurvePoint &here() { return here_; }
  /// The curve begins at here(), with that arc length in the plain norm.
  void begin(double step);
  /// At a point that no step has led to, of a system with other harmonics unless null.
  void stand_on(CurvePoint point, std::unique_ptr<HarmonicSystem> system);
  /// That point is given, steps begin short, and what comes does not hang together with the points before.
  void land();

  void save(BranchState &state, Archive &archive);
  void restore(const BranchState &state, Archive &archive);

private:
  using End = BranchSummary::End;

  bool refine(CurvePoint &trial) override { return harmonics_.refine(trial); }
  Outcome pass(Vec normal, double step, bool at_kink) override;
  Outcome settle(Vec way) override;
  void stepped() override { harmonics_.spare(here_); }
  void halved(const std::string &why) override;
  void turned_kink(double angle, double parameter) override;
  Outcome no_step() override { return Outcome::refused; }
  bool iterations_are_expensive() const override { return response.iterations_are_expensive(); }

  Outcome tell(std::vector<Place> &places, const std::vector<double> &lengths, bool at_kink);
  Outcome tell(const Place &place);
  void tell_fold(Place &place, bool higher, bool at_kink);
  void give(CurvePoint &s, double arclength, const Stability *stability, bool located = false);
  void begin_amplitude();
  void adopt(std::unique_ptr<HarmonicSystem> system);
  bool change_harmonics(int harmonics, int most_newton, double error);
  void archive(Archive &archive);
  void archive_points(Archive &archive, SavedVectors &vectors);
  void describe(CurvePoint &point);
  void end_beyond_limits();

  BranchReport &report_;
  const double limit_; // of the amplitude
  const int most_points_, most_peaks_;
  StabilityWatch stability_;
  HarmonicsControl harmonics_;
  AmplitudeCourse amplitude_;
  double largest_ = 0; // amplitude so far
  double arclength_ = 0;
  int folds_before_ = 0; // turning points until the step at hand
};

} // namespace dovetail
