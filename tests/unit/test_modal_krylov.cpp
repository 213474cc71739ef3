// Solves by GMRES in the modes of the stuck structure: what they leave, how many iterations they take, what they tell.
#include <gtest/gtest.h>

#include <cmath>

#include "modal/modal_krylov.hpp"
#include "modal_scene.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

const Damping damped(0.05, 0.03, 0.02);

struct Krylov {
  double missed; // |J x - r| / |r|
  int iterations, sign;
  double left;
  bool converged;
};

Krylov solved(Scene &scene, double accuracy, int seed = 9) {
  ModalKrylov in_modes(scene.stuck, scene.layout);
  in_modes.begin(false);
  const UniqueVec r = vector_of(scene.system, 1, seed, 0.4);
  UniqueVec x = scene.system.unknowns(), product = scene.system.unknowns();
  in_modes.take(scene.parts(), r);
  const bool converged = in_modes.solve(r, x, accuracy, 300);
  check(MatMult(scene.J, x, product), "");
  return {relative_difference(product, r), in_modes.iterations(), in_modes.sign(), in_modes.left(), converged};
}

} // namespace

// Where nothing slips and nothing damps the springs the diagonal is all there is; with every mode among the motions of
// the coarse space, too.
TEST(ModalKrylov, takes_few_iterations_where_its_preconditioner_is_the_inverse) {
  for (const bool cyclic : {false, true})
    for (const bool corrected : {false, true}) {
      const Option lowest("-hb_modal_lowest", corrected ? "1000" : "0");
      Scene scene(corrected ? damped : Damping(0, 0.3), 4, {Law::coulomb, Law::coulomb, Law::coulomb}, cyclic);
      scene.move(corrected ? 2 : 1e-3);
      for (const int seed : {9, 10, 11}) {
        const Krylov found = solved(scene, 1e-5, seed);
        EXPECT_TRUE(found.converged);
        EXPECT_LE(found.iterations, corrected ? 3 : 2) << cyclic << corrected;
        EXPECT_LT(found.missed, 1e-3) << cyclic << corrected;
        EXPECT_LT(found.left, 5e-5);
      }
    }
}

TEST(ModalKrylov, tells_the_sign_of_the_determinant) {
  const Option lowest("-hb_modal_lowest", "4");
  int signs = 0;
  for (int seed = 0; seed < 8; ++seed) {
    Scene scene(damped, 3, {}, seed % 2 == 1);
    scene.move(0.3 * (seed + 1), seed / 2 + 7);
    const Krylov found = solved(scene, 1e-6);
    EXPECT_TRUE(found.converged);
    EXPECT_EQ(found.sign, scene.sign()) << seed;
    signs += found.sign;
  }
  EXPECT_LT(std::abs(signs), 8);
}

TEST(ModalKrylov, leaves_what_it_was_asked_for_and_counts) {
  const Option lowest("-hb_modal_lowest", "0");
  Scene scene(damped, 4);
  scene.move(4);
  int before = 0;
  for (const double accuracy : {1e-2, 1e-4, 1e-6}) {
    const Krylov found = solved(scene, accuracy);
    EXPECT_TRUE(found.converged);
    EXPECT_LT(found.missed, 30 * accuracy);
    EXPECT_GT(found.left, 0);
    EXPECT_LT(found.left, 1.1 * accuracy + 1e-5);
    EXPECT_GT(found.iterations, before);
    before = found.iterations;
  }
}

// Factors of all motions serve the Jacobians that follow, less well, until Newton's method begins again; and none is
// made for one Jacobian alone.
TEST(ModalKrylov, corrects_among_motions_by_factors_of_an_earlier_jacobian) {
  const Option lowest("-hb_modal_lowest", "1000");
  Scene scene(damped, 4);
  ModalKrylov in_modes(scene.stuck, scene.layout);
  const UniqueVec r = vector_of(scene.system, 1, 9, 0.4);
  UniqueVec x = scene.system.unknowns(), product = scene.system.unknowns();
  const auto iterations = [&](double accuracy) {
    EXPECT_TRUE(in_modes.solve(r, x, accuracy, 300));
    check(MatMult(scene.J, x, product), "");
    EXPECT_LT(relative_difference(product, r), 100 * accuracy);
    return in_modes.iterations();
  };
  EXPECT_TRUE(in_modes.corrected());
  EXPECT_EQ(in_modes.usual_accuracy(), 1e-4);
  in_modes.begin(false);
  scene.move(2);
  in_modes.take(scene.parts(), r);
  const int fresh = iterations(1e-4);
  EXPECT_LE(fresh, 2);
  EXPECT_LE(iterations(1e-5), 3);
  scene.move(3);
  in_modes.take(scene.parts(), r);
  const int stale = iterations(1e-4);
  EXPECT_GT(stale, 2 * fresh);
  in_modes.begin(false);
  in_modes.take(scene.parts(), r);
  EXPECT_LE(iterations(1e-4), 2);
  in_modes.begin(true);
  in_modes.take(scene.parts(), r);
  const int alone = iterations(1e-4);
  EXPECT_GT(alone, stale);
  in_modes.begin(false);
  in_modes.take(scene.parts(), r);
  EXPECT_LE(iterations(1e-4), 2);
}

// Another right side or border than the one before, also without a new start.
TEST(ModalKrylov, solves_for_what_it_is_given) {
  for (const char *few : {"0", "4"}) {
    const Option lowest("-hb_modal_lowest", few);
    Scene scene(damped, 4);
    ModalKrylov in_modes(scene.stuck, scene.layout);
    UniqueVec x = scene.system.unknowns(), product = scene.system.unknowns();
    in_modes.begin(false);
    for (const int seed : {9, 10, 11}) {
      scene.move(2, seed); // the border, too
      const UniqueVec r = vector_of(scene.system, 1, seed, 0.4), other = vector_of(scene.system, 2, seed + 5, -0.3);
      in_modes.take(scene.parts(), r);
      if (!in_modes.corrected()) EXPECT_FALSE(in_modes.solve(r, x, 1e-6, 2)); // it takes more
      for (const Vec given : {Vec(r), Vec(other), Vec(r)}) {
        EXPECT_TRUE(in_modes.solve(given, x, 1e-6, 300));
        check(MatMult(scene.J, x, product), "");
        EXPECT_LT(relative_difference(product, given), 1e-2) << few << seed; // it is judged in another norm
      }
    }
  }
}

// Of many iterations no basis is thrown away, so that the sign is that of all of them.
TEST(ModalKrylov, tells_the_sign_after_many_iterations) {
  const Option lowest("-hb_modal_lowest", "0");
  int signs = 0;
  for (int seed = 0; seed < 6; ++seed) {
    Scene scene(Damping(0.01, 0.01), 10);
    scene.move(2.5 + 0.5 * seed, seed / 2 + 7);
    const Krylov found = solved(scene, 1e-5);
    EXPECT_TRUE(found.converged);
    EXPECT_GT(found.iterations, 35);
    EXPECT_EQ(found.sign, scene.sign()) << seed;
    signs += found.sign;
  }
  EXPECT_LT(std::abs(signs), 6);
}
