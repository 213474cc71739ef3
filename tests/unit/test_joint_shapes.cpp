// Shapes of a joint on a structure of which they are known: a row of equal masses that springs tie to the next one and
// contacts to the ground, each direction by itself. Stuck, cosine waves are its modes, and its joint's shapes.
#include <gtest/gtest.h>

#include <cmath>

#include "stuck/joint_shapes.hpp"

using namespace dovetail;

namespace {

constexpr int points = 60;
constexpr double tie = 300, contact = 1;

StuckBasis basis_of(const Layout &layout, ReducedModel model) {
  const std::vector<double> joint(3 * model.own_points.size(), contact);
  for (int i = 3 * model.own_points.begin; i < 3 * model.own_points.end; ++i)
    for (int j = 0; j < 3 * points; ++j) {
      const bool last = i / 3 == 0 || i / 3 == points - 1;
      model.kxx.push_back(i == j ? (last ? tie : 2 * tie) : std::abs(i - j) == 3 ? -tie : 0);
      model.mxx.push_back(i == j);
    }
  return stuck_basis(model, joint, layout);
}

} // namespace

TEST(JointShapes, hold_what_is_known_of_the_energy) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD;
  model.modes = 0, model.points = points;
  model.own_modes = own_share(model.comm, 0), model.own_points = own_share(model.comm, points);
  const Layout layout(model, 1);
  const StuckBasis basis = basis_of(layout, model);
  const std::size_t n = 3 * points;
  std::vector<double> expected; // three directions each, those with more than a tenth
  for (int wave = 0; wave < 4; ++wave)
    expected.insert(expected.end(), 3, contact / (contact + 2 * tie * (1 - std::cos(std::acos(-1.0) * wave / points))));
  ASSERT_EQ(basis.shapes.size(), n * expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k)
    for (std::size_t i = 0; i < expected.size(); ++i) {
      double strained = 0, in_contacts = 0; // Phi is orthogonal here, and the contacts' springs are all the same
      for (std::size_t j = 0; j < n; ++j) {
        const double product = basis.shapes[i * n + j] * basis.shapes[k * n + j];
        strained += basis.lambda[j] * product, in_contacts += contact * product;
      }
      EXPECT_NEAR(strained, i == k, 1e-10);
      EXPECT_NEAR(in_contacts, i == k ? expected[k] : 0, 1e-3) << i << " " << k;
    }
}
