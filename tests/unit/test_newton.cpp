// Newton's method on one equation against the same by hand, and what its linear solver is asked for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "continuation/corrector.hpp"
#include "told_solves.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double at = 0.75; // p, which nothing depends on

Equations equation(double (*f)(double), double (*slope)(double)) {
  return one([f](double x, double) { return f(x); }, [slope](double x, double) { return slope(x); },
             [](double, double) { return 0.0; });
}

double chaotic(double x) { return x * x * x - 2 * x + 2; } // from 0 to 1 and back, or to -1.77
double chaotic_slope(double x) { return 3 * x * x - 2; }
double root(double x) { return std::copysign(std::sqrt(std::abs(x)), x); } // from x to -x and back
double root_slope(double x) { return 0.5 / std::sqrt(std::abs(x)); }
double square(double x) { return x * x - 1; }
double square_slope(double x) { return 2 * x; }

struct Solved {
  int newton = 0;
  double x = 0, residual = 0;
  std::string why = ""; // not converged
};

// As Corrector's comments say.
Solved by_hand(double (*f)(double), double (*slope)(double), double x, const NewtonSettings &settings,
               const NewtonEffort &effort) {
  std::vector<std::pair<double, double>> met{{std::abs(f(x)), 0}};
  for (int newton = 1;; ++newton) {
    const double step = std::abs(f(x) / slope(x));
    x -= f(x) / slope(x);
    const double residual = std::abs(f(x));
    const auto outcome = [&](const char *why) { return Solved{newton, x, residual, why}; };
    if (step < settings.step_tolerance * std::hypot(x, at) && residual < settings.residual_tolerance)
      return outcome("");
    if (newton == effort.most) return outcome("too many Newton iterations");
    const std::size_t n = met.size();
    if (effort.steady && n > 2 && residual > met[n - 1].first && met[n - 1].first > met[n - 2].first)
      return outcome("Newton runs astray");
    if (effort.reach != 0 && step > effort.reach) return outcome("Newton runs far away");
    for (const auto &[r, s] : met)
      if (std::abs(residual - r) < 0.02 * residual && std::abs(step - s) < 0.02 * step)
        return outcome("Newton runs in a circle");
    if (newton == settings.max_iterations) return outcome("Newton did not converge within newton.max_iterations");
    met.push_back({residual, step});
  }
}

void expect_as_by_hand(double (*f)(double), double (*slope)(double), double x, const NewtonSettings &settings,
                       const NewtonEffort &effort, std::vector<std::string> &met) {
  ToldProblem problem(equation(f, slope));
  Corrector corrector(problem, settings);
  const UniqueVec y = problem.vector({x, at}), e = problem.vector({0, 1});
  const Solved wanted = by_hand(f, slope, x, settings, effort);
  const auto found = corrector.solve(y, e, at, effort);
  EXPECT_EQ(found.converged, wanted.why.empty()) << x;
  EXPECT_EQ(found.why, wanted.why) << x;
  EXPECT_EQ(found.newton, wanted.newton) << x;
  EXPECT_NEAR(found.residual, wanted.residual, 1e-6 * (1e-8 + wanted.residual)) << x;
  EXPECT_NEAR(values(y)[0], found.converged ? wanted.x : x, 1e-9) << x;
  met.push_back(wanted.why);
}

} // namespace

TEST(Newton, is_given_up_where_and_as_its_settings_say) {
  std::vector<std::string> met;
  const NewtonEffort efforts[] = {{}, {.most = 2}, {.reach = 1.5}, {.steady = true}};
  for (const NewtonEffort &effort : efforts)
    for (int i = 0; i < 40; ++i)
      expect_as_by_hand(chaotic, chaotic_slope, 3 - 0.1503 * i, {1e-8, 1e-8, 12}, effort, met);
  for (const double step : {1e-1, 1e-3, 1e-8})
    for (const double residual : {1e-1, 1e-4, 1e-12})
      for (const double x : {1.0, 1.5, 4.0}) expect_as_by_hand(square, square_slope, x, {step, residual, 20}, {}, met);
  expect_as_by_hand(root, root_slope, 2, {1e-8, 1e-8, 30}, {}, met);
  for (const char *why : {"", "too many Newton iterations", "Newton runs far away", "Newton runs astray",
                          "Newton runs in a circle", "Newton did not converge within newton.max_iterations"})
    EXPECT_GT(std::count(met.begin(), met.end(), why), 0) << why;
}

// Where it goes slowly towards a solution, residuals and corrections become smaller by 1 and 2 per cent.
TEST(Newton, slow_progress_is_no_circle) {
  const auto f = [](double x) { return std::copysign(std::pow(std::abs(x), 0.505), x); };
  const auto slope = [](double x) { return 0.505 * std::pow(std::abs(x), -0.495); };
  std::vector<std::string> met;
  expect_as_by_hand(f, slope, 1, {1e-8, 1e-8, 20}, {}, met);
  EXPECT_EQ(met[0], "Newton did not converge within newton.max_iterations");
}

TEST(Newton, a_residual_that_is_no_number_ends_it) {
  ToldProblem problem(equation([](double x) { return std::sqrt(x) + 1; }, [](double x) { return 0.5 / std::sqrt(x); }));
  for (const double x : {1, -1}) { // the first becomes negative
    const UniqueVec y = problem.vector({x, at}), e = problem.vector({0, 1});
    const auto outcome = Corrector(problem, {1e-8, 1e-8, 20}).solve(y, e, at);
    EXPECT_FALSE(outcome.converged);
    EXPECT_EQ(outcome.why, "the residual became NaN or infinite");
    EXPECT_EQ(values(y)[0], x);
  }
}

TEST(Newton, a_line_search_leads_out_of_a_circle_and_is_no_habit) {
  ToldProblem problem(equation(root, root_slope));
  Corrector corrector(problem, {1e-8, 1e-8, 60});
  const UniqueVec e = problem.vector({0, 1});
  for (int i = 0; i < 2; ++i) {
    const UniqueVec y = problem.vector({2, at});
    EXPECT_EQ(corrector.solve(y, e, at).why, "Newton runs in a circle");
    EXPECT_NE(corrector.solve(y, e, at, {.line_search = true}).why, "Newton runs in a circle");
  }
  ToldProblem other(equation([](double x) { return std::atan(x); }, [](double x) { return 1 / (1 + x * x); }));
  const UniqueVec far = other.vector({3, at});
  Corrector searching(other, {1e-8, 1e-8, 60});
  EXPECT_FALSE(searching.solve(far, e, at).converged);
  EXPECT_TRUE(searching.solve(far, e, at, {.line_search = true}).converged);
}

TEST(Newton, hears_options_of_its_prefix) {
  ToldProblem problem(equation(square, square_slope));
  const UniqueVec e = problem.vector({0, 1});
  int newton[2];
  for (const bool damped : {false, true}) {
    const UniqueVec y = problem.vector({2, at});
    if (damped) check(PetscOptionsSetValue(nullptr, "-hb_snes_linesearch_damping", "0.5"), "");
    newton[damped] = Corrector(problem, {1e-4, 1e-4, 60}).solve(y, e, at).newton;
  }
  check(PetscOptionsClearValue(nullptr, "-hb_snes_linesearch_damping"), "");
  EXPECT_LT(newton[0], 7);
  EXPECT_GT(newton[1], 9); // half of each step: an octave an iteration
}

TEST(Newton, linear_solves_are_asked_for_what_each_purpose_needs) {
  ToldProblem problem(circle());
  Told &told = problem.told;
  Corrector corrector(problem, {1e-10, 1e-10, 30});
  const UniqueVec y = problem.vector({0.5, 0.6}), e = problem.vector({0, 1}), r = problem.vector({1, 0}),
                  out = problem.unknowns();
  const auto last_of = [&](auto &&work) {
    told.asked.clear();
    work();
    EXPECT_FALSE(told.asked.empty());
    for (const double one : told.asked) EXPECT_EQ(one, told.asked.back());
    return told.asked.back();
  };
  for (int i = 0; i < 2; ++i) {
    corrector.tangent_accuracy = i == 0 ? Corrector::usual_accuracy : Corrector::high_accuracy;
    EXPECT_EQ(last_of([&] { corrector.solve(y, e, 0.6 + 0.1 * i); }), 0.5);
    EXPECT_EQ(last_of([&] { corrector.tangent(out); }), i == 0 ? 1e-6 : 1e-10);
    EXPECT_EQ(last_of([&] { corrector.correct(r, out); }), 0.2);
    EXPECT_EQ(last_of([&] { corrector.tangent_at(y, e, out); }), i == 0 ? 1e-6 : 1e-10);
  }
}

TEST(Newton, counts_what_linear_solves_took_and_tells_the_solver_where_it_begins) {
  ToldProblem problem(circle());
  Told &told = problem.told;
  told.memory = 11;
  Corrector corrector(problem, {1e-10, 1e-10, 30});
  const UniqueVec y = problem.vector({0.5, 0.6}), e = problem.vector({0, 1}), t = problem.unknowns();
  for (int i = 1; i < 3; ++i) {
    const auto outcome = corrector.solve(y, e, 0.6 + 0.05 * i);
    EXPECT_GT(outcome.newton, 1);
    EXPECT_EQ(outcome.linear, 3 * outcome.newton);
    EXPECT_EQ(outcome.inexact, outcome.newton);
    EXPECT_EQ(static_cast<int>(told.begun.size()), i);
    EXPECT_EQ(told.begun.back(), 11);
    for (const auto &direction : {corrector.tangent(t), corrector.correct(y, t), corrector.tangent_at(y, e, t)}) {
      EXPECT_TRUE(direction.found);
      EXPECT_EQ(direction.linear, 3);
      EXPECT_EQ(direction.inexact, 1);
    }
  }
  EXPECT_EQ(corrector.solve(y, e, 0.8, {.exact = true}).why, "linear solves leave more than was asked");
}

TEST(Newton, a_factorisation_without_room_gets_a_second_chance) {
  for (const int failures : {1, 2})
    for (const bool for_memory : {true, false}) {
      ToldProblem problem(circle());
      Told &told = problem.told;
      told.fail_at = 1, told.fail_until = 1 + (failures == 1 ? 1 : 100); // of the second iteration
      if (!for_memory) told.reason = PC_FACTOR_NUMERIC_ZEROPIVOT;
      Corrector corrector(problem, {1e-10, 1e-10, 30});
      const UniqueVec y = problem.vector({0.5, 0.6}), e = problem.vector({0, 1});
      const auto outcome = corrector.solve(y, e, 0.6);
      const bool converges = failures == 1 && for_memory;
      EXPECT_EQ(outcome.converged, converges);
      EXPECT_EQ(told.recoveries, for_memory && failures == 2 ? 2 : 1);
      EXPECT_EQ(outcome.why, converges ? "" : "told to fail");
      if (!converges) continue;
      ToldProblem other(circle());
      const UniqueVec z = other.vector({0.5, 0.6});
      const auto plain = Corrector(other, {1e-10, 1e-10, 30}).solve(z, e, 0.6);
      EXPECT_EQ(outcome.newton, 1 + plain.newton); // with those in vain
      EXPECT_EQ(outcome.inexact, told.solves);
      EXPECT_EQ(outcome.linear, 3 * told.solves);
      EXPECT_EQ(values(y), values(z));
    }
}

TEST(Newton, what_cannot_be_solved_is_told_and_the_solver_made_fit_again) {
  ToldProblem problem(circle());
  Told &told = problem.told;
  Corrector corrector(problem, {1e-10, 1e-10, 30});
  const UniqueVec y = problem.vector({0.8, 0.6}), e = problem.vector({0, 1}), t = problem.unknowns();
  ASSERT_TRUE(corrector.solve(y, e, 0.6).converged);
  const auto direction = corrector.tangent(t);
  EXPECT_EQ(direction.sign, 1); // of 2 x
  EXPECT_NEAR(values(t)[0], -0.75, 1e-12);
  EXPECT_TRUE(corrector.correct(problem.vector({1, 0}), t).found);
  EXPECT_NEAR(values(t)[0], 1 / 1.6, 1e-12);
  EXPECT_EQ(values(t)[1], 0);
  EXPECT_EQ(corrector.tangent_at(problem.vector({-2, 1}), e, t).sign, -1);
  EXPECT_NEAR(values(t)[0], 0.5, 1e-12);
  EXPECT_EQ(told.recoveries, 0);
  told.fail_at = 0, told.fail_until = 1000;
  EXPECT_FALSE(corrector.tangent_at(y, e, t).found);
  EXPECT_EQ(told.recoveries, 1);
  const auto failed = corrector.tangent(t);
  EXPECT_FALSE(failed.found);
  EXPECT_EQ(failed.sign, 0);
  EXPECT_EQ(told.recoveries, 1);
  EXPECT_FALSE(corrector.correct(y, t).found);
  EXPECT_EQ(told.recoveries, 2);
}

TEST(Newton, an_error_within_comes_out_as_it_is) {
  struct Throwing : ToldProblem {
    using ToldProblem::ToldProblem;
    void residual(Vec y, Vec f) override {
      if (evaluations-- == 0) throw InputError("told to throw");
      ToldProblem::residual(y, f);
    }
    int evaluations = -1;
  } problem(circle());
  Corrector corrector(problem, {1e-10, 1e-10, 30});
  const UniqueVec y = problem.vector({0.5, 0.6}), e = problem.vector({0, 1});
  for (const int evaluations : {0, 2}) {
    problem.evaluations = evaluations;
    try {
      corrector.solve(y, e, 0.6);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const InputError &error) {
      EXPECT_STREQ(error.what(), "told to throw");
    }
    EXPECT_EQ(values(y), (std::vector<double>{0.5, 0.6}));
  }
  problem.evaluations = -1;
  EXPECT_TRUE(corrector.solve(y, e, 0.6).converged);
}

// Of a sum no more than random signs leave; and nothing of the plane, which the last solve left by 5.
TEST(Newton, rounding_errors_are_of_the_equations_alone_and_have_no_order) {
  constexpr int n = 100;
  for (const bool alternating : {false, true}) {
    ToldProblem problem({n,
                         [=](const double *y, double *f) {
                           std::fill_n(f, n, 0.0);
                           for (int i = 0; i < n; ++i) f[0] += (alternating && i % 2 == 1 ? -1 : 1) * (y[i] - 1.5);
                         },
                         [](const double *, double *J) { std::fill_n(J, n * (n + 1), 1.0); }});
    problem.told.fail_at = 0, problem.told.fail_until = 1000;
    Corrector corrector(problem, {1e-10, 1e-10, 30});
    const UniqueVec y = problem.vector(std::vector<double>(n + 1, 1.5)), e = problem.unknowns();
    set_parameter(e, 1);
    EXPECT_FALSE(corrector.solve(y, e, 6.5).converged);
    EXPECT_LT(corrector.rounding(), n / 2 * PETSC_MACHINE_EPSILON);
  }
}

// Of y0 - yj, whose last bits count where they have other signs: of three choices of signs each is needed for one j.
TEST(Newton, rounding_errors_that_cancel_by_one_choice_of_signs_are_found_by_another) {
  for (const int j : {3, 2, 6}) {
    ToldProblem problem({7,
                         [=](const double *y, double *f) {
                           std::fill_n(f, 7, 0.0);
                           f[0] = y[0] - y[j];
                         },
                         [](const double *, double *J) { std::fill_n(J, 56, 1.0); }});
    problem.told.fail_at = 0, problem.told.fail_until = 1000;
    Corrector corrector(problem, {1e-10, 1e-10, 30});
    const UniqueVec y = problem.vector(std::vector<double>(8, 1.5)), e = problem.unknowns();
    set_parameter(e, 1);
    EXPECT_FALSE(corrector.solve(y, e, 6.5).converged);
    EXPECT_EQ(corrector.rounding(), 2 * PETSC_MACHINE_EPSILON) << j;
  }
}

// Of forces that cancel, as of a stiff link: s (x0 - x1) comes in steps of a thousand tolerances.
TEST(Newton, takes_what_rounding_leaves) {
  constexpr double s = 1e10;
  ToldProblem problem({2,
                       [](const double *y, double *f) {
                         f[0] = s * (y[0] - y[1]) + y[0] - 1.0 / 3, f[1] = s * (y[1] - y[0]) + y[1] - 1.0 / 7;
                       },
                       [](const double *, double *J) {
                         const double rows[] = {s + 1, -s, 0, -s, s + 1, 0};
                         std::copy_n(rows, 6, J);
                       }});
  Corrector corrector(problem, {1e-8, 1e-10, 30});
  const UniqueVec y = problem.vector({5, 7, at}), e = problem.unknowns();
  set_parameter(e, 1);
  const auto found = corrector.solve(y, e, at);
  EXPECT_TRUE(found.converged) << found.why;
  EXPECT_GT(found.residual, 1e-8);
  for (const int i : {0, 1}) EXPECT_NEAR(values(y)[i], 5.0 / 21, 1e-9);
}

// But not what a wrong Jacobian leaves, with steps as small.
TEST(Newton, takes_nothing_else_for_rounding) {
  ToldProblem problem(equation([](double x) { return x - 2; }, [](double) { return 1e12; }));
  Corrector corrector(problem, {1e-8, 1e-10, 30});
  const UniqueVec y = problem.vector({5, at}), e = problem.vector({0, 1});
  EXPECT_FALSE(corrector.solve(y, e, at).converged);
}
