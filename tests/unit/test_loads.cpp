// Several load patterns, each with its own course: in the equations, in what modes left out do, in time, and reduced.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "harmonic/dense_model.hpp"
#include "harmonic/left_out_forces.hpp"
#include "harmonic/response_parameter.hpp"
#include "lattice_model.hpp"
#include "reduction/left_out.hpp"
#include "small_model.hpp"
#include "small_steps.hpp"
#include "small_system.hpp"
#include "transient/steady_state.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

const LoadCourse forth{force_pattern, {0.2, 1.0, 0.3, 0, 0.2}, ""}, across{"across", {-0.4, 0.5, -0.7, 0.3}, ""};

PreloadedModel with_two_patterns(PreloadedModel model) {
  ReducedModel &reduced = model.reduced;
  LoadPattern pattern{"across", {-0.3, 0.9}, {}};
  for (int i = 3 * reduced.own_points.begin; i < 3 * reduced.own_points.end; ++i)
    pattern.fx.push_back(0.4 * wave(i, 60));
  reduced.loads.push_back(pattern);
  LeftOut &left = reduced.left_out;
  left.squares = {9, 25}, left.loads = {{0.3, -0.2}, {0.5, 0.1}}, left.with_modes = {0.1, 0.02, -0.03, 0.05};
  for (std::size_t i = 0; i < 2 * pattern.fx.size(); ++i)
    left.coupling.push_back(0.1 * wave(static_cast<int>(i) + 6 * reduced.own_points.begin, 70));
  return model;
}

HarmonicSystem system_with(const std::vector<LoadCourse> &loads) {
  return HarmonicSystem(scaled(with_two_patterns(small_preloaded(PETSC_COMM_WORLD)), 0.05, {}), 3, exactly, loads);
}

// |a + b - both| / |both|
double not_the_sum(Vec a, Vec b, Vec both) {
  check(VecAXPY(a, 1, b), "");
  return relative_difference(a, both);
}

DenseModel shaken(std::vector<LoadCase> loads) {
  HarmonicSystem system = system_with({forth});
  DenseModel model = dense_model(system);
  model.loads = std::move(loads);
  for (ContactPoint &point : model.contact) point.mu = {0.3, 0.4};
  return model;
}

std::vector<LoadCase> two_loads() {
  std::vector<LoadCase> loads(2);
  for (int i = 0; i < 11; ++i) loads[0].vector.push_back(2 * wave(i, 80)), loads[1].vector.push_back(wave(i, 90));
  loads[0].fourier = {0.2, 1, 0, 0, 0.3}, loads[1].fourier = {-0.3, 0, 1.5, 0.4, 0, 0.2, 0.1};
  return loads;
}

} // namespace

TEST(Loads, force_is_the_sum_of_the_patterns) {
  HarmonicSystem one = system_with({forth}), other = system_with({across}), both = system_with({forth, across});
  const UniqueVec rest = vector_of(both, 0, 1, 0.8);
  UniqueVec a = one.unknowns(), b = one.unknowns(), c = one.unknowns();
  one.residual(rest, a), other.residual(rest, b), both.residual(rest, c);
  EXPECT_GT(norm(b), 0.1);
  EXPECT_LT(not_the_sum(a, b, c), 1e-14);
  for (const auto &[system, sum] : {std::pair{&one, Vec(a)}, {&other, Vec(b)}, {&both, Vec(c)}}) {
    const LeftOutModes modes(*system, rest);
    modes.forces(modes.motion(rest, 1), sum);
  }
  EXPECT_GT(norm(b), 0.01);
  EXPECT_LT(not_the_sum(a, b, c), 1e-14);
  EXPECT_EQ(highest_harmonic(both.loads()), 2);
  EXPECT_THROW(system_with({{"along", {0, 1}, ""}}), InputError);
}

TEST(Loads, a_factor_on_all_of_them) {
  HarmonicSystem system = system_with({forth, across});
  system.vary(ResponseParameter(*parameter_named("force"), 0.8));
  const UniqueVec at = vector_of(system, 0.4, 3, 0.7), more = vector_of(system, 0.4, 3, 1.7),
                  border = vector_of(system, 0, 1, 0);
  UniqueVec f = system.unknowns(), g = system.unknowns(), column = system.unknowns(),
            factor = vector_of(system, 0, 1, 1);
  system.residual(at, f), system.residual(more, g);
  check(VecAXPY(g, -1, f), "");
  const UniqueMat J = system.matrix();
  system.jacobian(at, border, J);
  check(MatMult(J, factor, column), "");
  EXPECT_GT(norm(column), 0.1);
  EXPECT_LT(relative_difference(column, g), 1e-13);
}

TEST(Loads, with_fewer_and_more_harmonics) { // those a course has not are zeros
  const HarmonicSystem system = system_with({forth, across});
  const HarmonicSystem few(system, 1, exactly), many(system, 9, exactly);
  for (PetscInt d = 0; d < system.layout().own_dofs(); ++d) {
    EXPECT_EQ(force_coefficient(few.loads(), d, cosine(1)), force_coefficient(system.loads(), d, cosine(1)));
    EXPECT_EQ(force_coefficient(many.loads(), d, sine(9)), 0);
  }
  EXPECT_EQ(highest_harmonic(few.loads()), 1);
  EXPECT_EQ(highest_harmonic(many.loads()), 2);
}

TEST(Loads, in_time_against_small_steps) {
  if (!alone()) return; // nothing is shared out
  const DenseModel model = shaken(two_loads());
  const double omega = 0.8;
  Flow flow(model, omega);
  Flow::State state = flow.rest();
  Motion motion;
  for (int period = 0; period < 3; ++period) ASSERT_TRUE(flow.period(state, 0, motion));
  std::array<long, 2> seen{};
  const Numbers fine = from_rest_in_small_steps(model, omega, 3, 2, seen);
  Numbers found = flow.motion_state(state).q;
  const Numbers rate = flow.motion_state(state).v;
  found.insert(found.end(), rate.begin(), rate.end());
  EXPECT_LT(distance(found, fine), 2e-6);
  EXPECT_GT(seen[0], 0) << "nothing slips";
}

TEST(Loads, in_time_two_halves_are_one) {
  std::vector<LoadCase> one = two_loads(), halves;
  for (const LoadCase &load : one)
    for (int half = 0; half < 2; ++half) {
      halves.push_back(load);
      for (double &a : halves.back().fourier) a /= 2;
    }
  const SteadyState whole = steady_state(shaken(one), 0.8, {}, {5, 400, 1e-9}),
                    split = steady_state(shaken(halves), 0.8, {}, {5, 400, 1e-9});
  EXPECT_TRUE(whole.settled && split.settled);
  EXPECT_LT(distance(split.coefficients, whole.coefficients), 1e-8);
}

namespace {

FullModel lattice_with(int patterns, int first = 0) {
  FullModel model = lattice_model(PETSC_COMM_WORLD, 6, 3, 5);
  PetscInt begin, end;
  model.forces.clear();
  for (int j = first; j < first + patterns; ++j) {
    model.forces.push_back({"p" + std::to_string(j), {}});
    UniqueVec &values = model.forces.back().values;
    check(VecDuplicate(model.preload, values.out()), "");
    check(VecGetOwnershipRange(values, &begin, &end), "");
    for (PetscInt i = begin; i < end; ++i)
      check(VecSetValue(values, i, std::pow(10.0, j % 3) * wave(i, j), INSERT_VALUES), "");
    check(VecAssemblyBegin(values), ""), check(VecAssemblyEnd(values), "");
  }
  return model;
}

ReducedModel reduced_from(FullModel model, ModeKind kind, PetscInt modes = 40) {
  ClampedStructure parts = clamp(std::move(model));
  const ReductionSettings settings{kind, modes, false, std::vector<char>(parts.elastic_dofs.size(), 0)};
  MemoryPlan plan;
  plan.keep_psi = true, plan.block = 64;
  Stages stages;
  return craig_bampton(std::move(parts), settings, plan, stages).model;
}

// What all modes of a model yield to a static load: sum of F_a^2 / w^2.
double yielding(const std::vector<double> &squares, const std::vector<double> &load) {
  double sum = 0;
  for (std::size_t j = 0; j < squares.size(); ++j) sum += load[j] * load[j] / squares[j];
  return sum;
}

} // namespace

TEST(Loads, each_pattern_is_reduced_as_if_alone) {
  const ReducedModel all = reduced_from(lattice_with(3), ModeKind::eigen);
  ASSERT_EQ(all.loads.size(), 3u);
  ASSERT_EQ(all.left_out.loads.size(), 3u);
  for (int j = 0; j < 3; ++j) {
    const ReducedModel alone = reduced_from(lattice_with(1, j), ModeKind::eigen);
    const LoadPattern &found = all.loads[j], &wanted = alone.loads[0];
    EXPECT_EQ(found.name, wanted.name);
    EXPECT_LT(distance(found.fa, wanted.fa), 1e-9);
    EXPECT_LT(distance(found.fx, wanted.fx), 1e-9);
  }
}

TEST(Loads, residuals_yield_for_every_pattern) { // as eigenmodes yield with what they leave out
  const ReducedModel whole = reduced_from(lattice_with(3), ModeKind::eigen, 147);
  const ReducedModel few = reduced_from(lattice_with(3), ModeKind::residual),
                     plain = reduced_from(lattice_with(3), ModeKind::eigen);
  for (int j = 0; j < 3; ++j) {
    const double wanted = yielding(whole.kaa, whole.loads[j].fa);
    EXPECT_NEAR(yielding(few.kaa, few.loads[j].fa) / wanted, 1, 1e-8) << j;
    EXPECT_LT(yielding(plain.kaa, plain.loads[j].fa) / wanted, 1 - 1e-5) << j;
    EXPECT_NEAR((yielding(plain.kaa, plain.loads[j].fa) + yielding(plain.left_out.squares, plain.left_out.loads[j])) /
                    wanted,
                1, 1e-8)
        << j;
  }
}

TEST(Loads, more_patterns_than_probes) { // mixtures of them, in which each counts
  ClampedStructure parts = clamp(lattice_with(20));
  const Tall probes = load_probes(PETSC_COMM_WORLD, parts.force_e);
  EXPECT_EQ(probes.columns, lanczos_block / 2);
  const auto weights = gram(PETSC_COMM_WORLD, probes, 0, probes.columns, parts.force_e, 0, 20);
  for (int j = 0; j < 20; ++j) {
    double most = 0;
    for (int i = 0; i < probes.columns; ++i) most = std::max(most, std::abs(weights[j * probes.columns + i]));
    EXPECT_GT(most, 0.1) << j;
  }
  const ReducedModel reduced = reduced_from(lattice_with(20), ModeKind::residual);
  ASSERT_EQ(reduced.loads.size(), 20u);
  EXPECT_GT(reduced.left_out.squares.size(), 0u);
  EXPECT_EQ(reduced.left_out.loads.size(), 20u);
}
