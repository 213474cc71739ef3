#pragma once
// Along the response curve from beginning to end: one step after the other, and recovery where they lead nowhere.
#include <string>

#include "analyses/response_recovery.hpp"

namespace dovetail {

class Follower {
public:
  Follower(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings,
           const BranchObserver &observer);

  /// From the solution near y at settings.from.
  BranchSummary run(Vec y);
  BranchSummary go_on(const BranchState &state);

private:
  using End = BranchSummary::End;

  BranchSummary follow(bool between);
  void step();
  void after_step();
  void look_back();
  bool winds();
  void leave_windings();
  void leave_lost();
  bool leave(const std::string &why);
  BranchState state();

  const BranchSettings &settings_;
  const BranchObserver &observer_;
  BranchReport report_;
  ResponseStepper stepper_;
  ResponseRecovery recovery_;
};

} // namespace dovetail
