// Strategies of recovery on a made-up curve that says what was tried.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "recovery/recovery.hpp"

namespace dovetail {
namespace {

using Kind = Failure::Kind;

struct Curve : RecoveryContext {
  Sweep range{1, 2, {}};
  std::vector<std::string> tried;
  std::function<bool(const std::string &what, double where)> succeeds = [](const std::string &, double) {
    return false;
  };
  int made = 0;
  bool stop = false;

  bool attempt(const std::string &what, double where) {
    tried.push_back(what);
    places.push_back(where);
    return succeeds(what, where);
  }
  std::vector<double> places, shares, ends;

  Sweep sweep() const override { return range; }
  bool interrupted() override { return stop; }
  int jumps() const override { return made; }
  bool solve_at(double value) override { return attempt("solve", value); }
  bool integrate_at(double value, double share) override {
    shares.push_back(share);
    return attempt("integrate", value);
  }
  bool solve_by_simpler(double value) override { return attempt("simpler", value); }
  bool begin_at(double from, double to) override {
    ends.push_back(to);
    return attempt("begin", from);
  }
  void go_on(const Failure &, bool integrated) override { tried.push_back(integrated ? "integrated" : "jumped"); }
};

// What is tried for a failure, each kind of try once.
std::vector<std::string> order(Kind kind, const Strategies &strategies = Strategies::all()) {
  Curve curve;
  EXPECT_FALSE(recover(strategies, {kind, "", 1.2}, curve));
  curve.tried.erase(std::unique(curve.tried.begin(), curve.tried.end()), curve.tried.end());
  return curve.tried;
}

void near(const std::vector<double> &found, const std::vector<double> &wanted) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 1e-12) << i;
}

Strategies listed(const std::vector<std::string> &names) {
  Strategies out;
  for (const std::string &name : names) EXPECT_TRUE(out.add(Strategies::named(name)));
  return out;
}

} // namespace

TEST(Recovery, every_failure_has_its_tries_in_order) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(order(Kind::no_start), (Words{"simpler", "integrate"}));
  EXPECT_EQ(order(Kind::nowhere), (Words{"begin"}));
  for (const Kind kind : {Kind::no_step, Kind::crowded, Kind::drifting, Kind::lost})
    EXPECT_EQ(order(kind), (Words{"solve", "integrate"}));
}

TEST(Recovery, the_order_is_that_of_the_list) {
  EXPECT_EQ(order(Kind::no_step, listed({"integration", "jump"})), (std::vector<std::string>{"integrate", "solve"}));
  EXPECT_TRUE(order(Kind::no_step, Strategies()).empty());
}

TEST(Recovery, a_branch_that_must_not_change_gets_no_jump) {
  Strategies kept = Strategies::all();
  kept.keep_branch();
  EXPECT_EQ(kept.text(), "fewer_harmonics, elsewhere");
  EXPECT_EQ(order(Kind::lost, kept), std::vector<std::string>{});
}

TEST(Recovery, names_stand_in_a_list_once) {
  Strategies list = listed({"jump"});
  EXPECT_FALSE(list.add(Strategies::named("jump")));
  EXPECT_EQ(list.text(), "jump");
  EXPECT_EQ(Strategies::named("leap"), nullptr);
  EXPECT_EQ(Strategies().text(), "none");
}

TEST(Recovery, the_first_success_ends_the_trying) {
  Curve curve;
  curve.succeeds = [](const std::string &what, double where) { return what == "solve" && where > 1.205; };
  EXPECT_TRUE(recover(Strategies::all(), {Kind::no_step, "", 1.2}, curve));
  EXPECT_EQ(curve.tried, (std::vector<std::string>{"solve", "solve", "solve", "jumped"}));
  EXPECT_NEAR(curve.places.back(), 1.21, 1e-12);
}

TEST(Recovery, a_user_who_wants_to_stop_ends_it_too) {
  Curve curve;
  curve.stop = true;
  EXPECT_FALSE(recover(Strategies::all(), {Kind::no_step, "", 1.2}, curve));
  EXPECT_EQ(curve.tried, std::vector<std::string>(6, "solve"));
}

TEST(Recovery, jumps_are_not_made_for_ever) {
  Curve curve;
  curve.made = most_jumps;
  EXPECT_FALSE(recover(Strategies::all(), {Kind::lost, "", 1.2}, curve));
  EXPECT_TRUE(curve.tried.empty());
  --curve.made;
  EXPECT_FALSE(recover(Strategies::all(), {Kind::lost, "", 1.2}, curve));
  EXPECT_EQ(curve.tried.size(), 11u); // six places to jump to, five to integrate at
}

TEST(Recovery, work_is_shared_among_the_places_that_are_left) {
  Curve curve;
  EXPECT_FALSE(recover(listed({"integration"}), {Kind::lost, "", 1.9}, curve));
  ASSERT_EQ(curve.places.size(), 4u); // the last is the end of the sweep
  EXPECT_EQ(curve.shares, (std::vector<double>{0.25, 1.0 / 3, 0.5, 1}));
  EXPECT_EQ(curve.places.back(), 2);
}

TEST(Recovery, frequencies_ahead_meet_those_wanted_and_end_with_the_sweep) {
  near(ahead({1, 2, {}}, 1.5, {0.1, 0.2}), {1.6, 1.7});
  near(ahead({2, 1, {}}, 1.5, {0.1, 0.2}), {1.4, 1.3}); // downwards
  near(ahead({1, 2, {1.55, 1.52, 1.65}}, 1.5, {0.1, 0.2}), {1.52, 1.6, 1.65, 1.7});
  near(ahead({1, 2, {1.5, 1.6}}, 1.5, {0.1, 0.2}), {1.6, 1.7}); // not where it was, and each once
  near(ahead({1, 2, {}}, 1.95, {0.01, 0.1, 0.2}), {1.96, 2});
  near(ahead({1, 2, {}}, 2.5, {0.1, 0.2}), {2});
}

TEST(Recovery, elsewhere_is_the_other_end_first_and_nowhere_for_one_frequency) {
  Curve curve;
  EXPECT_FALSE(recover(Strategies::all(), {Kind::nowhere, "", 1}, curve));
  EXPECT_EQ(curve.places.front(), 2);
  EXPECT_EQ(curve.places.size(), 7u);
  Curve point;
  point.range = {1, 1, {}};
  EXPECT_FALSE(recover(Strategies::all(), {Kind::nowhere, "", 1}, point));
  EXPECT_TRUE(point.tried.empty());
}

// Ever farther, so that a narrow gap loses little of the curve and a wide one is crossed.
TEST(Recovery, places_that_are_tried) {
  Curve jumps, integrated, begun;
  EXPECT_FALSE(recover(listed({"jump"}), {Kind::no_step, "", 1}, jumps));
  near(jumps.places, {1.0001, 1.001, 1.01, 1.05, 1.2, 1.4});
  EXPECT_FALSE(recover(listed({"integration"}), {Kind::no_step, "", 1}, integrated));
  near(integrated.places, {1.001, 1.01, 1.05, 1.2, 1.4});
  EXPECT_FALSE(recover(listed({"elsewhere"}), {Kind::nowhere, "", 1}, begun));
  near(begun.places, {2, 1.02, 1.2, 1.35, 1.5, 1.65, 1.8});
  EXPECT_EQ(begun.ends, (std::vector<double>{1, 2, 2, 2, 2, 2, 2})); // the way of the sweep, but from its end
}

// Each strategy by itself: which failures it is for, and what it asks for.
TEST(FewerHarmonics, asks_for_simpler_models_at_a_first_point_only) {
  for (const Kind kind : {Kind::nowhere, Kind::no_step, Kind::crowded, Kind::drifting, Kind::lost})
    EXPECT_FALSE(fewer_harmonics().handles(kind));
  Curve curve;
  curve.succeeds = [](const std::string &, double) { return true; };
  EXPECT_TRUE(fewer_harmonics().handles(Kind::no_start));
  EXPECT_TRUE(fewer_harmonics().attempt({Kind::no_start, "", 1.2}, curve));
  EXPECT_EQ(curve.tried, std::vector<std::string>{"simpler"}); // the curve goes on from there as from any first point
  EXPECT_EQ(curve.places, std::vector<double>{1.2});
}

TEST(Jump, goes_on_at_the_first_solution_ahead) {
  EXPECT_FALSE(jump().handles(Kind::no_start) || jump().handles(Kind::nowhere));
  Curve curve;
  curve.succeeds = [](const std::string &, double where) { return where > 1.25; };
  EXPECT_TRUE(jump().attempt({Kind::no_step, "", 1.2}, curve));
  EXPECT_EQ(curve.tried.back(), "jumped");
  EXPECT_NEAR(curve.places.back(), 1.4, 1e-12);
}

TEST(Integration, is_for_first_points_and_for_places_ahead) {
  EXPECT_FALSE(integration().handles(Kind::nowhere));
  Curve start;
  start.succeeds = [](const std::string &, double) { return true; };
  EXPECT_TRUE(integration().attempt({Kind::no_start, "", 1.2}, start));
  EXPECT_EQ(start.tried, std::vector<std::string>{"integrate"});
  EXPECT_EQ(start.shares, std::vector<double>{1}); // all the work that is left
  Curve curve;
  curve.succeeds = start.succeeds;
  EXPECT_TRUE(integration().attempt({Kind::no_step, "", 1.2}, curve));
  EXPECT_EQ(curve.tried, (std::vector<std::string>{"integrate", "integrated"}));
}

TEST(Elsewhere, begins_at_the_first_place_that_has_a_point) {
  EXPECT_FALSE(elsewhere().handles(Kind::no_start));
  Curve curve;
  curve.succeeds = [](const std::string &, double where) { return where > 1.1 && where < 1.9; };
  EXPECT_TRUE(elsewhere().attempt({Kind::nowhere, "", 1}, curve));
  ASSERT_EQ(curve.places.size(), 3u); // the other end, 2 %, 20 %
  EXPECT_NEAR(curve.places.back(), 1.2, 1e-12);
  Curve other;
  other.succeeds = [](const std::string &, double) { return true; };
  EXPECT_TRUE(elsewhere().attempt({Kind::nowhere, "", 1}, other));
  EXPECT_EQ(other.places, std::vector<double>{2}); // the other end
}

} // namespace dovetail
