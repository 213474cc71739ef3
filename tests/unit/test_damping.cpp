// Every kind of damping in both forms of the harmonic system, on as many ranks as the test runs with.
#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <tuple>

#include "harmonic/left_out_forces.hpp"
#include "small_system.hpp"
#include "stability/large_stability.hpp"
#include "stability/stability.hpp"
#include "transient/flow.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

Damping with_ratios(Damping damping) {
  damping.ratios = {{1, 0.03}, {5, 0.01}, {2, 0.002}};
  return damping;
}

Damping with_matrix(Damping damping) {
  damping.matrix = true;
  return damping;
}

Damping of_parts(Damping damping) {
  damping.of_parts = true;
  return damping;
}

Damping with_springs(Damping damping) {
  damping.contact = true;
  return damping;
}

Damping of_fixed_modes(Damping damping) {
  damping.ratios = {{1, 0.03}, {2, 0.01}}, damping.of_fixed = true;
  return damping;
}

// In the modes of the stuck structure.
const std::vector<Damping> diagonal = {
    {0, 0.06, 0}, {0, 0, 0.05}, {0.05, 0.03, 0.02}, with_ratios({}), with_ratios({0.02, 0.03, 0.02})};

const std::vector<Damping> full = {with_matrix({}),
                                   with_matrix(with_ratios({0.02, 0.03, 0.02})),
                                   of_parts({0, 0, 0.2}),
                                   of_parts(with_matrix({0.02, 0.03, 0.1})),
                                   with_springs(0.05),
                                   of_fixed_modes({}),
                                   with_springs(of_fixed_modes(with_matrix(of_parts({0.05, 0.01, 0.1}))))};

std::vector<Damping> all_kinds() {
  std::vector<Damping> kinds = diagonal;
  kinds.insert(kinds.end(), full.begin(), full.end());
  return kinds;
}

const std::vector<Damping> kinds = all_kinds();

struct Solved {
  double missed; // |J x - r| / |r|
  int iterations;
};

// A modal system's equations at a motion of that size, where KSP is asked for `accuracy`.
Solved solved(const Damping &damping, double size, double accuracy) {
  HarmonicSystem system = small_system(LinearForm::modal, exactly, {}, damping);
  const UniqueVec y = vector_of(system, size, 3, 1.3), border = vector_of(system, 1, 7, 0.2),
                  r = vector_of(system, 1, 9, 0.4);
  UniqueVec x = system.unknowns(), product = system.unknowns();
  const UniqueMat J = system.matrix();
  UniqueKSP ksp;
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
  system.set_up(ksp, J);
  system.jacobian(y, border, J);
  check(KSPSetOperators(ksp, J, J), "");
  check(KSPSetTolerances(ksp, accuracy, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
  check(KSPSolve(ksp, r, x), "");
  check(MatMult(J, x, product), "");
  return {relative_difference(product, r), system.take_effort(J, 1).iterations};
}

// What its iterations are measured by: xi K, or the same without its ratios where it has nothing else.
Damping usual(Damping damping) {
  if (damping.ratios.empty() || damping.matrix || damping.of_parts || damping.contact || damping.of_fixed) return 0.05;
  damping.ratios.clear();
  return damping;
}

// All stuck; slip; slip and lift-off.
std::vector<double> sizes() { return alone() ? std::vector{0.05, 1.0, 4.0} : std::vector{4.0}; }

} // namespace

TEST(DynamicStiffness, is_formula_A) {
  const double K = 3, M = 0.7, omega = 1.3;
  const Damping damping(0.05, 0.03, 0.02);
  const DynamicStiffness structure(damping, omega);
  for (int k = 0; k < 4; ++k) {
    using Complex = std::complex<double>;
    const double w = k * omega;
    const Complex kappa(1, w * damping.stiffness + (k > 0 ? damping.structural : 0)), mu(w * w, -w * damping.mass),
        D = kappa * K - mu * M;
    EXPECT_NEAR(structure.in_phase(k, K, M), D.real(), 1e-15);
    EXPECT_NEAR(structure.quadrature(k, K, M), D.imag(), 1e-15);
    const DynamicStiffness more(damping, omega + 1e-4), less(damping, omega - 1e-4);
    EXPECT_NEAR(structure.inertia_slope(k), (more.inertia(k) - less.inertia(k)) / 2e-4, 1e-10);
    EXPECT_NEAR(structure.loss_slope(k), (more.loss(k) - less.loss(k)) / 2e-4, 1e-10);
    EXPECT_NEAR(structure.drag_slope(k), (more.drag(k) - less.drag(k)) / 2e-4, 1e-10);
  }
}

TEST(Damping, derivatives_are_those_of_differences) { // by the motion and by the frequency
  for (const Damping &damping : kinds)
    for (const LinearForm form : {LinearForm::assembled, LinearForm::modal})
      for (const double size : sizes()) {
        HarmonicSystem system = small_system(form, exactly, {}, damping);
        const UniqueVec y = vector_of(system, size, 3, 1.3);
        for (const UniqueVec &v : {vector_of(system, 1, 5, 0), vector_of(system, 0, 5, 1)})
          EXPECT_LT(directional_error(system, y, v), 1e-8) << size;
      }
}

TEST(Damping, modal_form_is_the_assembled_one) {
  for (const Damping &damping : kinds)
    for (const double size : sizes()) {
      const auto [residual, jacobian] = forms_differ(exactly, {}, damping, size);
      EXPECT_LT(residual, 1e-14);
      EXPECT_LT(jacobian, 1e-13) << size;
    }
}

// By factors, in the modes, and with few motions corrected. Dampers between modes, which factors leave out, cost GMRES
// no more than about half as many iterations as there are unknowns, 77.
TEST(Damping, the_modal_form_is_solved_with) {
  for (const auto &[factors, modes] : {std::pair{"4000", "0"}, {"0", "0"}, {"0", "4"}}) {
    const Option most("-hb_factors_most", factors), lowest("-hb_modal_lowest", modes);
    for (const double size : sizes())
      for (const auto &[some, times, more] : {std::tuple{&diagonal, 1.5, 4}, {&full, 2.0, 40}})
        for (const Damping &damping : *some) {
          const Solved one = solved(damping, size, 1e-10), plain = solved(usual(damping), size, 1e-10);
          EXPECT_LT(one.missed, 1e-8) << size << " " << factors << " " << modes;
          EXPECT_LE(one.iterations, times * plain.iterations + more) << size << " " << factors << " " << modes;
        }
  }
}

TEST(Damping, factors_of_all_points_are_exact) { // more than was asked: they tell the determinant's sign
  for (const Damping &damping : diagonal) EXPECT_LT(solved(damping, 4, 1e-8).missed, 1e-11);
}

// A mode kept in one model and left out of the other, in the motion that its own equation gives it.
TEST(Damping, modes_left_out_are_damped_as_those_kept) {
  using Complex = std::complex<double>;
  const double square = 9, load = 0.7, omega = 1.3;
  const std::vector<double> fourier = {0.2, 1.0, 0.3, 0.1, -0.4, 0, 0};
  ReducedModel few = small_reduced(PETSC_COMM_WORLD), many = few;
  many.modes = 3, many.own_modes = own_share(many.comm, 3);
  many.kaa.push_back(square), many.loads[0].fa.push_back(load);
  few.left_out.squares = {square}, few.left_out.loads = {{load}}, few.left_out.with_modes = {0, 0};
  const auto coupling = [](PetscInt contact_dof) { return 0.3 * wave(static_cast<int>(contact_dof), 70); };
  many.mxa.clear();
  for (PetscInt i = 0; i < few.own_contact_dofs(); ++i) {
    few.left_out.coupling.push_back(coupling(3 * few.own_points.begin + i));
    for (const double m : {few.mxa[2 * i], few.mxa[2 * i + 1], few.left_out.coupling.back()}) many.mxa.push_back(m);
  }
  const auto system_of = [&](ReducedModel model, const Damping &damping) {
    std::vector<ContactPoint> contact = small_contact(model);
    const std::vector<double> zero(model.own_contact_dofs(), 0.0);
    std::string note;
    return HarmonicSystem(scaled(contact_preload(std::move(model), std::move(contact), zero, note), damping, {}), 3,
                          exactly, course(fourier));
  };
  for (const Damping &damping : {Damping(0.05), Damping(0, 1.2), Damping(0, 0, 0.3), Damping(0.05, 0.8, 0.2)}) {
    HarmonicSystem small = system_of(few, damping), large = system_of(many, damping);
    const int w = small.layout().width;
    UniqueVec y = vector_of(small, 1, 3, omega), f = small.unknowns(), left = small.unknowns();
    UniqueVec z = large.unknowns(), g = large.unknowns();
    std::vector<double> q = all_coefficients(small.layout(), y), mode(w, 0.0);
    for (int k = 1; k <= 3; ++k) {
      const double speed = k * omega;
      const Complex kappa(1, speed * damping.stiffness + damping.structural), mu(speed * speed, -speed * damping.mass);
      Complex force = load * Complex(fourier[cosine(k)], -fourier[sine(k)]);
      for (int c = 0; c < 9; ++c)
        force += mu * coupling(c) * Complex(q[(2 + c) * w + cosine(k)], -q[(2 + c) * w + sine(k)]);
      const Complex a = force / (kappa * square - mu);
      mode[cosine(k)] = a.real(), mode[sine(k)] = -a.imag();
    }
    q.insert(q.begin() + 2 * w, mode.begin(), mode.end());
    set_coefficients(large.layout(), q, z);
    if (large.layout().owns_omega()) check(VecSetValue(z, large.layout().omega_row(), omega, INSERT_VALUES), "");
    check(VecAssemblyBegin(z), "");
    check(VecAssemblyEnd(z), "");
    small.residual(y, f), large.residual(z, g);
    const LeftOutModes modes(small, y);
    modes.forces(modes.motion(y, 1), left);
    const std::vector<double> plain = all_coefficients(small.layout(), f),
                              more = all_coefficients(small.layout(), left),
                              whole = all_coefficients(large.layout(), g);
    double largest = 0;
    for (int d = 0; d < 12; ++d)
      for (int i = 1; i < w; ++i) {
        const int row = d < 2 ? d : d - 1; // in the small model
        const double expected = d == 2 ? 0 : plain[row * w + i] + more[row * w + i];
        EXPECT_NEAR(whole[d * w + i], expected, 1e-12);
        if (d > 2) largest = std::max(largest, std::abs(more[row * w + i]));
      }
    EXPECT_GT(largest, 0.01);
  }
}

TEST(Damping, is_the_same_in_other_units) { // each row of the scaled system is a fixed multiple of the unscaled one
  const Scales scales{2, 1.4, 0.65};
  Damping damping = with_springs(with_matrix(of_parts({0.05, 0.03, 0.02})));
  const auto system = [&](const Scales &by) {
    PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
    add_damping_matrices(damping, model.reduced);
    return HarmonicSystem(scaled(std::move(model), damping, by), 3, exactly, course({0.2, 1.0, 0.3}));
  };
  for (const bool fixed : {true, false}) {
    damping = fixed ? of_fixed_modes(damping) : with_ratios(damping), damping.of_fixed = fixed;
    HarmonicSystem plain = system({}), other = system(scales);
    const UniqueVec y = vector_of(plain, 1, 3, 1.3), z = vector_of(other, 1, 3, 1.3 / scales.frequency);
    UniqueVec f = plain.unknowns(), g = other.unknowns();
    const PetscInt modal = plain.layout().own_modes.size() * plain.layout().width,
                   all = plain.layout().own_coefficients();
    double *of_z, *of_g;
    check(VecGetArray(z, &of_z), "");
    for (PetscInt i = 0; i < all; ++i) of_z[i] /= i < modal ? scales.modal : scales.contact;
    check(VecRestoreArray(z, &of_z), "");
    plain.residual(y, f), other.residual(z, g);
    check(VecGetArray(g, &of_g), "");
    const double acceleration = scales.modal * scales.frequency * scales.frequency;
    for (PetscInt i = 0; i < all; ++i) of_g[i] *= acceleration * (i < modal ? 1 : scales.modal / scales.contact);
    check(VecRestoreArray(g, &of_g), "");
    EXPECT_LT(relative_difference(g, f), 1e-13);
  }
}

TEST(Damping, other_harmonics_keep_the_dampers) {
  for (const Damping &damping : kinds) {
    HarmonicSystem more(small_system(LinearForm::assembled, exactly, {}, damping), 5, exactly);
    const std::unique_ptr<HarmonicSystem> modal = HarmonicSystem::modal(more, 5, exactly);
    const UniqueVec y = vector_of(more, 1, 3, 1.3), v = vector_of(more, 1, 5, 0.7);
    UniqueVec f = more.unknowns(), g = more.unknowns();
    more.residual(y, f), modal->residual(y, g);
    EXPECT_LT(relative_difference(g, f), 1e-13);
    EXPECT_LT(directional_error(more, y, v), 1e-8);
    EXPECT_LT(directional_error(*modal, y, v), 1e-8);
  }
}

TEST(Damping, springs_of_contacts_are_those_that_stick_at_the_preload) {
  const auto model_of = [](Law law, const Damping &damping) {
    PreloadedModel model = preloaded({law, law, law}, 12, {});
    return dense_model(HarmonicSystem(scaled(std::move(model), damping, {}), 3, exactly, course({0.2, 1.0, 0.3})));
  };
  for (const Law law : {Law::coulomb, Law::cone}) {
    EXPECT_TRUE(model_of(law, 0.05).C.empty());
    const DenseModel model = model_of(law, with_springs(0.05));
    int slips = 0, sticks = 0; // of all points, on every rank
    for (int r = 0; r < model.dofs(); ++r)
      for (int c = 0; c < model.dofs(); ++c) {
        double expected = 0;
        if (r == c && r >= model.modes) {
          const int d = (r - model.modes) % 3;
          const ContactPoint &point = model.contact[(r - model.modes) / 3];
          const std::array<double, 3> &force = model.standstill[(r - model.modes) / 3].force;
          ASSERT_GT(force[2], 0);
          const double size = law == Law::cone ? std::hypot(force[0], force[1]) : std::abs(force[d]);
          const bool stuck = d == 2 || size < (1 - 1e-9) * point.mu[d] * force[2];
          ++(stuck ? sticks : slips);
          expected = !stuck ? 0 : 0.05 * (d == 2 ? point.kn : point.kt[d]);
        }
        EXPECT_NEAR(model.C[r * model.dofs() + c], expected, 1e-15);
      }
    EXPECT_GT(slips, 0);
    EXPECT_GT(sticks, 3); // not only normal springs
  }
}

TEST(Damping, without_motions_in_time_nothing_is_judged_by_them) {
  for (const Damping &damping : {Damping(0, 0, 0.02), of_parts({0, 0, 0.02})}) {
    const HarmonicSystem system = small_system(LinearForm::assembled, exactly, {}, damping);
    const DenseModel model = dense_model(system);
    EXPECT_THROW(Flow(model, 1.0), ComputeError);
    EXPECT_THROW(StabilityTest{model}, ComputeError);
    EXPECT_THROW(LargeStabilityTest{system}, ComputeError);
  }
}
