#pragma once
// The peak near a motion at one value of the parameter: a smooth maximum, or a corner of the response.
#include "analyses/peak_follower.hpp"

namespace dovetail {

/// Points of a track that one condition picks: maxima, or a corner of the response where a slider begins to slip.
struct TrackLeg {
  std::unique_ptr<TrackCondition> condition;
  std::unique_ptr<PeakTrack> track;
  std::unique_ptr<Curve> curve;
  int point = 0, direction = 0; ///< the slider: a contact point, from 1, or 0: no corner; t1 or t2
  bool lies_in_corner() const { return point > 0; }
  std::string slider() const { return "x" + std::to_string(point) + (direction == 0 ? ".t1" : ".t2"); }
  ResponseMetric &metric() const { return static_cast<TrackMetric &>(curve->norm).response(); }
};

class PeakSearch {
public:
  /// Collective, like all that follows.
  PeakSearch(HarmonicSystem &system, std::shared_ptr<VariedPreload> preload, const NewtonSettings &newton,
             const TrackSettings &settings, SolveCounts &counts);

  PeakEquations &equations() { return peak_; }
  /// That of the case's condition, which is no corner.
  const std::shared_ptr<TrackLeg> &smooth() const { return smooth_; }
  /// That of a corner: of a contact point, from 1, whose owner knows the graze, and all ranks its direction.
  std::shared_ptr<TrackLeg> corner(int point, const Graze &graze);

  struct Found {
    std::shared_ptr<TrackLeg> leg;
    CurvePoint at;
  };
  /// The peak near [Y; Omega] at that value, or nothing.
  std::optional<Found> near(double value, Vec start);

  /// c to either side of a point in a corner: a peak while left < 0 < right. Nothing where a solve fails.
  struct Sides {
    double left, right;
    bool is_peak() const { return left < 0 && right > 0; }
  };
  std::optional<Sides> sides(PeakTrack &track, Vec y);
  /// From a point in a corner that is no peak, to the one beside it.
  std::optional<Found> beside(PeakTrack &track, const CurvePoint &s, const Sides &sides);

private:
  std::shared_ptr<TrackLeg> leg(std::unique_ptr<TrackCondition> condition);
  std::optional<Found> climb(double value);
  std::optional<Found> point_on(const std::shared_ptr<TrackLeg> &leg, double value);
  bool go_aside(PeakTrack &track, Vec y, double part);
  struct Candidate {
    double offset = HUGE_VAL; // in frequency, from the motion at hand
    int own_point = -1;
    Graze graze;
  };
  std::vector<Candidate> candidates();
  std::shared_ptr<TrackLeg> corner_leg(const Candidate &own, int winner);

  const TrackSettings &settings_;
  const NewtonSettings &newton_;
  SolveCounts &counts_;
  std::shared_ptr<VariedPreload> preload_;
  PeakEquations peak_;
  std::shared_ptr<TrackLeg> smooth_;
};

} // namespace dovetail
