// Where nonlinear modes begin: a mass on one contact point, whose modes and events are in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "norms.hpp"
#include "small_sector.hpp"
#include "stuck/stuck_mode.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double N = 10;
constexpr std::array<double, 3> ground{1, 4, 9};

// A mass of 1 on springs to the ground, with its point at rest as given.
StuckMode mode_of(const ContactPoint &point, const Standstill &at, const ModeWish &wish,
                  const std::array<double, 3> &springs = ground) {
  PreloadedModel model;
  ReducedModel &reduced = model.reduced;
  reduced.comm = PETSC_COMM_WORLD, reduced.points = 1;
  reduced.own_points = own_share(reduced.comm, 1), reduced.own_modes = own_share(reduced.comm, 0);
  if (reduced.own_points.size() == 1) {
    reduced.kxx = {springs[0], 0, 0, 0, springs[1], 0, 0, 0, springs[2]};
    reduced.mxx = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    model.contact = {point}, model.standstill = {at};
  }
  Case study;
  study.mode = wish;
  study.given = {{"mode.number", "case.toml:3"}, {"mode.near", "case.toml:4"}};
  return stuck_mode(model, study);
}

ContactPoint point_of(Law law, double mu = 0.3) { return {law, 50, {20, 30}, {mu, mu}, 0.05}; }
Standstill pressed_with(double t1, double t2) { return {{0, 0, 0.05 + N / 50}, {t1, t2, N}, {}}; }

void expect_onset(const StuckMode &mode, double amplitude, const std::string &what, bool straight = true) {
  if (std::isinf(amplitude)) {
    EXPECT_EQ(mode.onset.amplitude, amplitude);
  } else {
    EXPECT_NEAR(mode.onset.amplitude, amplitude, 1e-9);
    EXPECT_EQ(mode.onset.point, 1);
  }
  EXPECT_EQ(mode.onset.what, what);
  EXPECT_EQ(mode.straight, straight);
}

} // namespace

TEST(StuckMode, slips_where_friction_is_used_up_on_the_nearer_side) {
  const ContactPoint point = point_of(Law::coulomb);
  for (const double sense : {1.0, -1.0}) {
    const StuckMode mode = mode_of(point, pressed_with(sense * 1, 0), {1});
    EXPECT_NEAR(mode.omega, std::sqrt(1 + 20), 1e-12);
    EXPECT_NEAR(mode.largest, 1, 1e-12);
    expect_onset(mode, (0.3 * N - 1) / 20, "slips");
    expect_onset(mode_of(point, pressed_with(0, sense * 2), {2}), (0.3 * N - 2) / 30, "slips");
    expect_onset(mode_of(point, pressed_with(sense * 3, 0), {1}), 2 * 0.3 * N / 20, "slips", false);    // at its bound
    expect_onset(mode_of(point, pressed_with(sense * 1, 0), {3}), (0.3 * N - 1) / (0.3 * 50), "slips"); // as N sways
  }
}

TEST(StuckMode, without_friction_it_lifts_off_or_nothing_happens) {
  for (const ContactPoint &point : {point_of(Law::coulomb, 0), point_of(Law::unilateral)}) {
    const StuckMode aside = mode_of(point, pressed_with(0, 0), {1}), away = mode_of(point, pressed_with(0, 0), {3});
    EXPECT_NEAR(away.omega, std::sqrt(9 + 50), 1e-12);
    expect_onset(away, N / 50, "lifts off");
    if (point.mu[0] == 0) {
      EXPECT_NEAR(aside.omega, 1, 1e-12);
    }
    EXPECT_EQ(aside.onset.amplitude, INFINITY);
  }
  expect_onset(mode_of(point_of(Law::bilateral), pressed_with(0, 0), {3}), INFINITY, "");
}

TEST(StuckMode, an_open_point_closes) {
  const Standstill open{{0, 0, -0.1}, {0, 0, 0}, {}};
  for (const Law law : {Law::coulomb, Law::cone, Law::unilateral}) {
    const StuckMode mode = mode_of(point_of(law), open, {3});
    EXPECT_NEAR(mode.omega, 3, 1e-12);
    expect_onset(mode, 0.05 + 0.1, "closes");
    EXPECT_EQ(mode_of(point_of(law), open, {1}).onset.amplitude, INFINITY);
  }
}

TEST(StuckMode, a_cone_slips_where_its_friction_is_as_long_as_it_may_be) {
  const ContactPoint point = point_of(Law::cone);
  for (const double sense : {1.0, -1.0}) {
    expect_onset(mode_of(point, pressed_with(sense * 1, 2), {1}), (std::sqrt(5) - 1) / 20, "slips");
    expect_onset(mode_of(point, pressed_with(sense * 1, 2), {3}), (N - std::sqrt(5) / 0.3) / 50, "slips");
    EXPECT_FALSE(mode_of(point, pressed_with(sense * 3, 0), {1}).straight);
  }
  expect_onset(mode_of(point_of(Law::cone, 0), pressed_with(0, 0), {3}), N / 50, "lifts off");
}

TEST(StuckMode, is_the_one_of_that_number_or_near_that_frequency) {
  const ContactPoint point = point_of(Law::coulomb);
  for (const auto &[near, number] : {std::pair{0.1, 1}, {5.1, 1}, {5.3, 2}, {6.7, 2}, {6.8, 3}, {100.0, 3}})
    EXPECT_EQ(mode_of(point, pressed_with(0, 0), {0, near}).number, number) << near;
  const Standstill open{{0, 0, -0.1}, {0, 0, 0}, {}};
  EXPECT_EQ(mode_of(point, open, {0, 0.1}, {0, 4, 9}).number, 2); // no rigid motion
  const auto refused = [&](const ModeWish &wish, const std::array<double, 3> &springs) {
    try {
      mode_of(point, open, wish, springs);
    } catch (const InputError &error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused({4}, ground).find("case.toml:3: mode.number = 4: the structure has 3 modes"), std::string::npos);
  EXPECT_NE(refused({1}, {0, 4, 9}).find("case.toml:3: mode.number = 1: is a rigid motion"), std::string::npos);
  EXPECT_NE(refused({0, 1}, {0, 0, 0}).find("case.toml:4: mode.near: the structure has no mode"), std::string::npos);
}

namespace {

// Two masses on two points, any stiffness and any state at rest. On one rank.
PreloadedModel any_model(std::mt19937 &random, const std::array<Law, 2> &laws) {
  std::uniform_real_distribution<double> part(-1, 1);
  PreloadedModel model;
  ReducedModel &reduced = model.reduced;
  reduced.comm = PETSC_COMM_SELF, reduced.points = 2;
  reduced.own_points = own_share(reduced.comm, 2), reduced.own_modes = own_share(reduced.comm, 0);
  std::vector<double> A;
  for (int i = 0; i < 36; ++i) A.push_back(part(random));
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      double product = i == j;
      for (int k = 0; k < 6; ++k) product += 20 * A[6 * i + k] * A[6 * j + k];
      reduced.kxx.push_back(product), reduced.mxx.push_back(i == j ? 1 + 0.1 * i : 0);
    }
  for (const Law law : laws) {
    const double mu = 0.2 + 0.1 * part(random), normal = 5 + 3 * part(random);
    model.contact.push_back({law,
                             50,
                             {20 + 10 * part(random), law == Law::cone ? 30 : 30 + 5 * part(random)},
                             {mu, law == Law::cone ? mu : 1.4 * mu},
                             0.05});
    const bool open = law != Law::bilateral && part(random) > 0.7;
    if (open)
      model.standstill.push_back({{0, 0, 0.05 - std::abs(part(random))}, {}, {}});
    else
      model.standstill.push_back({{0, 0, 0.05 + normal / 50},
                                  {0.6 * mu * normal * part(random), 0.6 * mu * normal * part(random), normal},
                                  {}});
    if (law == Law::unilateral || law == Law::bilateral)
      model.standstill.back().force[0] = model.standstill.back().force[1] = 0;
  }
  return model;
}

// Amplitude up to which f, which is positive at first, stays so; f is concave.
double first_zero(const std::function<double(double)> &f) {
  double low = 0, high = 1;
  while (f(high) > 0 && high < 1e9) high *= 2;
  if (high >= 1e9) return INFINITY;
  for (int i = 0; i < 100; ++i) (f((low + high) / 2) > 0 ? low : high) = (low + high) / 2;
  return low;
}

// What happens first as the amplitude grows, looked for instant by instant.
Onset by_hand(const PreloadedModel &model, const std::vector<std::complex<double>> &phi, int instants) {
  Onset first{INFINITY, 0, ""};
  for (std::size_t p = 0; p < model.contact.size(); ++p) {
    const ContactPoint &point = model.contact[p];
    const Standstill &at = model.standstill[p];
    if (point.law == Law::bilateral) continue;
    const auto note = [&](double amplitude, const char *what) {
      if (amplitude < first.amplitude) first = {amplitude, static_cast<int>(p) + 1, what};
    };
    for (int i = 0; i < instants; ++i) {
      const auto moved = [&](int d) { return (phi[3 * p + d] * std::polar(1.0, 2 * M_PI * i / instants)).real(); };
      if (!(at.force[2] > 0)) {
        note(first_zero([&](double a) { return point.gap - at.x[2] - a * moved(2); }), "closes");
        continue;
      }
      const auto normal = [&](double a) { return at.force[2] + a * point.kn * moved(2); };
      const auto T = [&](int d, double a) { return at.force[d] + a * point.kt[d] * moved(d); };
      note(first_zero(normal), "lifts off");
      if (point.law == Law::cone)
        note(first_zero([&](double a) { return point.mu[0] * normal(a) - std::hypot(T(0, a), T(1, a)); }), "slips");
      for (int d = 0; d < 2 && point.law == Law::coulomb; ++d)
        note(first_zero([&](double a) { return point.mu[d] * normal(a) - std::abs(T(d, a)); }), "slips");
    }
  }
  return first;
}

} // namespace

TEST(StuckMode, onsets_are_those_of_motions_looked_at_one_by_one) {
  std::mt19937 random(11);
  std::array<int, 4> met{};
  for (int i = 0; i < 60; ++i) {
    const std::array<Law, 2> laws[] = {{Law::coulomb, Law::cone},
                                       {Law::cone, Law::cone},
                                       {Law::coulomb, Law::bilateral},
                                       {Law::unilateral, Law::coulomb}};
    const PreloadedModel model = any_model(random, laws[i % 4]);
    Case study;
    study.mode = ModeWish{1 + i % 6};
    study.given = {{"mode.number", "case.toml:3"}};
    const StuckMode mode = stuck_mode(model, study);
    ASSERT_EQ(mode.contact.size(), 6u);
    double most = 0, least = 0, mass = 0;
    for (int d = 0; d < 6; ++d) {
      const ContactPoint &point = model.contact[d / 3];
      const double x = mode.contact[d].real();
      const bool closed = point.law == Law::bilateral || model.standstill[d / 3].force[2] > 0;
      double force =
          (closed ? stuck_springs(point)[d % 3] : 0) * x - mode.omega * mode.omega * model.reduced.mxx[7 * d] * x;
      for (int j = 0; j < 6; ++j) force += model.reduced.kxx[6 * d + j] * mode.contact[j].real();
      EXPECT_NEAR(force, 0, 1e-9); // it is a mode
      EXPECT_EQ(mode.contact[d].imag(), 0);
      most = std::max(most, x), least = std::min(least, x), mass += model.reduced.mxx[7 * d] * x * x;
    }
    EXPECT_NEAR(mass, 1, 1e-12);
    EXPECT_GE(most, -least);
    EXPECT_NEAR(mode.largest, most, 1e-15);
    const Onset wanted = by_hand(model, mode.contact, 2);
    EXPECT_NEAR(mode.onset.amplitude, wanted.amplitude, 1e-9 * wanted.amplitude) << i;
    EXPECT_EQ(mode.onset.point, wanted.point);
    EXPECT_STREQ(mode.onset.what, wanted.what);
    EXPECT_TRUE(mode.straight);
    ++met[std::string(wanted.what) == "slips" ? 0 : std::string(wanted.what) == "closes" ? 1 : 2];
  }
  EXPECT_GT(met[0], 10);
  EXPECT_GT(met[1], 1);
}

// Of a sector with a phase for each direction: the least of a period, on planes and cones.
TEST(StuckMode, of_a_sector_it_begins_to_slip_somewhere_in_the_period) {
  for (const Law law : {Law::cone, Law::coulomb}) {
    ReducedModel reduced = small_sector();
    std::vector<ContactPoint> contact = small_contact(reduced);
    for (ContactPoint &point : contact) point.law = law, point.mu = {0.3, 0.3};
    std::string note;
    const std::vector<double> zero(reduced.own_contact_dofs(), 0.0);
    const PreloadedModel model = contact_preload(std::move(reduced), std::move(contact), zero, note);
    for (int number = 1; number < 8; ++number) {
      Case study;
      study.mode = ModeWish{number};
      study.engine_order = 1;
      study.given = {{"mode.number", "case.toml:3"}};
      const StuckMode mode = stuck_mode(model, study);
      Onset wanted = by_hand(model, mode.contact, 400);
      MPI_Allreduce(MPI_IN_PLACE, &wanted.amplitude, 1, MPI_DOUBLE, MPI_MIN, PETSC_COMM_WORLD);
      EXPECT_NEAR(mode.onset.amplitude, wanted.amplitude, 1e-4 * wanted.amplitude) << number;
      EXPECT_LE(mode.onset.amplitude, wanted.amplitude * (1 + 1e-9)) << number;
      if (alone()) {
        EXPECT_EQ(mode.onset.point, wanted.point);
        EXPECT_STREQ(mode.onset.what, wanted.what);
      }
      EXPECT_EQ(mode.twin, 0);
    }
  }
}

TEST(StuckMode, has_a_twin_where_two_have_one_frequency) {
  ContactPoint point = point_of(Law::coulomb);
  point.kt = {20, 20};
  for (const auto &[off, twins] : {std::pair{0.0, true}, {1e-9, true}, {1e-7, false}}) {
    const std::array<double, 3> springs{1, 1 + off, 9};
    EXPECT_EQ(mode_of(point, pressed_with(0, 0), {1}, springs).twin, twins ? 2 : 0);
    EXPECT_EQ(mode_of(point, pressed_with(0, 0), {2}, springs).twin, twins ? 1 : 0);
    EXPECT_EQ(mode_of(point, pressed_with(0, 0), {3}, springs).twin, 0);
  }
}

namespace {

// Masses of 1 on springs of 1, 4, 9, ... to the ground, at open points: frequencies 1, 2, 3, ...
PreloadedModel row_of(int points, int rigid = 0) {
  PreloadedModel model;
  model.reduced = grounded(points, [&](int i) { return i >= rigid ? (i + 1.0) * (i + 1.0) : 0; });
  model.contact.assign(model.reduced.own_points.size(), point_of(Law::coulomb));
  model.standstill.assign(model.reduced.own_points.size(), Standstill{{0, 0, -0.1}, {}, {}});
  return model;
}

std::string refused(const PreloadedModel &model, const ModeWish &wish) {
  Case study;
  study.mode = wish;
  study.given = {{"mode.number", "case.toml:3"}, {"mode.near", "case.toml:4"}};
  try {
    return "mode " + std::to_string(stuck_mode(model, study).number);
  } catch (const InputError &error) {
    return error.what();
  }
}

std::string listed(int count, int rigid = 0) {
  const FrequencyUnit unit = Case().frequency_unit;
  std::string text;
  for (int j = 1; j <= count; ++j)
    text += (j > 1 ? ", " : "") + std::to_string(j) + ": " + unit.text(j > rigid ? j : 0.0, 6);
  return text;
}

} // namespace

TEST(StuckMode, as_many_are_found_as_it_takes) {
  const PreloadedModel model = row_of(8); // 24 modes
  for (const auto &[near, number] :
       {std::pair{9.9, 10}, {10.4, 10}, {10.6, 11}, {20.6, 21}, {23.6, 24}, {99.0, 24}, {0.1, 1}})
    EXPECT_EQ(refused(model, {0, near}), "mode " + std::to_string(number)) << near;
  for (const int number : {1, 10, 11, 24}) EXPECT_EQ(refused(model, {number}), "mode " + std::to_string(number));
  const std::string joint = " modes, with its joint stuck at the preload state: ";
  EXPECT_EQ(refused(model, {25}), "case.toml:3: mode.number = 25: the structure has 24" + joint + listed(10) + ", ...");
  EXPECT_EQ(refused(row_of(3), {10}), "case.toml:3: mode.number = 10: the structure has 9" + joint + listed(9));
  EXPECT_EQ(refused(row_of(3, 2), {2}),
            "case.toml:3: mode.number = 2: is a rigid motion, which nothing brings back; the modes are " +
                listed(9, 2));
  EXPECT_EQ(refused(row_of(3, 2), {3}), "mode 3");
  EXPECT_EQ(refused(row_of(3, 2), {0, 0.5}), "mode 3");
}

// With modes of the reduction, which masses couple with the contacts.
TEST(StuckMode, is_one_of_the_reduced_structure) {
  const PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
  const Layout layout(model.reduced, 0);
  const auto [K, M] = SmallMatrices();
  std::vector<double> springs(11);
  for (std::size_t p = 0; p < model.contact.size(); ++p)
    for (int d = 0; d < 3; ++d)
      springs[layout.number(layout.own_modes.size() + 3 * static_cast<PetscInt>(p) + d)] =
          stuck_springs(model.contact[p])[d];
  MPI_Allreduce(MPI_IN_PLACE, springs.data(), 11, MPI_DOUBLE, MPI_SUM, layout.comm);
  for (int number = 1; number <= 11; ++number) {
    Case study;
    study.mode = ModeWish{number};
    study.given = {{"mode.number", "case.toml:3"}};
    const StuckMode mode = stuck_mode(model, study);
    ASSERT_EQ(mode.modal.size(), static_cast<std::size_t>(layout.own_modes.size()));
    ASSERT_EQ(mode.contact.size(), 3 * model.contact.size());
    std::vector<double> phi(11);
    for (PetscInt d = 0; d < layout.own_dofs(); ++d) {
      const PetscInt of_contact = d - layout.own_modes.size();
      phi[layout.number(d)] = (of_contact < 0 ? mode.modal[d] : mode.contact[of_contact]).real();
    }
    MPI_Allreduce(MPI_IN_PLACE, phi.data(), 11, MPI_DOUBLE, MPI_SUM, layout.comm);
    double mass = 0;
    for (std::size_t i = 0; i < 11; ++i) {
      double force = springs[i] * phi[i];
      for (std::size_t j = 0; j < 11; ++j) {
        force += (K[i * 11 + j] - mode.omega * mode.omega * M[i * 11 + j]) * phi[j];
        mass += phi[i] * M[i * 11 + j] * phi[j];
      }
      EXPECT_NEAR(force, 0, 1e-11) << number;
    }
    EXPECT_NEAR(mass, 1, 1e-12);
    const auto [least, most] = std::minmax_element(phi.begin(), phi.end());
    EXPECT_GE(*most, -*least);
  }
}

// A motion along which friction grows as fast as what it has to hold: a cone's equation is linear, or all but that.
TEST(StuckMode, of_a_cone_whose_bound_grows_with_the_motion) {
  ContactPoint point = point_of(Law::cone, 0.4); // 0.4 * 50 = 20, as along t1
  for (const double more : {0.0, 1e-15, 1e-12, 1e-3}) {
    point.kn = 50 * (1 + more);
    PreloadedModel model;
    ReducedModel &reduced = model.reduced;
    reduced.comm = PETSC_COMM_SELF, reduced.points = 1;
    reduced.own_points = {0, 1}, reduced.own_modes = {0, 0};
    const double across = -40; // t1 and n alike, in opposite senses
    reduced.kxx = {130, 0, across, 0, 1e4, 0, across, 0, 150 - point.kn};
    reduced.mxx = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    model.contact = {point}, model.standstill = {pressed_with(1, 2)};
    Case study;
    study.mode = ModeWish{1};
    study.given = {{"mode.number", "case.toml:3"}};
    const StuckMode mode = stuck_mode(model, study);
    // |T + a t| = 0.4 (N + a n): where a is positive N grows, where it is negative it falls
    const double t = 20 * mode.contact[0].real(), rate = 0.4 * point.kn * mode.contact[2].real();
    const auto left = [&](double a) { return 0.4 * N + a * rate - std::hypot(1 + a * t, 2); };
    const double a = -mode.onset.amplitude;
    EXPECT_NEAR(left(a), 0, 1e-9) << more;
    EXPECT_GT(left(0.99 * a), 0);
    EXPECT_STREQ(mode.onset.what, "slips");
  }
}
