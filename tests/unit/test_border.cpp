// A bordered matrix, solved with by elimination: products with the answer give the right-hand side.
#include <gtest/gtest.h>

#include <cmath>

#include "problems/border.hpp"

using namespace dovetail;

namespace {

constexpr int width = 3;

Layout layout() {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD;
  model.modes = 3, model.points = 5;
  model.own_modes = own_share(model.comm, model.modes), model.own_points = own_share(model.comm, model.points);
  return Layout(model, 2);
}

// A is diagonal, and one of its entries is hardly there.
struct Scene {
  Scene() {
    const PetscInt own = place.own_coefficients();
    begin = place.first_dof() * place.width;
    for (int b = 0; b < width; ++b) {
      for (PetscInt i = 0; i < own; ++i) border.columns[b].push_back(wave(i, b)), border.rows[b].push_back(wave(b, i));
      for (int a = 0; a < width; ++a) border.corner[a][b] = a == b ? 2 : 0.3 * a - 0.2 * b;
    }
    for (PetscInt i = 0; i < border.own(); ++i) r.push_back(wave(i, 7));
    x.resize(r.size());
  }
  double wave(PetscInt i, PetscInt j) const {
    return std::sin(static_cast<double>(0.7 * (begin + i) + 1.3 * (begin + j)));
  }
  double diagonal(PetscInt i) const { return begin + i == 4 ? 1e-3 : 2 + 0.1 * static_cast<double>(begin + i); }
  auto inverse() const {
    return [this](const double *of, double *answer) {
      for (PetscInt i = 0; i < place.own_coefficients(); ++i) answer[i] = of[i] / diagonal(i);
      return true;
    };
  }

  Layout place = layout();
  Border<width> border{place};
  PetscInt begin;
  std::vector<double> r, x;
};

} // namespace

TEST(Border, products_with_the_answer_are_the_right_hand_side) {
  Scene scene;
  ASSERT_TRUE(scene.border.eliminate(scene.inverse()));
  ASSERT_TRUE(scene.border.solve(scene.inverse(), scene.r.data(), scene.x.data()));
  std::vector<double> product(scene.r.size());
  for (PetscInt i = 0; i < scene.place.own_coefficients(); ++i) product[i] = scene.diagonal(i) * scene.x[i];
  scene.border.multiply(scene.x.data(), scene.border.last_of(scene.x.data()), product.data());
  for (std::size_t i = 0; i < product.size(); ++i) EXPECT_NEAR(product[i], scene.r[i], 1e-9);
}

TEST(Border, the_sign_is_that_of_what_is_left) {
  Scene scene;
  ASSERT_TRUE(scene.border.eliminate(scene.inverse()));
  const int before = scene.border.sign();
  for (auto &column : scene.border.columns[1]) column *= -1;
  for (auto &row : scene.border.corner) row[1] *= -1;
  ASSERT_TRUE(scene.border.eliminate(scene.inverse()));
  EXPECT_EQ(before, -scene.border.sign());
}

TEST(Border, without_a_regular_one_the_matrix_within_is_solved_with) {
  Scene scene;
  scene.border.columns[1].assign(scene.border.columns[1].size(), 0.0);
  for (auto &row : scene.border.corner) row[1] = 0;
  EXPECT_FALSE(scene.border.eliminate(scene.inverse()));
  ASSERT_TRUE(scene.border.solve(scene.inverse(), scene.r.data(), scene.x.data()));
  for (PetscInt i = 0; i < scene.border.own(); ++i)
    EXPECT_EQ(scene.x[i], i < scene.place.own_coefficients() ? scene.r[i] / scene.diagonal(i) : 0);
}

TEST(Border, failing_solves_are_told) {
  Scene scene;
  const auto fails = [](const double *, double *) { return false; };
  EXPECT_FALSE(scene.border.eliminate(fails));
  EXPECT_FALSE(scene.border.solve(fails, scene.r.data(), scene.x.data()));
}
