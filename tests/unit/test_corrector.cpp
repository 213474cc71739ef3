// Newton and tangents on the bordered system.
#include <gtest/gtest.h>

#include "analyses/branch.hpp"
#include "norms.hpp"
#include "one_mass.hpp"
#include "problems/forced_response.hpp"
#include "small_model.hpp"
#include "small_problems.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr NewtonSettings tight{1e-10, 1e-11, 30};

HarmonicSystem small_system(double load = 1) {
  return HarmonicSystem(scaled(small_preloaded(PETSC_COMM_WORLD), 0.05, {}), 3, 64, course({0, load}));
}

UniqueVec unit_omega(const HarmonicSystem &system) {
  UniqueVec e = system.unknowns();
  if (system.layout().owns_omega()) check(VecSetValue(e, system.layout().omega_row(), 1, INSERT_VALUES), "");
  check(VecAssemblyBegin(e), ""), check(VecAssemblyEnd(e), "");
  return e;
}

} // namespace

TEST(Corrector, fixed_frequency_solution_satisfies_the_equations) {
  HarmonicSystem system = small_system();
  ForcedResponse problem(system);
  Corrector corrector(problem, tight);
  const UniqueVec e = unit_omega(system);
  UniqueVec y = system.unknowns(), f = system.unknowns();
  check(VecAXPY(y, 0.7, e), "");
  const auto outcome = corrector.solve(y, e, 0.7);
  ASSERT_TRUE(outcome.converged) << outcome.why;
  EXPECT_DOUBLE_EQ(system.parameter_in(y), 0.7);
  system.residual(y, f);
  EXPECT_LT(norm(f), 1e-10);
}

TEST(Corrector, leaves_the_point_alone_when_it_fails) {
  HarmonicSystem system = small_system();
  ForcedResponse problem(system);
  Corrector corrector(problem, {1e-10, 1e-11, 1}); // one iteration is not enough
  const UniqueVec e = unit_omega(system);
  UniqueVec y = system.unknowns();
  check(VecAXPY(y, 0.7, e), "");
  const auto outcome = corrector.solve(y, e, 0.7);
  EXPECT_FALSE(outcome.converged);
  EXPECT_FALSE(outcome.why.empty());
  EXPECT_DOUBLE_EQ(norm(y), 0.7);
}

TEST(Corrector, gives_up_beyond_its_reach) {
  HarmonicSystem system = small_system();
  ForcedResponse problem(system);
  Corrector corrector(problem, tight);
  const UniqueVec e = unit_omega(system);
  UniqueVec y = system.unknowns();
  check(VecAXPY(y, 0.7, e), "");
  const auto outcome = corrector.solve(y, e, 0.7, {false, 0, 1e-3});
  EXPECT_EQ(outcome.why, "Newton runs far away");
  EXPECT_EQ(outcome.newton, 1);
  EXPECT_DOUBLE_EQ(norm(y), 0.7);
  EXPECT_TRUE(corrector.solve(y, e, 0.7, {false, 0, 1e3}).converged);
}

namespace {

// atan(x) = 0.5, whose linear solves all leave more than was asked, as they say.
struct Inexact : SmallProblem {
  struct Jacobian : SmallJacobian {
    using SmallJacobian::SmallJacobian;
    LinearEffort take_effort(int) override { return {1, 1}; }
  };
  Equations equations{1, [](const double *y, double *f) { f[0] = std::atan(y[0]) - 0.5; },
                      [](const double *y, double *J) { J[0] = 1 / (1 + y[0] * y[0]), J[1] = 0; }};
  Inexact() : SmallProblem({}) {}
  UniqueVec unknowns() const override { return SmallProblem(equations).unknowns(); }
  void residual(Vec y, Vec f) override { SmallProblem(equations).residual(y, f); }
  std::unique_ptr<BorderedJacobian> jacobian() override { return std::make_unique<Jacobian>(equations); }
};

} // namespace

TEST(Corrector, gives_up_where_solves_are_inexact_or_iterations_are_used_up_if_told_so) {
  Inexact problem;
  Corrector corrector(problem, tight);
  UniqueVec y = problem.unknowns(), e = problem.unknowns();
  set_parameter(e, 1);
  const auto exact = corrector.solve(y, e, 0, {.exact = true});
  EXPECT_EQ(exact.why, "linear solves leave more than was asked");
  EXPECT_GT(exact.inexact, 0);
  const auto once = corrector.solve(y, e, 0, {.most = 1});
  EXPECT_EQ(once.why, "too many Newton iterations");
  EXPECT_EQ(once.newton, 1);
  const auto outcome = corrector.solve(y, e, 0);
  EXPECT_TRUE(outcome.converged) << outcome.why;
  EXPECT_GT(outcome.inexact, outcome.newton);
}

// atan(x) = 0 from 3: each iteration is farther off than the one before.
TEST(Corrector, gives_up_where_the_residual_keeps_growing) {
  SmallProblem problem({1, [](const double *y, double *f) { f[0] = std::atan(y[0]); },
                        [](const double *y, double *J) { J[0] = 1 / (1 + y[0] * y[0]), J[1] = 0; }});
  Corrector corrector(problem, tight);
  UniqueVec y = problem.unknowns(), e = problem.unknowns();
  check(VecSetValue(y, 0, 3, INSERT_VALUES), "");
  set_parameter(e, 1);
  EXPECT_GT(corrector.solve(y, e, 0).newton, 4);
  const auto outcome = corrector.solve(y, e, 0, {.steady = true});
  EXPECT_EQ(outcome.why, "Newton runs astray");
  EXPECT_EQ(outcome.newton, 3);
}

TEST(Corrector, counts_one_linear_iteration_each_where_the_solver_is_direct) {
  SmallProblem problem({1, [](const double *y, double *f) { f[0] = std::atan(y[0]) - 0.5; },
                        [](const double *y, double *J) { J[0] = 1 / (1 + y[0] * y[0]), J[1] = 0; }});
  Corrector corrector(problem, tight);
  UniqueVec y = problem.unknowns(), e = problem.unknowns(), t = problem.unknowns();
  check(VecSetValue(y, 0, 1, INSERT_VALUES), "");
  set_parameter(e, 1);
  const auto outcome = corrector.solve(y, e, 0);
  ASSERT_TRUE(outcome.converged) << outcome.why;
  EXPECT_GT(outcome.newton, 2);
  EXPECT_EQ(outcome.linear, outcome.newton);
  EXPECT_EQ(corrector.tangent(t).linear, 0); // of a tangent those are not told
}

TEST(Corrector, rounding_is_what_last_bits_of_the_unknowns_leave) {
  constexpr int n = 8;
  const double stiffness = 1e6;
  SmallProblem problem({n,
                        [=](const double *y, double *f) {
                          for (int i = 0; i < n; ++i) f[i] = stiffness * (y[i] - 1);
                        },
                        [=](const double *, double *J) {
                          for (int i = 0; i < n; ++i) J[i * (n + 1) + i] = stiffness;
                        }});
  SolveCounts counts;
  const double rounding = Curve(problem, tight, 1, true, counts).rounding(0.5);
  EXPECT_GE(rounding, stiffness * PETSC_MACHINE_EPSILON / 2);
  EXPECT_LE(rounding, stiffness * PETSC_MACHINE_EPSILON * n);
}

// Stiff contacts that open: where it runs in a circle no number of iterations would help.
TEST(Corrector, gives_up_in_a_circle) {
  ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  std::vector<ContactPoint> contact = small_contact(model);
  for (ContactPoint &point : contact) point.kn *= 200;
  std::string note;
  const std::vector<double> zero(model.own_contact_dofs(), 0.0);
  const PreloadedModel stiff = contact_preload(std::move(model), std::move(contact), zero, note);
  int circles = 0;
  for (int i = 0; i < 40 && circles == 0; ++i) {
    const double load = std::pow(10, 0.05 * i), omega = 0.9;
    HarmonicSystem system(scaled(stiff, 0.05, {}), 3, 64, course({0, load}));
    ForcedResponse problem(system);
    Corrector corrector(problem, tight);
    const UniqueVec e = unit_omega(system);
    UniqueVec y = system.unknowns();
    check(VecAXPY(y, omega, e), "");
    const auto outcome = corrector.solve(y, e, omega);
    if (outcome.why != "Newton runs in a circle") continue;
    ++circles;
    EXPECT_LT(outcome.newton, tight.max_iterations);
    EXPECT_DOUBLE_EQ(norm(y), omega);
    EXPECT_GT(outcome.residual, tight.residual_tolerance);
  }
  EXPECT_EQ(circles, 1);
}

// The assembled border against bordering by block elimination: two solves with the Jacobian at fixed Omega.
TEST(Corrector, tangent_equals_block_elimination) {
  HarmonicSystem system = small_system();
  ForcedResponse problem(system);
  Corrector corrector(problem, tight);
  const UniqueVec e = unit_omega(system);
  UniqueVec y = system.unknowns();
  check(VecAXPY(y, 0.7, e), "");
  ASSERT_TRUE(corrector.solve(y, e, 0.7).converged);

  UniqueVec by_omega = system.unknowns(), border = system.unknowns(), t = system.unknowns(), wanted = system.unknowns();
  ASSERT_TRUE(corrector.tangent(by_omega).found); // dX/dOmega; its last entry is 1
  EXPECT_NEAR(system.parameter_in(by_omega), 1, 1e-14);
  PetscInt first, last;
  check(VecGetOwnershipRange(border, &first, &last), "");
  for (PetscInt row = first; row < last; ++row) check(VecSetValue(border, row, wave(row, 2), INSERT_VALUES), "");
  check(VecAssemblyBegin(border), ""), check(VecAssemblyEnd(border), "");
  double target;
  check(VecDot(border, y, &target), "");
  ASSERT_TRUE(corrector.solve(y, border, target).converged); // the same point on another plane
  ASSERT_TRUE(corrector.tangent(t).found);
  double along;
  check(VecDot(border, by_omega, &along), "");
  check(VecAXPY(wanted, 1 / along, by_omega), ""); // the null vector is one, only its length differs
  const double size = norm(wanted);
  check(VecAXPY(wanted, -1, t), "");
  EXPECT_LT(norm(wanted), 1e-8 * size); // both Jacobians were taken within eps_x of the point
}

TEST(Branch, hits_its_end_and_the_frequencies_asked_for) {
  for (const double to : alone() ? std::vector{1.6, 0.5} : std::vector{1.25}) { // either direction from 1.0
    HarmonicSystem system = small_system();
    UniqueVec y = system.unknowns();
    std::vector<double> omegas;
    const double named = to > 1 ? 1.2345 : 0.7654;
    const BranchObserver observer{[&](const BranchPoint &point) { omegas.push_back(point.parameter); },
                                  [](const BranchEvent &) {}};
    const auto summary = follow_branch(system, tight, {1.0, to, 0.05, true, 2000, {named}}, y, observer);
    EXPECT_EQ(summary.end, BranchSummary::End::arrived) << summary.why;
    EXPECT_EQ(omegas.front(), 1.0);
    EXPECT_EQ(omegas.back(), to);
    EXPECT_EQ(std::count(omegas.begin(), omegas.end(), named), 1);
    EXPECT_EQ(summary.counts.points, static_cast<int>(omegas.size()));
  }
}

TEST(Branch, equal_ends_give_one_point) {
  HarmonicSystem system = small_system();
  UniqueVec y = system.unknowns();
  int points = 0;
  const BranchObserver observer{[&](const BranchPoint &) { ++points; }, [](const BranchEvent &) {}};
  EXPECT_EQ(follow_branch(system, tight, {0.8, 0.8, 0.05, true, 2000, {}}, y, observer).end,
            BranchSummary::End::arrived);
  EXPECT_EQ(points, 1);
}

TEST(Branch, stops_at_max_points) {
  HarmonicSystem system = small_system();
  UniqueVec y = system.unknowns();
  int points = 0;
  const BranchObserver observer{[&](const BranchPoint &) { ++points; }, [](const BranchEvent &) {}};
  EXPECT_EQ(follow_branch(system, tight, {0.5, 3, 0.05, false, 7, {}}, y, observer).end,
            BranchSummary::End::max_points);
  EXPECT_EQ(points, 7);
}

// One mass on one unilateral spring, hung so that it lifts off: the resonance bends over, two folds must be passed.
// Sampling would put more of them on the curve.
TEST(Branch, passes_and_counts_turning_points) {
  HarmonicSystem system = one_mass({40, 40, 40}, {0, 0, -800}, {0, 0, 100},
                                   {Law::coulomb, 120, {30, 30}, {0.3, 0.3}, 0}, 0.01, 5, {0, 0, 1});
  UniqueVec y = system.unknowns();
  std::vector<double> omegas;
  int folds = 0;
  const BranchObserver observer{[&](const BranchPoint &point) { omegas.push_back(point.parameter); },
                                [&](const BranchEvent &event) { folds += event.kind == BranchEvent::Kind::fold; }};
  const auto summary = follow_branch(system, tight, {5, 16, 0.5, true, 2000, {}}, y, observer);
  EXPECT_EQ(summary.end, BranchSummary::End::arrived) << summary.why;
  EXPECT_EQ(summary.counts.folds, 2);
  EXPECT_EQ(folds, 2);
  bool backwards = false;
  for (std::size_t i = 1; i < omegas.size(); ++i) backwards = backwards || omegas[i] < omegas[i - 1];
  EXPECT_TRUE(backwards);
}

// A singular Jacobian must not spoil the solves after it (PETSc 3.18 would skip their factorisation silently).
TEST(Corrector, recovers_from_a_singular_jacobian) {
  HarmonicSystem system = small_system();
  ForcedResponse problem(system);
  Corrector corrector(problem, tight);
  const UniqueVec e = unit_omega(system), nothing = system.unknowns();
  UniqueVec y = system.unknowns();
  check(VecAXPY(y, 0.7, e), "");
  EXPECT_FALSE(corrector.solve(y, nothing, 0).converged); // a border of zeros
  EXPECT_TRUE(corrector.solve(y, e, 0.7).converged);
}
