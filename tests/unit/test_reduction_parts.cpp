// Parts of the reduction by themselves: tall matrices, fingerprints, rows that give a motion back.
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "reduction/elastic_modes.hpp"
#include "small_model.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"
#include "temporary_file.hpp"

using namespace dovetail;
using dovetail::testing::rank_here;
using dovetail::testing::TemporaryFile;

namespace {

double value_at(PetscInt row, PetscInt column) {
  return dovetail::testing::wave(static_cast<int>(row % 977), static_cast<int>(column));
}

Tall waves(PetscInt rows, PetscInt columns) {
  Tall made(rows, columns);
  for (PetscInt j = 0; j < columns; ++j)
    for (PetscInt i = 0; i < rows; ++i) made.column(j)[i] = value_at(i, j);
  return made;
}

int ranks() {
  int size;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  return size;
}

} // namespace

TEST(Tall, rotated_by_panels_it_is_the_product) {
  const std::vector<double> C = {1, 2, 3, -4, 5, 0.5}; // (3, 2)
  for (const PetscInt rows : {0, 1, 2047, 2048, 2049, 5000}) {
    Tall S = waves(rows, 4);
    rotate(S, 3, 2, C.data());
    double worst = 0;
    for (PetscInt i = 0; i < rows; ++i)
      for (PetscInt j = 0; j < 4; ++j) {
        double wanted = j < 2 ? 0 : value_at(i, j);
        for (PetscInt k = 0; j < 2 && k < 3; ++k) wanted += value_at(i, k) * C[j * 3 + k];
        worst = std::max(worst, std::abs(S.column(j)[i] - wanted));
      }
    EXPECT_LT(worst, 1e-14) << rows;
  }
}

TEST(Tall, products_of_some_columns) {
  const PetscInt rows = 5 + rank_here();
  const Tall S = waves(rows, 4), T = waves(rows, 3);
  const std::vector<double> own = own_gram(S, 1, 2, T, 1, 2), all = gram(PETSC_COMM_WORLD, S, 1, 2, T, 1, 2);
  for (PetscInt j = 0; j < 2; ++j)
    for (PetscInt i = 0; i < 2; ++i) {
      double sum = 0, of_all = 0;
      for (int rank = 0; rank < ranks(); ++rank)
        for (PetscInt row = 0; row < 5 + rank; ++row) of_all += value_at(row, 1 + i) * value_at(row, 1 + j);
      for (PetscInt row = 0; row < rows; ++row) sum += value_at(row, 1 + i) * value_at(row, 1 + j);
      EXPECT_NEAR(own[j * 2 + i], sum, 1e-14);
      EXPECT_NEAR(all[j * 2 + i], of_all, 1e-13);
    }
  const std::vector<double> C = {1, -2, 3, 0.5, 0.25, 4}; // (2, 3)
  Tall less = T;
  subtract_product(S, 2, C, less);
  for (PetscInt j = 0; j < 3; ++j)
    for (PetscInt i = 0; i < rows; ++i)
      EXPECT_NEAR(less.column(j)[i], T.column(j)[i] - C[2 * j] * S.column(0)[i] - C[2 * j + 1] * S.column(1)[i], 1e-14);
}

TEST(Tall, goes_to_whole_columns_and_back) {
  const PetscInt rows = 2 + rank_here();
  PetscInt first = 0, total = 0;
  for (int rank = 0; rank < ranks(); ++rank) first += rank < rank_here() ? 2 + rank : 0, total += 2 + rank;
  Tall S(rows, 5), T(rows, 7);
  for (PetscInt j = 0; j < 5; ++j)
    for (PetscInt i = 0; i < rows; ++i) S.column(j)[i] = 1000.0 * (first + i) + j;
  std::fill(T.values.begin(), T.values.end(), -1.0);
  const Tall whole = whole_columns(PETSC_COMM_WORLD, S);
  const Range mine = own_share(PETSC_COMM_WORLD, 5);
  ASSERT_EQ(whole.rows, total);
  ASSERT_EQ(whole.columns, mine.size());
  for (PetscInt j = 0; j < mine.size(); ++j)
    for (PetscInt i = 0; i < total; ++i) EXPECT_EQ(whole.column(j)[i], 1000.0 * i + mine.begin + j);
  take_own_rows(PETSC_COMM_WORLD, whole, T, 1, 5);
  for (PetscInt j = 0; j < 7; ++j)
    for (PetscInt i = 0; i < rows; ++i) EXPECT_EQ(T.column(j)[i], j > 0 && j < 6 ? S.column(j - 1)[i] : -1);
}

TEST(Tall, takes_columns_of_a_sparse_matrix_on_top) {
  UniqueMat A;
  PetscInt begin, end;
  check(MatCreateAIJ(PETSC_COMM_WORLD, 2, PETSC_DECIDE, PETSC_DETERMINE, 6, 6, nullptr, 6, nullptr, A.out()), "test");
  check(MatGetOwnershipRange(A, &begin, &end), "test");
  for (PetscInt i = begin; i < end; ++i)
    for (const PetscInt j : {0, 2, 4, 5}) check(MatSetValue(A, i, j, 10.0 * i + j, INSERT_VALUES), "test");
  check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY), "test");
  check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY), "test");
  Tall S(2, 3);
  std::fill(S.values.begin(), S.values.end(), 0.5);
  add_columns(A, 2, S); // columns 2, 3 (empty) and 4
  for (PetscInt i = 0; i < 2; ++i) {
    EXPECT_EQ(S.column(0)[i], 0.5 + 10.0 * (begin + i) + 2);
    EXPECT_EQ(S.column(1)[i], 0.5);
    EXPECT_EQ(S.column(2)[i], 0.5 + 10.0 * (begin + i) + 4);
  }
}

TEST(Fingerprint, is_of_every_number_and_of_its_place) {
  using Change = std::function<void(ReducedModel &)>;
  const auto add = [](std::vector<double> &numbers) { // a fourth rank has no point
    if (!numbers.empty()) numbers.back() += 1;
  };
  const auto model_with = [](MPI_Comm comm, const Change &change) {
    ReducedModel model = dovetail::testing::small_reduced(comm);
    Damping damping;
    damping.matrix = damping.of_parts = true;
    dovetail::testing::add_damping_matrices(damping, model);
    const std::size_t own = model.own_contact_dofs();
    model.left_out = {{9, 16}, {{1, 2}}, std::vector<double>(2 * own, 0.5), {1, 2, 3, 4}};
    change(model);
    return model;
  };
  const std::string plain = fingerprint_of(model_with(PETSC_COMM_WORLD, [](ReducedModel &) {}));
  EXPECT_EQ(plain.size(), 16u);
  EXPECT_EQ(plain, fingerprint_of(model_with(PETSC_COMM_SELF, [](ReducedModel &) {}))); // on any number of ranks
  const std::vector<Change> changes = {[](ReducedModel &m) { m.kaa[1] += 1; },
                                       [](ReducedModel &m) { std::swap(m.kaa[0], m.kaa[1]); },
                                       [add](ReducedModel &m) { add(m.mxa); },
                                       [add](ReducedModel &m) { add(m.mxx); },
                                       [add](ReducedModel &m) { add(m.kxx); },
                                       [](ReducedModel &m) { m.kxx.swap(m.mxx); },
                                       [add](ReducedModel &m) { add(m.r); },
                                       [](ReducedModel &m) { m.loads[0].fa[0] += 1; },
                                       [add](ReducedModel &m) { add(m.loads[0].fx); },
                                       [](ReducedModel &m) { m.loads[0].fx.swap(m.r); },
                                       [](ReducedModel &m) { m.left_out.squares[0] += 1; },
                                       [](ReducedModel &m) { m.left_out.loads[0][0] += 1; },
                                       [add](ReducedModel &m) { add(m.left_out.coupling); },
                                       [](ReducedModel &m) { m.left_out.with_modes[3] += 1; },
                                       [](ReducedModel &m) { m.viscous.aa[0] += 1; },
                                       [add](ReducedModel &m) { add(m.viscous.xa); },
                                       [add](ReducedModel &m) { add(m.viscous.xx); },
                                       [](ReducedModel &m) { m.viscous = {}; },
                                       [](ReducedModel &m) { m.structural.aa[0] += 1; },
                                       [](ReducedModel &m) { m.structural = {}; },
                                       [](ReducedModel &m) { std::swap(m.viscous, m.structural); },
                                       [](ReducedModel &m) { m.sectors = 2; }};
  std::set<std::string> all{plain};
  for (const Change &change : changes) all.insert(fingerprint_of(model_with(PETSC_COMM_WORLD, change)));
  EXPECT_EQ(all.size(), changes.size() + 1);
}

TEST(RecoveredRow, is_the_sum_of_rows_and_of_contact_motions) {
  const TemporaryFile file("recovered");
  const std::vector<double> kaa = {1, 2}, phi = {1, 2, 3, 4, 5, 6}, psi = {10, 20, 30, 40, 50, 60, 70, 80, 90},
                            complex_phi = {1, 1, 2, 2, 3, 3, 4, 4, 5, -5, 6, 6},
                            complex_psi = {1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  const std::vector<long> contact = {7, 2, 4}, elastic = {9, 1, 5};
  if (rank_here() == 0) {
    h5::Writer writer(file.path);
    writer.rows("/Kaa", {2}, 0, 2, kaa.data());
    writer.rows("/recovery/contact_dofs", {1, 3}, 0, 1, contact.data());
    writer.rows("/recovery/elastic_dofs", {3}, 0, 3, elastic.data());
    writer.rows("/recovery/Phi", {3, 2}, 0, 3, phi.data());
    writer.rows("/recovery/Psi", {3, 3}, 0, 3, psi.data());
    writer.rows("/cyclic/1/Phi", {3, 2, 2}, 0, 3, complex_phi.data());
    writer.rows("/cyclic/1/Psi", {3, 3, 2}, 0, 3, complex_psi.data());
    writer.close();
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  EXPECT_EQ(recovered_row(file.path, {1, 2, 9}, {2, 3, -1}),
            (std::vector<double>{2 * 3 - 1, 2 * 4 - 2, 2 * 40 - 10, 2 * 50 - 20 + 3, 2 * 60 - 30}));
  using Complex = std::complex<double>;
  const auto rows = recovered_rows(file.path, 3, {1, 5}, {1, 2});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0], (std::vector<Complex>{13, 16, 180, 210, 240}));
  EXPECT_EQ(rows[1], (std::vector<Complex>{{13, -7}, {16, 16}, {7 + 8, 8 + 10}, {9 + 12, 1 + 14}, {2 + 16, 3 + 18}}));
  try {
    recovered_row(file.path, {6}, {1});
    ADD_FAILURE() << "not refused";
  } catch (const InputError &error) {
    EXPECT_NE(std::string(error.what()).find("does not keep the motion of dof 6"), std::string::npos);
  }
}

TEST(RecoveredRow, without_modes_it_is_of_contact_motions_alone) {
  const TemporaryFile file("without_modes");
  const std::vector<double> none, psi = {10, 20, 30}, complex_psi = {1, 2, 3, 4, 5, 6};
  const std::vector<long> contact = {7, 2, 4}, elastic = {9};
  if (rank_here() == 0) {
    h5::Writer writer(file.path);
    writer.rows("/Kaa", {0}, 0, 0, none.data());
    writer.rows("/recovery/contact_dofs", {1, 3}, 0, 1, contact.data());
    writer.rows("/recovery/elastic_dofs", {1}, 0, 1, elastic.data());
    writer.rows("/recovery/Phi", {1, 0}, 0, 1, none.data());
    writer.rows("/recovery/Psi", {1, 3}, 0, 1, psi.data());
    writer.rows("/cyclic/1/Phi", {1, 0, 2}, 0, 1, none.data());
    writer.rows("/cyclic/1/Psi", {1, 3, 2}, 0, 1, complex_psi.data());
    writer.close();
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  EXPECT_EQ(recovered_row(file.path, {4, 9}, {2, 3}), (std::vector<double>{30, 60, 92}));
  using Complex = std::complex<double>;
  EXPECT_EQ(recovered_rows(file.path, 2, {9}, {2})[1], (std::vector<Complex>{{2, 4}, {6, 8}, {10, 12}}));
}
