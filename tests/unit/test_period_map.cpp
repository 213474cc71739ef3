// The derivative of the map over one period against central differences of the map itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "linear_motion.hpp"
#include "transient/period_map.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// Two contact points and two modes more, shaken so that contacts stick, slip, open and land.
DenseModel shaken(Law law, double mu, double force, double press) {
  const double other = law == Law::coulomb ? 0 : mu; // along t2
  DenseModel model = with_modes(
      dense_scene({{law, 30, {8, 12}, {mu, other}, 0.1}, {law, 20, {6, 6}, {mu, mu}, -0.2}}, 4, 1, {0.02, 0.03}, 0.05),
      {1.5, 12});
  shake(model, force);
  model.loads.push_back(model.loads[0]); // the same force in two patterns
  for (std::size_t i = 0; i < model.loads[0].vector.size(); ++i) model.loads[i % 2].vector[i] = 0;
  model.C = dashpots(model.dofs(), 0.2);
  for (std::size_t p = 0; p < model.contact.size(); ++p)
    model.standstill[p] = standstill(model.contact[p], {0, 0, model.contact[p].gap + press});
  return model;
}

// Differences that both steps and both sides agree about; NaN elsewhere: there is a corner.
double difference_quotient(double fine, double coarse, double left, double right, double size) {
  const double apart = std::max({std::abs(fine - coarse), std::abs(left - right)});
  return apart < 1e-3 * size ? fine : NAN;
}

struct Compared {
  int agree = 0, differ = 0, corners = 0;
  int open = 0, sticks = 0, slips = 0; // contacts at theta = 0
};

void compare(Flow &flow, PeriodMap &map, const Numbers &y, const Held &held, double omega, Compared &seen) {
  const int N = static_cast<int>(map.size());
  constexpr double turning = 0.7;
  Numbers out, plain;
  Dense derivative;
  flow.set_omega(omega);
  ASSERT_TRUE(map.next_held(y, plain, held));
  flow.set_omega(omega);
  ASSERT_TRUE(map.next_with_derivative(y, held, turning, out, derivative));
  for (int i = 0; i < N; ++i) EXPECT_NEAR(out[i], plain[i], 1e-8 * norm(plain));
  for (const TouchState &touch : map.state(y, held).touch)
    ++(!touch.closed ? seen.open : touch.slides || touch.side[0] != 0 ? seen.slips : seen.sticks);
  ASSERT_EQ(derivative.columns, N + 1);
  for (int j = 0; j <= N; ++j) {
    const auto moved = [&](double by) {
      Numbers at = y, image;
      if (j < N) at[j] += by;
      flow.set_omega(j < N ? omega : omega + by * turning);
      EXPECT_TRUE(map.next_held(at, image, held));
      return image;
    };
    const double h = 3e-6 * norm(y);
    const Numbers a = moved(-h), b = moved(h), c = moved(-h / 4), d = moved(h / 4);
    double size = 1e-2;
    for (int i = 0; i < N; ++i) size = std::max(size, std::abs(derivative(i, j)));
    for (int i = 0; i < N; ++i) {
      const double expected = difference_quotient((d[i] - c[i]) / (h / 2), (b[i] - a[i]) / (2 * h),
                                                  (plain[i] - a[i]) / h, (b[i] - plain[i]) / h, size);
      if (std::isnan(expected))
        ++seen.corners;
      else if (std::abs(derivative(i, j) - expected) < 2e-4 * size)
        ++seen.agree;
      else {
        ++seen.differ;
        if (seen.differ < 20)
          ADD_FAILURE() << i << " " << j << ": " << derivative(i, j) << " " << expected << " of " << size;
      }
    }
  }
}

} // namespace

class PeriodMapOf : public ::testing::TestWithParam<Law> {};

std::string name_of(const ::testing::TestParamInfo<Law> &of) {
  const char *names[] = {"coulomb", "cone", "unilateral", "bilateral"};
  return names[of.index];
}

INSTANTIATE_TEST_SUITE_P(Laws, PeriodMapOf, ::testing::Values(Law::coulomb, Law::cone, Law::unilateral, Law::bilateral),
                         name_of);

TEST_P(PeriodMapOf, derivative_is_that_of_differences) {
  const Law law = GetParam();
  Compared all;
  for (const auto &[mu, force, press] : {std::array{0.4, 1.0, 0.5},
                                         {0.4, 4.0, 0.05},
                                         {0.4, 15.0, 0.5},
                                         {0.4, 15.0, 0.05},
                                         {0.01, 1.0, 0.05},
                                         {0.05, 4.0, 0.5},
                                         {0.05, 15.0, 0.05}}) {
    SCOPED_TRACE(::testing::Message() << "law " << static_cast<int>(law) << ", " << mu << ", " << force << ", "
                                      << press);
    const DenseModel model = shaken(law, mu, force, press);
    Compared seen;
    for (const double omega : {0.8, 1.7, 2.9}) {
      Flow flow(model, omega);
      PeriodMap map(flow, 1000000);
      Numbers y = map.numbers(flow.rest()), next;
      Held still;
      for (int period = 0; period < 12; ++period) {
        ASSERT_TRUE(map.next(y, next, still));
        y = next;
        if (period % 3 == 2) compare(flow, map, y, period % 2 == 0 ? Held{} : still, omega, seen);
        flow.set_omega(omega);
      }
    }
    EXPECT_GT(seen.agree, 20 * seen.corners);
    all.open += seen.open, all.sticks += seen.sticks, all.slips += seen.slips;
  }
  EXPECT_EQ(all.open > 10, law != Law::bilateral) << all.open;
  EXPECT_EQ(all.slips > 10, has_friction(law)) << all.slips;
  EXPECT_GT(all.sticks, 10);
}
