#pragma once
// The continuation at work. branch.cpp: from beginning to end; steps.cpp: along the curve; places.cpp: what lies within
// a step; locate.cpp: where; corners.cpp: round corners; ladder.cpp: what is tried when no step converges; leaps.cpp:
// to frequencies ahead; in_time.cpp: along motions in time; astray.cpp: when steps lead nowhere; adapt.cpp: harmonics
// to a tolerance; first_point.cpp: where to begin; saved.cpp: where it stands, for a restart.
#include <array>
#include <memory>
#include <optional>

#include "continuation/amplitude.hpp"
#include "continuation/between.hpp"
#include "continuation/branch.hpp"
#include "continuation/curve.hpp"
#include "continuation/step_rules.hpp"
#include "continuation/trail.hpp"
#include "stability/large_stability.hpp"
#include "transient/orbit_curve.hpp"
#include "transient/steady_state.hpp"

namespace dovetail {

class Follower {
public:
  Follower(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings,
           const BranchObserver &observer);

  /// From the solution near y at settings.from; `why_there`: words for the first point, if they are wanted.
  BranchSummary run(Vec y, const std::string &why_there);
  BranchSummary go_on(const BranchState &state);

private:
  enum class Go { on, refused, ended, refined }; // refined: to be tried again, with more harmonics
  using End = BranchSummary::End;

  // branch.cpp
  BranchSummary follow(bool between);
  void begin(Station first);
  double beyond_start(double omega) const;
  Go after_step();
  void report(Station &s, double arclength, const Stability *stability, bool place = false);
  void notify(BranchEvent::Kind kind, const std::string &text, double omega, double amplitude = 0);
  Go end(End how, const std::string &why = "");
  bool farther(double omega) const;
  void note(std::optional<Station> &place, const Station &s) const;
  void recall_activity();
  double plain_length(Vec t) const;
  void begin_amplitude();

  // steps.cpp
  Go advance();
  bool exact() const;
  double allowed_astray() const; // Halvings::Measure
  Go try_step(double step);
  Go accept_step(Vec normal, double step, bool at_corner = false);
  Go pass_to_trial(Vec normal, double step, double plain, bool at_corner);
  void choose_step(double step, double turned, int newton);
  void limit_step();

  // astray.cpp
  void drop_anchors();
  bool follow_again(const std::string &why);
  void note_bend(double omega);
  void note_creeping();
  bool winds();
  void pass_crowd();
  bool leave_from_farthest(std::string why, bool briefly = false);

  // places.cpp
  struct Place {  // something worth a point of its own within a step
    double along; // way from the last point: on planes across the step, in corners such a part of it
    enum class Kind { wanted, fold, peak, branch, stability, limit, last } kind;
    Station at;
    double amplitude = 0;
  };
  using Measured = std::function<double(Station &)>;
  struct Bound { // of what is searched for a place
    double along;
    Vec y;
    double value;
  };
  std::vector<std::optional<Place>> find_folds(Vec normal, double step, bool at_corner);
  bool find_places(Vec normal, double step, bool at_corner, const Amplitude &next, std::vector<Place> &found);
  struct PieceEnd { // of a step, between turning points
    const Station &at;
    double along;
  };
  bool find_wanted(Vec normal, const PieceEnd &from, const PieceEnd &to, bool at_corner, std::vector<Place> &found);
  bool solve_wanted(Vec normal, const Station &a, const Station &b, double w, Place &place);
  void begin_stability();
  void tell_stability(double omega, double amplitude);
  void find_stability_change(Vec normal, double step, bool at_corner, std::vector<Place> &found);
  Go report_places(std::vector<Place> &found, double plain, bool at_corner);
  std::optional<Stability> judge(const Station &s);

  // locate.cpp
  bool solve_within(Vec normal, double along, Station &s, const StepEffort &effort = {});
  std::optional<Place> locate(Place::Kind kind, Vec normal, Bound from, Bound to, const Measured &f);
  Place place_at(const Station &s, Place::Kind kind, double along);
  Place corner_place(Place::Kind kind, double step, bool beyond, std::array<double, 2> values, const Measured &f);
  std::optional<Place> locate_in_corner(Place::Kind kind, double step, std::array<double, 2> values, const Measured &f);
  bool leads_back(double step, double missed);
  Place locate_branch_point(double step);

  // corners.cpp
  enum class Extent { first, all }; // legs that are tried
  bool round_corner(double step, Extent extent, Go &outcome);
  bool go_round(Vec t, double step, bool by_sign, Go &outcome);
  struct Meeting {            // of the lines along two tangents
    double ahead, back, miss; // lengths from here_ and back from the other one to where they are closest, how close
  };
  Meeting meeting(const Station &other) const;
  bool back_to_corner(Station &corner);

  // saved.cpp
  BranchState state();
  void restore(const BranchState &state);
  void archive(Archive &archive);
  void archive_vector(Archive &archive, const char *name, Vec y) const;
  void archive_points(Archive &archive);

  // ladder.cpp
  Go climb();
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
  void show(OrbitCurve::PlacePtr motion, Station &s);
  bool show_if(OrbitCurve::PlacePtr motion, Station &s);
  Go advance_in_time();
  bool back_to_harmonics();

  // adapt.cpp
  int least_harmonics() const;
  const ErrorEstimate &error_of(Station &s);
  const ErrorEstimate &affordable_error_of(Station &s);
  void count_estimates(double besides = 0);
  bool refined_for(Station &s);
  void spare_harmonics();
  bool change_harmonics(int harmonics, double error);

  // first_point.cpp
  bool interrupted();
  bool grow_load(double omega, std::vector<double> &q);
  /// brief: the quick ways only; patient: those, but for time integration, which may be long
  enum class Effort { full, brief, patient };
  bool first_point(double omega, Vec y, Station &first, std::string &how, Effort effort);

  HarmonicSystem *system_;
  const NewtonSettings &newton_;
  BranchSettings settings_;
  const BranchObserver &observer_;
  BranchSummary summary_;
  double omega_unit_;
  std::unique_ptr<HarmonicSystem> changed_; // with other harmonics or samples, in place of the one given
  std::unique_ptr<Curve> curve_;
  std::unique_ptr<AmplitudeMeter> meter_;
  std::unique_ptr<StabilityTest> stability_;            // of a small model, or
  std::unique_ptr<LargeStabilityTest> large_stability_; // of any
  std::unique_ptr<Estimator> estimator_;
  std::unique_ptr<OrbitCurve> orbit_; // while the curve is followed in time; here_ shows it then
  double balanced_at_ = 0;            // frequency where it was begun, or harmonic balance was tried again
  Station here_, trial_;              // last accepted point; the one being tried
  std::optional<Station> before_;     // where the smooth step to here_ began
  std::optional<Station> farthest_;   // where the curve turned back, or in time was, nearest to the end of the sweep
  std::optional<Station> anchors_[2]; // points of the curve to go back to, `anchored` to twice that behind; the next
  double anchor_arc_ = 0;             // way in the arc norm since the older one,
  double newer_arc_ = 0;              // and since the newer one
  int since_anchor_ = 0;              // points
  int repeated_at_ = 0;               // points until the last time; 0: never
  int careful_ = 0;                   // points that still are to be taken with steps no longer than
  double careful_step_ = 0;           // that
  std::vector<double> bends_;         // frequencies of turning points and corners, as they came
  UniqueVec predicted_;
  Amplitude amplitude_; // at here_
  BetweenPoints between_;
  double between_error_ = NAN; // of the piece up to the point that is reported
  Trail trail_;
  std::optional<Stability> verdict_; // at here_
  Halvings halvings_;
  int unchanged_ = 0; // points since harmonics were adapted
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
  std::string refusal_;
  std::optional<Place> branch_point_; // within the step being tried
  bool ended_ = false;
  std::string crowded_; // why steps lead nowhere although they converge
  struct Crowd {
    double omega;
    long newton;
  } crowd_{}, ahead_{};  // where the last stretch of the sweep was left behind, or was met first; iterations until then
  int windings_ = 0;     // times that a curve was left because it leads nowhere, since it went on
  double left_at_ = 0;   // frequency, the last time
  int stays_ = 0;        // times that no way on was found, since the curve was left;
  double stayed_at_ = 0; // farthest frequency, the last time
  double step_ = 0, arclength_ = 0;
  double curvature_ = 0;    // at the last smooth step: angle per arc length
  int corners_in_vain_ = 0; // times in succession that all legs were tried, up to most_waiting
  int still_ = 0;           // steps in succession along which only mean positions changed
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
