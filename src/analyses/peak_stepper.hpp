#pragma once
// Steps along the peak of a response curve: what happens between two points, and how the track ends.
#include "analyses/peak_follower.hpp"
#include "analyses/peak_search.hpp"
#include "continuation/stepper.hpp"

namespace dovetail {

class SavedVectors;

/// Follows the peak from its first point on, by the leg it lies on: smooth, or in a corner of the response.
class PeakStepper : private Stepper {
public:
  PeakStepper(HarmonicSystem &system, std::shared_ptr<VariedPreload> preload, const NewtonSettings &newton,
              const TrackSettings &settings, const BranchObserver &observer);

  BranchSummary run(Vec y, const BranchState *state);

private:
  using End = BranchSummary::End;

  bool find_first(Vec y);
  void begin(PeakSearch::Found found);
  bool goes_on();
  void restore(const BranchState &state);
  BranchState state();
  void archive_corner(Archive &archive);
  void archive(Archive &archive, SavedVectors &vectors);
  Outcome pass(Vec normal, double step, bool at_kink) override;
  bool takes_jump(double apart) override;
  void jumped() override;
  void halved(const std::string &why) override;
  void turned_kink(double angle, double value) override;
  Outcome no_step() override;
  bool is_peak(const CurvePoint &s);
  bool solve_within(const CurvePoint &until, double value, CurvePoint &s);
  Outcome pass_wanted(const CurvePoint &until);
  Outcome meet_minimum(Vec normal, double step);
  Outcome end(End how, const std::string &why = "");
  UniqueVec tangent_of(const CurvePoint &s, double along) const;
  void report(const CurvePoint &s, double arclength, bool located = false);
  void notify(BranchEvent::Kind kind, const std::string &text, const CurvePoint &s);
  std::string name() const { return settings_.parameter->name; }

  HarmonicSystem &system_;
  const NewtonSettings &newton_;
  const TrackSettings &settings_;
  const BranchObserver &observer_;
  BranchSummary summary_;
  PeakSearch search_;
  PeakEquations &peak_;
  std::shared_ptr<TrackLeg> leg_; // that is followed
  AmplitudeMeter meter_;
  double arclength_ = 0, sense_; // of the parameter
  double leap_;                  // of the range, beyond the next corner
  bool ended_ = false;
};

} // namespace dovetail
