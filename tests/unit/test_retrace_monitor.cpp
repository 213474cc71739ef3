// Whether a curve comes upon an older piece of itself, or of what was left before.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "continuation/retrace_monitor.hpp"
#include "problems/forced_response.hpp"
#include "small_model.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// A straight line: everything at rest, Omega alone changes.
struct Line {
  HarmonicSystem system{scaled(small_preloaded(PETSC_COMM_WORLD), 0.05, {}), 2, 64, course({0, 1e-3})};
  ForcedResponse problem{system};
  RetraceMonitor trail{1};
  UniqueVec y = system.unknowns(), t = system.unknowns();

  RetraceMonitor::Sense add(double omega, double sense, double motion = 0) { // of every unknown
    check(VecSet(y, motion), "");
    set_parameter(y, omega), set_parameter(t, sense);
    return trail.add(problem, y, t, 1);
  }
};

} // namespace

TEST(RetraceMonitor, curves_that_were_left_are_told_from_the_one_at_hand) {
  for (const bool left : {false, true}) {
    Line line;
    for (int i = 0; i < 20; ++i) EXPECT_EQ(line.add(0.01 * i, 1), RetraceMonitor::Sense::fresh);
    if (left) line.trail.leave();
    for (int i = 0; i < 5; ++i) EXPECT_EQ(line.add(0.155 - 0.01 * i, -1), RetraceMonitor::Sense::fresh);
    EXPECT_EQ(line.add(0.105, -1), RetraceMonitor::Sense::opposite);
    EXPECT_EQ(line.trail.met_left(), left);
  }
}

TEST(RetraceMonitor, a_way_that_is_run_again_has_the_same_sense) {
  Line line;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(line.add(0.01 * i, 1), RetraceMonitor::Sense::fresh);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(line.add(0.055 + 0.01 * i, 1), RetraceMonitor::Sense::fresh);
  EXPECT_EQ(line.add(0.105, 1), RetraceMonitor::Sense::same);
}

TEST(RetraceMonitor, points_beside_an_older_piece_are_fresh) {
  Line line;
  for (int i = 0; i < 20; ++i) line.add(0.01 * i, 1);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(line.add(0.155 - 0.01 * i, -1, 1e-3), RetraceMonitor::Sense::fresh);
}

TEST(RetraceMonitor, beside_is_measured_in_units_of_the_parameter) {
  Line line;
  line.trail = RetraceMonitor(1e-3);
  for (int i = 0; i < 20; ++i) line.add(0.01 * i, 1);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(line.add(0.155 - 0.01 * i, -1, 1e-5), RetraceMonitor::Sense::fresh);
  EXPECT_EQ(line.add(0.105, -1, 1e-5), RetraceMonitor::Sense::opposite);
}

namespace {

using Mark = Problem::Projected;

// What add() does, plainly: every older piece is looked at, none is left out as too far away.
struct Plain {
  double unit;
  std::vector<Mark> at{}, along{};
  int sense = 0, found = 0, met = 0, left = 0;

  double product(const Mark &a, const Mark &b, double motion) const {
    double sum = a[0] * b[0] / (unit * unit);
    for (std::size_t k = 1; k < a.size(); ++k) sum += a[k] * b[k] / (motion * motion);
    return sum;
  }
  int older(double motion) {
    const int last = static_cast<int>(at.size()) - 1;
    for (int i = 0; i < last - 4; ++i) {
      Mark chord, to, away;
      for (std::size_t k = 0; k < chord.size(); ++k) chord[k] = at[i + 1][k] - at[i][k], to[k] = at[last][k] - at[i][k];
      const double square = product(chord, chord, motion), s = product(chord, to, motion) / square;
      const double a = product(along[i], chord, motion), b = product(along[i + 1], chord, motion);
      if (s < 0 || s > 1 || a <= 0 || b <= 0) continue;
      // Hermite's cubic, with tangents that go as far along the chord as it is long
      for (std::size_t k = 0; k < away.size(); ++k)
        away[k] = to[k] - (3 * s * s - 2 * s * s * s) * chord[k] -
                  (s - 2 * s * s + s * s * s) * along[i][k] * square / a -
                  (s * s * s - s * s) * along[i + 1][k] * square / b;
      if (std::sqrt(product(away, away, motion) / square) > 1e-3) continue;
      met = i;
      return product(along[last], chord, motion) > 0 ? 1 : -1;
    }
    return 0;
  }
  int add(const Mark &y, const Mark &t, double motion) {
    at.push_back(y), along.push_back(t);
    const int now = older(motion > 0 ? motion : 1);
    found = now != 0 && now == sense ? found + 1 : now != 0;
    sense = now;
    return found >= 6 ? now : 0;
  }
};

// A closed curve in all projections, and its tangent.
std::vector<Mark> lissajous(double phase) {
  Mark y, t;
  for (std::size_t k = 0; k < y.size(); ++k) {
    const double n = 1 + static_cast<double>(k % 3), size = k == 0 ? 3 : 1.0 / (1 + static_cast<double>(k));
    y[k] = size * std::sin(n * phase + static_cast<double>(k)),
    t[k] = size * n * std::cos(n * phase + static_cast<double>(k));
  }
  return {y, t};
}

} // namespace

// Round a closed curve, now and then back, and beside it by about as much as just counts.
TEST(RetraceMonitor, finds_what_a_search_through_all_pieces_finds) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(0, 1);
  int same = 0, opposite = 0, left_met = 0;
  for (int run = 0; run < 40; ++run) {
    const double unit = 0.5 + 5 * part(random), beside = run % 3 == 0 ? 0 : std::pow(10, -4.5 + 2 * part(random));
    RetraceMonitor monitor(unit);
    Plain plain{unit};
    double phase = 6 * part(random), motion = run % 4 == 0 ? 0 : 0.2 + part(random);
    int sense = 1;
    for (int i = 0; i < 160; ++i) {
      if (i == 60 + run) sense = -sense;
      if (i == 50 && run % 2 == 0) monitor.leave(), plain.found = 0, plain.left = static_cast<int>(plain.at.size());
      if (i == 90) motion = std::max(motion, 1.0);
      phase += sense * (0.05 + 0.2 * part(random));
      std::vector<Mark> of = lissajous(phase);
      for (double &value : of[0]) value += beside * (2 * part(random) - 1);
      for (double &value : of[1]) value *= sense;
      const int wanted = plain.add(of[0], of[1], motion);
      const RetraceMonitor::Sense found = monitor.add(of, motion);
      EXPECT_EQ(found == RetraceMonitor::Sense::fresh, wanted == 0) << run << " " << i;
      EXPECT_EQ(found == RetraceMonitor::Sense::same, wanted > 0) << run << " " << i;
      if (wanted != 0) {
        EXPECT_EQ(monitor.met_left(), plain.met + 1 < plain.left) << run << " " << i;
        left_met += plain.met + 1 < plain.left;
      }
      same += wanted > 0, opposite += wanted < 0;
    }
  }
  EXPECT_GT(same, 200);
  EXPECT_GT(opposite, 200);
  EXPECT_GT(left_met, 100);
}

// Pieces whose tangents stand at 80 degrees to their chords: in their middle a point is farther off than a chord.
TEST(RetraceMonitor, knows_pieces_that_are_far_from_straight) {
  RetraceMonitor monitor(1);
  const double steep = std::tan(80 * M_PI / 180);
  const auto arc = [&](double s) { // s (1 - s) steep over each unit of the parameter, to alternate sides
    const double x = s - std::floor(s), side = static_cast<int>(std::floor(s)) % 2 == 0 ? steep : -steep;
    return std::vector<Mark>{{s, side * x * (1 - x)}, {1, side * (1 - 2 * x)}};
  };
  for (int i = 0; i <= 12; ++i) EXPECT_EQ(monitor.add(arc(i), 1), RetraceMonitor::Sense::fresh);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(monitor.add(arc(i + 0.5), 1), RetraceMonitor::Sense::fresh);
  EXPECT_EQ(monitor.add(arc(5.5), 1), RetraceMonitor::Sense::same);
}

// Pieces are 1 and 30 long by turns: a place in a long one is too far from the short one in front of it.
TEST(RetraceMonitor, long_pieces_behind_short_ones_are_known_again) {
  RetraceMonitor monitor(1);
  const auto at = [](double s) { return std::vector<Mark>{{s}, {1}}; };
  for (int i = 0; i < 10; ++i)
    for (const int more : {0, 1}) EXPECT_EQ(monitor.add(at(31 * i + more), 1), RetraceMonitor::Sense::fresh);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(monitor.add(at(31 * i + 16), 1), RetraceMonitor::Sense::fresh);
  EXPECT_EQ(monitor.add(at(31 * 5 + 16), 1), RetraceMonitor::Sense::same);
}

// From mark 4 to 5 is a piece unless the tangent at either runs against it.
TEST(RetraceMonitor, pieces_against_a_tangent_are_none) {
  for (const int against : {0, 4, 5}) {
    RetraceMonitor monitor(1);
    for (int i = 0; i < 10; ++i) monitor.add({Mark{1.0 * i}, Mark{i == against ? -0.5 : 0.5}}, 1);
    auto found = RetraceMonitor::Sense::fresh;
    for (int i = 1; i < 8; ++i) found = monitor.add({Mark{4 + 0.1 * i}, Mark{0.5}}, 1);
    EXPECT_EQ(found, against == 0 ? RetraceMonitor::Sense::same : RetraceMonitor::Sense::fresh) << against;
  }
}

// Each mark is its tangent as well: what is measured is the way between marks.
TEST(RetraceMonitor, a_curve_that_grows_as_fast_as_it_is_long_is_known_again) {
  RetraceMonitor monitor(1);
  const auto at = [](double s) {
    Mark y;
    for (std::size_t k = 0; k < y.size(); ++k) y[k] = std::exp(s) * (1 + static_cast<double>(k));
    return std::vector<Mark>{y, y};
  };
  for (int i = 0; i < 20; ++i) EXPECT_EQ(monitor.add(at(0.05 * i), 1), RetraceMonitor::Sense::fresh);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(monitor.add(at(0.325 + 0.05 * i), 1), RetraceMonitor::Sense::fresh);
  EXPECT_EQ(monitor.add(at(0.575), 1), RetraceMonitor::Sense::same);
}
