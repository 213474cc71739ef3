#pragma once
// Pseudo-arc-length continuation of the periodic response over its parameter (docs/theory/equations.md, section 8).
#include <functional>
#include <string>
#include <vector>

#include "analyses/branch_state.hpp"
#include "continuation/curve.hpp"
#include "problems/amplitude.hpp"
#include "problems/estimator.hpp"
#include "recovery/strategies.hpp"
#include "stability/stability.hpp"

namespace dovetail {

/// All values of the parameter, lengths and amplitudes in scaled numbers.
struct BranchSettings {
  double from = 0, to = 0; ///< of the parameter of the equations; equal: one point
  double step = 0;         ///< first arc length
  bool adaptive = true;    ///< false: `step` throughout, as the original
  int max_points = 1;
  std::vector<double> at;                    ///< solved exactly whenever the branch passes them, between from and to
  Watched watched = {};                      ///< whose amplitude is followed
  int stop_after_peaks = 0;                  ///< 0: never
  double stop_at_amplitude = 0;              ///< of what is watched; 0: never
  Strategies strategies = Strategies::all(); ///< what is tried besides steps along the curve
  double work = 1;                           ///< that they may take, so many times the default
  bool stability = false;                    ///< judge every point
  bool estimates = false;                    ///< of the error of every point
  double tolerance = 0;  ///< harmonics are added and dropped so that this estimate stays below; 0: they stay
  double between = 1e-3; ///< by how much the cubic between two points may miss the curve, relative
};

struct BranchPoint {
  Vec y;                        ///< [X; parameter], scaled; valid during the call only
  const HarmonicSystem &system; ///< whose unknowns y are: harmonics may be added on the way
  double parameter;             ///< scaled
  double arclength;             ///< along the branch so far, plain norm of the scaled unknowns
  Corrector::Outcome newton;
  const std::vector<Activity> &activity; ///< of the own contact points, scaled; valid during the call only
  const Stability *stability;            ///< null unless asked for
  const ErrorEstimate *error;            ///< likewise
  double between;         ///< estimated error of the amplitude on the piece of curve up to here: see BetweenPoints
  double progress;        ///< 0..1, how far from `from` to `to`
  bool located;           ///< found within a step, which led farther
  double omega = 0;       ///< frequency, scaled, where it is neither the parameter nor fixed
  Vec tangent = nullptr;  ///< d y by arc length, times any factor; null for modes
  double omega_slope = 0; ///< d omega likewise, times the same
};

/// Something worth a line in words. `fold`, `peak`, `branch` and `stability` are places on the curve, located, and the
/// point reported just before is that place; the others tell of difficulties.
struct BranchEvent {
  enum class Kind {
    fold,        ///< turning point in Omega
    peak,        ///< maximum of the watched amplitude
    branch,      ///< another branch crosses here
    stability,   ///< stability is lost or regained
    start,       ///< how a first point was found, when not plainly
    cut,         ///< step halved
    corner,      ///< went on along the curve beyond a corner
    harmonics,   ///< harmonics added from here on
    leap,        ///< on to the solution at a next frequency, which arc length does not lead to
    integration, ///< the same, found by time integration
    missed,      ///< a frequency of `at` without solution
    outside      ///< the curve leaves the sweep at its beginning: points there are not given
  } kind;
  std::string text;
  double parameter;     ///< scaled
  double amplitude = 0; ///< of what is watched, scaled; of the places only
  double omega = 0;     ///< as in BranchPoint
};

/// Whether the branch goes on elsewhere behind it.
inline bool is_jump(BranchEvent::Kind kind) {
  using Kind = BranchEvent::Kind;
  return kind == Kind::leap || kind == Kind::integration || kind == Kind::outside;
}

struct BranchObserver {
  std::function<void(const BranchPoint &)> point;
  std::function<void(const BranchEvent &)> event;
  std::function<void(BranchState)> state = {}; ///< after each step along the curve: enough to go on from. Optional.
  std::function<bool()> interrupted = {};      ///< asked after each step, agreed on by all ranks. Optional.
};

struct BranchSummary {
  enum class End {
    arrived,
    max_points,
    peaks,     ///< stop_after_peaks
    amplitude, ///< stop_at_amplitude
    vanished,  ///< of a track of peaks: it met a minimum
    interrupted,
    stalled,
    turned_back,
    retraced, ///< ran back over itself, or closed on itself
    no_start
  } end = End::arrived;
  Counts counts;
  double parameter = 0; ///< where it ended, scaled
  double farthest = 0;  ///< nearest to the end of the sweep since the last leap
  std::string why;      ///< when it did not arrive
  bool good() const {
    return end == End::arrived || end == End::max_points || end == End::peaks || end == End::amplitude ||
           end == End::vanished;
  }
};

/// Follows the branch from the solution near y (whose parameter is set to settings.from) to settings.to, or goes on
/// from `state` of an interrupted run with the same settings. Every accepted point goes to the observer at once.
/// Collective.
BranchSummary follow_branch(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings, Vec y,
                            const BranchObserver &observer, const BranchState *state = nullptr);

} // namespace dovetail
