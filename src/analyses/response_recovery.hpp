#pragma once
// What recovery may ask of the response curve, and the ways it is asked for: see recovery/recovery.hpp.
#include <optional>
#include <string>

#include "analyses/point_search.hpp"
#include "analyses/response_stepper.hpp"
#include "recovery/recovery.hpp"

namespace dovetail {

class ResponseRecovery : private RecoveryContext {
public:
  ResponseRecovery(const BranchSettings &settings, ResponseStepper &stepper, BranchReport &report)
      : settings_(settings), stepper_(stepper), report_(report),
        search_(stepper.response, settings.work, report.counts) {}

  /// The curve goes on beyond a failure. False where nothing helps, or the user wants to stop, and then it stands where
  /// it stood.
  bool recovers(Failure::Kind kind, const std::string &why, double from);
  /// A point at that value: from here().y as it is, from rest, or by what recovery has for it.
  bool first_point(double value);
  /// Where that came from, in words; empty: plainly.
  const std::string &how() const { return how_; }

  /// Work that time integration took.
  double integrated() const { return search_.integrated(); }
  void set_integrated(double work) { search_.set_integrated(work); }
  void archive(Archive &archive) { search_.archive(archive); }

private:
  Sweep sweep() const override { return {stepper_.range.from, stepper_.range.to, stepper_.range.at}; }
  bool interrupted() override { return report_.interrupted(); }
  int jumps() const override { return report_.counts.leaps + report_.counts.integrations; }
  bool solve_at(double value) override { return stand_on(search_.by_newton(value, stepper_.here().y)); }
  bool integrate_at(double value, double share) override;
  bool solve_by_simpler(double value) override {
    return stand_on(search_.by_fewer_harmonics(value, stepper_.here().y, false));
  }
  bool begin_at(double from, double to) override;
  void go_on(const Failure &failure, bool integrated) override;
  bool stand_on(std::optional<PointSearch::Found> found);

  const BranchSettings &settings_;
  ResponseStepper &stepper_;
  BranchReport &report_;
  PointSearch search_;
  bool starting_ = false; // a first point is sought
  std::string how_;
  double before_jump_ = 0; // value of the parameter where recovery began
};

} // namespace dovetail
