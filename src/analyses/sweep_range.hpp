#pragma once
// Where the curve is wanted: values of the parameter, scaled, in the order in which they are run through.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include "support/archive.hpp"

namespace dovetail {

struct SweepRange {
  double from = 0, to = 0;
  std::vector<double> at; ///< wanted exactly, between them
  double unit = 1;        ///< change that counts as much as the largest motion

  int direction() const { return to < from ? -1 : 1; }
  bool one_point() const { return to == from; }
  bool is_ahead(double value, double of) const { return direction() * (value - of) > 0; }
  /// How far a value lies before the beginning.
  double before_start(double value) const { return (from - value) * direction(); }
  /// How far a curve is followed there: a part of the range, or of its first value.
  double room_before() const { return from > 0 ? std::min(unit, from) : unit; }
  double progress(double value) const { return 1 - std::abs(to - value) / unit; }
  bool ends_between(double a, double b) const { return (to - a) * (to - b) <= 0 && a != b; }
  /// What is wanted on the way from a to b, the end included, in that order.
  std::vector<double> passed(double a, double b) const {
    const bool ends = ends_between(a, b);
    std::vector<double> out;
    for (const double w : between(a, b))
      if (!ends || (w - to) * (a - to) > 0) out.push_back(w);
    std::sort(out.begin(), out.end());
    if (b < a) std::reverse(out.begin(), out.end());
    if (ends) out.push_back(to);
    return out;
  }
  /// What is wanted strictly between a and b; and whether a step from a to b passes or meets any, or the end.
  std::vector<double> between(double a, double b) const {
    std::vector<double> out;
    std::copy_if(at.begin(), at.end(), std::back_inserter(out), [&](double w) { return (w - a) * (w - b) < 0; });
    return out;
  }
  bool passes(double a, double b) const {
    const auto passed = [&](double w) { return (w - a) * (w - b) <= 0 && w != a; };
    return passed(to) || std::any_of(at.begin(), at.end(), passed);
  }

  /// The case's range when restored: the curve may have been begun elsewhere, or at the other end.
  void archive(Archive &archive) {
    const double begun = from;
    int sense = direction();
    archive.field("from", from);
    archive.field("direction", sense);
    if (sense * (to - begun) < 0) to = begun;
  }
};

/// Nearest to the end of the range that a curve has come.
template <class Point> class Farthest {
public:
  explicit Farthest(const SweepRange &range) : range_(range) {}

  std::optional<Point> point; ///< where the curve turned back; nothing before
  bool is_behind(double value) const { return !point || range_.is_ahead(value, point->parameter); }
  double or_farther(double value) const { return is_behind(value) ? value : point->parameter; }

private:
  const SweepRange &range_;
};

} // namespace dovetail
