#include "analyses/peak_search.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "looking for a peak";
constexpr double aside = 1e-6;    // of the frequency: so far to either side of a corner c is looked at
constexpr double farthest = 0.02; // of the frequency, from the motion at hand to a corner
constexpr int most_corners = 6;   // that are tried

} // namespace

PeakSearch::PeakSearch(HarmonicSystem &system, std::shared_ptr<VariedPreload> preload, const NewtonSettings &newton,
                       const TrackSettings &settings, SolveCounts &counts)
    : settings_(settings), newton_(newton), counts_(counts), preload_(std::move(preload)),
      peak_(system, settings.search.watched) {
  if (settings.kind == TrackedPeak::phase)
    smooth_ = leg(std::make_unique<PhaseResonance>(peak_));
  else
    smooth_ = leg(std::make_unique<Extremum>(peak_));
}

std::shared_ptr<TrackLeg> PeakSearch::leg(std::unique_ptr<TrackCondition> condition) {
  auto leg = std::make_shared<TrackLeg>();
  leg->condition = std::move(condition);
  leg->track = std::make_unique<PeakTrack>(peak_, *settings_.parameter, preload_, *leg->condition,
                                           std::abs(settings_.search.to - settings_.search.from));
  leg->curve = std::make_unique<Curve>(*leg->track, newton_, std::abs(settings_.to - settings_.from), true, counts_);
  return leg;
}

// Near the motion that the equations have.
std::optional<PeakSearch::Found> PeakSearch::point_on(const std::shared_ptr<TrackLeg> &leg, double value) {
  Found found{leg, leg->curve->point()};
  leg->track->give(value, found.at.y);
  if (!leg->curve->solve_at(value, found.at)) return std::nullopt;
  return found;
}

std::optional<PeakSearch::Found> PeakSearch::climb(double value) {
  if (settings_.kind == TrackedPeak::amplitude && !peak_.climb()) return std::nullopt;
  return point_on(smooth_, value);
}

// Where sliders begin to slip, nearest first; of the own points, so that every rank has others.
std::vector<PeakSearch::Candidate> PeakSearch::candidates() {
  const Layout &layout = peak_.system().layout();
  const auto all = peak_.system().grazes(peak_.y());
  const double reach = farthest * peak_.omega(); // collective, and ranks have different numbers of grazes
  std::vector<Candidate> found;
  const double *along;
  check(VecGetArrayRead(peak_.along(), &along), doing);
  for (std::size_t p = 0; p < all.size(); ++p)
    for (const Graze &graze : all[p]) {
      const double *of_point = along + layout.own_point_offset(static_cast<PetscInt>(p));
      double rate = 0;
      for (int i = 0; i < layout.width; ++i)
        rate += graze.by_t[i] * of_point[graze.direction * layout.width + i] +
                graze.by_n[i] * of_point[2 * layout.width + i];
      const double offset = rate == 0 ? HUGE_VAL : -graze.height / rate;
      if (std::abs(offset) < reach) found.push_back({offset, static_cast<int>(p), graze});
    }
  check(VecRestoreArrayRead(peak_.along(), &along), doing);
  std::sort(found.begin(), found.end(),
            [](const Candidate &a, const Candidate &b) { return std::abs(a.offset) < std::abs(b.offset); });
  return found;
}

std::shared_ptr<TrackLeg> PeakSearch::corner_leg(const Candidate &own, int winner) {
  const Layout &layout = peak_.system().layout();
  const bool mine = layout.rank == winner;
  int place[2] = {mine ? static_cast<int>(layout.own_points.begin) + own.own_point + 1 : 0, own.graze.direction};
  MPI_Bcast(place, 2, MPI_INT, winner, layout.comm);
  Graze graze = mine ? own.graze : Graze{};
  graze.direction = place[1];
  return corner(place[0], graze);
}

std::shared_ptr<TrackLeg> PeakSearch::corner(int point, const Graze &graze) {
  const Range &own = peak_.system().layout().own_points;
  const bool mine = own.begin < point && point <= own.end;
  auto corner = leg(std::make_unique<Grazing>(peak_, mine ? point - 1 - static_cast<int>(own.begin) : -1, graze));
  corner->point = point, corner->direction = graze.direction;
  return corner;
}

std::optional<PeakSearch::Found> PeakSearch::near(double value, Vec start) {
  const Layout &layout = peak_.system().layout();
  peak_.take(start);
  peak_.set(*settings_.parameter, value, preload_);
  if (!peak_.solve()) return std::nullopt;
  UniqueVec base = peak_.system().unknowns();
  check(VecCopy(peak_.y(), base), doing);
  if (auto found = climb(value)) return found;
  if (settings_.kind != TrackedPeak::amplitude) return std::nullopt;
  peak_.take(base);
  if (!peak_.differentiate()) return std::nullopt;
  const std::vector<Candidate> own = candidates();
  std::size_t next = 0;
  for (int i = 0; i < most_corners; ++i) {
    struct {
      double offset;
      int rank;
    } best{next < own.size() ? std::abs(own[next].offset) : HUGE_VAL, layout.rank};
    MPI_Allreduce(MPI_IN_PLACE, &best, 1, MPI_DOUBLE_INT, MPI_MINLOC, layout.comm);
    if (!std::isfinite(best.offset)) break;
    const Candidate mine = best.rank == layout.rank ? own[next++] : Candidate{};
    double offset = mine.offset;
    MPI_Bcast(&offset, 1, MPI_DOUBLE, best.rank, layout.comm);
    const std::shared_ptr<TrackLeg> corner = corner_leg(mine, best.rank);
    peak_.take(base);
    if (!peak_.differentiate()) return std::nullopt;
    peak_.move(offset);
    auto found = point_on(corner, value);
    if (!found) continue;
    const auto looked = sides(*corner->track, found->at.y);
    if (looked && looked->is_peak()) return found;
    if (looked)
      if (auto other = beside(*corner->track, found->at, *looked)) return other;
  }
  return std::nullopt;
}

// The motion a little to one side, with what differentiate() knows of it.
bool PeakSearch::go_aside(PeakTrack &track, Vec y, double part) {
  track.take(y);
  if (!peak_.differentiate()) return false;
  peak_.move(part * peak_.omega());
  return peak_.solve() && peak_.differentiate();
}

std::optional<PeakSearch::Sides> PeakSearch::sides(PeakTrack &track, Vec y) {
  Sides found{};
  if (!go_aside(track, y, -aside)) return std::nullopt;
  found.left = peak_.c();
  if (!go_aside(track, y, aside)) return std::nullopt;
  found.right = peak_.c();
  return found;
}

std::optional<PeakSearch::Found> PeakSearch::beside(PeakTrack &track, const CurvePoint &s, const Sides &sides) {
  for (const double part : {sides.left > 0 ? -aside : 0.0, sides.right < 0 ? aside : 0.0})
    if (part != 0 && go_aside(track, s.y, part))
      if (auto found = climb(s.parameter)) return found;
  return std::nullopt;
}

} // namespace dovetail
