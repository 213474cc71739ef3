// Shapes of a joint on a structure of which they are known: a row of equal masses that springs tie to the next one and
// contacts to the ground, each direction by itself. Stuck, cosine waves are its modes, and its joint's shapes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "small_model.hpp"
#include "stuck/joint_shapes.hpp"

using namespace dovetail;
using namespace dovetail::testing;

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

// Directions that neither the structure nor a spring holds have no part in any shape, whatever rounding makes of their
// squares.
TEST(JointShapes, leave_out_what_nothing_holds) {
  const ReducedModel model = grounded(8, [](int i) { return i % 3 == 0 ? 3.0 : 0.0; });
  const Layout layout(model, 1);
  std::vector<double> springs(24);
  for (int i = 0; i < 24; ++i) springs[i] = i % 3 == 1 ? 0 : 1;
  const StuckBasis basis = stuck_basis(model, springs, layout);
  ASSERT_EQ(basis.shapes.size(), 24u * 16);
  for (int k = 0; k < 16; ++k) { // a square is 0, 1 or 4, and what the joint holds of it all or a quarter
    double strained = 0, loose = 0, wanted = k < 8 ? 1 : 4;
    for (int j = 0; j < 24; ++j) {
      const double product = std::pow(basis.shapes[k * 24 + j], 2);
      strained += basis.lambda[j] * product;
      if (basis.lambda[j] < 0.5)
        loose += product;
      else if (std::abs(basis.lambda[j] - wanted) > 0.5)
        EXPECT_LT(product, 1e-5);
    }
    EXPECT_NEAR(strained, 1, 1e-10);
    EXPECT_LT(loose, 1e-17); // rounding errors, over a millionth of the largest frequency
  }
}

namespace {

// A ring of points that springs tie to the next one with a turn of phase, and contacts to the ground.
constexpr double phase = 0.3;

SectorIndex ring() {
  SectorIndex index;
  for (int i = 0; i < 3 * points; ++i)
    for (int j = 0; j < 3 * points; ++j) {
      const bool next = j == (i + 3) % (3 * points), before = i == (j + 3) % (3 * points);
      index.kxx.push_back(i == j ? 2 * tie : next ? -std::polar(tie, phase) : before ? -std::polar(tie, -phase) : 0);
      index.mxx.push_back(i == j);
    }
  return index;
}

} // namespace

TEST(JointShapes, of_complex_matrices_hold_what_is_known) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD, model.points = points;
  model.own_modes = own_share(model.comm, 0), model.own_points = own_share(model.comm, points);
  const Layout layout(model, 1);
  const SectorIndex index = ring();
  const StuckBasis basis =
      std::move(stuck_bases(model, {&index}, std::vector<double>(3 * points, contact), layout).at(0));
  std::vector<double> expected;
  for (int wave = 0; wave < points; ++wave) {
    const double part = contact / (contact + 2 * tie * (1 - std::cos(2 * std::acos(-1.0) * wave / points + phase)));
    if (part > 0.1) expected.insert(expected.end(), 3, part);
  }
  std::sort(expected.rbegin(), expected.rend());
  const std::size_t n = 3 * points;
  ASSERT_EQ(expected.size(), 9u);
  ASSERT_EQ(basis.shapes.size(), 2 * n * expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k)
    for (std::size_t i = 0; i < expected.size(); ++i) {
      std::complex<double> strained = 0, in_contacts = 0;
      for (std::size_t j = 0; j < n; ++j) {
        const double *a = &basis.shapes[i * 2 * n + j], *b = &basis.shapes[k * 2 * n + j];
        const auto product = std::complex<double>(a[0], -a[n]) * std::complex<double>(b[0], b[n]);
        strained += basis.lambda[j] * product, in_contacts += contact * product;
      }
      EXPECT_NEAR(std::abs(strained - double(i == k)), 0, 1e-10);
      EXPECT_NEAR(std::abs(in_contacts - (i == k ? expected[k] : 0)), 0, 1e-3) << i << " " << k;
    }
}

TEST(JointShapes, of_complex_matrices_leave_out_what_nothing_holds) {
  ReducedModel model = grounded(8, [](int i) { return i % 3 == 0 ? 3.0 : 0.0; });
  const Layout layout(model, 1);
  SectorIndex index;
  index.kxx.assign(model.kxx.begin(), model.kxx.end()), index.mxx.assign(model.mxx.begin(), model.mxx.end());
  std::vector<double> springs(24);
  for (int i = 0; i < 24; ++i) springs[i] = i % 3 == 1 ? 0 : 1;
  const StuckBasis basis = std::move(stuck_bases(model, {&index}, springs, layout).at(0));
  ASSERT_EQ(basis.shapes.size(), 2 * 24u * 16);
  for (const double value : basis.shapes) EXPECT_LT(std::abs(value), 1.1); // 1 / sqrt(1)
}
