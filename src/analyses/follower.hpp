#pragma once
// The response curve at work, on the steps of continuation/stepper.hpp. branch.cpp: from beginning to end; passing.cpp:
// what is done with a step; places.cpp: what lies within it; ladder.cpp: what is tried when no step converges;
// leaps.cpp: to frequencies ahead; in_time.cpp: along motions in time; astray.cpp: when steps lead nowhere; adapt.cpp:
// harmonics to a tolerance; first_point.cpp: where to begin; saved.cpp: where it stands, for a restart.
#include <array>
#include <memory>
#include <optional>

#include "analyses/branch.hpp"
#include "analyses/recovery_limits.hpp"
#include "continuation/between.hpp"
#include "continuation/progress_monitors.hpp"
#include "continuation/retrace_monitor.hpp"
#include "continuation/stepper.hpp"
#include "problems/amplitude.hpp"
#include "problems/response_curve.hpp"
#include "stability/large_stability.hpp"
#include "transient/orbit_curve.hpp"
#include "transient/steady_state.hpp"

namespace dovetail {

class Follower : private Stepper {
public:
  Follower(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings,
           const BranchObserver &observer);

  /// From the solution near y at settings.from; `why_there`: words for the first point, if they are wanted.
  BranchSummary run(Vec y, const std::string &why_there);
  BranchSummary go_on(const BranchState &state);

private:
  using End = BranchSummary::End;

  // branch.cpp
  BranchSummary follow(bool between);
  void begin(CurvePoint first);
  double beyond_start(double omega) const;
  Outcome after_step();
  void report(CurvePoint &s, double arclength, const Stability *stability, bool place = false);
  void notify(BranchEvent::Kind kind, const std::string &text, double omega, double amplitude = 0);
  Outcome end(End how, const std::string &why = "");
  bool farther(double omega) const;
  void recall_activity();
  double plain_length(Vec t) const;
  void begin_amplitude();
  ResponseMetric &metric() { return response_->metric(); }

  // passing.cpp: Stepper's
  bool refine(CurvePoint &trial) override { return refined_for(trial); }
  Outcome pass(Vec normal, double step, double plain, bool at_kink) override;
  Outcome settle(Vec way) override;
  void stepped() override { spare_harmonics(); }
  void halved(const std::string &why) override;
  void turned_kink(double angle, double omega) override;
  Outcome no_step() override;
  bool iterations_are_expensive() const override { return dear(); }
  bool may(Strategy which) const { return settings_.strategies.has(which); }

  // astray.cpp
  void drop_anchors();
  bool follow_again(const std::string &why);
  void note_bend(double omega);
  bool winds();
  void pass_crowd();
  bool leave_from_farthest(std::string why, bool briefly = false);

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

  // ladder.cpp
  Outcome climb();
  void take_system(HarmonicSystem &system);
  void adopt(std::unique_ptr<HarmonicSystem> system);
  bool rebuild(std::unique_ptr<HarmonicSystem> system, int most = 0);
  bool better_sampling();
  /// once: twice as many harmonics; usual: again and again; last: more, closer to each other, and more of Newton's
  /// iterations, and then ample ones; ample: these only
  enum class Resort { once, usual, last, ample };
  int needed_harmonics(double omega, Resort resort = Resort::usual) const;
  int ample_harmonics(double omega, double parts = ample_parts) const;
  bool more_harmonics();
  bool solve_finer(const std::vector<double> &q, double omega, Resort resort);
  std::string difference() const;

  // leaps.cpp
  /// To frequencies ahead: Newton or integration from the last point; as for a first point of a branch, with all that
  /// there is at some, or by Newton and long integration at more of them; or at as many by brief integration.
  enum class Way { newton, integration, anew, sown, scattered };
  static bool integrates(Way way);
  static Strategy strategy_of(Way way);
  bool dear() const;
  bool from_other_end(const std::string &why, double lost, bool briefly);
  void stand_anew();
  double integration_left() const;
  bool arrive_at(double omega, Way way, const DenseModel &model, double share);
  std::vector<double> aims(Way way, double from, double most) const;
  bool leap(Way way, double from, double most = 0.2);

  // in_time.cpp
  bool begin_in_time(const DenseModel &model, const SteadyState &steady, double omega);
  bool first_in_time(double omega);
  void show(OrbitCurve::PlacePtr motion, CurvePoint &s);
  bool show_if(OrbitCurve::PlacePtr motion, CurvePoint &s);
  Outcome advance_in_time();
  bool back_to_harmonics();

  // adapt.cpp
  int least_harmonics() const;
  const ErrorEstimate &error_of(CurvePoint &s);
  const ErrorEstimate &affordable_error_of(CurvePoint &s);
  void count_estimates(double besides = 0);
  bool refined_for(CurvePoint &s);
  void spare_harmonics();
  bool change_harmonics(int harmonics, double error);

  // first_point.cpp
  bool interrupted();
  bool grow_load(double omega, std::vector<double> &q);
  /// brief: the quick ways only; patient: those, but for time integration, which may be long
  enum class Effort { full, brief, patient };
  bool first_point(double omega, Vec y, CurvePoint &first, std::string &how, Effort effort);

  HarmonicSystem *system_;
  const NewtonSettings &newton_;
  BranchSettings settings_;
  const BranchObserver &observer_;
  BranchSummary summary_;
  std::unique_ptr<HarmonicSystem> changed_; // with other harmonics or samples, in place of the one given
  std::unique_ptr<ResponseCurve> response_; // the curve at hand, of system_
  std::unique_ptr<AmplitudeMeter> meter_;
  std::unique_ptr<StabilityTest> stability_;            // of a small model, or
  std::unique_ptr<LargeStabilityTest> large_stability_; // of any
  std::unique_ptr<Estimator> estimator_;
  std::unique_ptr<OrbitCurve> orbit_;    // while the curve is followed in time; here_ shows it then
  double balanced_at_ = 0;               // frequency where it was begun, or harmonic balance was tried again
  std::optional<CurvePoint> farthest_;   // where the curve turned back, or in time was, nearest to the end of the sweep
  std::optional<CurvePoint> anchors_[2]; // points of the curve to go back to, `anchored` to twice that behind; the next
  double anchor_arc_ = 0;                // way in the arc norm since the older one,
  double newer_arc_ = 0;                 // and since the newer one
  int since_anchor_ = 0;                 // points
  int repeated_at_ = 0;                  // points until the last time; 0: never
  Amplitude amplitude_;                  // at here_
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
  int in_vain_ = 0;        // harmonics for which more were tried and led nowhere,
  int end_in_vain_ = 0;    // and with which the other end was looked at briefly, likewise
  double lent_at_ = 0;     // frequency where more were taken last
  int lent_from_;          // fewest that are gone back to after more were taken: the case's, or more than had failed
  int folds_before_ = 0;   // turning points until the step at hand
  bool ended_ = false;
  double arclength_ = 0;
  int direction_ = 1;
  const int asked_for_;       // harmonics, by the case,
  const int asked_samples_;   // and samples
  const double begun_at_;     // frequency
  bool turned_round_ = false; // what is left is followed from the other end
  int last_verdict_ = -1;     // the last that was certain: 1 stable, 0 unstable; -1: none yet
  struct Fold {
    double omega, amplitude;
  };
  std::optional<Fold> fold_since_; // the last turning point since that verdict: where stability may have changed
};

} // namespace dovetail
