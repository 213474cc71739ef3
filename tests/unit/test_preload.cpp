// Contact preload (eq 7), also where plain Newton has no chance.
#include <gtest/gtest.h>

#include "preload/preload_problem.hpp"
#include "small_model.hpp"
#include "support/error.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// K_xx x_p + g(x_p) + R of own rows; K_xx row-major, all of x_p gathered.
double imbalance(const PreloadedModel &model) {
  const ReducedModel &reduced = model.reduced;
  std::vector<double> x(reduced.contact_dofs(), 0.0);
  for (std::size_t p = 0; p < model.standstill.size(); ++p)
    for (int d = 0; d < 3; ++d) x[3 * (reduced.own_points.begin + p) + d] = model.standstill[p].x[d];
  MPI_Allreduce(MPI_IN_PLACE, x.data(), static_cast<int>(x.size()), MPI_DOUBLE, MPI_SUM, reduced.comm);
  double worst = 0;
  for (std::size_t i = 0; i < reduced.r.size(); ++i) {
    double sum = reduced.r[i] + model.standstill[i / 3].force[i % 3];
    for (std::size_t j = 0; j < x.size(); ++j) sum += reduced.kxx[i * x.size() + j] * x[j];
    worst = std::max(worst, std::abs(sum));
  }
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE, MPI_MAX, reduced.comm);
  return worst;
}

ContactPoint joint(Law law, double kn, std::array<double, 2> kt, double mu, double gap) {
  return {law, kn, kt, {mu, mu}, gap};
}

// One point, diagonal stiffness.
PreloadedModel one_point(std::array<double, 3> stiffness, std::array<double, 3> r, const ContactPoint &point,
                         std::string &note) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD;
  model.points = 1;
  model.own_points = own_share(model.comm, 1);
  model.own_modes = own_share(model.comm, 0);
  std::vector<ContactPoint> contact;
  std::vector<double> initial;
  if (model.own_points.size() == 1) {
    model.r.assign(r.begin(), r.end());
    model.loads[0].fx = {0, 0, 0}, model.kxx.assign(9, 0.0), model.mxx = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int d = 0; d < 3; ++d) model.kxx[4 * d] = stiffness[d];
    contact = {point}, initial = {0, 0, 0};
  }
  return contact_preload(std::move(model), std::move(contact), initial, note);
}

// A plate on many points, stiff against all but its rigid translations: K_xx = k (1 - 1 1^T / N) in each direction, and
// what `held` holds of it. Pressed and pushed along t1 by so much a point, some points more than others.
ReducedModel plate(PetscInt points, double held, double push) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD, model.points = points;
  model.own_points = own_share(model.comm, points), model.own_modes = own_share(model.comm, 0);
  for (PetscInt i = 3 * model.own_points.begin; i < 3 * model.own_points.end; ++i) {
    const double part = std::cos(2 * M_PI * static_cast<double>(i / 3) / static_cast<double>(points)); // sum 0
    model.r.push_back(i % 3 == 0 ? -push * (1 + part) : i % 3 == 2 ? -1 : 0);
    for (PetscInt j = 0; j < 3 * points; ++j)
      model.kxx.push_back(i % 3 != j % 3 ? 0 : (i == j ? 10 + held : 0) - 10.0 / static_cast<double>(points));
  }
  return model;
}

// Of a joint without friction, which a force of 4 times that course drives.
Scales scales_of_course(std::vector<double> course) {
  std::string note;
  PreloadedModel model = one_point({10, 10, 10}, {0, 0, -2}, joint(Law::unilateral, 30, {}, 0, 0), note);
  for (double &f : model.reduced.loads[0].fx) f = 4;
  Case study;
  study.omega_from = 2;
  study.loads[0].fourier = std::move(course);
  return choose_scales(study, model);
}

} // namespace

TEST(Preload, balances_the_joint) { EXPECT_LT(imbalance(small_preloaded(PETSC_COMM_WORLD)), 1e-12); }

TEST(Preload, closed_form_of_one_sticking_point) {
  std::string note;
  const PreloadedModel model = one_point({10, 10, 10}, {0.1, 0, -2}, joint(Law::coulomb, 30, {5, 5}, 0.5, 0), note);
  if (model.standstill.empty()) return;
  EXPECT_NEAR(model.standstill[0].x[0], -0.1 / 15, 1e-14);
  EXPECT_NEAR(model.standstill[0].x[2], 2.0 / 40, 1e-14);
  EXPECT_EQ(model.standstill[0].w[0], 0); // stuck: the memory it started with
}

TEST(Preload, slipping_point_leaves_its_memory_behind) {
  std::string note;
  const PreloadedModel model = one_point({10, 10, 10}, {-3, 0, -2}, joint(Law::coulomb, 30, {5, 5}, 0.2, 0), note);
  if (model.standstill.empty()) return;
  const double normal = 30 * 2.0 / 40, x = (3 - 0.2 * normal) / 10; // friction at its limit helps to carry 3 N
  EXPECT_NEAR(model.standstill[0].x[0], x, 1e-13);
  EXPECT_NEAR(model.standstill[0].w[0], x - 0.2 * normal / 5, 1e-13);
}

TEST(Preload, a_body_held_by_its_joint_alone) { // K_xx = 0
  std::string note;
  const PreloadedModel model = one_point({0, 0, 0}, {0.1, 0.2, -2}, joint(Law::coulomb, 30, {5, 4}, 0.5, 0.3), note);
  if (model.standstill.empty()) return;
  EXPECT_NEAR(model.standstill[0].x[0], -0.1 / 5, 1e-14);
  EXPECT_NEAR(model.standstill[0].x[1], -0.2 / 4, 1e-14);
  EXPECT_NEAR(model.standstill[0].x[2], 0.3 + 2.0 / 30, 1e-14);
}

// A second point that is farther from closing than anything moves: the first one is pressed all the same.
TEST(Preload, an_open_point_however_far_is_no_measure_of_the_forces) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD;
  model.points = 2;
  model.own_points = own_share(model.comm, 2), model.own_modes = own_share(model.comm, 0);
  const std::vector<ContactPoint> both = {joint(Law::coulomb, 1e9, {5, 5}, 0.5, 0),
                                          joint(Law::coulomb, 1e9, {5, 5}, 0.5, 1e8)};
  std::vector<ContactPoint> contact;
  for (PetscInt p = model.own_points.begin; p < model.own_points.end; ++p) {
    contact.push_back(both[p]);
    for (int d = 0; d < 3; ++d) {
      model.r.push_back(d == 2 ? -2 : 0), model.loads[0].fx.push_back(0);
      for (int j = 0; j < 6; ++j) model.kxx.push_back(j == 3 * p + d ? 10 : 0), model.mxx.push_back(j == 3 * p + d);
    }
  }
  const PetscInt first = model.own_points.begin;
  const std::vector<double> initial(3 * contact.size());
  std::string note;
  const PreloadedModel loaded = contact_preload(std::move(model), std::move(contact), initial, note);
  for (std::size_t p = 0; p < loaded.standstill.size(); ++p) {
    const bool pressed = first + static_cast<PetscInt>(p) == 0;
    EXPECT_NEAR(loaded.standstill[p].force[2], pressed ? 2 * 1e9 / (1e9 + 10) : 0, 1e-9);
    EXPECT_NEAR(loaded.standstill[p].x[2], pressed ? 2 / (1e9 + 10) : 0.2, 1e-9);
  }
}

TEST(Preload, says_so_when_nothing_holds_the_body) { // pulled away from the joint
  std::string note;
  EXPECT_THROW(one_point({0, 0, 0}, {0, 0, 2}, joint(Law::coulomb, 30, {5, 4}, 0.5, 0), note), ComputeError);
}

// Push and pull of 5 N in the plane, along (3, -4), against equal springs of 10 N/m: the cone gives way along that
// line.
TEST(Preload, slips_in_the_plane_under_the_cone) {
  std::string note;
  const PreloadedModel model = one_point({10, 10, 10}, {-3, 4, -2}, joint(Law::cone, 30, {5, 5}, 0.2, 0), note);
  if (model.standstill.empty()) return;
  const Standstill &rest = model.standstill[0];
  const double bound = 0.2 * 30 * 2.0 / 40, along[] = {0.6, -0.8};
  for (int d = 0; d < 2; ++d) {
    EXPECT_NEAR(rest.force[d], bound * along[d], 1e-12);
    EXPECT_NEAR(rest.x[d], (5 - bound) / 10 * along[d], 1e-12);
    EXPECT_NEAR(rest.w[d], rest.x[d] - rest.force[d] / 5, 1e-12);
  }
}

TEST(Preload, without_friction_only_the_structure_holds_the_plane) {
  for (const Law law : {Law::unilateral, Law::bilateral}) {
    std::string note;
    const PreloadedModel model = one_point({10, 20, 10}, {-3, 4, -2}, joint(law, 30, {5, 5}, 0.5, -0.1), note);
    if (model.standstill.empty()) continue;
    const Standstill &rest = model.standstill[0];
    EXPECT_NEAR(rest.x[0], 0.3, 1e-13);
    EXPECT_NEAR(rest.x[1], -0.2, 1e-13);
    EXPECT_NEAR(rest.x[2], (2 - 30 * 0.1) / 40, 1e-13);
    EXPECT_EQ(rest.w, (Memory{0, 0}));
    EXPECT_EQ(rest.force[0], 0);
  }
}

TEST(Preload, a_spring_that_pulls_is_never_open) { // drawn away by 2 N, gap 0.3
  std::string note;
  const PreloadedModel open = one_point({10, 10, 10}, {0, 0, 2}, joint(Law::unilateral, 30, {}, 0, 0.3), note);
  const PreloadedModel held = one_point({10, 10, 10}, {0, 0, 2}, joint(Law::bilateral, 30, {}, 0, 0.3), note);
  EXPECT_EQ(note, "");
  if (open.standstill.empty()) return;
  EXPECT_NEAR(open.standstill[0].x[2], -0.2, 1e-14);
  EXPECT_EQ(open.standstill[0].force[2], 0);
  EXPECT_NEAR(held.standstill[0].x[2], (30 * 0.3 - 2) / 40, 1e-13);
  EXPECT_NEAR(held.standstill[0].force[2], 30 * ((30 * 0.3 - 2) / 40 - 0.3), 1e-12);
}

// The plate rests on its springs: each bears 1 N, and its mean goes where the springs let it.
TEST(Preload, closed_form_of_a_plate_that_its_joint_alone_holds) {
  constexpr int points = 150;
  const ReducedModel model = plate(points, 0, 0.2);
  const std::vector<ContactPoint> contact(model.own_points.size(), joint(Law::coulomb, 30, {5, 5}, 0.5, 0.1));
  PreloadProblem problem(model, contact);
  std::vector<double> x(model.r.size());
  std::string note;
  ASSERT_TRUE(problem.find(x, 1, note));
  for (std::size_t p = 0; p < contact.size(); ++p) {
    const double part = std::cos(2 * M_PI * static_cast<double>(model.own_points.begin + p) / points);
    EXPECT_NEAR(x[3 * p], 0.2 / 5 + 0.2 * part / 15, 1e-13);
    EXPECT_NEAR(x[3 * p + 1], 0, 1e-13);
    EXPECT_NEAR(x[3 * p + 2], 0.1 + 1.0 / 30, 1e-13);
  }
}

// While friction falls step by step, points begin to slip one after the other. Factors of the stuck joint serve for
// all of them, and what is found is what a search of its own finds.
TEST(Preload, kept_factors_find_the_same_states) {
  constexpr int points = 150, steps = 12;
  const ReducedModel model = plate(points, 5, 0.3);
  std::vector<ContactPoint> contact(model.own_points.size(), joint(Law::coulomb, 30, {5, 5}, 1, 0));
  PreloadProblem kept(model, contact);
  std::vector<double> x(model.r.size());
  std::string note;
  int slipping = 0;
  kept.keep_factors(x);
  for (int step = 0; step < steps; ++step) {
    for (ContactPoint &point : contact) point.mu = {0.22 - 0.005 * step, 0.22 - 0.005 * step};
    PreloadProblem alone(model, contact);
    std::vector<double> found(x.size());
    ASSERT_TRUE(kept.find(x, 1, note));
    ASSERT_TRUE(alone.find(found, 1, note));
    slipping = 0;
    for (std::size_t p = 0; p < contact.size(); ++p) slipping += static_force(contact[p], &x[3 * p]).w[0] != 0;
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(x[i], found[i], 1e-12) << step << " " << i;
  }
  MPI_Allreduce(MPI_IN_PLACE, &slipping, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  EXPECT_GT(slipping, points / 4);
  EXPECT_LT(slipping, points);
  EXPECT_LT(kept.factorisations(), steps / 2);
  EXPECT_EQ(note, "");
}

// A path may be begun again anywhere: the bits of a state are those of its setting alone.
TEST(Preload, what_is_found_does_not_depend_on_what_was_before) {
  const ReducedModel model = plate(150, 5, 0.3);
  std::vector<ContactPoint> contact(model.own_points.size(), joint(Law::coulomb, 30, {5, 5}, 1, 0));
  const std::vector<double> origin(model.r.size());
  const auto found = [&](PreloadProblem &problem, double mu) {
    for (ContactPoint &point : contact) point.mu = {mu, mu};
    std::vector<double> x = origin;
    std::string note;
    EXPECT_TRUE(problem.find(x, 1, note));
    const std::vector<double> slope = problem.follow(x, model.r);
    x.insert(x.end(), slope.begin(), slope.end());
    return x;
  };
  PreloadProblem on(model, contact);
  on.keep_factors(origin);
  for (const double mu : {0.21, 0.02, 0.19}) {
    for (ContactPoint &point : contact) point.mu = {1, 1};
    PreloadProblem afresh(model, contact);
    afresh.keep_factors(origin);
    EXPECT_EQ(found(on, mu), found(afresh, mu)) << mu;
  }
}

TEST(Preload, a_change_is_followed) { // against a difference of two states
  const ReducedModel model = plate(150, 0.5, 0.3);
  const std::vector<ContactPoint> contact(model.own_points.size(), joint(Law::coulomb, 30, {5, 5}, 0.3, 0));
  PreloadProblem problem(model, contact);
  std::vector<double> x(model.r.size()), more = x;
  std::string note;
  ASSERT_TRUE(problem.find(x, 1, note));
  ASSERT_TRUE(problem.find(more, 1 + 1e-6, note));
  const std::vector<double> dx = problem.follow(x, model.r); // by the load
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(dx[i], (more[i] - x[i]) / 1e-6, 1e-7);
}

// Every law at places stuck, slipping, open and touching: slope against differences, and what the memory left holds.
TEST(StaticForce, slope_and_memory_belong_to_the_force) {
  const double places[][3] = {{0.1, 0.2, 1}, {3, 0.1, 1}, {-3, 4, 1}, {0, -2, 0.5}, {1, 1, -1}};
  for (const Law law : {Law::coulomb, Law::cone, Law::unilateral, Law::bilateral})
    for (const auto &x : places) {
      const ContactPoint point = joint(law, 2, {1, 3}, 0.5, 0.125);
      const StaticForce g = static_force(point, x);
      for (int j = 0; j < 3; ++j) {
        const double step = 1e-6;
        double ahead[] = {x[0], x[1], x[2]}, behind[] = {x[0], x[1], x[2]};
        ahead[j] += step, behind[j] -= step;
        const StaticForce a = static_force(point, ahead), b = static_force(point, behind);
        for (int i = 0; i < 3; ++i)
          EXPECT_NEAR(g.slope[i][j], (a.force[i] - b.force[i]) / (2 * step), 1e-8) << int(law) << " " << i << " " << j;
      }
      const double bound = 0.5 * std::max(0.0, g.force[2]);
      for (int d = 0; d < 2; ++d) {
        if (has_friction(law))
          EXPECT_NEAR(g.force[d], point.kt[d] * (x[d] - g.w[d]), 1e-14);
        else
          EXPECT_TRUE(g.force[d] == 0 && g.w[d] == 0);
        EXPECT_LE(std::abs(g.force[d]), bound * (1 + 1e-12));
      }
      if (law == Law::cone) {
        EXPECT_LE(std::hypot(g.force[0], g.force[1]), bound * (1 + 1e-12));
      }
    }
}

TEST(StaticForce, touching_without_force_counts_as_closed) {
  const double x[] = {0.5, 0.5, 0.25};
  for (const Law law : {Law::coulomb, Law::cone, Law::unilateral, Law::bilateral}) {
    const StaticForce g = static_force(joint(law, 2, {1, 3}, 0.5, 0.25), x);
    const double springs[] = {has_friction(law) ? 1.0 : 0, has_friction(law) ? 3.0 : 0, 2};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) EXPECT_EQ(g.slope[i][j], i == j ? springs[i] : 0);
    EXPECT_EQ(g.force, (std::array<double, 3>{}));
  }
}

// Such a joint sets no measure for the motion, and divides by nothing.
TEST(ScaledPreload, of_a_joint_without_friction) {
  const Scales scales = scales_of_course({0, 1});
  EXPECT_NEAR(scales.contact, 4.0 / 30, 1e-14); // largest force over largest stiffness
  EXPECT_TRUE(std::isfinite(scales.modal) && scales.modal > 0);
}

// The course makes good what units a pattern has. What is constant moves nothing.
TEST(ScaledPreload, measures_the_amplitude_of_the_load) {
  EXPECT_NEAR(scales_of_course({100, 3, 4}).contact, 5 * 4.0 / 30, 1e-14);
}

TEST(ScaledPreload, refuses_loads_whose_energies_are_no_numbers) {
  for (const double size : {1e-300, 1e300}) EXPECT_THROW(scales_of_course({0, size}), InputError);
}
