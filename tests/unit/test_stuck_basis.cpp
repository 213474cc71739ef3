// Which modes of the stuck structure there are and where they come from: many are kept in a file, still more have a
// substitute. On any number of ranks.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "small_sector.hpp"
#include "stuck/near_basis.hpp"
#include "stuck/sector_modes.hpp"
#include "temporary_file.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Reals = std::vector<double>;

double rising(int i) { return 1.0 + i; }

ReducedModel row_of(int points, const std::filesystem::path &file = {}) {
  ReducedModel model = grounded(points, rising);
  model.stuck_file = file, model.file = "made-up.h5";
  return model;
}

} // namespace

// Of a thousand dofs and more; and for the springs they were found with.
TEST(StuckBasisFile, keeps_the_modes_of_many_dofs) {
  for (const int points : {333, 334}) {
    const TemporaryFile file("stuck_basis");
    const ReducedModel model = row_of(points, file.path);
    const Layout layout(model, 0);
    const Reals soft(model.own_contact_dofs(), 0.5), stiff(model.own_contact_dofs(), 0.75);
    const StuckBasis first = stuck_basis(model, soft, layout);
    MPI_Barrier(PETSC_COMM_WORLD);
    ASSERT_EQ(std::filesystem::exists(file.path), points == 334);
    for (int j = 0; j < 3 * points; ++j) EXPECT_NEAR(first.lambda[j], rising(j) + 0.5, 1e-9);
    if (points == 333) continue;
    const auto written = std::filesystem::last_write_time(file.path);
    const StuckBasis again = stuck_basis(model, soft, layout);
    EXPECT_EQ(again.lambda, first.lambda);
    for (std::size_t d = 0; d < first.exact.rows(); ++d)
      EXPECT_TRUE(std::equal(first.exact.row(d), first.exact.row(d) + 3 * points, again.exact.row(d)));
    EXPECT_EQ(std::filesystem::last_write_time(file.path), written);
    const StuckBasis other = stuck_basis(model, stiff, layout);
    for (int j = 0; j < 3 * points; ++j) EXPECT_NEAR(other.lambda[j], rising(j) + 0.75, 1e-9);
  }
}

TEST(ModalBasis, has_a_substitute_of_many_dofs_without_dampers) {
  const ReducedModel model = row_of(10);
  const Layout layout(model, 0);
  const Reals springs(model.own_contact_dofs(), 0.5);
  for (const auto &[many, dampers, near] :
       {std::tuple{"30", false, true}, {"31", false, false}, {"30", true, false}, {"0", false, true}}) {
    const Option least("-hb_modal_many", many);
    const StuckBasis basis = modal_basis(model, springs, layout, dampers, 1);
    EXPECT_EQ(basis.near, near) << many;
    EXPECT_NEAR(basis.lambda[0], rising(0) + 0.5, 1e-9);
    EXPECT_NEAR(basis.damped[0], rising(0), 1e-6);
    EXPECT_EQ(basis.rates, Reals(30));
    EXPECT_EQ(basis.losses, Reals(30));
    EXPECT_EQ(basis.shapes.size(), near ? basis.shapes.size() / 30 * 30 : 30u * 4); // 0.5 of 0.5 + 1 .. 4 is a tenth
  }
  EXPECT_FALSE(modal_basis(model, springs, layout, false, 1).near);
  const Option least("-hb_modal_many", "0");
  const ReducedModel soft = grounded(10, [](int) { return 0.0; }); // there is none: all modes then
  EXPECT_FALSE(modal_basis(soft, Reals(soft.own_contact_dofs()), Layout(soft, 0), false, 1).near);
}

TEST(DampedDiagonal, has_no_negative_stiffness_of_the_structure) { // the springs hold all there is, but for rounding
  ReducedModel model = row_of(20);
  std::fill(model.kxx.begin(), model.kxx.end(), 0.0);
  for (double &m : model.mxx) m += 1e-2; // not diagonal
  const Layout layout(model, 0);
  const StuckBasis basis = stuck_basis(model, Reals(model.own_contact_dofs(), 1 / 3.0), layout);
  for (const double value : basis.damped) {
    EXPECT_GE(value, 0);
    EXPECT_LT(value, 1e-14);
  }
}

TEST(StuckBases, of_an_index_without_a_positive_mass_are_refused) {
  ReducedModel model = small_sector();
  for (Complex &value : model.indices[1].mxx) value = -value;
  const Layout layout(model, 0);
  const Reals springs(model.own_contact_dofs(), 1.0);
  EXPECT_THROW(stuck_bases(model, {&model.indices[0], &model.indices[1]}, springs, layout), InputError);
  EXPECT_EQ(stuck_bases(model, {&model.indices[0], &model.indices[2]}, springs, layout).size(), 2u);
  EXPECT_THROW(sector_modes(model, 2, springs, 3), InputError);
}

namespace {

HermitianPencil diagonal_pencil(const Reals &stiff, const Reals &heavy) {
  const int n = static_cast<int>(stiff.size());
  HermitianPencil made{ComplexDense(n, n), ComplexDense(n, n)};
  for (int i = 0; i < n; ++i) made.K(i, i) = stiff[i], made.M(i, i) = heavy[i];
  return made;
}

} // namespace

TEST(SectorModes, of_diagonal_matrices_are_quotients_in_any_unit) {
  for (const double unit : {1.0, 1e-24, 1e24}) {
    const SectorModes found =
        sector_modes(diagonal_pencil({8 * unit, 0, 6 * unit, 3 * unit}, {2, 1, 3, 0.5}), 4, "a.h5");
    const Reals wanted{0, 2, 4, 6};
    for (int j = 0; j < 4; ++j) EXPECT_NEAR(found.squares[j], wanted[j] * unit, 1e-12 * unit);
    const int places[] = {1, 2, 0, 3};
    const double lengths[] = {1, 1 / std::sqrt(3), M_SQRT1_2, M_SQRT2};
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        EXPECT_NEAR(std::abs(found.shapes(i, j) - (places[j] == i ? lengths[j] : 0)), 0, 1e-12);
  }
}

TEST(SectorModes, have_squares_of_0_of_rigid_motions) { // two masses on one spring with a turn of phase
  HermitianPencil of = diagonal_pencil({3, 3}, {1, 2});
  of.K(0, 1) = -std::polar(3.0, 0.4), of.K(1, 0) = std::conj(of.K(0, 1));
  const SectorModes found = sector_modes(of, 2, "a.h5");
  EXPECT_EQ(found.squares[0], 0);
  EXPECT_NEAR(found.squares[1], 4.5, 1e-13);
  EXPECT_NEAR(std::abs(found.shapes(0, 0) - std::polar(1.0, 0.4) * found.shapes(1, 0)), 0, 1e-12);
  EXPECT_NEAR(std::abs(found.shapes(0, 0)), 1 / std::sqrt(3), 1e-12);
  for (int j = 0; j < 2; ++j) EXPECT_NEAR(std::imag(found.shapes(0, j)), 0, 1e-12); // of as large ones the first
}

TEST(SectorModes, without_stiffness_are_rigid_and_without_mass_refused) {
  for (const double square : sector_modes(diagonal_pencil({0, 0}, {1, 2}), 2, "a.h5").squares)
    EXPECT_NEAR(square, 0, 1e-15);
  for (const Reals &heavy : {Reals{1, 0}, {1, -1}, {-1, -2}})
    EXPECT_THROW(sector_modes(diagonal_pencil({1, 2}, heavy), 2, "a.h5"), InputError);
}
