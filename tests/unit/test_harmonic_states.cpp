// What a harmonic system answers does not depend on what it was asked before: another motion, another parameter, or the
// same ones. On any number of ranks.
#include <gtest/gtest.h>

#include <cmath>

#include "continuation/problem.hpp"
#include "modal/dampers.hpp"
#include "small_sector.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Reals = std::vector<double>;

Damping all_kinds() {
  Damping damping(0.05, 0.03, 0.1);
  damping.matrix = damping.contact = damping.of_parts = true;
  return damping;
}

struct Joint {
  explicit Joint(LinearForm form) {
    PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
    add_damping_matrices(all_kinds(), model.reduced);
    model.reduced.file = "made-up.h5";
    preload = std::make_shared<VariedPreload>(model);
    system.emplace(scaled(std::move(model), all_kinds(), {}), 3, exactly, course({0.2, 1.0, 0.3}), form);
  }
  std::shared_ptr<VariedPreload> preload;
  std::optional<HarmonicSystem> system;
};

struct Answers {
  UniqueVec residual, product;
  double along;
};

Answers answers(HarmonicSystem &system, double size, double last, bool jacobian_first) {
  const UniqueVec y = vector_of(system, size, 3, last), border = vector_of(system, 1, 7, 0.2),
                  v = vector_of(system, 1, 5, 0.7);
  Answers out{system.unknowns(), system.unknowns(), 0};
  const UniqueMat J = system.matrix();
  if (jacobian_first) system.jacobian(y, border, J);
  out.along = system.residual(y, out.residual, border);
  double wanted;
  check(VecDot(y, border, &wanted), "");
  EXPECT_NEAR(out.along, wanted, 1e-12 * (1 + std::abs(wanted)));
  if (!jacobian_first) system.jacobian(y, border, J);
  check(MatMult(J, v, out.product), "");
  return out;
}

void expect_same(const Answers &found, const Answers &wanted) {
  EXPECT_LT(relative_difference(found.residual, wanted.residual), 1e-13);
  EXPECT_LT(relative_difference(found.product, wanted.product), 1e-13);
}

} // namespace

TEST(HarmonicStates, answers_are_of_the_motion_that_is_asked_about) {
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal})
    for (const double size : {0.05, 4.0}) {
      Joint fresh(form), other(form), worn(form);
      const Answers wanted = answers(*fresh.system, size, 1.3, false);
      expect_same(answers(*other.system, size, 1.3, true), wanted);
      for (const auto &[s, last] : {std::pair{1.0, 1.3}, {size, 0.8}, {size, 1.3}})
        answers(*worn.system, s, last, true);
      expect_same(answers(*worn.system, size, 1.3, true), wanted);
      expect_same(answers(*worn.system, size, 1.3, false), wanted);
    }
}

// Each of them alone, with another value of it before, and back to the frequency.
TEST(HarmonicStates, answers_are_of_the_value_of_the_parameter_that_is_asked_about) {
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal}) {
    Joint worn(form);
    for (const PathParameter &parameter : all_parameters) {
      const bool frequency = &parameter == &frequency_parameter();
      const double value = frequency ? 1.3 : parameter.positive() ? 0.8 : 0.02;
      Joint fresh(form);
      for (Joint *joint : {&fresh, &worn}) joint->system->vary(ResponseParameter(parameter, 1.3), joint->preload);
      const Answers wanted = answers(*fresh.system, 2, value, false);
      answers(*worn.system, 2, value * 0.9, true);
      expect_same(answers(*worn.system, 2, value, true), wanted);
      if (frequency) continue;
      EXPECT_EQ(worn.system->setting().omega, 1.3);
      const bool changed = parameter.changes_joint && fresh.system->layout().own_points.size() > 0;
      EXPECT_EQ(fresh.system->constant().empty(), !changed) << parameter.name;
      worn.system->vary(ResponseParameter(parameter, 1.3), worn.preload);
      worn.system->set(parameter.positive() ? 1 : 0); // as the case has it
    }
  }
}

// Loads and damping at the values that are set; a constant force is a load of minus its mean.
TEST(HarmonicStates, dense_models_are_of_what_is_set) {
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal}) {
    Joint joint(form);
    HarmonicSystem &system = *joint.system;
    const DenseModel plain = dense_model(system);
    ASSERT_EQ(plain.loads.size(), 1u);
    EXPECT_EQ(plain.file, "made-up.h5");
    const auto [K, M] = SmallMatrices();
    for (std::size_t i = 0; i < K.size(); ++i) {
      EXPECT_NEAR(plain.K[i], K[i], 1e-15);
      EXPECT_NEAR(plain.M[i], M[i], 1e-15);
      double given = 0; // as add_damping_matrices does, without springs
      for (int d = 0; d < 3; ++d)
        given += 0.04 * wave(static_cast<int>(i / 11), 80 + d) * wave(static_cast<int>(i % 11), 80 + d);
      if (i % 12 != 0) EXPECT_NEAR(plain.C[i], given, 1e-14);
    }
    const ReducedModel whole = small_reduced(PETSC_COMM_SELF);
    Reals load = whole.loads[0].fa;
    load.insert(load.end(), whole.loads[0].fx.begin(), whole.loads[0].fx.end());
    EXPECT_EQ(plain.loads[0].vector, load);
    EXPECT_EQ(plain.loads[0].fourier, (Reals{0.2, 1.0, 0.3, 0, 0, 0, 0}));
    for (const char *name : {"damping", "force"}) {
      const bool damping = name == std::string("damping");
      system.vary(ResponseParameter(*parameter_named(name), 1.3));
      system.set(0.5);
      const DenseModel half = dense_model(system);
      for (std::size_t i = 0; i < K.size(); ++i) EXPECT_NEAR(half.C[i], plain.C[i] * (damping ? 0.5 : 1), 1e-15);
      EXPECT_EQ(half.loads[0].fourier[1], damping ? 1 : 0.5);
      EXPECT_EQ(half.damping.stiffness, damping ? 0.025 : 0.05);
      EXPECT_EQ(half.loads.size(), 1u);
    }
    system.vary(ResponseParameter(*parameter_named("preload"), 1.3), joint.preload);
    system.set(0.8);
    const DenseModel pressed = dense_model(system);
    ASSERT_EQ(pressed.loads.size(), 2u);
    EXPECT_EQ(pressed.loads[1].fourier, Reals{-2});
    Reals constant(11);
    for (std::size_t i = 0; i < system.constant().size(); ++i)
      constant[2 + 3 * system.layout().own_points.begin + i] = system.constant()[i];
    MPI_Allreduce(MPI_IN_PLACE, constant.data(), 11, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_EQ(pressed.loads[1].vector, constant);
    ASSERT_EQ(pressed.contact.size(), 3u);
    for (int p = 0; p < 3; ++p) EXPECT_EQ(pressed.contact[p].kn, (Reals{5, 4, 6})[p]);
  }
}

// Of the assembled form a modal one is made, with all its damping; of a sector, and of a modal one, the same kind.
TEST(HarmonicStates, the_modal_form_of_a_system_is_that_system) {
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal})
    for (const bool cyclic : {false, true}) {
      Damping damping(0.05, 0.03);
      damping.contact = true;
      HarmonicSystem like = sector_system(1, exactly, {}, damping, {}, cyclic, form);
      const std::unique_ptr<HarmonicSystem> modal = HarmonicSystem::modal(like, 5, exactly);
      EXPECT_EQ(modal->form(), cyclic ? form : LinearForm::modal);
      EXPECT_EQ(modal->harmonics(), 5);
      HarmonicSystem wanted(like, 5, exactly);
      expect_same(answers(*modal, 0.6, 1.1, true), answers(wanted, 0.6, 1.1, true));
    }
}

TEST(HarmonicStates, new_unknowns_are_zero) {
  const Joint joint(LinearForm::assembled);
  UniqueVec y = joint.system->unknowns();
  EXPECT_EQ(norm(y), 0);
  PetscInt size;
  check(VecGetSize(y, &size), "");
  EXPECT_EQ(size, 11 * 7 + 1);
}
