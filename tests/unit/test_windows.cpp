// Contacts that are open for most of the period: what they see of a motion, and the Jacobian solved with by that.
#include <gtest/gtest.h>

#include <cmath>

#include "modal/window.hpp"
#include "one_point.hpp"
#include "small_system.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr int harmonics = 40, width = 2 * harmonics + 1;

// A motion with waves that die out, below the gap but for its crests.
std::vector<double> bouncing(int seed, double deep) {
  std::vector<double> X(3 * width);
  for (int d = 0; d < 3; ++d)
    for (int i = 1; i < width; ++i) X[d * width + i] = wave(seed, d * width + i) * std::exp(-0.2 * ((i + 1) / 2));
  X[2 * width] = -deep;
  return X;
}

double wave_at(int number, double theta) {
  const int k = (number + 1) / 2;
  return number == 0 ? M_SQRT1_2 : number % 2 ? std::cos(k * theta) : std::sin(k * theta);
}

MaskMeans mask_of(const std::vector<std::pair<double, double>> &spans) { // in closed form
  MaskMeans mask;
  mask.reset(harmonics);
  for (const auto &[begin, end] : spans) {
    mask.cosine[0] += (end - begin) / (2 * M_PI);
    for (int m = 1; m < width; ++m) {
      mask.cosine[m] += (std::sin(m * end) - std::sin(m * begin)) / (2 * M_PI * m);
      mask.sine[m] += (std::cos(m * begin) - std::cos(m * end)) / (2 * M_PI * m);
    }
  }
  return mask;
}

} // namespace

TEST(Window, few_waves_tell_all_of_them_while_it_is_closed) {
  for (const auto &spans : {std::vector<std::pair<double, double>>{{1, 1.2}}, {{0.3, 0.9}, {4, 4.05}}, {{6, 6.5}}}) {
    const Window window = window_of(mask_of(spans), width);
    const std::size_t few = window.waves.size();
    double closed = 0;
    for (const auto &[begin, end] : spans) closed += (end - begin) / (2 * M_PI);
    EXPECT_LT(few, closed * width + 12 * spans.size());
    ASSERT_EQ(window.weights.size(), few * width);
    for (int i = 0; i < width; ++i) {
      double square = 0; // of what is left, as the mean over the window
      for (const auto &[begin, end] : spans)
        for (int step = 0; step < 200; ++step) {
          const double theta = begin + (step + 0.5) / 200 * (end - begin);
          double left = wave_at(i, theta);
          for (std::size_t q = 0; q < few; ++q) left -= window.weights[q * width + i] * wave_at(window.waves[q], theta);
          square += left * left * (end - begin) / (2 * M_PI * closed) / 200;
        }
      EXPECT_LT(std::sqrt(square), 1e-5) << i;
    }
    EXPECT_TRUE(window_of(mask_of(spans), few - 1).waves.empty());
  }
}

TEST(Window, derivative_of_the_force_is_that_of_the_few_waves) {
  for (int seed = 0; seed < 8; ++seed)
    for (const Law law : {Law::coulomb, Law::unilateral, Law::bilateral}) {
      ContactPoint point = typical;
      point.law = law;
      ContactForces forces({point}, {standstill(point, {0.3, -0.2, 0.3})}, harmonics, exactly);
      std::vector<double> G(3 * width);
      forces.evaluate(bouncing(seed, 3).data(), G.data());
      const Window window =
          law == Law::bilateral ? whole_window(harmonics) : window_of(forces.derivative(0).closed, width);
      const int few = static_cast<int>(window.waves.size());
      ASSERT_GT(few, 0);
      if (law != Law::bilateral) EXPECT_LT(few, width / 2);
      const std::size_t places = block_places(law).size();
      std::vector<double> whole(places * width * width), part(places * few * few);
      forces.write(0, whole.data());
      forces.write(0, window.waves.data(), few, part.data());
      const auto scale = [](int i) { return i == 0 ? M_SQRT1_2 : 1; };
      double most = 0, largest = 0;
      for (std::size_t b = 0; b < places; ++b)
        for (int i = 0; i < few; ++i)
          for (int j = 0; j < few; ++j) {
            const double there = whole[b * width * width + window.waves[i] * width + window.waves[j]];
            EXPECT_NEAR(part[(b * few + i) * few + j], there, 1e-13 * point.kn);
          }
      for (std::size_t b = 0; b < places; ++b)
        for (int i = 0; i < width; ++i)
          for (int j = 0; j < width; ++j) {
            double sum = 0;
            for (int p = 0; p < few; ++p)
              for (int q = 0; q < few; ++q)
                sum += window.weights[p * width + i] * part[(b * few + p) * few + q] * scale(window.waves[p]) /
                       scale(window.waves[q]) * window.weights[q * width + j];
            const double there = whole[b * width * width + i * width + j] * scale(i) / scale(j);
            most = std::max(most, std::abs(sum - there)), largest = std::max(largest, std::abs(there));
          }
      EXPECT_LT(most, 1e-4 * largest) << seed;
    }
}

namespace {

struct Solved {
  double rough, precise, work, open;
  int sign;
};

// Solves with the Jacobian of a motion that leaves the joint open but for crests, roughly and to 1e-10.
Solved solve(HarmonicSystem &system, int seed, double deep, int border_seed) {
  const Layout &layout = system.layout();
  std::vector<double> all(static_cast<std::size_t>(layout.dofs()) * width);
  for (PetscInt i = 0; i < layout.modes * width; ++i)
    all[i] = wave(seed, static_cast<int>(i)) * std::exp(-0.1 * (i % width));
  for (PetscInt p = 0; p < layout.points; ++p) {
    const std::vector<double> X = bouncing(seed + 3 * static_cast<int>(p), deep);
    std::copy(X.begin(), X.end(), all.begin() + (layout.modes + 3 * p) * width);
  }
  UniqueVec y = vector_of(system, 0, 3, 1.3);
  set_coefficients(layout, all, y);
  const UniqueVec border = vector_of(system, 1, border_seed, 0.2), r = vector_of(system, 1, 9, 0.4);
  UniqueVec x = system.unknowns(), rough = system.unknowns(), product = system.unknowns();
  const UniqueMat J = system.matrix();
  UniqueKSP ksp;
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
  system.set_up(ksp, J);
  system.jacobian(y, border, J);
  check(KSPSetOperators(ksp, J, J), "");
  check(KSPSetTolerances(ksp, 0.5, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
  check(KSPSolve(ksp, r, rough), "");
  const double work = system.take_solver_work(J);
  const int sign = system.determinant_sign(ksp);
  check(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
  check(KSPSolve(ksp, r, x), "");
  check(MatMult(J, x, product), "");
  double open = 0;
  for (const Activity &did : system.activity()) open += did.open;
  MPI_Allreduce(MPI_IN_PLACE, &open, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return {relative_difference(rough, x), relative_difference(product, r), work, open / layout.points, sign};
}

} // namespace

TEST(Windows, solve_with_the_jacobian_and_tell_its_sign) {
  const HarmonicSystem like = small_system(LinearForm::modal), assembled_like = small_system(LinearForm::assembled);
  const Option none("-hb_modal_ksp_max_it", "1"); // in the modes
  int sum = 0;
  for (int seed = 0; seed < 20; ++seed) {
    HarmonicSystem system(like, harmonics, exactly), assembled(assembled_like, harmonics, exactly);
    const double deep = seed % 5 == 4 ? 60 : 2.4 + 0.4 * (seed % 3); // 60: always open
    const Solved by_windows = solve(system, seed, deep, seed / 2 + 7),
                 by_mumps = solve(assembled, seed, deep, seed / 2 + 7);
    EXPECT_GT(by_windows.open, 0.8);
    EXPECT_LT(by_windows.rough, 1e-3) << seed;
    EXPECT_LT(by_windows.precise, 1e-9) << seed;
    EXPECT_LT(by_windows.work, std::pow(9 * width, 3) / 3)
        << seed; // factors of all coefficients: more than thrice that
    EXPECT_EQ(by_windows.sign, by_mumps.sign) << seed;
    sum += by_windows.sign;
  }
  EXPECT_LT(std::abs(sum), 18); // both signs are met
}

// Where all coefficients are too many to be factored and GMRES in the modes fails.
TEST(Windows, help_where_nothing_else_does) {
  const HarmonicSystem like = small_system(LinearForm::modal);
  const Option none("-hb_modal_ksp_max_it", "1"), few("-hb_factors_most", "700");
  for (const double deep : {1.6, 1.8, 2.0, 2.2}) {
    HarmonicSystem system(like, harmonics, exactly);
    const Solved by_windows = solve(system, 3, deep, 7);
    EXPECT_LT(by_windows.rough, 1e-3) << deep;
    EXPECT_LT(by_windows.precise, 1e-9) << deep << " open " << by_windows.open;
  }
}
