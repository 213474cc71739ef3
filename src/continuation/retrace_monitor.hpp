#pragma once
// The way behind: by it a curve is known that runs back over itself, or closes.
#include <array>
#include <vector>

#include "continuation/problem.hpp"
#include "support/archive.hpp"
#include "support/growing_list.hpp"

namespace dovetail {

class RetraceMonitor {
public:
  /// `unit`: of the parameter, as for the curve.
  explicit RetraceMonitor(double unit) : unit_(unit) {}

  enum class Sense { fresh, same, opposite };
  /// Takes note of a point and its tangent. `motion`: the largest met so far, plain norm. Returns whether this point
  /// and the `enough` before it all lie on older pieces of the way, and which way round those were run. Collective.
  Sense add(const Problem &problem, Vec y, Vec t, double motion);
  /// The same of what is projected already.
  Sense add(const std::vector<Problem::Projected> &of, double motion);

  /// All marks, and what restores them.
  const GrowingList &marks() const { return marks_; }
  void archive(Archive &archive) {
    archive.field("found", found_);
    archive.field("sense", sense_);
    archive.field("left", left_);
  }
  void restore(GrowingList marks) { marks_ = std::move(marks); }
  /// The curve was left: what comes next does not hang together with the point before.
  void leave() { found_ = 0, left_ = count(); }
  /// Whether the older piece that was come upon is of the curve before it was left.
  bool met_left() const { return met_ + 1 < left_; }

private:
  static constexpr int size = Problem::projections, enough = 6;
  int count() const { return static_cast<int>(marks_.size()) / (2 * size); }
  struct Weights {
    std::array<double, 2> unit; // of the parameter, of the motion
    double product(const double *a, const double *b) const;
  };
  void lengthen_way(const Weights &weights);
  int first_near(int i, int last, double far) const;
  int older(double motion); // +1 or -1 if the last mark lies on an older piece run in that sense; else 0

  double unit_;
  std::vector<double> way_; // length of the way up to each mark, or more
  GrowingList marks_; // (points, 2, size): the parameter and projections of the motion, then the same of the tangent
  int found_ = 0, sense_ = 0; // points in succession on older pieces
  int met_ = 0;               // mark where the last of these begins
  int left_ = 0;              // marks of the curves that were left
};

} // namespace dovetail
