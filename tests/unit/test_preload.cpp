// Contact preload (eq 7), also where plain Newton has no chance.
#include <gtest/gtest.h>

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
    model.fx = {0, 0, 0}, model.kxx.assign(9, 0.0), model.mxx = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int d = 0; d < 3; ++d) model.kxx[4 * d] = stiffness[d];
    contact = {point}, initial = {0, 0, 0};
  }
  return contact_preload(std::move(model), std::move(contact), initial, note);
}

} // namespace

TEST(Preload, balances_the_joint) { EXPECT_LT(imbalance(small_preloaded(PETSC_COMM_WORLD)), 1e-12); }

TEST(Preload, closed_form_of_one_sticking_point) {
  std::string note;
  const PreloadedModel model = one_point({10, 10, 10}, {0.1, 0, -2}, {30, {5, 5}, {0.5, 0.5}, 0}, note);
  if (model.standstill.empty()) return;
  EXPECT_NEAR(model.standstill[0].x[0], -0.1 / 15, 1e-14);
  EXPECT_NEAR(model.standstill[0].x[2], 2.0 / 40, 1e-14);
  EXPECT_EQ(model.standstill[0].w[0], 0); // stuck: the memory it started with
}

TEST(Preload, slipping_point_leaves_its_memory_behind) {
  std::string note;
  const PreloadedModel model = one_point({10, 10, 10}, {-3, 0, -2}, {30, {5, 5}, {0.2, 0.2}, 0}, note);
  if (model.standstill.empty()) return;
  const double normal = 30 * 2.0 / 40, x = (3 - 0.2 * normal) / 10; // friction at its limit helps to carry 3 N
  EXPECT_NEAR(model.standstill[0].x[0], x, 1e-13);
  EXPECT_NEAR(model.standstill[0].w[0], x - 0.2 * normal / 5, 1e-13);
}

TEST(Preload, a_body_held_by_its_joint_alone) { // K_xx = 0
  std::string note;
  const PreloadedModel model = one_point({0, 0, 0}, {0.1, 0.2, -2}, {30, {5, 4}, {0.5, 0.5}, 0.3}, note);
  if (model.standstill.empty()) return;
  EXPECT_NEAR(model.standstill[0].x[0], -0.1 / 5, 1e-14);
  EXPECT_NEAR(model.standstill[0].x[1], -0.2 / 4, 1e-14);
  EXPECT_NEAR(model.standstill[0].x[2], 0.3 + 2.0 / 30, 1e-14);
}

TEST(Preload, says_so_when_nothing_holds_the_body) { // pulled away from the joint
  std::string note;
  EXPECT_THROW(one_point({0, 0, 0}, {0, 0, 2}, {30, {5, 4}, {0.5, 0.5}, 0}, note), ComputeError);
}
