// Block Lanczos from inside: what its basis, its Ritz pairs and their residuals are, against K^-1 M in full; and what
// it asks of SLEPc's EPS. On any number of ranks.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "reduction/block_lanczos.hpp"
#include "reduction/block_search.hpp"
#include "some_sector.hpp"
#include "support/dense.hpp"
#include "temporary_file.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr PetscInt n = 24, width = 3, room = 30;

using Change = std::function<void(FullModel &)>;

void set(Mat A, PetscInt i, PetscInt j, double value) { // an entry, on its owner
  PetscInt begin, end;
  check(MatGetOwnershipRange(A, &begin, &end), "test");
  if (begin <= i && i < end) check(MatSetValue(A, i, j, value, INSERT_VALUES), "test");
  check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY), "test");
  check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY), "test");
}

std::vector<double> gathered_rows(BV V, PetscInt columns) { // (n, columns) column-major, on every rank
  std::vector<double> all(n * columns, 0.0);
  for (PetscInt j = 0; j < columns; ++j) {
    Vec column;
    const double *values;
    PetscInt begin, end;
    check(BVGetColumn(V, j, &column), "test");
    check(VecGetOwnershipRange(column, &begin, &end), "test");
    check(VecGetArrayRead(column, &values), "test");
    std::copy(values, values + end - begin, &all[j * n + begin]);
    check(VecRestoreArrayRead(column, &values), "test");
    check(BVRestoreColumn(V, j, &column), "test");
  }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return all;
}

// Of a model, with shift-and-invert about 0.
void set_operators(const FullModel &model, UniqueEPS &eps) {
  ST st;
  KSP ksp;
  PC pc;
  check(EPSCreate(PETSC_COMM_WORLD, eps.out()), "test");
  check(EPSSetOperators(eps, model.K, model.M), "test");
  check(EPSSetProblemType(eps, EPS_GHEP), "test");
  check(EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE), "test");
  check(EPSGetST(eps, &st), "test");
  check(STSetType(st, STSINVERT), "test");
  check(STGetKSP(st, &ksp), "test");
  check(KSPSetType(ksp, KSPPREONLY), "test");
  check(KSPGetPC(ksp, &pc), "test");
  check(PCSetType(pc, PCLU), "test");
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "test");
}

// A search in the scattered model, and all of it on every rank.
struct Searched {
  FullModel model = scattered_model(PETSC_COMM_WORLD, n, 0);
  Dense M{n, n}, inverse{n, n}; // M, K^-1 M
  UniqueEPS eps;
  ST st;
  UniqueBV V, start;
  Search search;

  explicit Searched(const Change &change = {}, PetscInt most = room) {
    if (change) change(model);
    Dense K(n, n);
    for (const auto &[A, into] : {std::pair{Mat(model.K), &K}, {Mat(model.M), &M}}) {
      const Range own = own_share(PETSC_COMM_WORLD, n);
      for (PetscInt i = own.begin; i < own.end; ++i)
        for (PetscInt j = 0; j < n; ++j) check(MatGetValue(A, i, j, &(*into)(i, j)), "test");
      MPI_Allreduce(MPI_IN_PLACE, into->values.data(), n * n, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    }
    Factors factors;
    factors.factor(K);
    inverse = M;
    for (int j = 0; j < n; ++j) factors.solve(inverse.column(j));
    set_operators(model, eps);
    check(EPSSetUp(eps), "test");
    check(EPSGetST(eps, &st), "test");
    for (const auto &[bv, columns] : {std::pair{&V, most}, {&start, width}}) {
      check(BVCreate(PETSC_COMM_WORLD, bv->out()), "test");
      check(BVSetSizes(*bv, own_share(PETSC_COMM_WORLD, n).size(), n, columns), "test");
      check(BVSetFromOptions(*bv), "test");
    }
    fill([](int i, int j) { return scattered(i, 700 + j); });
    check(search.create(st, V, start), "test");
  }

  void fill(const std::function<double(int, int)> &entry) {
    const Range own = own_share(PETSC_COMM_WORLD, n);
    for (PetscInt j = 0; j < width; ++j) {
      Vec column;
      check(BVGetColumn(start, j, &column), "test");
      for (PetscInt i = own.begin; i < own.end; ++i) check(VecSetValue(column, i, entry(i, j), INSERT_VALUES), "test");
      check(VecAssemblyBegin(column), "test"), check(VecAssemblyEnd(column), "test");
      check(BVRestoreColumn(start, j, &column), "test");
    }
  }
  std::vector<double> times(const Dense &A, const double *x) const {
    std::vector<double> y(n, 0.0);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) y[i] += A(i, j) * x[j];
    return y;
  }
  double product(const double *x, const double *y) const { // x^T M y
    const std::vector<double> My = times(M, y);
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += x[i] * My[i];
    return sum;
  }

  void expect_orthonormal() const {
    const PetscInt columns = search.known + search.block;
    const std::vector<double> basis = gathered_rows(V, columns);
    for (PetscInt i = 0; i < columns; ++i)
      for (PetscInt j = 0; j < columns; ++j)
        ASSERT_NEAR(product(&basis[i * n], &basis[j * n]), i == j, 1e-11) << i << " " << j << " of " << columns;
  }
  void expect_ritz_pairs() const {
    const PetscInt k = search.known;
    const std::vector<double> basis = gathered_rows(V, k);
    Ritz found;
    check(search.ritz_pairs(found), "test");
    ASSERT_EQ(found.value.size(), static_cast<std::size_t>(k));
    ASSERT_EQ(found.vector.size(), static_cast<std::size_t>(k * k));
    std::vector<double> x(k * n, 0.0);
    for (PetscInt pair = 0; pair < k; ++pair)
      for (PetscInt j = 0; j < k; ++j)
        for (int i = 0; i < n; ++i) x[pair * n + i] += basis[j * n + i] * found.vector[pair * k + j];
    for (PetscInt pair = 0; pair < k; ++pair) {
      if (pair > 0) EXPECT_LE(std::abs(found.value[pair]), std::abs(found.value[pair - 1]));
      std::vector<double> y = times(inverse, &x[pair * n]);
      for (PetscInt other = 0; other < k; ++other)
        EXPECT_NEAR(product(&x[other * n], y.data()), other == pair ? found.value[pair] : 0, 1e-12)
            << pair << " of " << k;
      for (int i = 0; i < n; ++i) y[i] -= found.value[pair] * x[pair * n + i];
      EXPECT_NEAR(search.residual(found, pair), std::sqrt(std::max(0.0, product(y.data(), y.data()))), 1e-9)
          << pair << " of " << k;
    }
  }
};

} // namespace

TEST(BlockSearch, its_basis_is_orthonormal_and_its_residuals_are_those_of_the_vectors) {
  Searched all;
  Search &search = all.search;
  EXPECT_EQ(search.most, room);
  check(search.begin(), "test");
  EXPECT_EQ(search.known, 0);
  EXPECT_EQ(search.block, width);
  all.expect_orthonormal();
  for (PetscInt known = width; known <= n; known += width) {
    check(search.expand(), "test");
    EXPECT_EQ(search.known, known);
    EXPECT_EQ(search.block, known < n ? width : 0); // nothing is left
    all.expect_orthonormal();
    all.expect_ritz_pairs();
  }
}

TEST(BlockSearch, goes_on_from_its_best_vectors) {
  Searched all;
  Search &search = all.search;
  check(search.begin(), "test");
  for (int i = 0; i < 4; ++i) check(search.expand(), "test");
  Ritz before, after;
  check(search.ritz_pairs(before), "test");
  check(search.restart(before, 5), "test");
  EXPECT_EQ(search.known, 5);
  EXPECT_EQ(search.block, width);
  all.expect_orthonormal();
  check(search.ritz_pairs(after), "test");
  for (int j = 0; j < 5; ++j) EXPECT_NEAR(after.value[j], before.value[j], 1e-14);
  for (PetscInt known = 5 + width; known < n; known += width) {
    check(search.expand(), "test");
    EXPECT_EQ(search.known, known);
    all.expect_orthonormal();
    all.expect_ritz_pairs();
  }
}

TEST(BlockSearch, other_noise_is_orthogonal_to_what_it_has) {
  Searched all;
  Search &search = all.search;
  check(search.begin(), "test");
  check(search.expand(), "test");
  const std::vector<double> first = gathered_rows(all.start, width), kept = gathered_rows(all.V, width);
  check(search.begin_with_other_noise(), "test");
  EXPECT_EQ(search.known, width);
  EXPECT_EQ(search.block, width);
  const std::vector<double> second = gathered_rows(all.start, width), basis = gathered_rows(all.V, width);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_NEAR(second[i], 2 * first[i] * first[i] - 1, 1e-15);
    EXPECT_EQ(basis[i], kept[i]);
  }
  all.expect_orthonormal();
  check(search.expand(), "test");
  EXPECT_EQ(search.known, 2 * width);
  all.expect_orthonormal();
}

TEST(BlockSearch, dependent_noise_makes_a_narrower_block) {
  for (const double apart : {0.0, 1e-7, 1e-3}) { // equal, nearly, and for Cholesky's way far enough
    Searched all;
    all.fill(
        [&](int i, int j) { return scattered(i, j == 2 ? 700 : 700 + j) + (j == 2 ? apart * scattered(i, 709) : 0); });
    check(all.search.begin(), "test");
    EXPECT_EQ(all.search.block, apart > 0 ? 3 : 2) << apart;
    all.expect_orthonormal();
    check(all.search.expand(), "test");
    all.expect_orthonormal();
    all.expect_ritz_pairs();
  }
}

TEST(BlockSearch, ends_with_what_has_mass) {
  Searched all([](FullModel &model) {
    check(MatZeroEntries(model.M), "test");
    for (PetscInt i = 0; i < 7; ++i) set(model.M, 3 * i, 3 * i, 1.0 + i);
  });
  Search &search = all.search;
  check(search.begin(), "test");
  for (const PetscInt known : {3, 6, 7}) {
    check(search.expand(), "test");
    EXPECT_EQ(search.known, known);
    EXPECT_EQ(search.block, known == 3 ? 3 : known == 6 ? 1 : 0);
    all.expect_orthonormal();
    all.expect_ritz_pairs();
  }
  check(search.begin_with_other_noise(), "test");
  EXPECT_EQ(search.block, 0);
}

TEST(BlockSearch, no_mass_or_a_negative_one_has_no_inner_product) {
  const std::string words = "inner product is not well defined";
  for (const Change &change : {Change([](FullModel &model) { check(MatZeroEntries(model.M), "test"); }),
                               Change([](FullModel &model) { check(MatScale(model.M, -1), "test"); })}) {
    Searched all(change);
    EXPECT_NE(said<ComputeError>([&] { check(all.search.begin(), "test"); }).find(words), std::string::npos);
  }
}

namespace {

struct Solver {
  FullModel model = scattered_model(PETSC_COMM_WORLD, 60, 0);
  UniqueEPS eps;
  std::vector<UniqueVec> noise;

  explicit Solver(PetscInt columns = 4) {
    register_block_lanczos();
    register_block_lanczos();
    set_operators(model, eps);
    check(EPSSetType(eps, block_lanczos), "test");
    check(EPSSetDimensions(eps, 5, PETSC_DEFAULT, PETSC_DEFAULT), "test");
    std::vector<Vec> raw;
    for (PetscInt j = 0; j < columns; ++j) {
      noise.emplace_back();
      check(MatCreateVecs(model.K, noise[j].out(), nullptr), "test");
      const Range own = own_share(PETSC_COMM_WORLD, 60);
      for (PetscInt i = own.begin; i < own.end; ++i)
        check(VecSetValue(noise[j], i, scattered(i, j), INSERT_VALUES), "test");
      check(VecAssemblyBegin(noise[j]), "test"), check(VecAssemblyEnd(noise[j]), "test");
      raw.push_back(noise[j]);
    }
    if (columns > 0) check(EPSSetInitialSpace(eps, columns, raw.data()), "test");
  }
};

std::string refused(const std::function<void(EPS)> &change, PetscInt columns = 4) {
  const Solver solver(columns);
  change(solver.eps);
  return said<ComputeError>([&] { check(EPSSolve(solver.eps), "test"); });
}

} // namespace

TEST(BlockLanczos, of_slepc_it_wants_a_block_and_the_values_next_to_zero) {
  const auto has = [](const std::string &text, const char *words) { return text.find(words) != std::string::npos; };
  EXPECT_EQ(refused([](EPS) {}), "nothing was thrown");
  EXPECT_TRUE(has(refused([](EPS eps) { EPSSetWhichEigenpairs(eps, EPS_LARGEST_REAL); }), "that are next to 0"));
  EXPECT_TRUE(has(refused([](EPS eps) { EPSSetTarget(eps, 3); }), "that are next to 0"));
  EXPECT_TRUE(has(refused([](EPS) {}, 0), "wants an initial space: as many vectors as a block has"));
  EXPECT_TRUE(
      has(refused([](EPS eps) { EPSSetDimensions(eps, 5, 8, PETSC_DEFAULT); }), "-eps_ncv 9 at least, and 8 is given"));
  EXPECT_EQ(refused([](EPS eps) { EPSSetDimensions(eps, 5, 9, PETSC_DEFAULT); }), "nothing was thrown");
}

TEST(BlockLanczos, sizes_that_it_takes_by_itself) {
  EXPECT_EQ(lanczos_columns(100, 1000, 4), 300);
  EXPECT_EQ(lanczos_columns(10, 1000, 4), 42);
  EXPECT_EQ(lanczos_columns(10, 40, 4), 40);
  EXPECT_EQ(lanczos_columns(1, 1000), 1 + 8 * lanczos_block);
  const Solver solver;
  check(EPSSolve(solver.eps), "test");
  PetscInt nev, ncv, mpd, most, converged, steps;
  double tol;
  check(EPSGetDimensions(solver.eps, &nev, &ncv, &mpd), "test");
  check(EPSGetTolerances(solver.eps, &tol, &most), "test");
  check(EPSGetConverged(solver.eps, &converged), "test");
  check(EPSGetIterationNumber(solver.eps, &steps), "test");
  EXPECT_EQ(ncv, 37); // 5 + 8 * 4
  EXPECT_EQ(mpd, 37);
  EXPECT_EQ(most, 200 * (37 / 4 + 1));
  EXPECT_EQ(converged, 5);
  EXPECT_NEAR(steps, 17, 1);
  EPSConvergedReason reason;
  check(EPSGetConvergedReason(solver.eps, &reason), "test");
  EXPECT_EQ(reason, EPS_CONVERGED_TOL);
  Dense K(60, 60), M(60, 60);
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j) K(i, j) = stiffness_of(i, j), M(i, j) = mass_of(i, j);
  const std::vector<double> wanted = symmetric_modes(K, M);
  for (int j = 0; j < 5; ++j) {
    double value;
    check(EPSGetEigenvalue(solver.eps, j, &value, nullptr), "test");
    EXPECT_NEAR(value / wanted[j], 1, 1e-11);
  }
  check(EPSSolve(solver.eps), "test"); // again, from the same start
  check(EPSGetConverged(solver.eps, &converged), "test");
  EXPECT_EQ(converged, 5);
}

TEST(BlockLanczos, says_how_wide_its_blocks_are) {
  const Solver solver;
  const TemporaryFile file("view");
  PetscViewer viewer;
  check(PetscViewerASCIIOpen(PETSC_COMM_WORLD, file.path.c_str(), &viewer), "test");
  check(EPSView(solver.eps, viewer), "test"); // none yet
  check(EPSSolve(solver.eps), "test");
  check(EPSView(solver.eps, viewer), "test");
  check(PetscViewerDestroy(&viewer), "test");
  MPI_Barrier(PETSC_COMM_WORLD);
  std::ifstream in(file.path);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  EXPECT_NE(text.find("type: blocklanczos"), std::string::npos);
  EXPECT_LT(text.find("  block of 0 vectors\n"), text.find("  block of 4 vectors\n")) << text;
  EXPECT_NE(text.find("  block of 4 vectors\n"), std::string::npos) << text;
}
