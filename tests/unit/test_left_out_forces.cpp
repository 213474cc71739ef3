// What the modes of a sector do that were left out, in complex numbers. On any number of ranks.
#include <gtest/gtest.h>

#include "harmonic/left_out_forces.hpp"
#include "small_sector.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr int own = 2, rest = 9;
constexpr double omega = 1.3;

Complex mass(int h, int d, int j) { // of -h the conjugate
  const Complex m(0.3 * wave(d, 70 + j + 10 * std::abs(h)), h == 0 ? 0 : 0.2 * wave(d, 90 + j + 10 * std::abs(h)));
  return h < 0 ? std::conj(m) : m;
}
Complex pull(int h, int j) { // of the load, likewise
  const Complex f(wave(j, 30 + std::abs(h)), h == 0 ? 0 : wave(j, 50 + std::abs(h)));
  return h < 0 ? std::conj(f) : f;
}
double square(int h, int j) { return 9.0 + std::abs(h) + 5 * j; }

// `left`: modes of each nodal diameter.
HarmonicSystem system_without(const std::array<int, 4> &left, const Damping &damping) {
  ReducedModel model = small_sector();
  const auto fill = [&](auto &modes, int h, auto number) {
    modes.loads.resize(1);
    for (int j = 0; j < left[h]; ++j)
      modes.squares.push_back(square(h, j)), modes.loads[0].push_back(number(pull(h, j)));
    for (int d = 0; d < own + rest; ++d)
      for (int j = 0; j < left[h]; ++j) {
        const int i = d - own - 3 * static_cast<int>(model.own_points.begin);
        if (d < own) modes.with_modes.push_back(number(mass(h, d, j)));
        if (i >= 0 && i < model.own_contact_dofs()) modes.coupling.push_back(number(mass(h, d, j)));
      }
  };
  fill(model.left_out, 0, [](Complex value) { return value.real(); });
  for (int h = 1; h <= sectors / 2; ++h) fill(model.indices[h - 1].left_out, h, [](Complex value) { return value; });
  std::vector<ContactPoint> contact = small_contact(model);
  const std::vector<double> zero(model.own_contact_dofs(), 0.0);
  std::string note;
  ScaledModel made = scaled(contact_preload(std::move(model), std::move(contact), zero, note), damping, {});
  made.engine_order = 2; // indices 2, -2, 0, 2
  return HarmonicSystem(std::move(made), harmonics, exactly, course(fourier));
}

} // namespace

// Each harmonic's modes by themselves: motion c - i s.
TEST(SectorLeftOut, move_and_pull_back_as_their_equation_says) {
  const Damping damping(0.05, 0.8, 0.2);
  std::vector<double> f = fourier;
  f.resize(coefficient_count(harmonics));
  for (const std::array<int, 4> &left : {std::array{2, 1, 3, 2}, {3, 1, 2, 2}}) {
    HarmonicSystem system = system_without(left, damping);
    const int w = system.layout().width;
    const UniqueVec y = vector_of(system, 1, 3, omega), out = system.unknowns();
    const std::vector<double> q = all_coefficients(system.layout(), y);
    const auto at = [](const std::vector<double> &of, int first, int stride, int k) {
      return Complex(of[first + stride * cosine(k)], -of[first + stride * sine(k)]);
    };
    for (const double load : {0.0, 0.7}) {
      const LeftOutModes modes(system, y);
      const std::vector<double> motion = modes.motion(y, load);
      modes.forces(motion, out);
      const std::vector<double> found = all_coefficients(system.layout(), out);
      for (int k = 1; k <= harmonics; ++k) {
        const int h = system.wave().index(k), count = left[std::abs(h)];
        const double speed = k * omega;
        const Complex kappa(1, speed * damping.stiffness + damping.structural),
            mu(speed * speed, -speed * damping.mass);
        std::vector<Complex> moved;
        for (int j = 0; j < count; ++j) {
          Complex driven = load * at(f, 0, 1, k) * pull(h, j);
          for (int d = 0; d < own + rest; ++d) driven += mu * std::conj(mass(h, d, j)) * at(q, d * w, 1, k);
          moved.push_back(driven / (kappa * square(h, j) - mu));
          EXPECT_NEAR(std::abs(at(motion, j, 3, k) - moved[j]), 0, 1e-12) << k << " " << j;
        }
        for (int d = 0; d < own + rest; ++d) {
          Complex wanted = 0;
          for (int j = 0; j < count; ++j) wanted -= mu * mass(h, d, j) * moved[j];
          EXPECT_NEAR(std::abs(at(found, d * w, 1, k) - wanted), 0, 1e-12 * (1 + std::abs(wanted))) << k << " " << d;
        }
      }
    }
  }
}
