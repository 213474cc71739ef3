#pragma once
// What lies within a step and is worth a point of its own: values wanted exactly, turning points, maxima, other
// branches, changes of stability, limits, the end of the range.
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analyses/branch_report.hpp"
#include "analyses/response.hpp"
#include "analyses/stability_watch.hpp"
#include "analyses/sweep_range.hpp"
#include "continuation/event_locator.hpp"

namespace dovetail {

struct Place : Located {
  enum class Kind { wanted, fold, peak, branch, stability, limit, last } kind;
  double amplitude = 0;
};

/// A step of the curve that Newton's method has found an end for.
struct Span {
  const CurvePoint &here, &trial;
  Amplitude amplitude, next; ///< at both ends
  Vec normal;                ///< of the planes across it
  double step;
  bool at_kink; ///< round a kink: no plane tells where on which leg something lies
};

struct Places {
  std::vector<Place> list;    ///< in the order in which the curve passes them
  int unlocated_folds = 0;    ///< turning points that are only known to be there
  long newton_at_kinks = 0;   ///< iterations that locating took in kinks
  bool complete = true;       ///< false: the step ends the range, but no solution is found exactly there,
  std::string why_incomplete; ///< for that reason
};

/// For one step.
class PlaceFinder {
public:
  /// `limit`: amplitude where the curve is to end; 0: none.
  PlaceFinder(const Response &response, const SweepRange &range, double limit, StabilityWatch &stability,
              BranchReport &report, const EventLocator &locator, const Span &span)
      : response_(response), range_(range), limit_(limit), stability_(stability), report_(report), locator_(locator),
        span_(span) {}

  /// `crossing`: another branch, which the step's checks have found. Collective.
  Places find(std::optional<Located> crossing);

private:
  void find_folds();
  void find_peaks();
  void find_limit();
  void find_stability_change();
  void find_wanted();

  struct PieceEnd { // of the step, between turning points
    const CurvePoint &at;
    double along;
  };
  bool find_wanted(const PieceEnd &from, const PieceEnd &to, std::vector<Place> &wanted);
  bool solve_wanted(const CurvePoint &a, const CurvePoint &b, double value, Place &place);
  bool hides_folds(double rate, double next) const;
  std::vector<std::pair<double, CurvePoint>> points_between();
  std::vector<double> slopes_within();
  std::optional<std::pair<double, CurvePoint>> on_curve(int part);
  bool find_peak_in(int part, const Measured &slope);
  CurvePoint on_cubic(int part);

  std::optional<Place> locate(Place::Kind kind, std::array<double, 2> values, const Measured &f);
  Place in_kink(Place::Kind kind, bool beyond, std::array<double, 2> values, const Measured &f);
  bool keep(std::optional<Place> place);
  void tell_later(int &count, BranchEvent::Kind kind, const std::string &text, double parameter, double amplitude = 0);

  const Response &response_;
  const SweepRange &range_;
  const double limit_;
  StabilityWatch &stability_;
  BranchReport &report_;
  const EventLocator &locator_;
  const Span span_;
  Places found_;
  std::vector<std::function<void()>> untold_; // if the step is taken
};

} // namespace dovetail
