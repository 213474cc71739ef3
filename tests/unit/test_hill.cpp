// Hill's method: what contact points answer to waves, and the exponents near zero.
#include <gtest/gtest.h>

#include "linear_motion.hpp"
#include "scenes.hpp"
#include "stability/contact_reading.hpp"
#include "stability/hill.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Complex = std::complex<double>;

DenseModel model_of(const Scene &s) {
  DenseModel model = dense_scene({s.point}, 1, 1, 0.05, 0);
  model.standstill = {s.rest};
  return model;
}

// Some slider came to rest where the motion just does not move it, which the linearisation knows and the history does
// not. Then nothing moves it all round.
bool shakes_down(const ContactReading &reading) {
  int runs[2]{}, holds[2]{};
  for (const Linearisation::Run &run : reading.linear(0)) ++runs[run.direction];
  for (const ContactHistory::Hold &hold : reading.history().holds) ++holds[hold.slider];
  for (int d = 0; d < 2; ++d) {
    if (runs[d] == holds[d]) continue;
    EXPECT_EQ(holds[d], 0);
    for (int i = 0; i < reading.history().intervals(); ++i) EXPECT_EQ(reading.history().interval(i)[d], Answer::spring);
    return true;
  }
  return false;
}

double worst(const std::vector<double> &a, const std::vector<double> &b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most / std::max(largest(b), 1e-3);
}

} // namespace

// Whole waves are what harmonic balance differentiates by.
TEST(Waves, whole_ones_give_the_derivative_of_harmonic_balance) {
  int compared = 0, held = 0;
  for (int number = 0; number < scenes; ++number) {
    const Scene s = scene(number);
    const DenseModel model = model_of(s);
    ContactReading reading(model, s.harmonics);
    reading.read(s.X);
    if (shakes_down(reading)) continue;
    const int n = coefficient_count(s.harmonics);
    std::vector<double> expected(block_places(s.point.law).size() * n * n);
    reading.linear(0).write(s.point, expected.data());
    ++compared, held += !reading.history().holds.empty();
    ASSERT_LT(worst(reading.answers(Waves::whole, s.harmonics), expected), 1e-9) << "scene " << number;
  }
  EXPECT_GT(compared, 0.8 * scenes);
  EXPECT_GT(held, 400);
}

// To the blocks for one lag it adds what makes them those of another, also far from the exponents that are sought.
TEST(SliderMemory, of_any_lag) {
  int held = 0;
  for (int number = 0; number < scenes; number += 3) {
    const Scene s = scene(number);
    const DenseModel model = model_of(s);
    ContactReading reading(model, s.harmonics);
    reading.read(s.X);
    held += !reading.history().holds.empty();
    for (const Waves waves : {Waves::whole, Waves::half})
      for (const double t : {-0.4, 0.1, 0.4, 3.0}) {
        const int w = wave_coefficients(waves, s.harmonics);
        const SliderMemory memory(reading.history().holds, waves, s.harmonics, 0);
        std::vector<double> p(3 * w), c(memory.size()), none(memory.size()), ct(memory.size()), pushed(3 * w);
        for (int i = 0; i < 3 * w; ++i) p[i] = std::sin(1.0 + 2 * i);
        Dense A(memory.size(), memory.size()); // c = follow(c t, p)
        for (int i = 0; i < memory.size(); ++i) {
          ct = none, ct[i] = t;
          memory.follow(ct.data(), pushed.data(), A.column(i));
          for (int j = 0; j < memory.size(); ++j) A(j, i) = (i == j) - A(j, i);
        }
        memory.follow(none.data(), p.data(), c.data());
        Factors factors;
        ASSERT_TRUE(memory.size() == 0 || factors.factor(A));
        if (memory.size() > 0) factors.solve(c.data());
        for (int i = 0; i < memory.size(); ++i) ct[i] = t * c[i];
        memory.push(ct.data(), pushed.data());
        std::vector<double> at_shift = reading.answers(waves, s.harmonics, exponent_shift),
                            expected = reading.answers(waves, s.harmonics, exponent_shift + t), forces[2];
        for (const bool there : {false, true}) {
          forces[there].assign(3 * w, 0);
          const double *next = (there ? expected : at_shift).data();
          for (const BlockPlace place : block_places(s.point.law))
            for (int i = 0; i < w; ++i)
              for (int j = 0; j < w; ++j) forces[there][place.row * w + i] += *next++ * p[place.column * w + j];
        }
        for (int i = 0; i < 3 * w; ++i) forces[0][i] -= pushed[i];
        ASSERT_LT(worst(forces[0], forces[1]), t < 1 ? 1e-6 : 1e-2) << "scene " << number << ", t = " << t;
      }
  }
  EXPECT_GT(held, 130);
}

// Half waves are odd harmonics of twice the period: the same motion, passed twice, answers to those.
TEST(Waves, half_ones_give_that_of_twice_the_period) {
  int held = 0;
  for (int number = 0; number < scenes; number += 2) {
    const Scene s = scene(number);
    const int H = s.harmonics, n = coefficient_count(H), twice = coefficient_count(2 * H);
    Scene passed_twice = s;
    passed_twice.harmonics = 2 * H;
    passed_twice.X.assign(3 * twice, 0.0);
    for (int d = 0; d < 3; ++d) {
      passed_twice.X[d * twice] = s.X[d * n];
      for (int k = 1; k <= H; ++k) {
        passed_twice.X[d * twice + cosine(2 * k)] = s.X[d * n + cosine(k)];
        passed_twice.X[d * twice + sine(2 * k)] = s.X[d * n + sine(k)];
      }
    }
    const DenseModel model = model_of(s);
    ContactReading reading(model, H), of_both(model, 2 * H);
    reading.read(s.X), of_both.read(passed_twice.X);
    if (shakes_down(reading) || shakes_down(of_both)) continue;
    held += !reading.history().holds.empty();
    const std::size_t places = block_places(s.point.law).size();
    std::vector<double> full(places * twice * twice), expected;
    of_both.linear(0).write(s.point, full.data());
    for (std::size_t b = 0; b < places; ++b)
      for (int i = 0; i < 2 * H; ++i)
        for (int j = 0; j < 2 * H; ++j) // odd harmonic 2k - 1 is wave k - 1/2
          expected.push_back(full[b * twice * twice + (i / 2 * 4 + 1 + i % 2) * twice + j / 2 * 4 + 1 + j % 2]);
    ASSERT_LT(worst(reading.answers(Waves::half, H), expected), 1e-8) << "scene " << number;
  }
  EXPECT_GT(held, 200);
}

namespace {

// Hill's problem of two modes and three coupled points under some motion.
class HillScene {
public:
  HillScene(Law law, int harmonics, double amplitude, int seed, bool coupled)
      : model_(with_modes(
            dense_scene(
                {{law, 5, {3, 4}, {0.4, 0.3}, 0}, {law, 4, {2, 2}, {0.5, 0.4}, -0.1}, {law, 6, {3, 3}, {0.2, 0.2}, 0}},
                2, 1, {0.04, 0.02}, 0.05),
            {1.3, 4})),
        hill_(model_), harmonics_(harmonics), reading_(model_, harmonics) {
    if (coupled) model_.C = dashpots(model_.dofs(), 0.2); // modes with one another, too
    std::mt19937 random(seed);
    const int few = 3, n = coefficient_count(few), w = coefficient_count(harmonics);
    std::vector<double> X(static_cast<std::size_t>(model_.dofs()) * w);
    for (int p = 0; p < 3; ++p) {
      const std::vector<double> of_point = random_motion(random, few, amplitude, 1);
      for (int d = 0; d < 3; ++d) std::copy_n(&of_point[d * n], n, &X[(model_.modes + 3 * p + d) * w]);
    }
    reading_.read(X);
  }

  Hill &hill(Waves waves, double omega) {
    hill_.assemble(waves, harmonics_, omega, reading_.answers(waves, harmonics_));
    return hill_;
  }
  const ContactReading &reading() const { return reading_; }
  const DenseModel &model() const { return model_; }

private:
  DenseModel model_;
  Hill hill_;
  int harmonics_;
  ContactReading reading_;
};

// All eigenvalues over Omega, by LAPACK, of the problem linearised in (p, p' / Omega).
std::vector<Complex> all_exponents(const Hill &hill, double omega) {
  const int N = hill.size();
  Dense mass(N, N), A(2 * N, 2 * N);
  std::vector<double> unit(N), rate(N), stiffness(N);
  for (int c = 0; c < N; ++c) unit.assign(N, 0), unit[c] = 1, hill.mass_times(unit.data(), mass.column(c));
  Factors factors;
  EXPECT_TRUE(factors.factor(mass));
  for (int c = 0; c < N; ++c) {
    unit.assign(N, 0), unit[c] = 1;
    hill.rate_times(unit.data(), rate.data());
    hill.stiffness_times(unit.data(), stiffness.data());
    factors.solve(rate.data()), factors.solve(stiffness.data());
    A(c, N + c) = 1;
    for (int r = 0; r < N; ++r) A(N + r, c) = -stiffness[r] / (omega * omega), A(N + r, N + c) = -rate[r] / omega;
  }
  return eigenvalues(A);
}

} // namespace

TEST(Hill, finds_every_exponent_near_zero) {
  int seen = 0;
  for (const auto &[omega, coupled] : {std::pair(0.6, false), {1.1, false}, {2.3, false}, {1.1, true}})
    for (const Waves waves : {Waves::whole, Waves::half}) {
      HillScene scene(Law::coulomb, 6, 0.4, 5, coupled);
      ASSERT_GT(scene.reading().history().intervals(), 6);
      Hill &hill = scene.hill(waves, omega);
      const Hill::Exponents found = hill.near_zero();
      ASSERT_TRUE(found.found);
      std::vector<Complex> near;
      const std::vector<Complex> all = all_exponents(hill, omega);
      for (const Complex s : all)
        if (std::abs(s.imag()) < 0.25 && std::abs(s) < 0.4) near.push_back(s);
      seen += static_cast<int>(near.size());
      EXPECT_LT(farthest(near, found.values), 1e-6);
      EXPECT_LT(farthest(found.values, all), 1e-6);
    }
  EXPECT_GT(seen, 20);
}

// Without sliders there is nothing that Hill's method neglects but waves beyond H: it goes to the truth with H.
TEST(Hill, agrees_with_the_map_over_one_period) {
  const double omega = 0.9;
  for (const bool coupled : {false, true}) {
    double error[2];
    for (const bool many : {false, true}) {
      HillScene scene(Law::unilateral, many ? 24 : 8, 0.6, 3, coupled);
      ASSERT_GT(scene.reading().history().intervals(), 4);
      std::vector<Complex> expected = Monodromy(scene.model()).multipliers(scene.reading().history(), omega), found;
      for (const Waves waves : {Waves::whole, Waves::half})
        for (const Complex s : scene.hill(waves, omega).near_zero().values)
          found.push_back((waves == Waves::half ? -1.0 : 1.0) * std::exp(2 * M_PI * s));
      error[many] = farthest(found, expected);
      EXPECT_GT(found.size(), 10u);
    }
    EXPECT_LT(error[0], 0.02);
    EXPECT_LT(error[1], error[0] / 5);
  }
}
