// Factors of K_ee, what is made with them, and what is said where they or the modes cannot be. On any number of ranks.
#include <gtest/gtest.h>

#include "lattice_model.hpp"
#include "reduction/clamped_structure.hpp"
#include "reduction/elastic_modes.hpp"
#include "reduction/elastic_partition.hpp"
#include "reduction/mumps_failed.hpp"
#include "small_system.hpp"
#include "some_sector.hpp"
#include "support/gathered.hpp"
#include "temporary_file.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// Diagonal but for what is added, rows in even shares.
struct Pair {
  UniqueMat K, M;
  std::vector<long> names;

  Pair(
      int size, const std::function<double(int, int)> &stiffness,
      const std::function<double(int, int)> &mass = [](int i, int j) { return i == j ? 1.0 : 0.0; }) {
    const Range own = own_share(PETSC_COMM_WORLD, size);
    for (const auto &[A, entry] : {std::pair{&K, &stiffness}, {&M, &mass}}) {
      check(MatCreateAIJ(PETSC_COMM_WORLD, own.size(), own.size(), size, size, size, nullptr, size, nullptr, A->out()),
            "test");
      for (int i = own.begin; i < own.end; ++i)
        for (int j = 0; j < size; ++j)
          if (const double value = (*entry)(i, j); value != 0 || i == j)
            check(MatSetValue(*A, i, j, value, INSERT_VALUES), "test");
      check(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY), "test");
      check(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY), "test");
      check(MatSetOption(*A, MAT_SYMMETRIC, PETSC_TRUE), "test");
    }
    for (int i = own.begin; i < own.end; ++i) names.push_back(i);
  }
  PetscInt rows() const { return static_cast<PetscInt>(names.size()); }
};

std::function<double(int, int)> diagonal(const std::function<double(int)> &entry) {
  return [entry](int i, int j) { return i == j ? entry(i) : 0.0; };
}

std::string not_factored(const std::function<double(int, int)> &stiffness) {
  const Pair pair(6, stiffness);
  ClampedSolver solver(pair.K, "bar.h5");
  return said<InputError>([&] { solver.factor(); });
}

} // namespace

TEST(ClampedSolver, sparse_right_hand_sides_go_where_they_are_wanted) {
  for (const char *whole : {"true", "false"}) {
    const Option way("-kee_whole", whole);
    const Pair pair(11, stiffness_of);
    ClampedSolver solver(pair.K, "test");
    EXPECT_EQ(solver.attempts(), 0);
    solver.factor();
    EXPECT_EQ(solver.attempts(), 1);
    int ranks;
    MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
    EXPECT_EQ(solver.shared(), ranks > 1 && std::string(whole) == "false");
    SparseColumns sides;
    if (rank_here() == 0) sides = {{0, 2, 2, 3, 5, 6}, {1, 10, 0, 4, 5, 7}, {1, 2, 3, 4, 5, 6}}; // the second is empty
    Tall X(pair.rows(), 8), wanted(pair.rows(), 5);
    std::fill(X.values.begin(), X.values.end(), 77.0);
    solver.solve_sparse(sides, X, 2, 5);
    const std::tuple<int, int, double> entries[] = {{0, 1, 1}, {0, 10, 2}, {2, 0, 3}, {3, 4, 4}, {3, 5, 5}, {4, 7, 6}};
    for (const auto &[column, row, value] : entries)
      for (PetscInt i = 0; i < pair.rows(); ++i)
        if (pair.names[i] == row) wanted.column(column)[i] = value;
    const Tall product = multiply(pair.K, X, 2, 5), dense = solver.solve(wanted);
    for (std::size_t i = 0; i < wanted.values.size(); ++i) EXPECT_NEAR(product.values[i], wanted.values[i], 1e-13);
    for (int j = 0; j < 5; ++j)
      for (PetscInt i = 0; i < pair.rows(); ++i) EXPECT_NEAR(dense.column(j)[i], X.column(j + 2)[i], 1e-14);
    for (const int j : {0, 1, 7})
      for (PetscInt i = 0; i < pair.rows(); ++i) EXPECT_EQ(X.column(j)[i], 77);
    if (solver.shared()) continue;
    solver.solve_sparse(rank_here() == 0 ? SparseColumns{{0, 0}, {}, {}} : SparseColumns(), X, 0, 1); // no entry at all
    for (PetscInt i = 0; i < pair.rows(); ++i) EXPECT_EQ(X.column(0)[i], 0);
    EXPECT_EQ(solver.solve(Tall(pair.rows(), 0)).columns, 0);
  }
}

TEST(ClampedSolver, a_stiffness_that_is_not_positive_is_the_models_fault) {
  const std::string words = "bar.h5: K_ee, the stiffness with the contact dofs held, is not positive definite (MUMPS ";
  EXPECT_EQ(not_factored(diagonal([](int i) { return 1.0 + i; })), "nothing was thrown");
  EXPECT_EQ(not_factored(diagonal([](int i) { return i == 4 ? -1.0 : 1.0; })).find(words + "0)"), 0u); // it goes on
  EXPECT_EQ(not_factored(diagonal([](int i) { return i == 4 ? 0.0 : 1.0; })).find(words + "-10)"), 0u);
}

TEST(ClampedSolver, forecasts_are_of_the_ordering_that_options_choose) {
  for (const auto &[number, name] :
       {std::pair{"0", "AMD"}, {"2", "AMF"}, {"3", "SCOTCH"}, {"4", "PORD"}, {"6", "QAMD"}}) {
    const Option ordering("-kee_mat_mumps_icntl_7", number), alone("-kee_whole", "true");
    const Pair chain(400, [](int i, int j) { return i == j ? 2.0 : std::abs(i - j) == 1 ? -0.9 : 0.0; });
    ClampedSolver solver(chain.K, "test");
    EXPECT_EQ(solver.ordering(), name);
  }
  const Pair full(400, stiffness_of);
  const Option alone("-kee_whole", "true");
  ClampedSolver solver(full.K, "test");
  EXPECT_NEAR(solver.forecast_flops() / (400.0 * 400 * 400 / 3), 1, 0.05); // of a dense Cholesky factorisation
  EXPECT_GE(solver.forecast_bytes(), 1e6);                                 // whole megabytes
  EXPECT_LT(solver.forecast_bytes(), 2e7);
  const ClampedStructure parts = clamp(lattice_model(PETSC_COMM_WORLD, 20, 8, 5));
  const Option on_disk("-kee_mat_mumps_icntl_22", "1");
  const ClampedSolver other(parts.K.ee, "test");
  EXPECT_LT(other.forecast_bytes(), parts.solver->forecast_bytes());
}

TEST(ClampedSolver, files_that_cannot_be_written_are_told) {
  const Option on_disk("-kee_mat_mumps_icntl_22", "1");
  setenv("MUMPS_OOC_TMPDIR", "/nonexistent/folder", 1);
  const Pair pair(300, stiffness_of);
  ClampedSolver solver(pair.K, "test");
  const std::string words = said<ComputeError>([&] { solver.factor(); });
  unsetenv("MUMPS_OOC_TMPDIR");
  EXPECT_EQ(words.find("while factoring K_ee: MUMPS error -90 ("), 0u) << words;
  EXPECT_NE(words.find("); its files could not be written: out of core it needs room where MUMPS_OOC_TMPDIR points"),
            std::string::npos)
      << words;
}

TEST(ClampedSolver, mumps_says_something_only_if_it_is_asked_to) {
  const auto words = [] {
    ::testing::internal::CaptureStdout();
    {
      const Pair pair(300, stiffness_of);
      ClampedSolver solver(pair.K, "test");
      solver.factor();
    }
    return ::testing::internal::GetCapturedStdout();
  };
  EXPECT_EQ(words(), "");
  const Option talking("-kee_mat_mumps_icntl_4", "2");
  EXPECT_NE(words().find("ANALYSIS STEP"), std::string::npos); // each rank has its own
}

TEST(ClampedSolver, errors_of_mumps_come_with_advice) {
  EXPECT_EQ(mumps_failed("factoring", -5, 7), "while factoring K_ee: MUMPS error -5 (7)");
  for (const int error : {-8, -9})
    EXPECT_NE(mumps_failed("factoring", error, 0).find("try -kee_mat_mumps_icntl_14 400"), std::string::npos);
  for (const int error : {-7, -13})
    EXPECT_NE(mumps_failed("factoring", error, 0).find("out of memory: take more ranks or"), std::string::npos);
  EXPECT_NE(mumps_failed("factoring", -90, 0).find("where MUMPS_OOC_TMPDIR points"), std::string::npos);
}

TEST(ElasticModes, signs_follow_the_largest_entry_and_among_equals_the_lowest_name) {
  const auto turned = [](std::vector<double> values, std::vector<long> names) { // the first rank has all entries
    if (rank_here() > 0) values.clear(), names.clear();
    fix_sign(PETSC_COMM_WORLD, names, values.data());
    int count = static_cast<int>(values.size());
    MPI_Bcast(&count, 1, MPI_INT, 0, PETSC_COMM_WORLD);
    values.resize(count);
    MPI_Bcast(values.data(), count, MPI_DOUBLE, 0, PETSC_COMM_WORLD);
    return values;
  };
  using Values = std::vector<double>;
  EXPECT_EQ(turned({1, -3, 2}, {0, 1, 2}), (Values{-1, 3, -2}));
  EXPECT_EQ(turned({-1, 3, -2}, {0, 1, 2}), (Values{-1, 3, -2}));
  EXPECT_EQ(turned({-2, 2, 1}, {5, 3, 4}), (Values{-2, 2, 1}));
  EXPECT_EQ(turned({-2, 2, 1}, {3, 5, 4}), (Values{2, -2, -1}));
  EXPECT_EQ(turned({-2 + 1e-6, 2, 1}, {3, 5, 4}), (Values{2 - 1e-6, -2, -1})); // as good as equal
  EXPECT_EQ(turned({-2 + 4e-6, 2, 1}, {3, 5, 4}), (Values{-2 + 4e-6, 2, 1}));
  EXPECT_EQ(turned({0, 0}, {0, 1}), (Values{0, 0}));
  std::vector<double> one = {-1.0 - rank_here()}; // the last rank's is the largest
  const double before = one[0];
  fix_sign(PETSC_COMM_WORLD, {rank_here()}, one.data());
  EXPECT_EQ(one[0], -before);
}

TEST(ElasticModes, are_counted_below_a_square) {
  const Pair pair(7, diagonal([](int i) { return i < 4 ? 1.0 + i : 4.0; }),
                  diagonal([](int i) { return i == 3 ? 2.0 : 1.0; }));
  for (const auto &[square, count] :
       {std::pair{0.5, 0}, {1.5, 1}, {2.0 - 1e-9, 1}, {2.0 + 1e-9, 3}, {3.5, 4}, {4.5, 7}})
    EXPECT_EQ(modes_below(pair.K, pair.M, square), count) << square; // 1, 2, 2, 3, 4, 4, 4
  EXPECT_NO_THROW(check_none_missed(pair.K, pair.M, {1, 2, 2}));
  EXPECT_NO_THROW(check_none_missed(pair.K, pair.M, {1, 2})); // as good as the last one
  EXPECT_NO_THROW(check_none_missed(pair.K, pair.M, {1, 2, 2, 3, 4, 4 * (1 + 5e-5)}));
  const std::string words = said<ComputeError>([&] { check_none_missed(pair.K, pair.M, {1, 2, 3}); });
  EXPECT_EQ(words, "while computing modes: 3 modes lie below " +
                       std::to_string(std::sqrt(3 * (1 - 1e-4)) / (2 * M_PI)) +
                       " Hz, but 2 were found there; ask for a few more in reduction.modes");
  EXPECT_NE(said<ComputeError>([&] {
              check_none_missed(pair.K, pair.M, {1, 2, 2, 3, 4 * (1 + 2e-4)});
            }),
            "nothing was thrown");
}

TEST(ElasticModes, are_normal_and_none_where_none_is_asked_for) {
  const Pair pair(9, diagonal([](int i) { return 4.0 * (1 + i); }), diagonal([](int) { return 4.0; }));
  ClampedSolver solver(pair.K, "bar.h5");
  solver.factor();
  const ElasticModes two = elastic_modes(solver, pair.K, pair.M, pair.names, 2, "bar.h5"),
                     none = elastic_modes(solver, pair.K, pair.M, pair.names, 0, "bar.h5");
  ASSERT_EQ(two.squares.size(), 2u);
  for (int j = 0; j < 2; ++j) {
    EXPECT_NEAR(two.squares[j], 1 + j, 1e-12);
    for (PetscInt i = 0; i < pair.rows(); ++i)
      EXPECT_NEAR(two.shapes.column(j)[i], pair.names[i] == j ? 0.5 : 0, 1e-10);
  }
  EXPECT_TRUE(none.squares.empty());
  EXPECT_EQ(none.shapes.columns, 0);
}

TEST(ElasticModes, a_motion_without_strain_is_told_from_a_soft_one) {
  const auto words = [](double spring) { // two masses, joined firmly, on a soft spring
    const Pair pair(2, [=](int i, int j) { return i == j ? 1 + spring : -1.0; });
    ClampedSolver solver(pair.K, "bar.h5");
    solver.factor();
    return said<InputError>([&] { elastic_modes(solver, pair.K, pair.M, pair.names, 1, "bar.h5"); });
  };
  EXPECT_EQ(words(3e-12), "nothing was thrown");
  EXPECT_EQ(words(4e-13),
            "bar.h5: a rigid-body motion is left in K_ee: with the contact dofs held, mode 1 has no stiffness (w^2 = "
            "0.000000). Constraints are missing, or a part is not connected.");
}

TEST(ElasticModes, the_backward_error_of_each_is_looked_at) {
  const auto words = [](double off) { // factors of another matrix; |K v - w^2 M v| / (|K| + w^2 |M|) |v|
    const Pair pair(2, diagonal([](int i) { return 1.0 + i; })),
        other(2, diagonal([=](int i) { return (1 + off) * (1.0 + i); }));
    ClampedSolver solver(other.K, "bar.h5");
    solver.factor();
    return said<ComputeError>([&] { elastic_modes(solver, pair.K, pair.M, pair.names, 1, "bar.h5"); });
  };
  EXPECT_EQ(words(2.7e-8), "nothing was thrown"); // a third of it
  EXPECT_EQ(words(3.3e-8),
            "while computing modes: mode 1 has a backward error of 1.1e-08, not below 1e-08; are stiffness or mass "
            "of some parts many orders apart?");
  EXPECT_NE(words(-3.3e-8), "nothing was thrown");
}

// A bar in two halves: few springs are cut, and those dofs that touch a contact point are shared out as well.
TEST(ElasticPartition, cuts_little_and_shares_out_what_touches_contact_points) {
  int ranks;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const FullModel model = lattice_model(PETSC_COMM_WORLD, 24, 6, 36); // a face of it in contact
  const auto own = elastic_share(model.K, model.contact_dofs);
  EXPECT_TRUE(std::is_sorted(own.begin(), own.end()));
  if (ranks == 1) {
    EXPECT_EQ(own.size(), std::size_t(model.dofs - 3 * 36));
    return;
  }
  std::vector<int> owner(model.dofs, 0);
  for (const PetscInt dof : own) owner[dof] = 1 + rank_here();
  MPI_Allreduce(MPI_IN_PLACE, owner.data(), model.dofs, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  PetscInt begin, end;
  check(MatGetOwnershipRange(model.K, &begin, &end), "test");
  long cut = 0;
  std::vector<long> touching(ranks, 0), all(ranks, 0);
  for (PetscInt i = begin; i < end; ++i) {
    if (owner[i] == 0) continue;
    PetscInt count;
    const PetscInt *columns;
    bool touches = false;
    check(MatGetRow(model.K, i, &count, &columns, nullptr), "test");
    for (PetscInt at = 0; at < count; ++at) {
      cut += owner[columns[at]] > 0 && owner[columns[at]] != owner[i];
      touches = touches || owner[columns[at]] == 0;
    }
    check(MatRestoreRow(model.K, i, &count, &columns, nullptr), "test");
    ++all[owner[i] - 1], touching[owner[i] - 1] += touches;
  }
  for (auto *counts : {&all, &touching})
    MPI_Allreduce(MPI_IN_PLACE, counts->data(), ranks, MPI_LONG, MPI_SUM, PETSC_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, &cut, 1, MPI_LONG, MPI_SUM, PETSC_COMM_WORLD);
  long touching_all = 0, elastic = 0;
  for (const long count : touching) touching_all += count;
  for (const long count : all) elastic += count;
  for (const long count : all) EXPECT_LT(count, 1.1 * elastic / ranks);
  EXPECT_LT(*std::max_element(touching.begin(), touching.end()), (ranks == 2 ? 1.6 : 2.5) * touching_all / ranks);
  EXPECT_LT(cut, 0.03 * ranks * 20 * elastic); // of some 20 entries of each; by chance half of them would be
}
