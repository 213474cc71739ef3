// Where a structure resonates, and whether friction at rest holds a body, against closed forms and sums by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "small_model.hpp"
#include "stuck/resonances.hpp"
#include "support/error.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Reals = std::vector<double>;
using Ints = std::vector<int>;

// Closed points.
PreloadedModel row_of(int points, double (*stiffness)(int dof), Law law = Law::coulomb) {
  PreloadedModel model;
  ReducedModel &reduced = model.reduced = grounded(points, stiffness);
  reduced.r.assign(reduced.own_contact_dofs(), 0.0);
  reduced.loads[0].fx.assign(reduced.own_contact_dofs(), 1.0);
  model.contact.assign(reduced.own_points.size(), {law, 64, {20, 30}, {0.3, 0.4}, 0});
  model.standstill.assign(reduced.own_points.size(), {{0, 0, 0.1}, {0, 0, 6.4}, {}});
  return model;
}

Case sweep(double from, double to, Reals fourier = {0, 1}) {
  Case study;
  study.loads = course(std::move(fourier));
  study.omega_from = from, study.omega_to = to;
  return study;
}

double rising(int dof) { return (dof + 1.0) * (dof + 1.0); }

Reals sorted_roots(Reals squares, std::size_t most) {
  std::sort(squares.begin(), squares.end());
  squares.resize(std::min(most, squares.size()));
  for (double &value : squares) value = std::sqrt(value);
  return squares;
}

void expect_near(const Reals &found, const Reals &wanted) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 1e-9) << i;
}

} // namespace

// Frequencies without contacts are 1 to 48, and the springs of a point 20, 30 and 64 more.
TEST(ResonanceSets, as_many_are_found_as_the_load_meets) {
  const PreloadedModel model = row_of(16, rising);
  Reals open, slipping, stuck;
  for (int i = 0; i < 48; ++i) {
    const double spring = std::array{20, 30, 64}[i % 3];
    open.push_back(rising(i)), slipping.push_back(rising(i) + (i % 3 == 2 ? 64 : 0)),
        stuck.push_back(rising(i) + spring);
  }
  for (const auto &[to, fourier, most] : {std::tuple{8.0, Reals{0, 1}, 10u},
                                          {15.0, Reals{0, 1}, 20u},
                                          {8.0, Reals{0, 1, 0, 0, 2}, 20u},
                                          {8.0, Reals{3}, 10u},
                                          {30.0, Reals{0, 1}, 40u},
                                          {300.0, Reals{0, 1}, 48u}}) {
    const Resonances found = resonances(model, sweep(2, to, fourier));
    ASSERT_TRUE(found.known);
    expect_near(found.stuck.omega, sorted_roots(stuck, most));
    const std::size_t more = found.open.omega.size(); // these lie lower: more of them may be wanted
    EXPECT_TRUE(more == most || more == std::min(2 * most, 48u));
    expect_near(found.open.omega, sorted_roots(open, more));
    expect_near(found.slipping.omega, sorted_roots(slipping, found.slipping.omega.size()));
    EXPECT_TRUE(most == 48 || found.open.omega.back() > to * (fourier.size() == 5 ? 2 : 1) || fourier.size() == 1);
    const double reach = std::min({found.stuck.omega.back(), found.slipping.omega.back(), found.open.omega.back()});
    EXPECT_EQ(found.reach, most == 48 ? INFINITY : reach);
    EXPECT_EQ(found.points, 16);
    EXPECT_EQ(found.closed, 16);
    EXPECT_EQ(found.may_lift, 16);
    EXPECT_NEAR(found.clamping, 16 * 6.4, 1e-9);
    EXPECT_TRUE(found.all_stuck.omega.empty());
    EXPECT_EQ(found.sliding.force, 0);
  }
  const Resonances backwards = resonances(model, sweep(8, 2)), forwards = resonances(model, sweep(2, 8));
  EXPECT_EQ(backwards.stuck.in_sweep, forwards.stuck.in_sweep);
}

TEST(ResonanceSets, no_more_than_eighty_are_looked_for) {
  const PreloadedModel model = row_of(30, rising);
  const Resonances found = resonances(model, sweep(2, 300));
  EXPECT_EQ(found.stuck.omega.size(), 80u);
  EXPECT_EQ(found.open.omega.size(), 80u);
  EXPECT_LT(found.reach, 300);
}

// Motions that nothing brings back are at rest, also where they are pushed away.
TEST(ResonanceSets, rigid_and_unstable_motions_are_no_resonances) {
  const PreloadedModel model = row_of(4, [](int dof) { return dof == 0 ? -100.0 : dof == 1 ? 0 : rising(dof); });
  const Resonances found = resonances(model, sweep(0, 3.5));
  ASSERT_TRUE(found.known);
  for (const int j : {0, 1}) {
    EXPECT_EQ(found.open.omega[j], 0);
    EXPECT_EQ(found.open.in_sweep[j], 0);
  }
  EXPECT_EQ(found.open.in_sweep[2], 1);
}

TEST(ResonanceSets, the_lowest_harmonic_that_meets_one_in_the_sweep_is_told) {
  const PreloadedModel model = row_of(4, [](int dof) { return dof < 2 ? 0 : rising(dof); });
  const Resonances found = resonances(model, sweep(3, 5, {0, 1, 0, 0, 0, 0.5, 0})); // harmonics 1 and 3
  ASSERT_TRUE(found.known);
  ASSERT_GE(found.open.omega.size(), 12u);
  EXPECT_EQ(found.open.omega[0], 0);
  EXPECT_EQ(found.open.omega[1], 0);
  EXPECT_EQ(Ints(found.open.in_sweep.begin(), found.open.in_sweep.begin() + 12),
            (Ints{0, 0, 1, 1, 1, 0, 0, 0, 3, 3, 3, 3}));
}

// Every mode is one dof's alone, and a load drives those that it acts on.
TEST(ResonanceSets, modes_are_driven_by_what_works_on_them) {
  PreloadedModel model = row_of(2, rising);
  ReducedModel &reduced = model.reduced;
  reduced.loads.push_back({"other", {}, {}});
  reduced.modes = 3, reduced.own_modes = own_share(reduced.comm, 3), reduced.kaa = {1e3, 2e3, 3e3};
  reduced.mxa.assign(reduced.own_contact_dofs() * 3, 0.0);
  reduced.loads[0].fa = {0, 0, 3}, reduced.loads[1].fa = {2, 0, 0};
  for (LoadPattern &load : reduced.loads) load.fx.assign(reduced.own_contact_dofs(), 0.0);
  const auto push = [&](int pattern, int dof, double force) {
    const int own = dof - 3 * static_cast<int>(reduced.own_points.begin);
    if (own >= 0 && own < static_cast<int>(reduced.own_contact_dofs())) reduced.loads[pattern].fx[own] = force;
  };
  push(0, 0, 2), push(0, 3, 1e-5), push(0, 5, 1e-12), push(1, 1, 1), push(1, 3, 1);
  Case study = sweep(1, 2);
  study.loads = {{"force", {0, 1, 0, 0, 0}, ""},
                 {"other", {5, 0, 0, 0, 3, 2}, ""}}; // cos; sin of the second, cos of the third
  const Resonances found = resonances(model, study);
  ASSERT_EQ(found.driven.size(), 9u); // three of the reduction last
  EXPECT_EQ(found.driven[6], (Ints{2, 3}));
  EXPECT_EQ(found.driven[7], Ints());
  EXPECT_EQ(found.driven[8], Ints{1});
  const Reals frequencies{1, 4, 9, 16, 25, 36}, springs{20, 30, 64, 20, 30, 64};
  Reals order;
  for (int i = 0; i < 6; ++i) order.push_back(frequencies[i] + springs[i]);
  Reals sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (int i = 0; i < 6; ++i) {
    const std::size_t place = std::find(sorted.begin(), sorted.end(), order[i]) - sorted.begin();
    Ints wanted;
    if (i == 0 || i == 3) wanted.push_back(1); // 1e-12 of 2 is nothing
    if (i == 1 || i == 3) wanted.push_back(2), wanted.push_back(3);
    EXPECT_EQ(found.driven[place], wanted) << i;
  }
}

TEST(ResonanceSets, open_points_have_no_springs_and_ratios_count_with_all) {
  PreloadedModel model = row_of(4, rising);
  int closed = 0;
  Reals stuck, all;
  for (int p = 0; p < 4; ++p) {
    const int own = p - static_cast<int>(model.reduced.own_points.begin);
    const bool open = p % 2 == 1;
    if (open && own >= 0 && own < static_cast<int>(model.contact.size())) model.standstill[own].force[2] = 0;
    closed += !open;
    for (int d = 0; d < 3; ++d) {
      const double spring = std::array{20, 30, 64}[d];
      stuck.push_back(rising(3 * p + d) + (open ? 0 : spring)), all.push_back(rising(3 * p + d) + spring);
    }
  }
  Case study = sweep(1, 2);
  for (const bool ratios : {false, true}) {
    if (ratios) study.damping.ratios = {{1, 0.01}};
    const Resonances found = resonances(model, study);
    EXPECT_EQ(found.closed, closed);
    expect_near(found.stuck.omega, sorted_roots(stuck, 10));
    if (ratios)
      expect_near(found.all_stuck.omega, sorted_roots(all, 10));
    else
      EXPECT_TRUE(found.all_stuck.omega.empty());
  }
  const Resonances whole = resonances(row_of(4, rising), study); // nothing is open: that is the stuck structure
  EXPECT_TRUE(whole.all_stuck.omega.empty());
  PreloadedModel heavy = row_of(4, rising);
  for (double &m : heavy.reduced.mxx) m = -m;
  EXPECT_FALSE(resonances(heavy, study).known);
  const PreloadedModel bilateral = row_of(4, rising, Law::bilateral);
  const Resonances held = resonances(bilateral, study);
  EXPECT_EQ(held.may_lift, 0);
  EXPECT_EQ(held.clamping, 0);
  EXPECT_EQ(held.closed, 4);
}

namespace {

// A body of that many points, stiffly joined, that only friction keeps from sliding along t1 and t2.
PreloadedModel sliding_body(int points, Law law) {
  PreloadedModel model = row_of(
      points, [](int dof) { return dof % 3 == 2 ? 9.0 : 0.0; }, law);
  ReducedModel &reduced = model.reduced;
  const int first = 3 * static_cast<int>(reduced.own_points.begin), n = 3 * points;
  for (int i = 0; i < static_cast<int>(reduced.own_contact_dofs()); ++i) {
    const int dof = first + i;
    for (int j = 0; j < n; ++j)
      if (dof % 3 < 2 && j % 3 == dof % 3) reduced.kxx[i * n + j] += 1e3 * ((j == dof) - 1.0 / points);
    reduced.r[i] = dof % 3 == 0 ? 0.3 : dof % 3 == 1 ? -0.2 : -6.4;
    reduced.loads[0].fx[i] = dof % 3 == 0 ? 1.0 + dof : dof % 3 == 1 ? 0.5 : 0.1;
  }
  return model;
}

// Of a body that slides as a whole: the worst instant of 128.
Sliding by_hand(int points, Law law, const Reals &fourier) {
  double force[2]{}, rest[2]{};
  for (int p = 0; p < points; ++p) force[0] += 1.0 + 3 * p, force[1] += 0.5, rest[0] -= 0.3, rest[1] += 0.2;
  Sliding worst;
  double most = 0;
  for (int i = 0; i < 128; ++i) {
    const double angle = 2 * M_PI * i / 128;
    double f = fourier[0] / 2;
    for (std::size_t k = 1; 2 * k - 1 < fourier.size(); ++k) {
      f += fourier[2 * k - 1] * std::cos(static_cast<double>(k) * angle);
      if (2 * k < fourier.size()) f += fourier[2 * k] * std::sin(static_cast<double>(k) * angle);
    }
    const double push[2] = {rest[0] + f * force[0], rest[1] + f * force[1]};
    const double largest = std::max(std::abs(push[0]), std::abs(push[1])),
                 x[2] = {push[0] / largest, push[1] / largest};
    const double asked = push[0] * x[0] + push[1] * x[1],
                 held = points * 6.4 *
                        (law == Law::cone ? 0.3 * std::hypot(x[0], x[1]) : 0.3 * std::abs(x[0]) + 0.4 * std::abs(x[1]));
    if (asked / held > most) most = asked / held, worst = {asked, held};
  }
  return worst;
}

} // namespace

TEST(Sliding, is_where_friction_is_asked_for_most) {
  for (const Law law : {Law::coulomb, Law::cone})
    for (const int points : {1, 3})
      for (const Reals &fourier : {Reals{0, 1}, {1.5, 0.2, 0.9}, {0.4, 0, 1, 0.3, -0.8}, {-2, 0.1}, {0.0, 0.01}}) {
        const Resonances found = resonances(sliding_body(points, law), sweep(1, 2, fourier));
        const Sliding wanted = by_hand(points, law, fourier);
        EXPECT_NEAR(found.sliding.force, wanted.force, 1e-6 * wanted.force);
        EXPECT_NEAR(found.sliding.held, wanted.held, 1e-6 * wanted.held);
        EXPECT_EQ(found.sliding.without_bound(), wanted.force > wanted.held);
      }
  EXPECT_EQ(resonances(sliding_body(2, Law::unilateral), sweep(1, 2, {0, 1})).sliding.held, 0);
}

TEST(Sliding, is_held_by_closed_points_alone) {
  for (const Law law : {Law::coulomb, Law::cone}) {
    PreloadedModel model = sliding_body(3, law);
    for (std::size_t p = 0; p < model.standstill.size(); ++p)
      if (model.reduced.own_points.begin + p != 1) model.standstill[p].force[2] = p ? -1 : 0;
    Case study = sweep(1, 2, {0.4, 0, 1, 0.3, -0.8});
    const Resonances found = resonances(model, study);
    const Sliding wanted = by_hand(3, law, study.loads[0].fourier); // the same instant, of one point
    EXPECT_NEAR(found.sliding.force, wanted.force, 1e-6 * wanted.force);
    EXPECT_NEAR(found.sliding.held, wanted.held / 3, 1e-6 * wanted.held);
    study.loads.push_back({force_pattern, {}, ""}); // that is never there
    EXPECT_EQ(resonances(model, study).sliding.force, found.sliding.force);
  }
}
