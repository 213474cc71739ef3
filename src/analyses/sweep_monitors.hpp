#pragma once
// What is watched along a curve besides its points: whether it goes on, and its amplitude between them.
#include <cmath>

#include "continuation/between.hpp"
#include "continuation/progress_monitors.hpp"
#include "continuation/retrace_monitor.hpp"

namespace dovetail {

struct SweepMonitors {
  explicit SweepMonitors(double unit) : retraced(unit), cluster(unit), ahead(unit) {}

  RetraceMonitor retraced;
  FoldClusterMonitor cluster;
  NoProgressMonitor ahead;
  DriftMonitor drift;

  void archive(Archive &archive) {
    archive.part("retraced", [&] { retraced.archive(archive); });
    archive.part("cluster", [&] { cluster.archive(archive); });
    archive.part("progress", [&] { ahead.archive(archive); });
  }
};

struct AmplitudeCourse {
  Amplitude here;        ///< slope by the weighted arc length
  BetweenPoints between; ///< with slopes by the plain one
  double error = NAN;    ///< of the piece up to the point that is given

  /// No step along the curve has led to here. `plain`: length of the tangent in the plain norm.
  void begin(const Amplitude &now, double plain) {
    here = now, error = NAN;
    between.begin({now.value, now.slope / plain});
  }
  /// After a step of that plain length.
  AmplitudeCourse after(const Amplitude &next, double plain, double way, bool at_kink) const {
    AmplitudeCourse out = *this;
    if (at_kink)
      out.begin(next, plain);
    else
      out.here = next, out.error = out.between.add(way, {next.value, next.slope / plain});
    return out;
  }
  void archive(Archive &archive) {
    archive.field("amplitude", here.value);
    archive.field("amplitude_slope", here.slope);
    archive.part("between", [&] { between.archive(archive); });
  }
};

} // namespace dovetail
