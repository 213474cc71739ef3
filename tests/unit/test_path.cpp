// Paths over the joint's parameters: the equations at a value are those of a joint made with it, and their derivative.
#include <gtest/gtest.h>

#include "harmonic/dense_model.hpp"
#include "harmonic/harmonic_system.hpp"
#include "small_system.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

const std::vector<std::vector<Law>> laws = {{Law::coulomb, Law::coulomb, Law::coulomb},
                                            {Law::cone, Law::unilateral, Law::coulomb},
                                            {Law::bilateral, Law::coulomb, Law::cone}};

constexpr double of_rounding = 1e-9; // left of differences of forces of some units over steps of 1e-5

bool knows(const PathParameter &parameter, const std::vector<Law> &some) { // the cone has one friction
  const std::string name = parameter.name;
  return (name != "friction_1" && name != "friction_2") || std::find(some.begin(), some.end(), Law::cone) == some.end();
}

HarmonicSystem system_of(PreloadedModel model, LinearForm form, int samples) {
  return HarmonicSystem(scaled(std::move(model), 0.05, {}), 3, samples, course({0.2, 1.0, 0.3}), form);
}

// Points that slip in the preload, on all ranks.
int sliding(const PreloadedModel &model) {
  int count = 0;
  for (std::size_t p = 0; p < model.contact.size(); ++p)
    count += has_friction(model.contact[p].law) && model.standstill[p].w != Memory{};
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  return count;
}

constexpr double omega = 1.3;

// Pulls of the preload: with the second, points slip in it.
std::vector<double> pulls() { return alone() ? std::vector<double>{1.0, 12.0} : std::vector<double>{12.0}; }

// Of motions: with the last one points slip and open.
std::vector<double> sizes() { return alone() ? std::vector<double>{0.004, 0.06, 0.6} : std::vector<double>{0.6}; }

// Of the parameter: the nominal one, where it is positive, and another.
std::vector<double> values(const PathParameter &parameter) {
  return alone() ? std::vector{parameter.positive() ? 1.0 : 0.0, 0.7} : std::vector{0.7};
}

const std::vector<std::vector<bool>> some_points = {{}, {false, true, false}, {true, false, false}};

// Every kind of damping, times a factor.
HarmonicSystem damped(LinearForm form, bool of_fixed, double factor = 1) {
  Damping damping(0.05 * factor, 0.03 * factor, 0.02 * factor);
  damping.ratios = {{1, 0.03 * factor}, {2, 0.01 * factor}};
  damping.of_fixed = of_fixed, damping.matrix = damping.contact = damping.of_parts = true;
  PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
  add_damping_matrices(damping, model.reduced);
  for (auto *values : {&model.reduced.viscous.aa, &model.reduced.viscous.xa, &model.reduced.viscous.xx})
    for (double &value : *values) value *= factor;
  return HarmonicSystem(scaled(std::move(model), damping, {}), 3, exactly, course({0.2, 1.0, 0.3}), form);
}

} // namespace

class PathOf : public ::testing::TestWithParam<int> {
protected:
  const std::vector<bool> &points() const { return some_points[GetParam()]; }
  bool takes(const PathParameter &parameter) const { return points().empty() || has_points(parameter); }
};

INSTANTIATE_TEST_SUITE_P(Points, PathOf, ::testing::Range(0, 3));

TEST_P(PathOf, derivative_by_every_parameter) {
  for (const double pull : pulls())
    for (const auto &law : laws)
      for (const PathParameter &parameter : all_parameters) {
        if (&parameter == &frequency_parameter() || !knows(parameter, law) || !takes(parameter)) continue;
        for (const int samples : alone() ? std::vector<int>{exactly, 64} : std::vector<int>{exactly}) {
          PreloadedModel model = preloaded(law, pull, {});
          const auto varied = std::make_shared<VariedPreload>(model, points());
          HarmonicSystem system = system_of(std::move(model), LinearForm::modal, samples);
          system.vary(ResponseParameter(parameter, omega), varied);
          for (const double size : sizes())
            for (const double value : values(parameter)) {
              const UniqueVec y = vector_of(system, size, 3, value), v = vector_of(system, 0, 5, 1);
              const TwoWays by = along(system, y, v); // both are 0 by friction where nothing slips
              EXPECT_LE(by.difference, 2e-7 * std::max(by.product, by.slope) + of_rounding)
                  << parameter.name << " " << value << ", motion " << size << ", samples " << samples << ", pull "
                  << pull;
            }
        }
      }
}

TEST_P(PathOf, equations_are_those_of_a_joint_made_with_the_value) {
  for (const double pull : pulls())
    for (const auto &law : laws)
      for (const PathParameter &parameter : all_parameters) {
        if (!parameter.changes_joint || !knows(parameter, law) || !takes(parameter)) continue;
        PreloadedModel nominal = preloaded(law, pull, {});
        if (pull > 1) ASSERT_GT(sliding(nominal), 0);
        const std::vector<Standstill> origin = nominal.standstill;
        const auto varied = std::make_shared<VariedPreload>(nominal, points());
        const ResponseParameter path(parameter, omega);
        PreloadedModel made = preloaded(law, pull, path.at(0.6), points());
        const std::vector<Standstill> rest = made.standstill;
        for (const LinearForm form : {LinearForm::modal, LinearForm::assembled})
          for (const double size : sizes()) {
            HarmonicSystem system = system_of(nominal, form, exactly), other = system_of(made, form, exactly);
            system.vary(path, varied);
            const UniqueVec y = vector_of(system, size, 3, 0.6), z = vector_of(other, size, 3, omega);
            UniqueVec f = system.unknowns(), g = other.unknowns();
            const Layout &layout = system.layout();
            double *own; // the same total displacement
            check(VecGetArray(z, &own), "");
            for (std::size_t i = 0; i < 3 * rest.size(); ++i)
              own[layout.own_point_offset(0) + i * layout.width] += 2 * (origin[i / 3].x[i % 3] - rest[i / 3].x[i % 3]);
            check(VecRestoreArray(z, &own), "");
            system.residual(y, f), other.residual(z, g);
            EXPECT_LT(relative_difference(f, g), 1e-11) << parameter.name << ", motion " << size << ", pull " << pull;
            const UniqueMat A = system.matrix(), B = other.matrix();
            const UniqueVec v = vector_of(system, 1, 9, 0), border = vector_of(system, 0, 1, 0);
            system.jacobian(y, border, A), other.jacobian(z, border, B);
            check(MatMult(A, v, f), ""), check(MatMult(B, v, g), "");
            EXPECT_LT(relative_difference(f, g), 1e-11) << parameter.name << ", motion " << size << ", pull " << pull;
          }
      }
}

TEST(Path, damping_is_that_of_a_case_made_with_the_value) {
  const ResponseParameter path(*parameter_named("damping"), omega);
  for (const LinearForm form : {LinearForm::modal, LinearForm::assembled})
    for (const bool of_fixed : {true, false}) {
      HarmonicSystem system = damped(form, of_fixed), other = damped(form, of_fixed, 0.6);
      system.vary(path);
      const UniqueVec y = vector_of(system, 0.06, 3, 0.6), z = vector_of(other, 0.06, 3, omega),
                      v = vector_of(system, 1, 9, 0), border = vector_of(system, 0, 1, 0);
      UniqueVec f = system.unknowns(), g = other.unknowns();
      system.residual(y, f), other.residual(z, g);
      EXPECT_LT(relative_difference(f, g), 1e-12);
      const UniqueMat A = system.matrix(), B = other.matrix();
      system.jacobian(y, border, A), other.jacobian(z, border, B);
      check(MatMult(A, v, f), ""), check(MatMult(B, v, g), "");
      EXPECT_LT(relative_difference(f, g), 1e-12);
      EXPECT_LT(directional_error(system, y, vector_of(system, 0.1, 5, 1)), 2e-7);

      // weights . column, as the border is none
      const UniqueVec last = vector_of(system, 0, 1, 1), weights = vector_of(system, 1, 11, 0);
      double product;
      check(MatMult(A, last, f), ""), check(VecDot(f, weights, &product), "");
      EXPECT_GT(std::abs(product), 1e-3);
      EXPECT_NEAR(system.weighed_damping(y, weights), product, 1e-12 * std::abs(product));
    }
}

TEST(Path, damping_of_a_motion_in_time_is_that_at_the_value) {
  HarmonicSystem system = damped(LinearForm::modal, true), other = damped(LinearForm::modal, true, 0.6);
  system.vary(ResponseParameter(*parameter_named("damping"), omega));
  ASSERT_TRUE(system.set(0.6));
  const DenseModel a = dense_model(system), b = dense_model(other);
  for (std::size_t i = 0; i < a.K.size(); ++i) EXPECT_NEAR(a.viscous(i), b.viscous(i), 1e-14);
}

TEST(Path, a_joint_without_preload_state_has_no_equations) {
  PreloadedModel nominal = preloaded(laws[0], 1, {});
  const auto varied = std::make_shared<VariedPreload>(nominal);
  HarmonicSystem system = system_of(std::move(nominal), LinearForm::modal, exactly);
  system.vary(ResponseParameter(*parameter_named("preload"), omega), varied);
  EXPECT_TRUE(system.set(0.5));
  EXPECT_FALSE(system.set(std::nan("")));
  UniqueVec f = system.unknowns();
  system.residual(vector_of(system, 0.01, 3, std::nan("")), f);
  EXPECT_TRUE(std::isnan(norm(f)));
  EXPECT_EQ(system.constant().size(), 3u * system.layout().own_points.size());
  EXPECT_TRUE(system.set(0.5)); // nothing remains of it
  system.residual(vector_of(system, 0.01, 3, 0.5), f);
  EXPECT_TRUE(std::isfinite(norm(f)));
}
