#pragma once
// Curves that lead nowhere although every step converges: numbers only, told after each step.
#include <vector>

#include "support/archive.hpp"

namespace dovetail {

/// Turning points and kinks that crowd within a small part of the range.
class FoldClusterMonitor {
public:
  /// `unit`: range of the parameter.
  explicit FoldClusterMonitor(double unit) : unit_(unit) {}

  void folded(double parameter); ///< a turning point or a kink lies there
  bool crowded() const { return crowded_; }
  /// The farthest of the last folds and `here`, in that sense (+1, -1), and what lies just beyond. Forgets them.
  double beyond(double here, int sense);

  void archive(Archive &archive);

private:
  double unit_;
  std::vector<double> folds_; // as they came
  bool crowded_ = false;
};

/// A curve that winds on between values of the parameter that it has met.
class NoProgressMonitor {
public:
  explicit NoProgressMonitor(double unit) : unit_(unit) {}

  /// Sense of the range: +1 or -1.
  void begin(double parameter, long newton, int sense);
  /// A step was made to there, after so many iterations in all.
  void stepped(double parameter, long newton);
  void spare(long newton) { ahead_.newton += newton; } ///< iterations that do not count
  void restart_count(long newton) { ahead_.newton = newton; }
  /// Whether it has wound for more iterations than `patience`, the sooner the more often it was left, since it was
  /// `farthest`.
  bool winds(double farthest, long newton, double patience) const;

  void left(double parameter);   ///< the curve was left there, for a place ahead
  void stayed(double parameter); ///< no way on was found; the farthest it has been
  int times_left() const { return left_; }
  int times_stayed() const { return stayed_; }

  void archive(Archive &archive);

private:
  double beyond(double a, double b) const { return sense_ * (a - b); }

  double unit_;
  int sense_ = 1;
  struct {
    double parameter = 0;
    long newton = 0;
  } ahead_;      // where the last stretch of the range was met first; iterations until then
  int left_ = 0; // times that the curve was left because it leads nowhere, since it went on
  double left_at_ = 0;
  int stayed_ = 0; // times that no way on was found, since it was left
  double stayed_at_ = 0;
};

/// A straight line along which nothing but mean positions changes: a body that drifts.
class DriftMonitor {
public:
  /// `swing`, `way`: of a step, without and with mean positions.
  void stepped(double swing, double way);
  bool drifts() const;
  void forget() { still_ = 0; }

private:
  int still_ = 0;
};

} // namespace dovetail
