// The modal form at its limits: which share of the unknowns a rank has, how many motions are corrected, exact
// resonances without damping, Omega by itself, signs of eigenvalues met.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "modal/modal_krylov.hpp"
#include "modal/window_factors.hpp"
#include "modal_scene.hpp"
#include "support/shell.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

StuckBases only(StuckBasis basis) {
  StuckBases bases;
  bases.of_index.push_back(std::make_shared<StuckBasis>(std::move(basis)));
  return bases;
}

Layout layout_of(PetscInt points, int harmonics) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD, model.points = points;
  model.own_modes = own_share(model.comm, 0), model.own_points = own_share(model.comm, points);
  return Layout(model, harmonics);
}

} // namespace

// Its matrix costs as much as eight iterations, or its factors do: of few dofs none are worth it.
TEST(ModalShare, motions_are_as_many_as_eight_iterations_are_worth) {
  const StuckBases bases = only({});
  int ranks;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const auto few = [&](PetscInt points, int harmonics) {
    return static_cast<int>(ModalShare(bases, layout_of(points, harmonics)).few);
  };
  EXPECT_EQ(few(83, 1), 0); // 249 dofs
  for (const int points : {84, 400})
    for (const int harmonics : {0, 1, 10}) {
      const double n = 3 * points, w = 2 * harmonics + 1;
      // 2 c^2 w^2 = 8 * 4 n w; 2/3 (c w)^3 = 8 * 4 n w * (contact dofs of a rank)
      const int by_matrix = static_cast<int>(std::sqrt(16 * n / w)),
                by_factors = static_cast<int>(std::cbrt(48 * n * n / ranks) / std::cbrt(w * w));
      EXPECT_EQ(few(points, harmonics), std::min(by_matrix, by_factors)) << points << " " << harmonics;
    }
}

TEST(ModalShare, whole_vectors_are_for_several_ranks_and_short_ones) {
  const Layout layout = layout_of(3, 1); // 28 unknowns
  int ranks;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  for (const auto &[most, dampers, everywhere] :
       {std::tuple{"28", false, true}, {"27", false, false}, {"28", true, false}}) {
    const Option option("-hb_modal_whole", most);
    StuckBasis basis;
    if (dampers) basis.viscous = Slab<float>(1, 9);
    const ModalShare share(only(std::move(basis)), layout);
    EXPECT_EQ(share.everywhere, everywhere && ranks > 1);
    const Range own = own_share(layout.comm, 9);
    EXPECT_EQ(share.own.begin, share.everywhere ? 0 : own.begin);
    EXPECT_EQ(share.own.end, share.everywhere ? 9 : own.end);
    EXPECT_EQ(share.holds_last, share.everywhere || layout.owns_omega());
    EXPECT_EQ(share.comm, share.everywhere ? MPI_COMM_SELF : layout.comm);
  }
  EXPECT_EQ(ModalShare(only({}), layout_of(1000, 3)).everywhere, false); // 21001 unknowns
  EXPECT_EQ(ModalShare(only({}), layout_of(900, 3)).everywhere, ranks > 1);
}

namespace {

// So many dofs of frequencies 1, 2, 3 and so on; the joint holds a half of what the last three have.
struct Grounded {
  static double spring(int dof) { return dof < 297 ? 1e-6 : std::pow(1 + dof, 2) / 2; }
  ReducedModel model = grounded(100, [](int i) { return std::pow(1 + i, 2) - spring(i); });
  Layout layout{model, 1};
  std::vector<ContactPoint> points;
  StuckBases bases = only(basis());
  ContactForces forces{points, std::vector<Standstill>(points.size(), {{0, 0, 1}, {0, 0, 1e6}, {}}), 1, exactly};

  StuckBasis basis() {
    points.clear();
    for (int p = static_cast<int>(model.own_points.begin); p < model.own_points.end; ++p)
      points.push_back({Law::coulomb, spring(3 * p + 2), {spring(3 * p), spring(3 * p + 1)}, {1, 1}, 0});
    return stuck_basis(model, stuck_springs(points), layout);
  }
  PetscInt motions(double omega, const Damping &damping = 0.05) {
    Reals still(points.size() * 9), G(still.size());
    forces.evaluate(still.data(), G.data());
    const ModalShare share(bases, layout);
    const DynamicStiffness structure(damping, omega);
    ModalOperator contacts(bases, layout, share);
    contacts.take(ContactDerivative(forces), nullptr, structure);
    CoarseSpace space(bases, layout, share);
    std::vector<float> matrix = space.part(contacts, structure);
    MPI_Allreduce(MPI_IN_PLACE, matrix.data(), static_cast<int>(matrix.size()), MPI_FLOAT, MPI_SUM, layout.comm);
    space.factor(std::move(matrix), structure);
    return space.size() / 3;
  }
};

} // namespace

TEST(CoarseSpaceSize, is_of_modes_to_half_as_much_again_and_of_the_joint) {
  Grounded scene;
  ASSERT_EQ(scene.bases.mean().shapes.size(), 300u * 3);
  const PetscInt most = ModalShare(scene.bases, scene.layout).few;
  ASSERT_EQ(most, alone() ? 40 : most);
  for (const int near : {1, 2, 7, 20}) { // modes below 1.5 omega
    EXPECT_EQ(scene.motions((near + 0.9) / 1.5), near + 3);
    EXPECT_EQ(scene.motions((near + 1.1) / 1.5), near + 1 + 3);
  }
  EXPECT_EQ(scene.motions(0.1), 1 + 3); // one at least
  EXPECT_EQ(scene.motions(190), most);
  const Option few("-hb_modal_lowest", "5");
  EXPECT_EQ(scene.motions(190), 5 + 3);
}

TEST(CoarseSpaceSize, is_nothing_where_the_diagonal_is_singular) {
  Grounded scene;
  StuckBasis rigid = scene.basis();
  rigid.lambda[0] = rigid.damped[0] = 0;
  scene.bases = only(std::move(rigid));
  EXPECT_EQ(scene.motions(1), 0);
}

// The first mode, of the first harmonic, to the last bit; nothing damps it. It is as if held.
TEST(ExactResonance, leaves_numbers_in_all_that_divide_by_it) {
  Scene scene(Damping(0, 0), 2);
  scene.move(2);
  StuckBasis tuned = stuck_basis(scene.scaled.model.reduced, stuck_springs(scene.scaled.model.contact), scene.layout);
  tuned.lambda[0] = scene.system.structure(scene.omega).inertia(1);
  ASSERT_EQ(scene.system.structure(scene.omega).in_phase(1, tuned.lambda[0], 1), 0);
  const StuckBases bases = only(std::move(tuned));
  const UniqueVec r = vector_of(scene.system, 1, 9, 0.4);
  UniqueVec x = scene.system.unknowns();
  ContactFactors factors(bases, scene.layout);
  factors.look_at(ContactDerivative(*scene.forces), true);
  ASSERT_TRUE(factors.factor(scene.parts(), true));
  factors.solve(ReadValues(r), Values(x));
  EXPECT_TRUE(std::isfinite(norm(x)) && norm(x) < 1e3);
  const Option lowest("-hb_modal_lowest", "0");
  ModalKrylov in_modes(bases, scene.layout);
  in_modes.begin(false), in_modes.take(scene.parts(), r);
  in_modes.solve(r, x, 1e-4, 300);
  EXPECT_TRUE(std::isfinite(norm(x)) && norm(x) < 1e3);
}

// The last equation says Omega = 0.4 / 0.2 and nothing else, and no other has a part of it.
TEST(OmegaByItself, is_solved_for) {
  Scene scene(Damping(0.05, 0.03), 2);
  scene.move(2);
  std::fill(scene.column.begin(), scene.column.end(), 0.0);
  const bool last = scene.layout.owns_omega();
  std::fill(scene.border.begin(), scene.border.end() - last, 0.0);
  if (last) scene.border.back() = 0.2;
  scene.system.fill(scene.J, scene.system.structure(scene.omega), scene.column.data(), scene.border.data());
  for (const char *few : {"0", "4"}) {
    const Option lowest("-hb_modal_lowest", few);
    ModalKrylov in_modes(scene.stuck, scene.layout);
    in_modes.begin(false);
    const UniqueVec r = vector_of(scene.system, 1, 9, 0.4);
    UniqueVec x = scene.system.unknowns(), product = scene.system.unknowns();
    in_modes.take(scene.parts(), r);
    EXPECT_TRUE(in_modes.solve(r, x, 1e-6, 300));
    check(MatMult(scene.J, x, product), "");
    EXPECT_LT(relative_difference(product, r), 1e-3);
    EXPECT_NEAR(scene.system.parameter_in(x), 2, 1e-3);
  }
}

namespace {

// Of a diagonal matrix, by GMRES with as many iterations.
int sign_met(const Reals &diagonal, double right, int iterations) {
  const PetscInt n = static_cast<PetscInt>(diagonal.size());
  UniqueMat A;
  UniqueVec b, x;
  UniqueKSP ksp;
  check(MatCreateAIJ(PETSC_COMM_SELF, n, n, n, n, 1, nullptr, 0, nullptr, A.out()), "");
  for (PetscInt i = 0; i < n; ++i) check(MatSetValue(A, i, i, diagonal[i], INSERT_VALUES), "");
  check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY), ""), check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY), "");
  check(MatCreateVecs(A, x.out(), b.out()), "");
  check(VecSet(b, right), "");
  check(KSPCreate(PETSC_COMM_SELF, ksp.out()), "");
  check(KSPSetOperators(ksp, A, A), "");
  check(KSPSetType(ksp, KSPGMRES), "");
  check(KSPGMRESSetRestart(ksp, 300), "");
  PC pc;
  check(KSPGetPC(ksp, &pc), "");
  check(PCSetType(pc, PCNONE), "");
  check(KSPSetComputeEigenvalues(ksp, PETSC_TRUE), "");
  check(KSPSetTolerances(ksp, 1e-9, 0, 1e30, iterations), "");
  check(KSPSolve(ksp, b, x), "");
  return sign_of_met(ksp);
}

} // namespace

TEST(SignOfMet, is_that_of_negative_eigenvalues) {
  EXPECT_EQ(sign_met({1, 2, 3}, 1, 20), 1);
  EXPECT_EQ(sign_met({1, -2, 3}, 1, 20), -1);
  EXPECT_EQ(sign_met({-1, -2, 3}, 1, 20), 1);
  EXPECT_EQ(sign_met({-1, -2, -3}, 1, 20), -1);
  EXPECT_EQ(sign_met({-5}, 1, 20), -1);
  EXPECT_EQ(sign_met({-1, -2, -3}, 0, 20), 0); // nothing to do, nothing met
  EXPECT_EQ(sign_met({-1, -2, -3}, 1, 2), 0);  // not solved
  Reals many;
  for (int i = 1; i <= 160; ++i) many.push_back(i % 2 ? i : -i);
  EXPECT_EQ(sign_met(many, 1, 300), 0); // of more than 150 iterations the last ones would tell
}

TEST(WindowsOfLaws, have_none_of_laws_that_are_not_piecewise_linear) {
  Scene scene(0.05, 8, {Law::unilateral, Law::cone, Law::coulomb});
  const StuckBases open = bases_of(scene.scaled, scene.layout, false);
  scene.move(1);
  WindowFactors factors(open, scene.layout);
  EXPECT_FALSE(factors.look_at(*scene.forces, 1e12));
}

// Reduced matrices are held once.
TEST(ModalMemory, matrices_are_not_held_twice) {
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal})
    for (const bool cyclic : {false, true}) {
      const HarmonicSystem system = sector_system(1, exactly, {}, 0.05, {}, cyclic, form);
      const ReducedModel &held = system.scaled().model.reduced;
      EXPECT_TRUE(held.kxx.empty() && held.mxx.empty() && held.mxa.empty());
      EXPECT_EQ(held.kxx.capacity() + held.mxx.capacity() + held.mxa.capacity(), 0u);
      if (cyclic) EXPECT_THROW(system.couplings(), ComputeError); // others in every harmonic
      for (const SectorIndex &index : held.indices)
        EXPECT_TRUE(index.kxx.empty() && index.mxx.empty() && index.mxa.empty() && index.loads.empty());
    }
  Damping damping(0.05, 0, 0.1);
  damping.matrix = damping.of_parts = true;
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal}) {
    const HarmonicSystem system = small_system(form, exactly, {}, damping);
    const ReducedModel &held = system.scaled().model.reduced;
    EXPECT_EQ(held.viscous.aa.empty(), form == LinearForm::modal);
    EXPECT_EQ(held.structural.aa.empty(), form == LinearForm::modal);
  }
}
