// A solution along those of smaller loads, of equations over any parameter.
#include <gtest/gtest.h>

#include "analyses/load_steps.hpp"
#include "norms.hpp"
#include "small_system.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr NewtonSettings tight{1e-10, 1e-9, 30};
constexpr double omega = 1.3, friction = 0.7;

// Friction of all points may be followed at a frequency; the load is `load` times that of small_system().
HarmonicSystem system_over(bool over_friction, double load) {
  PreloadedModel model = preloaded({Law::coulomb, Law::coulomb, Law::coulomb}, 1, {});
  auto preload = over_friction ? std::make_shared<VariedPreload>(model) : nullptr;
  HarmonicSystem system(scaled(std::move(model), 0.05, {}), 3, exactly, course({0.2, load, 0.3}));
  if (over_friction) system.vary(ResponseParameter(*parameter_named("friction"), omega), preload);
  return system;
}

} // namespace

TEST(LoadSteps, end_at_a_solution_of_the_whole_load) {
  for (const bool over_friction : {false, true})
    for (const double load : {1.0, 30.0}) {
      HarmonicSystem system = system_over(over_friction, load);
      const double value = over_friction ? friction : omega;
      SolveCounts counts;
      BranchSettings settings;
      settings.from = settings.to = value;
      const Response response(system, tight, settings, value, counts);
      UniqueVec y = system.unknowns(), f = system.unknowns();
      ASSERT_TRUE(solve_by_load_steps(response, system, value, y)) << over_friction << load;
      set_parameter(y, value);
      system.residual(y, f);
      set_parameter(f, 0);
      EXPECT_LT(norm(f), 1e-8) << over_friction << load;
    }
}
