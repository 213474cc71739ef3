// Residual and Jacobian of the harmonic-balance system, on as many ranks as the test runs with.
#include <gtest/gtest.h>

#include "harmonic/harmonic_system.hpp"
#include "norms.hpp"
#include "small_model.hpp"
#include "support/error.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr int harmonics = 3;
const std::vector<double> fourier = {0.2, 1.0, 0.3, 0.0, 0.2};

HarmonicSystem small_system(double scale = 1, int samples = 64, const std::vector<Law> &laws = {}) {
  PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
  for (std::size_t p = 0; !laws.empty() && p < model.contact.size(); ++p)
    model.contact[p].law = laws[model.reduced.own_points.begin + p];
  const Scales scales{scale, 0.7 * scale, 1.3 / scale};
  return HarmonicSystem(scaled(std::move(model), 0.05, scale == 1 ? Scales{} : scales), harmonics, samples,
                        course(fourier));
}

// A motion of the given size, the same on any number of ranks; `seed` picks another.
UniqueVec motion(const HarmonicSystem &system, double size, int seed, double omega) {
  const Layout &layout = system.layout();
  UniqueVec y = system.unknowns();
  double *own;
  check(VecGetArray(y, &own), "");
  const int n = layout.width;
  for (PetscInt j = 0; j < layout.own_modes.size(); ++j)
    for (int i = 0; i < n; ++i) own[j * n + i] = size * wave(seed + i, layout.own_modes.begin + j);
  for (PetscInt d = 0; d < 3 * layout.own_points.size(); ++d)
    for (int i = 0; i < n; ++i)
      own[(layout.own_modes.size() + d) * n + i] = size * wave(seed + i, 10 + 3 * layout.own_points.begin + d);
  if (layout.owns_omega()) own[layout.own_coefficients()] = omega;
  check(VecRestoreArray(y, &own), "");
  return y;
}

} // namespace

TEST(HarmonicSystem, jacobian_in_slip_lift_off_and_stick) {
  HarmonicSystem system = small_system();
  for (const double size : {0.004, 0.06, 0.6}) { // from all stuck to all opening
    const UniqueVec y = motion(system, size, 3, 0.8);
    for (int seed = 100; seed < 104; ++seed) {
      const UniqueVec v = motion(system, 1, seed, 0);
      EXPECT_LT(directional_error(system, y, v), 1e-8) << "size " << size;
    }
  }
}

TEST(HarmonicSystem, derivative_of_every_law_and_evaluation) {
  for (const auto &[samples, laws] : {std::pair<int, std::vector<Law>>{exactly, {}},
                                      {exactly, {Law::cone, Law::bilateral, Law::unilateral}},
                                      {64, {Law::unilateral, Law::coulomb, Law::cone}}}) {
    HarmonicSystem system = small_system(1, samples, laws);
    for (const double size : {0.004, 0.06, 0.6}) {
      const UniqueVec y = motion(system, size, 7, 0.8);
      for (int seed = 100; seed < 104; ++seed) {
        const UniqueVec v = motion(system, 1, seed, 0);
        EXPECT_LT(directional_error(system, y, v), 1e-8) << "samples " << samples << ", size " << size;
      }
    }
  }
}

TEST(HarmonicSystem, every_contact_state_occurs) { // else the test above shows less than it says
  HarmonicSystem system = small_system();
  std::array<long, 3> seen{}; // stuck, slips, opens
  for (const double size : {0.004, 0.06, 0.6}) {
    const UniqueVec y = motion(system, size, 3, 0.8);
    UniqueVec f = system.unknowns();
    system.residual(y, f);
    for (const Activity &did : system.activity()) ++seen[did.open > 0 ? 2 : did.slip > 0 ? 1 : 0];
  }
  MPI_Allreduce(MPI_IN_PLACE, seen.data(), 3, MPI_LONG, MPI_SUM, PETSC_COMM_WORLD);
  for (const long count : seen) EXPECT_GT(count, 0);
}

TEST(HarmonicSystem, derivative_by_omega) { // eq (13)
  HarmonicSystem system = small_system();
  const UniqueVec y = motion(system, 0.3, 5, 1.3), v = motion(system, 0, 0, 1);
  EXPECT_LT(directional_error(system, y, v), 1e-9);
}

TEST(HarmonicSystem, border_is_the_last_row) {
  HarmonicSystem system = small_system();
  const UniqueVec y = motion(system, 0.3, 5, 1.3), border = motion(system, 1, 9, 0.5), v = motion(system, 1, 17, -0.4);
  UniqueVec product = system.unknowns();
  const UniqueMat J = system.matrix();
  system.jacobian(y, border, J);
  check(MatMult(J, v, product), "");
  double wanted;
  check(VecDot(border, v, &wanted), "");
  EXPECT_NEAR(system.parameter_in(product), wanted, 1e-12 * std::abs(wanted));
}

TEST(HarmonicSystem, linear_part_is_eq_11) { // row by row against the formulas, where no contact acts
  ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  PreloadedModel open{model, small_contact(model), std::vector<Standstill>(model.own_points.size())};
  for (ContactPoint &point : open.contact) point.gap = 1e6;
  const double xi = 0.05, omega = 0.9;
  HarmonicSystem system(scaled(std::move(open), xi, {}), harmonics, 16, course(fourier));
  const Layout &layout = system.layout();
  const int n = layout.width;
  // One modal and one contact unknown of harmonic 2 moves; every row's answer is known.
  for (const PetscInt row : {layout.mode_row(1), layout.contact_row(4)}) {
    const bool modal = row == layout.mode_row(1);
    UniqueVec y = system.unknowns(), f = system.unknowns();
    if (layout.rank == 0) check(VecSetValue(y, row * n + sine(2), 1.0, INSERT_VALUES), "");
    if (layout.rank == 0) check(VecSetValue(y, layout.omega_row(), omega, INSERT_VALUES), "");
    check(VecAssemblyBegin(y), ""), check(VecAssemblyEnd(y), "");
    system.residual(y, f);
    const double *own;
    check(VecGetArrayRead(f, &own), "");
    const double z = 2 * omega;
    for (PetscInt i = 0; i < model.own_contact_dofs(); ++i) {
      const double *at = own + (layout.own_modes.size() + i) * n;
      const double k = modal ? 0 : model.kxx[i * 9 + 4], m = modal ? model.mxa[i * 2 + 1] : model.mxx[i * 9 + 4];
      EXPECT_NEAR(at[sine(2)], k - z * z * m - model.loads[0].fx[i] * 0.2, 1e-13);
      EXPECT_NEAR(at[cosine(2)], z * xi * k, 1e-13);
      EXPECT_NEAR(at[0], -model.loads[0].fx[i] * 0.2, 1e-13);
      EXPECT_NEAR(at[cosine(1)], -model.loads[0].fx[i], 1e-13);
    }
    for (PetscInt j = 0; j < layout.own_modes.size(); ++j) {
      const PetscInt mode = layout.own_modes.begin + j;
      const double k = modal && mode == 1 ? 4 : 0, load = model.loads[0].fa[mode] * 0.2;
      if (modal) {
        EXPECT_NEAR(own[j * n + sine(2)], k - z * z * (mode == 1) - load, 1e-13);
        EXPECT_NEAR(own[j * n + cosine(2)], z * xi * k, 1e-13);
      }
    }
    check(VecRestoreArrayRead(f, &own), "");
  }
}

TEST(Scaling,
     residual_is_the_same_in_other_units) { // each row of the scaled system is a fixed multiple of the unscaled one
  HarmonicSystem plain = small_system(), other = small_system(2.0);
  const Scales &s = other.scales();
  const UniqueVec y = motion(plain, 0.3, 5, 1.3);
  UniqueVec z = motion(other, 0.3, 5, 1.3 / s.frequency), f = plain.unknowns(), g = other.unknowns();
  const PetscInt modal = plain.layout().own_modes.size() * plain.layout().width,
                 all = plain.layout().own_coefficients();
  double *own;
  check(VecGetArray(z, &own), "");
  for (PetscInt i = 0; i < all; ++i) own[i] /= i < modal ? s.modal : s.contact;
  check(VecRestoreArray(z, &own), "");
  plain.residual(y, f);
  other.residual(z, g);
  const double *a, *b;
  check(VecGetArrayRead(f, &a), "");
  check(VecGetArrayRead(g, &b), "");
  const double w2 = s.frequency * s.frequency;
  for (PetscInt i = 0; i < all; ++i)
    EXPECT_NEAR(a[i], b[i] * (i < modal ? s.modal * w2 : s.modal * s.modal * w2 / s.contact), 1e-12);
  check(VecRestoreArrayRead(f, &a), "");
  check(VecRestoreArrayRead(g, &b), "");
}
