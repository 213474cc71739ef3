#pragma once
// The response curve at work, on the steps of continuation/stepper.hpp. branch.cpp: from beginning to end; passing.cpp:
// what is done with a step; places.cpp: what lies within it; recovery.cpp: what recovery tries; adapt.cpp: harmonics to
// a tolerance; saved.cpp: where it stands, for a restart.
#include <array>
#include <memory>
#include <optional>

#include "analyses/branch.hpp"
#include "continuation/between.hpp"
#include "continuation/progress_monitors.hpp"
#include "continuation/retrace_monitor.hpp"
#include "continuation/stepper.hpp"
#include "problems/amplitude.hpp"
#include "problems/response_curve.hpp"
#include "recovery/recovery.hpp"
#include "stability/large_stability.hpp"
#include "transient/steady_state.hpp"

namespace dovetail {

class Follower : private Stepper, private RecoveryContext {
public:
  Follower(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings,
           const BranchObserver &observer);

  /// From the solution near y at settings.from.
  BranchSummary run(Vec y);
  BranchSummary go_on(const BranchState &state);

private:
  using End = BranchSummary::End;

  // branch.cpp
  BranchSummary follow(bool between);
  void begin();
  double beyond_start(double omega) const;
  Outcome after_step();
  bool winds();
  void leave_windings();
  void report(CurvePoint &s, double arclength, const Stability *stability, bool place = false);
  void notify(BranchEvent::Kind kind, const std::string &text, double omega, double amplitude = 0);
  Outcome end(End how, const std::string &why = "");
  bool farther(double omega) const;
  std::string parameter_name() const { return system_->parameter().kind().name; }
  bool is_sweep() const { return &system_->parameter().kind() == &frequency_parameter(); } // over the frequency
  std::string at_key() const { return is_sweep() ? "continuation.at" : "path.at"; }
  bool stands_farthest() const { return farther(here_.parameter); }
  void recall_activity();
  double plain_length(Vec t) const;
  void begin_amplitude();
  ResponseMetric &metric() { return response_->metric(); }
  /// Iterations are: harmonics were raised to many more than the case has.
  bool dear() const { return settings_.tolerance == 0 && system_->harmonics() > 2 * asked_for_; }

  // passing.cpp: Stepper's
  bool refine(CurvePoint &trial) override { return refined_for(trial); }
  Outcome pass(Vec normal, double step, double plain, bool at_kink) override;
  Outcome settle(Vec way) override;
  void stepped() override { spare_harmonics(); }
  void halved(const std::string &why) override;
  void turned_kink(double angle, double omega) override;
  Outcome no_step() override;
  bool iterations_are_expensive() const override { return dear(); }

  // places.cpp
  struct Place : Located { // something worth a point of its own within a step
    enum class Kind { wanted, fold, peak, branch, stability, limit, last } kind;
    double amplitude = 0;
  };
  std::vector<std::optional<Place>> find_folds(Vec normal, double step, bool at_corner);
  bool find_places(Vec normal, double step, bool at_corner, const Amplitude &next, std::vector<Place> &found);
  struct PieceEnd { // of a step, between turning points
    const CurvePoint &at;
    double along;
  };
  bool find_wanted(Vec normal, const PieceEnd &from, const PieceEnd &to, bool at_corner, std::vector<Place> &found);
  bool solve_wanted(Vec normal, const CurvePoint &a, const CurvePoint &b, double w, Place &place);
  void begin_stability();
  void tell_stability(double omega, double amplitude);
  void find_stability_change(Vec normal, double step, bool at_corner, std::vector<Place> &found);
  Outcome report_places(std::vector<Place> &found, double plain, bool at_corner);
  std::optional<Stability> judge(const CurvePoint &s);

  std::optional<Place> locate(Place::Kind kind, Vec normal, Bound from, Bound to, const Measured &f);
  Place place_at(const CurvePoint &s, Place::Kind kind, double along);
  Place corner_place(Place::Kind kind, double step, bool beyond, std::array<double, 2> values, const Measured &f);

  // saved.cpp
  BranchState state();
  void restore(const BranchState &state);
  void archive(Archive &archive);
  void archive_vector(Archive &archive, const char *name, Vec y) const;
  void archive_points(Archive &archive);

  // recovery.cpp: RecoveryContext's, and what they are made of
  bool recovers(Failure::Kind kind, const std::string &why, double from);
  bool leave(const std::string &why);
  bool first_point(double omega);
  Sweep sweep() const override { return {settings_.from, settings_.to, settings_.at}; }
  bool interrupted() override;
  int jumps() const override { return summary_.counts.leaps + summary_.counts.integrations; }
  bool solve_at(double omega) override;
  bool integrate_at(double omega, double share) override;
  bool solve_by_simpler(double omega) override;
  bool begin_at(double from, double to) override;
  void go_on(const Failure &failure, bool integrated) override;
  void land();
  void take_system(HarmonicSystem &system);
  void adopt(std::unique_ptr<HarmonicSystem> system);
  bool rebuild(std::unique_ptr<HarmonicSystem> system, int most = 0);
  int needed_harmonics(double value);
  bool solve_finer(const SteadyState &steady, double omega);
  double integration_left() const;
  std::string difference() const;

  // adapt.cpp
  int least_harmonics() const;
  const ErrorEstimate &error_of(CurvePoint &s);
  const ErrorEstimate &affordable_error_of(CurvePoint &s);
  void count_estimates(double besides = 0);
  bool refined_for(CurvePoint &s);
  void spare_harmonics();
  bool change_harmonics(int harmonics, double error);

  HarmonicSystem *system_;
  const NewtonSettings &newton_;
  BranchSettings settings_;
  const BranchObserver &observer_;
  BranchSummary summary_;
  std::unique_ptr<HarmonicSystem> changed_; // with other harmonics, in place of the one given
  std::unique_ptr<ResponseCurve> response_; // the curve at hand, of system_
  std::unique_ptr<AmplitudeMeter> meter_;
  std::unique_ptr<StabilityTest> stability_;            // of a small model, or
  std::unique_ptr<LargeStabilityTest> large_stability_; // of any
  std::unique_ptr<Estimator> estimator_;
  std::optional<CurvePoint> farthest_; // where the curve turned back, nearest to the end of the sweep
  Amplitude amplitude_;                // at here_
  BetweenPoints between_;
  double between_error_ = NAN; // of the piece up to the point that is reported
  RetraceMonitor retraced_;
  FoldClusterMonitor cluster_;
  NoProgressMonitor progress_;
  DriftMonitor drift_;
  std::optional<Stability> verdict_; // at here_
  int unchanged_ = 0;                // points since harmonics were adapted
  struct Adapted {
    int harmonics = 0;
    double error = 0;
  } raised_, coarse_;      // before harmonics were added for the step at hand; and where more did not help
  double estimating_ = 0;  // work that estimates may take
  double integrating_ = 0; // that time integration took
  bool starting_ = false;  // a first point is sought,
  std::string how_;        // and was found in that way
  double before_jump_ = 0; // frequency where recovery began
  double lent_at_ = 0;     // frequency where more harmonics were taken last
  const int asked_for_;    // harmonics, by the case
  int folds_before_ = 0;   // turning points until the step at hand
  bool ended_ = false;
  double arclength_ = 0;
  int direction_ = 1;
  int last_verdict_ = -1; // the last that was certain: 1 stable, 0 unstable; -1: none yet
  struct Fold {
    double omega, amplitude;
  };
  std::optional<Fold> fold_since_; // the last turning point since that verdict: where stability may have changed
};

} // namespace dovetail
