// Paths over the joint's parameters: the equations at a value are those of a joint made with it, and their derivative.
#include <gtest/gtest.h>

#include "harmonic/harmonic_system.hpp"
#include "small_system.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

const std::vector<std::vector<Law>> laws = {{Law::coulomb, Law::coulomb, Law::coulomb},
                                            {Law::cone, Law::unilateral, Law::coulomb},
                                            {Law::bilateral, Law::coulomb, Law::cone}};

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

} // namespace

TEST(Path, derivative_by_every_parameter) {
  for (const double pull : {1.0, 12.0}) // the second slips in the preload
    for (const auto &law : laws)
      for (const PathParameter &parameter : all_parameters) {
        if (&parameter == &frequency_parameter() || !knows(parameter, law)) continue;
        for (const int samples : {exactly, 64}) {
          PreloadedModel model = preloaded(law, pull, {});
          const auto varied = std::make_shared<VariedPreload>(model);
          HarmonicSystem system = system_of(std::move(model), LinearForm::modal, samples);
          system.vary(ResponseParameter(parameter, omega), varied);
          for (const double size : {0.004, 0.06, 0.6})
            for (const double value : {parameter.positive() ? 1.0 : 0.0, 0.7}) {
              const UniqueVec y = vector_of(system, size, 3, value), v = vector_of(system, 0, 5, 1);
              const TwoWays by = along(system, y, v); // both are 0 by friction where nothing slips
              EXPECT_LE(by.difference, 2e-7 * std::max(by.product, by.slope) + 1e-12)
                  << parameter.name << " " << value << ", motion " << size << ", samples " << samples << ", pull "
                  << pull;
            }
        }
      }
}

TEST(Path, equations_are_those_of_a_joint_made_with_the_value) {
  for (const double pull : {1.0, 12.0})
    for (const auto &law : laws)
      for (const PathParameter &parameter : all_parameters) {
        if (!parameter.changes_joint || !knows(parameter, law)) continue;
        PreloadedModel nominal = preloaded(law, pull, {});
        if (pull > 1) ASSERT_GT(sliding(nominal), 0);
        const std::vector<Standstill> origin = nominal.standstill;
        const auto varied = std::make_shared<VariedPreload>(nominal);
        const ResponseParameter path(parameter, omega);
        PreloadedModel made = preloaded(law, pull, path.at(0.6));
        const std::vector<Standstill> rest = made.standstill;
        for (const LinearForm form : {LinearForm::modal, LinearForm::assembled})
          for (const double size : {0.004, 0.06, 0.6}) {
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
  EXPECT_TRUE(system.set(0.5)); // nothing remains of it
  system.residual(vector_of(system, 0.01, 3, 0.5), f);
  EXPECT_TRUE(std::isfinite(norm(f)));
}
