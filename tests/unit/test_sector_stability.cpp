// Stability of a travelling wave from one sector, against the whole ring of sectors, which knows no cyclic symmetry.
#include <gtest/gtest.h>

#include "harmonic/sector_modes.hpp"
#include "linear_motion.hpp"
#include "small_sector.hpp"
#include "stability/growth.hpp"
#include "stability/hill.hpp"
#include "stability/sector_stability.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Verdict = Stability::Verdict;

// A mode and a contact point a sector, under some wave that travels round.
class Ring {
public:
  Ring(int sectors, int engine_order, Law law, int harmonics, double damping, double amplitude)
      : harmonics_(harmonics), matrices_(make(sectors)) {
    sector_.sectors = sectors, sector_.engine_order = engine_order, sector_.modes = 1, sector_.points = 1;
    sector_.of_index = &matrices_, sector_.damping = damping;
    const ContactPoint point{law, 5, {3, 4}, {0.4, 0.3}, 0};
    of_sector_.modes = 1, of_sector_.points = 1;
    of_sector_.contact = {point}, of_sector_.standstill = {standstill(point, {0, 0, 0.5})};
    constexpr int few = 3, n = coefficient_count(few);
    const int w = coefficient_count(harmonics);
    std::mt19937 random(5);
    const std::vector<double> X = random_motion(random, few, amplitude, 1);
    motion_.assign(4 * w, 0.0);
    for (int d = 0; d < 3; ++d) std::copy_n(&X[d * n], n, &motion_[(1 + d) * w]);
  }

  const SectorEquations &sector() const { return sector_; }
  const DenseModel &points() const { return of_sector_; }
  const std::vector<double> &motion() const { return motion_; }

  // Modes first, then the contact points of all sectors. Sector j moves as Z_k exp(-2 pi i k EO j / N).
  DenseModel whole() const {
    const int N = sector_.sectors;
    DenseModel model;
    model.modes = N, model.points = N, model.damping = sector_.damping;
    const int n = model.dofs();
    model.K.assign(n * n, 0), model.M.assign(n * n, 0), model.C.assign(n * n, 0); // C: no modes of the whole
    for (int j = 0; j < N; ++j)
      for (int l = 0; l < N; ++l)
        for (int h = 0; h < N; ++h)
          for (int r = 0; r < 4; ++r)
            for (int c = 0; c < 4; ++c) {
              const int index = sector_.index(0, h), at = place(j, r) * n + place(l, c);
              const HermitianPencil &of = matrices_[std::abs(index)];
              const Complex turn = std::polar(1.0 / N, -2 * M_PI * h * (j - l) / N);
              const auto part = [&](Complex value) { return (turn * (index < 0 ? std::conj(value) : value)).real(); };
              model.K[at] += part(of.K(r, c)), model.M[at] += part(of.M(r, c));
            }
    model.contact.assign(N, of_sector_.contact[0]), model.standstill.assign(N, of_sector_.standstill[0]);
    return model;
  }
  std::vector<double> whole_motion(int harmonics) const {
    const int N = sector_.sectors, w = coefficient_count(harmonics_), wide = coefficient_count(harmonics);
    std::vector<double> q(4 * N * wide);
    for (int j = 0; j < N; ++j)
      for (int r = 0; r < 4; ++r) {
        const double *of = &motion_[r * w];
        double *to = &q[place(j, r) * wide];
        to[0] = of[0];
        for (int k = 1; k <= std::min(harmonics_, harmonics); ++k) {
          const Complex z =
              Complex(of[cosine(k)], -of[sine(k)]) * std::polar(1.0, -2 * M_PI * k * sector_.engine_order * j / N);
          to[cosine(k)] = z.real(), to[sine(k)] = -z.imag();
        }
      }
    return q;
  }

  // Of all shifts, over Omega.
  std::vector<Complex> exponents(double part, double omega, double strip, const std::vector<int> &shifts) const {
    ContactReading reading(of_sector_, harmonics_);
    reading.read(motion_);
    const ComplexWaves waves(part, harmonics_);
    const std::vector<Complex> blocks = answers(waves, reading, of_sector_.contact);
    SectorHill hill(sector_);
    std::vector<Complex> all;
    for (const int shift : shifts) {
      hill.assemble(shift, waves, omega, blocks, of_sector_.contact);
      const SectorHill::Exponents found = hill.near_zero(strip);
      EXPECT_TRUE(found.found);
      for (const Complex s : found.values) all.push_back(s + Complex(0, part));
    }
    return all;
  }

  std::vector<int> every_shift() const {
    std::vector<int> all(sector_.sectors);
    for (int n = 0; n < sector_.sectors; ++n) all[n] = n;
    return all;
  }

private:
  int place(int j, int r) const { return r == 0 ? j : sector_.sectors + 3 * j + r - 1; }

  static std::vector<HermitianPencil> make(int sectors) {
    std::vector<HermitianPencil> all;
    for (int h = 0; h <= sectors / 2; ++h) {
      HermitianPencil of{ComplexDense(4, 4), ComplexDense(4, 4)};
      const bool real = h == 0 || 2 * h == sectors;
      for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c) {
          const Complex k = entry(r, c, h), m = entry(r, c, 20 + h);
          const Complex coupling = r == 0 || c == 0 ? Complex(0) : real ? k.real() : k;
          of.K(r, c) = 0.2 * coupling + (r == c ? (r == 0 ? 1.5 + 0.4 * h : 2.0) : 0.0);
          of.M(r, c) = 0.05 * (r == 0 && c == 0 ? Complex(0) : real ? m.real() : m) + (r == c ? 1.0 : 0.0);
        }
      all.push_back(std::move(of));
    }
    return all;
  }

  int harmonics_;
  std::vector<HermitianPencil> matrices_;
  SectorEquations sector_;
  DenseModel of_sector_;
  std::vector<double> motion_;
};

// All eigenvalues over Omega of Hill's problem of the whole ring, by LAPACK.
std::vector<Complex> of_the_whole(const Hill &hill, double omega) {
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

// The same harmonics, and sliders that slip, stick and open: no difference but round-off.
TEST(SectorHill, has_the_exponents_of_the_whole_ring) {
  constexpr double omega = 0.9;
  for (const auto &[sectors, engine_order] : {std::pair(4, 1), {5, 2}, {4, 2}, {3, 0}}) {
    const Ring ring(sectors, engine_order, Law::coulomb, 3, 0.05, 0.5);
    const DenseModel model = ring.whole();
    ContactReading reading(model, 3);
    reading.read(ring.whole_motion(3));
    ASSERT_GT(reading.history().intervals(), 4 * sectors);
    ASSERT_FALSE(reading.history().holds.empty());
    Hill hill(model);
    for (const Waves waves : {Waves::whole, Waves::half}) {
      hill.assemble(waves, 3, omega, reading.answers(waves, 3));
      const std::vector<Complex> all = of_the_whole(hill, omega);
      std::vector<Complex> near;
      for (const Complex s : all)
        if (std::abs(s.imag()) < 0.25 && std::abs(s) < 0.39) near.push_back(s);
      const double part = waves == Waves::half ? 0.5 : 0;
      std::vector<Complex> found = ring.exponents(part, omega, 0.25, ring.every_shift());
      for (Complex &s : found) s -= Complex(0, part);
      EXPECT_GT(near.size(), 4u);
      EXPECT_LT(farthest(near, found), 2e-6) << sectors << " sectors, engine order " << engine_order;
      EXPECT_LT(farthest(found, all), 2e-6) << sectors << " sectors, engine order " << engine_order;
    }
  }
}

// Without sliders nothing is left out but harmonics: all strips together go to the map over one period of the ring.
TEST(SectorHill, has_the_multipliers_of_the_ring_over_one_period) {
  constexpr double omega = 0.9;
  double error[2];
  for (const bool many : {false, true}) {
    const Ring ring(5, 2, Law::unilateral, many ? 24 : 8, 0.02, 0.6);
    const DenseModel model = ring.whole();
    ContactReading reading(model, 6);
    reading.read(ring.whole_motion(6));
    ASSERT_GT(reading.history().intervals(), 10);
    const std::vector<Complex> all = Monodromy(model).multipliers(reading.history(), omega);
    std::vector<Complex> found, slow;
    for (int strip = 0; strip < 4; ++strip)
      for (const Complex s : ring.exponents(strip / 4.0, omega, 0.125, ring.every_shift()))
        found.push_back(std::exp(2 * M_PI * s));
    for (const Complex m : all)
      if (std::abs(m) > 0.6) slow.push_back(m);
    EXPECT_GT(slow.size(), 10u);
    error[many] = std::max(farthest(found, all), farthest(slow, found));
  }
  EXPECT_LT(error[0], 0.05);
  EXPECT_LT(error[1], error[0] / 5);
}

// All contacts stick, and the damping is proportional to all there is: the slowest mode of all nodal diameters decays
// by b w^2 / 2. A negative b lets the fastest one grow.
TEST(SectorStability, of_a_wave_that_sticks_in_closed_form) {
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal})
    for (const double b : {0.02, -0.02}) {
      Damping damping(b);
      damping.contact = true;
      const HarmonicSystem system = sector_system(1, exactly, {}, damping, {}, true, form, true);
      const ReducedModel model = small_sector();
      const std::vector<double> springs = stuck_springs(system.contact());
      double slowest = INFINITY, fastest = 0;
      int diameter = -1;
      for (int h = 0; h <= sectors / 2; ++h) {
        const SectorModes modes = sector_modes(model, h, springs, static_cast<int>(system.layout().dofs()));
        slowest = std::min(slowest, modes.squares.front());
        if (modes.squares.back() > fastest) fastest = modes.squares.back(), diameter = h;
      }
      const double omega = 1.3;
      std::vector<double> motion(system.layout().dofs() * coefficient_count(harmonics));
      motion[coefficient_count(harmonics) * system.layout().modes + 1] = 1e-3;
      const Stability found = SectorStabilityTest(system).judge(motion, omega);
      EXPECT_EQ(found.verdict, b > 0 ? Verdict::stable : Verdict::unstable);
      EXPECT_EQ(found.diameter, b > 0 ? -1 : diameter);
      EXPECT_NEAR(found.growth, -b / 2 * (b > 0 ? slowest : fastest) / omega, 1e-7);
    }
}
