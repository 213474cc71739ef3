// Factors of the Jacobian in modes by themselves, of contacts and of windows, against the assembled one.
#include <gtest/gtest.h>

#include <cmath>

#include "modal/window_factors.hpp"
#include "modal_scene.hpp"

using namespace dovetail;
using namespace dovetail::testing;

// Of all points they invert the Jacobian; of those that move only where nothing is damped by contacts.
TEST(ContactFactors, invert_the_jacobian) {
  int signs = 0, fewer = 0;
  for (const bool cyclic : {false, true})
    for (const auto &laws : {std::vector<Law>{}, several})
      for (const double size : {0.05, 0.4, 1.0, 4.0})
        for (const bool all : {true, false}) {
          Scene scene(all ? Damping(0.05, 0.03, 0.02) : Damping(0, 0.3), 4, laws, cyclic);
          scene.move(size, static_cast<int>(7 + 5 * size) + all);
          ContactFactors factors(scene.stuck, scene.layout);
          EXPECT_FALSE(factors.factored());
          factors.look_at(ContactDerivative(*scene.forces), all);
          ASSERT_TRUE(factors.factor(scene.parts(), true));
          EXPECT_LT(scene.missed_by(factors), 1e-9) << size << all << cyclic;
          ASSERT_TRUE(factors.factor(scene.parts(), true));
          EXPECT_LT(scene.missed_by(factors), 1e-9) << size << all << cyclic;
          EXPECT_EQ(factors.determinant_sign(), scene.sign()) << size << all << cyclic;
          signs += factors.determinant_sign();
          const int rows = laws.empty() ? 9 : 5; // without friction a point has one direction
          if (all) {
            EXPECT_EQ(factors.size(), rows * scene.layout.width);
            EXPECT_TRUE(factors.of_all());
            EXPECT_TRUE(factors.exact());
          }
          EXPECT_EQ(factors.of_all(), factors.size() == rows * scene.layout.width);
          fewer += factors.size() > 0 && !factors.of_all();
          factors.forget();
          EXPECT_FALSE(factors.factored());
        }
  EXPECT_GT(fewer, 3);
  EXPECT_LT(std::abs(signs), 31);
}

// Of points that stick, the damping of their springs off the diagonal: nothing where it is small, or else no more than
// that. The same from what is told as from a count.
TEST(ContactFactors, leave_out_little_of_what_sticks) {
  for (const double damping : {1e-3, 1e-2}) {
    Scene scene(damping, 4);
    scene.move(0.01);
    ContactFactors counted(scene.stuck, scene.layout), told(scene.stuck, scene.layout);
    const double own = told.own_moving(ContactDerivative(*scene.forces));
    double moving = own;
    MPI_Allreduce(MPI_IN_PLACE, &moving, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    counted.look_at(ContactDerivative(*scene.forces), false);
    told.look_at(ContactDerivative(*scene.forces), false, moving);
    EXPECT_EQ(counted.size(), moving * scene.layout.width);
    EXPECT_LT(moving, 9);
    EXPECT_EQ(told.size(), counted.size());
    ASSERT_TRUE(counted.factor(scene.parts()) && told.factor(scene.parts()));
    EXPECT_LT(scene.missed_by(counted), 10 * damping);
    EXPECT_EQ(scene.missed_by(told), scene.missed_by(counted));
    EXPECT_FALSE(counted.exact());
  }
}

TEST(ContactFactors, of_many_unknowns_are_in_single_precision_unless_told) {
  Scene scene(0.05, 20); // 9 rows of 41
  scene.move(1);
  ContactFactors factors(scene.stuck, scene.layout);
  factors.look_at(ContactDerivative(*scene.forces), true);
  ASSERT_TRUE(factors.factor(scene.parts()));
  const double rough = scene.missed_by(factors);
  EXPECT_LT(rough, 1e-3);
  EXPECT_GT(rough, 1e-8);
  EXPECT_FALSE(factors.exact());
  EXPECT_FALSE(factors.tells_sign());
  EXPECT_EQ(factors.determinant_sign(), scene.sign());
  ASSERT_TRUE(factors.factor(scene.parts(), true));
  EXPECT_LT(scene.missed_by(factors), 1e-10);
  EXPECT_TRUE(factors.exact() && factors.tells_sign());
}

TEST(ContactFactors, hold_means_where_bodies_are_held) {
  Scene scene(0.05, 3);
  scene.move(4);
  ContactFactors factors(scene.stuck, scene.layout), plain(scene.stuck, scene.layout);
  factors.look_at(ContactDerivative(*scene.forces), true), plain.look_at(ContactDerivative(*scene.forces), true);
  const Reals held(3 * scene.layout.own_points.size(), 2.5);
  JacobianParts parts = scene.parts();
  ASSERT_TRUE(plain.factor(parts, true));
  parts.held = held.data();
  ASSERT_TRUE(factors.factor(parts, true));
  const UniqueVec r = vector_of(scene.system, 1, 9, 0.4);
  UniqueVec x = scene.system.unknowns(), product = scene.system.unknowns();
  factors.solve(ReadValues(r), Values(x));
  check(MatMult(scene.J, x, product), "");
  {
    const ReadValues in(x);
    const Values out(product);
    for (std::size_t d = 0; d < held.size(); ++d) {
      const PetscInt at = scene.layout.own_point_offset(0) + static_cast<PetscInt>(d) * scene.layout.width;
      out[at] += 2.5 * in[at];
    }
  }
  EXPECT_LT(relative_difference(product, r), 1e-10);
}

TEST(ContactFactors, work_is_that_of_lapack_and_products) {
  for (const bool cyclic : {false, true}) {
    Scene other(0.05, 4, {}, cyclic);
    other.move(4);
    ContactFactors factors(other.stuck, other.layout);
    factors.look_at(ContactDerivative(*other.forces), true);
    const double rows = 9, width = 9, size = rows * width, length = cyclic ? 22 : 11;
    EXPECT_DOUBLE_EQ(factors.work(), size * size * size + 100 * size * size + 6 * width * rows * rows * length + 4e5);
    EXPECT_DOUBLE_EQ(factors.work_to_solve(), 12 * size * size + 8 * length * width * (rows + 11) + 1e5);
  }
}

TEST(ContactFactors, a_singular_matrix_is_told) {
  Scene scene(0.05, 3);
  scene.move(1);
  ContactFactors factors(scene.stuck, scene.layout);
  factors.look_at(ContactDerivative(*scene.forces), true);
  std::fill(scene.border.begin(), scene.border.end(), 0.0);
  EXPECT_FALSE(factors.factor(scene.parts(), true));
  EXPECT_EQ(factors.determinant_sign(), 0);
}

namespace {

// A motion that leaves every point open but for a crest or two.
Reals crests(const Layout &layout, double deep, int seed) {
  const int w = layout.width;
  Reals all(static_cast<std::size_t>(layout.dofs()) * w);
  for (PetscInt d = 0; d < layout.dofs(); ++d)
    for (int i = 1; i < w; ++i)
      all[d * w + i] = wave(seed, static_cast<int>(d) * w + i) * std::exp(-0.2 * ((i + 1) / 2));
  for (PetscInt p = 0; p < layout.points; ++p) all[(layout.modes + 3 * p + 2) * w] = -deep;
  return all;
}

} // namespace

// To what few waves leave, 1e-5 of each.
TEST(WindowFactors, all_but_invert_the_jacobian_where_contacts_are_open) {
  int signs = 0;
  for (int seed = 0; seed < 6; ++seed)
    for (const double deep : {1.0, 2.0, 60.0}) { // the last is always open
      Scene scene(Damping(0.05, 0.03), 20,
                  seed % 2 ? std::vector<Law>{} : std::vector{Law::unilateral, Law::coulomb, Law::coulomb});
      const StuckBases open = bases_of(scene.scaled, scene.layout, false);
      scene.move(crests(scene.layout, deep, seed), seed / 2 + 7);
      WindowFactors factors(open, scene.layout);
      ASSERT_TRUE(factors.look_at(*scene.forces, 1e12));
      ASSERT_TRUE(factors.factor(scene.parts()));
      EXPECT_LT(scene.missed_by(factors), deep == 60 ? 1e-10 : 1e-3) << seed << " " << deep;
      ASSERT_TRUE(factors.factor(scene.parts())); // nothing is left of the factors before
      EXPECT_LT(scene.missed_by(factors), deep == 60 ? 1e-10 : 1e-3) << seed << " " << deep;
      EXPECT_EQ(factors.determinant_sign(), scene.sign());
      EXPECT_EQ(factors.size() == 0, deep == 60);
      EXPECT_LT(factors.size(), 9 * scene.layout.width);
      EXPECT_FALSE(factors.exact());
      signs += factors.determinant_sign();
      const double work = factors.work();
      EXPECT_FALSE(factors.look_at(*scene.forces, 0.99 * work));
      EXPECT_FALSE(factors.factored());
      EXPECT_TRUE(factors.look_at(*scene.forces, 1.01 * work));
    }
  EXPECT_LT(std::abs(signs), 18);
}

TEST(WindowFactors, take_all_waves_of_points_that_are_closed_for_long) {
  Scene scene(Damping(0.05, 0.03), 8, {Law::bilateral, Law::coulomb, Law::unilateral});
  const StuckBases open = bases_of(scene.scaled, scene.layout, false);
  scene.move(0.05);
  WindowFactors factors(open, scene.layout);
  ASSERT_TRUE(factors.look_at(*scene.forces, 1e12));
  const double w = scene.layout.width, size = 5 * w, rows = 5, n = 11;
  EXPECT_EQ(factors.size(), size);
  ASSERT_TRUE(factors.factor(scene.parts()));
  EXPECT_LT(scene.missed_by(factors), 1e-9);
  double products = 0; // by waves and directions of each window
  for (const double directions : {1.0, 3.0, 1.0})
    products += 4 * w * w * w + 100 * w * w + 2 * size * size * directions * w;
  const double of_products = 3.5 * (2 * w + 0.7 * size) * size * size;
  EXPECT_NEAR(factors.work(), of_products + 3.5 * products + 6 * w * rows * rows * n + 2e5, 1e-6);
  EXPECT_NEAR(factors.work_to_solve(), 25 * size * size + 8 * w * (n * (rows + n) + size) + 1e5, 1e-6);
}

TEST(ContactFactors, of_up_to_300_unknowns_are_in_double_precision) {
  for (const int harmonics_ : {4, 16, 17}) { // 81, 297 and 315
    Scene scene(0.05, harmonics_);
    scene.move(1);
    ContactFactors factors(scene.stuck, scene.layout);
    factors.look_at(ContactDerivative(*scene.forces), true);
    ASSERT_TRUE(factors.factor(scene.parts()));
    EXPECT_EQ(scene.missed_by(factors) < 1e-9, harmonics_ < 17);
    EXPECT_EQ(factors.exact(), harmonics_ < 17);
  }
}
