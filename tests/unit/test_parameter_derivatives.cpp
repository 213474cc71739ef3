// Derivatives by parameters, each against another way to it: the Jacobian's last column, and differences.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "continuation/problem.hpp"
#include "small_system.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double omega = 1.3;

// Whose points slip and open.
struct Joint {
  explicit Joint(LinearForm form = LinearForm::assembled) {
    PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
    preload = std::make_shared<VariedPreload>(model);
    system.emplace(scaled(std::move(model), 0.05, {}), 3, exactly, course({0.2, 1.0, 0.3}), form);
  }
  UniqueVec motion(double last) const { return vector_of(*system, 0.6, 3, last); }

  std::shared_ptr<VariedPreload> preload;
  std::optional<HarmonicSystem> system;
};

double value_of(const PathParameter &parameter, double factor = 0.8) {
  return &parameter == &frequency_parameter() ? omega : parameter.positive() ? factor : 0.02;
}

// The last column of the Jacobian where that parameter is the last unknown, and 0 below it.
UniqueVec column_of(Joint &joint, const PathParameter &parameter, double value) {
  HarmonicSystem &system = *joint.system;
  system.vary(ResponseParameter(parameter, omega), joint.preload);
  const UniqueMat J = system.matrix();
  UniqueVec column = system.unknowns();
  system.jacobian(joint.motion(value), vector_of(system, 0, 1, 0), J);
  check(MatMult(J, vector_of(system, 0, 1, 1), column), "");
  return column;
}

double product(Vec a, Vec b) {
  double sum;
  check(VecDot(a, b, &sum), "");
  return sum;
}

} // namespace

TEST(ParameterDerivatives, by_a_parameter_are_the_last_column_of_a_path_over_it) {
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal})
    for (const PathParameter &parameter : all_parameters) {
      const bool frequency = &parameter == &frequency_parameter();
      Joint joint(form), other(form);
      HarmonicSystem &system = *joint.system;
      if (frequency)
        system.vary(ResponseParameter());
      else
        system.vary(ResponseParameter().beside(parameter, value_of(parameter)), joint.preload);
      UniqueVec found = system.unknowns();
      check(VecSet(found, 7), "");
      system.by_parameter(joint.motion(omega), parameter, found);
      const UniqueVec wanted = column_of(other, parameter, value_of(parameter));
      EXPECT_GT(norm(wanted), 1e-3) << parameter.name;
      EXPECT_LT(relative_difference(found, wanted), 1e-12) << parameter.name;
      EXPECT_EQ(parameter_of(found), 0) << parameter.name;
    }
}

TEST(ParameterDerivatives, weighed_ones_of_points_add_up_to_that_of_the_joint) {
  Joint joint;
  HarmonicSystem &system = *joint.system;
  const UniqueVec weights = vector_of(system, 1, 11, 0);
  std::map<std::string, double> sums;
  for (const ByParameter &point : system.weighed(joint.motion(omega), weights)) {
    sums["normal_stiffness"] += point.normal_stiffness, sums["gap"] += point.gap;
    sums["tangential_stiffness_1"] += point.tangential_stiffness[0];
    sums["tangential_stiffness_2"] += point.tangential_stiffness[1];
    sums["friction_1"] += point.friction[0], sums["friction_2"] += point.friction[1];
  }
  for (const char *name :
       {"normal_stiffness", "tangential_stiffness_1", "tangential_stiffness_2", "friction_1", "friction_2", "gap"}) {
    double found = sums[name];
    MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    const PathParameter &parameter = *parameter_named(name);
    Joint other;
    const double wanted = product(column_of(other, parameter, parameter.positive() ? 1 : 0), weights);
    EXPECT_GT(std::abs(wanted), 1e-3) << name;
    EXPECT_NEAR(found, wanted, 1e-11 * std::abs(wanted)) << name;
  }
}

TEST(ParameterDerivatives, of_the_heights_of_grazes_at_every_point) {
  for (const PathParameter &parameter : all_parameters) {
    if (&parameter == &frequency_parameter()) continue;
    Joint joint;
    HarmonicSystem &system = *joint.system;
    const UniqueVec y = joint.motion(omega);
    const auto at = [&](double value) {
      system.vary(ResponseParameter().beside(parameter, value), joint.preload);
      return system.grazes(y);
    };
    const double value = value_of(parameter), h = 1e-5;
    const auto less = at(value - h), more = at(value + h), grazes = at(value);
    EXPECT_EQ(grazes.size(), static_cast<std::size_t>(system.layout().own_points.size()));
    int most = 0, found = 0;
    for (const auto &of_point : grazes) most = std::max(most, static_cast<int>(of_point.size()));
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
    for (int p = 0; p < 3; ++p) // on all ranks as often, for it is collective
      for (int i = 0; i < most; ++i) {
        const bool own = p < static_cast<int>(grazes.size()) && i < static_cast<int>(grazes[p].size());
        const double by = system.by_parameter(y, own ? p : -1, own ? grazes[p][i] : Graze{}, parameter);
        if (!own) {
          EXPECT_EQ(by, 0);
          continue;
        }
        const bool the_same = less[p].size() == grazes[p].size() && more[p].size() == grazes[p].size();
        EXPECT_TRUE(the_same) << parameter.name << ", point " << p;
        if (!the_same) continue;
        const double size = grazes[p][i].size;
        EXPECT_NEAR(by, (more[p][i].height - less[p][i].height) / (2 * h), 1e-6 * size)
            << parameter.name << ", point " << p << ", graze " << i;
        ++found;
      }
    MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_GT(found, 3) << parameter.name;
  }
}
