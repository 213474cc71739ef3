// The reduction against dense LAPACK, MUMPS's own Schur complement and SLEPc; on any number of ranks.
#include <gtest/gtest.h>

#include "lattice_model.hpp"
#include "reduction/elastic_modes.hpp"
#include "reduction/elastic_partition.hpp"
#include "reduction/reduced_model.hpp"
#include "support/memory.hpp"

#include <petscblaslapack.h> // needs petscsys.h before it

namespace dovetail {
namespace {

constexpr int length = 9, width = 4, points = 5, modes = 12, n = 3 * length * width * width, nc = 3 * points;

MemoryPlan roomy(bool keep_psi = true, PetscInt block = 256) {
  MemoryPlan plan;
  plan.keep_psi = keep_psi, plan.block = block;
  return plan;
}

Reduction reduced(const MemoryPlan &plan, bool check_modes = false) {
  ClampedStructure parts = clamp(testing::lattice_model(PETSC_COMM_WORLD, length, width, points));
  ReductionSettings settings{ModeKind::eigen, modes, check_modes, std::vector<char>(parts.elastic_dofs.size(), 1)};
  Stages stages;
  return craig_bampton(std::move(parts), settings, plan, stages);
}

// Everything on every rank as dense matrices, (n, n) column-major, and the answers by LAPACK.
struct Dense {
  std::vector<double> K, M, F, P;
  std::vector<int> e, c;

  Dense() {
    const FullModel model = testing::lattice_model(PETSC_COMM_SELF, length, width, points);
    for (const auto &[A, out] : {std::pair{Mat(model.K), &K}, std::pair{Mat(model.M), &M}}) {
      out->assign(n * n, 0.0);
      for (int i = 0; i < n; ++i) {
        PetscInt count;
        const PetscInt *columns;
        const double *values;
        check(MatGetRow(A, i, &count, &columns, &values), "test");
        for (int j = 0; j < count; ++j) (*out)[columns[j] * n + i] = values[j];
        check(MatRestoreRow(A, i, &count, &columns, &values), "test");
      }
    }
    for (const auto &[v, out] : {std::pair{Vec(model.forces[0].values), &F}, std::pair{Vec(model.preload), &P}}) {
      const double *values;
      check(VecGetArrayRead(v, &values), "test");
      out->assign(values, values + n);
      check(VecRestoreArrayRead(v, &values), "test");
    }
    std::vector<char> held(n, 0);
    for (const auto &point : model.contact_dofs)
      for (const int dof : point) c.push_back(dof), held[dof] = 1;
    for (int i = 0; i < n; ++i)
      if (!held[i]) e.push_back(i);
  }

  // Solves K_ee X = B, B (n_e, columns), in place.
  void solve(std::vector<double> &B, int columns) const {
    const PetscBLASInt ne = static_cast<int>(e.size()), rhs = columns;
    std::vector<double> A;
    for (const int j : e)
      for (const int i : e) A.push_back(K[j * n + i]);
    std::vector<PetscBLASInt> pivots(ne);
    PetscBLASInt info;
    LAPACKgesv_(&ne, &rhs, A.data(), &ne, pivots.data(), B.data(), &ne, &info);
    ASSERT_EQ(info, 0);
  }

  std::vector<double> psi() const { // (n_e, nc) column-major
    std::vector<double> B;
    for (const int j : c)
      for (const int i : e) B.push_back(-K[j * n + i]);
    solve(B, nc);
    return B;
  }
};

double largest(const std::vector<double> &values) {
  double most = 0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

void expect_rows(const std::vector<double> &own, const Range &range, const std::vector<double> &wanted, int columns,
                 double tolerance) { // wanted: (all rows, columns) row-major
  ASSERT_EQ(own.size(), static_cast<std::size_t>(3 * range.size() * columns));
  const double scale = largest(wanted);
  for (std::size_t at = 0; at < own.size(); ++at)
    ASSERT_NEAR(own[at], wanted[3 * range.begin * columns + at], tolerance * scale) << "entry " << at;
}

std::vector<double> wanted_mass(const Dense &dense, const std::vector<double> &psi) {
  const int ne = static_cast<int>(dense.e.size());
  std::vector<double> T(n * nc, 0.0), MT(n * nc, 0.0),
      out(nc * nc, 0.0); // columns: unit contact motions and what they carry along
  for (int j = 0; j < nc; ++j) {
    for (int i = 0; i < ne; ++i) T[j * n + dense.e[i]] = psi[j * ne + i];
    T[j * n + dense.c[j]] = 1;
    for (int l = 0; l < n; ++l)
      for (int i = 0; i < n; ++i) MT[j * n + i] += dense.M[l * n + i] * T[j * n + l];
  }
  for (int i = 0; i < nc; ++i)
    for (int j = 0; j < nc; ++j)
      for (int l = 0; l < n; ++l) out[i * nc + j] += T[i * n + l] * MT[j * n + l];
  return out;
}

class ByLapack : public ::testing::TestWithParam<std::pair<bool, int>> {};

TEST_P(ByLapack, ContactMatricesAndLoads) {
  const auto [keep_psi, block] = GetParam();
  const Reduction found = reduced(roomy(keep_psi, block));
  const ReducedModel &model = found.model;
  const Dense dense;
  const auto psi = dense.psi();
  const int ne = static_cast<int>(dense.e.size());
  std::vector<double> kxx(nc * nc), fx(nc), r(nc), xe0;
  for (const int i : dense.e) xe0.push_back(dense.P[i]);
  dense.solve(xe0, 1);
  for (int i = 0; i < nc; ++i) {
    fx[i] = dense.F[dense.c[i]], r[i] = -dense.P[dense.c[i]];
    for (int l = 0; l < ne; ++l) {
      fx[i] += psi[i * ne + l] * dense.F[dense.e[l]];
      r[i] += dense.K[dense.e[l] * n + dense.c[i]] * xe0[l];
    }
    for (int j = 0; j < nc; ++j) {
      kxx[i * nc + j] = dense.K[dense.c[j] * n + dense.c[i]];
      for (int l = 0; l < ne; ++l) kxx[i * nc + j] += dense.K[dense.e[l] * n + dense.c[i]] * psi[j * ne + l];
    }
  }
  expect_rows(model.kxx, model.own_points, kxx, nc, 1e-12);
  expect_rows(model.mxx, model.own_points, wanted_mass(dense, psi), nc, 1e-12);
  expect_rows(model.loads[0].fx, model.own_points, fx, 1, 1e-12);
  expect_rows(model.r, model.own_points, r, 1, 1e-12);
  EXPECT_LT(found.backward_error, 1e-14);
  for (std::size_t i = 0; i < found.recovery.elastic_dofs.size(); ++i) { // rows kept, wherever the partition put them
    const auto at = std::lower_bound(dense.e.begin(), dense.e.end(), found.recovery.elastic_dofs[i]) - dense.e.begin();
    ASSERT_NEAR(found.recovery.xe0[i], xe0[at], 1e-12 * largest(xe0));
    for (int j = 0; j < nc; ++j) ASSERT_NEAR(found.recovery.psi[i * nc + j], psi[j * ne + at], 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Reduction, ByLapack,
                         ::testing::Values(std::pair{true, 256}, std::pair{true, 4}, std::pair{false, 256},
                                           std::pair{false, 4}));

TEST(Reduction, EqualsMumpsOwnSchurComplement) { // on each rank by itself: PETSc has no parallel one
  const FullModel model = testing::lattice_model(PETSC_COMM_SELF, length, width, points);
  std::vector<PetscInt> contact;
  for (const auto &point : model.contact_dofs) contact.insert(contact.end(), point.begin(), point.end());
  UniqueMat factor, schur;
  UniqueIS is;
  MatFactorInfo info;
  check(ISCreateGeneral(PETSC_COMM_SELF, nc, contact.data(), PETSC_COPY_VALUES, is.out()), "test");
  check(MatGetFactor(model.K, MATSOLVERMUMPS, MAT_FACTOR_LU, factor.out()), "test");
  check(MatFactorSetSchurIS(factor, is), "test");
  check(MatFactorInfoInitialize(&info), "test");
  check(MatLUFactorSymbolic(factor, model.K, nullptr, nullptr, &info), "test");
  check(MatLUFactorNumeric(factor, model.K, &info), "test");
  check(MatFactorCreateSchurComplement(factor, schur.out(), nullptr), "test");
  const double *values;
  check(MatDenseGetArrayRead(schur, &values), "test");
  const std::vector<double> wanted(values, values + nc * nc);
  check(MatDenseRestoreArrayRead(schur, &values), "test");
  const Reduction found = reduced(roomy());
  expect_rows(found.model.kxx, found.model.own_points, wanted, nc, 1e-12);
}

TEST(Reduction, ModesEqualThoseOfSlepc) {
  const Reduction found = reduced(roomy(), true);
  const ClampedStructure alone = clamp(testing::lattice_model(PETSC_COMM_SELF, length, width, points));
  UniqueEPS eps;
  check(EPSCreate(PETSC_COMM_SELF, eps.out()), "test");
  check(EPSSetOperators(eps, alone.K.ee, alone.M.ee), "test");
  check(EPSSetProblemType(eps, EPS_GHEP), "test");
  check(EPSSetType(eps, EPSLAPACK), "test");
  check(EPSSetWhichEigenpairs(eps, EPS_SMALLEST_REAL), "test");
  check(EPSSolve(eps), "test");
  for (int j = 0; j < modes; ++j) {
    double square;
    UniqueVec shape;
    check(MatCreateVecs(alone.K.ee, shape.out(), nullptr), "test");
    check(EPSGetEigenpair(eps, j, &square, nullptr, shape, nullptr), "test");
    EXPECT_NEAR(found.model.kaa[j] / square, 1, 1e-10);
    const double *v;
    check(VecGetArrayRead(shape, &v), "test");
    double most = 0, sign = 0;
    for (std::size_t i = 0; i < alone.elastic_dofs.size(); ++i)
      if (std::abs(v[i]) > std::abs(most)) most = v[i];
    sign = most < 0 ? -1 : 1;
    const auto &dofs = found.recovery.elastic_dofs;
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      const auto at =
          std::lower_bound(alone.elastic_dofs.begin(), alone.elastic_dofs.end(), dofs[i]) - alone.elastic_dofs.begin();
      ASSERT_NEAR(found.recovery.phi[i * modes + j], sign * v[at], 1e-8 * std::abs(most)) << "mode " << j + 1;
    }
    check(VecRestoreArrayRead(shape, &v), "test");
  }
}

ReducedModel small_reduced(PetscInt kept, int count, const MemoryPlan &plan, ModeKind kind = ModeKind::eigen,
                           double load = 1) {
  ClampedStructure parts = clamp(testing::lattice_model(PETSC_COMM_WORLD, 6, 3, count));
  for (double &value : parts.force_e.values) value *= load;
  ReductionSettings settings{kind, kept < 0 ? parts.elastic + kept : kept, false,
                             std::vector<char>(parts.elastic_dofs.size(), 0)};
  Stages stages;
  return craig_bampton(std::move(parts), settings, plan, stages).model;
}

TEST(Reduction, ModesLeftOutAreTheRestWhereFewAreLeft) {
  for (const auto &plan : {roomy(), roomy(false, 4)}) {
    const ReducedModel all = small_reduced(147, 5, plan), most = small_reduced(-5, 5, plan);
    const LeftOut &left = most.left_out;
    ASSERT_EQ(all.modes, most.modes + 5);
    EXPECT_TRUE(all.left_out.squares.empty());
    ASSERT_EQ(left.squares.size(), 5u);
    for (int j = 0; j < 5; ++j) {
      const int mode = most.modes + j;
      EXPECT_NEAR(left.squares[j] / all.kaa[mode], 1, 1e-8);
      EXPECT_NEAR(std::abs(left.loads[0][j]), std::abs(all.loads[0].fa[mode]), 1e-7 * largest(all.loads[0].fa));
      for (PetscInt i = 0; i < most.own_contact_dofs(); ++i)
        ASSERT_NEAR(std::abs(left.coupling[5 * i + j]), std::abs(all.mxa[i * all.modes + mode]),
                    1e-7 * largest(all.mxa));
    }
  }
}

// sum_l g_l^2 / w_l^2 over the modes left out, g = load + s M_lx x: what they yield to a motion x of the contacts.
double yielding(const ReducedModel &model, PetscInt from, const std::vector<double> &squares,
                const std::vector<double> &load, const std::vector<double> &coupling, double s) {
  const PetscInt all = static_cast<PetscInt>(squares.size());
  std::vector<double> g(all, 0.0);
  for (PetscInt i = 0; i < model.own_contact_dofs(); ++i)
    for (PetscInt l = 0; l < all; ++l)
      g[l] += s * std::cos(0.1 * (3 * model.own_points.begin + i)) * coupling[i * all + l];
  MPI_Allreduce(MPI_IN_PLACE, g.data(), all, MPI_DOUBLE, MPI_SUM, model.comm);
  double sum = 0;
  for (PetscInt l = from; l < all; ++l) sum += (g[l] + load[l]) * (g[l] + load[l]) / squares[l];
  return sum;
}

TEST(Reduction, ModesLeftOutYieldLikeAllThatAreLeft) {
  for (const auto &[count, tolerance] : {std::pair{5, 1e-8}, std::pair{9, 0.2}}) { // as many probes as dofs, or not
    const ReducedModel all = small_reduced(162 - 3 * count, count, roomy());
    for (const PetscInt kept : {0, 3, 20}) {
      const ReducedModel few = small_reduced(kept, count, roomy());
      const LeftOut &left = few.left_out;
      ASSERT_LE(left.squares.size(), 16u);
      for (const double s : {0.0, 1e3, 1e5}) {
        const double found = yielding(few, 0, left.squares, left.loads[0], left.coupling, s);
        EXPECT_NEAR(found / yielding(all, kept, all.kaa, all.loads[0].fa, all.mxa, s), 1, tolerance)
            << kept << " modes kept, s = " << s;
      }
    }
  }
}

TEST(Reduction, ResidualsYieldForAllThatIsLeftOut) { // with as many probes as contact dofs and loads
  const ReducedModel all = small_reduced(147, 5, roomy());
  for (const PetscInt kept : {32, 45}) {
    const ReducedModel few = small_reduced(kept, 5, roomy(), ModeKind::residual),
                       plain = small_reduced(kept, 5, roomy());
    ASSERT_EQ(few.modes, kept);
    for (PetscInt j = 0; j < kept - 16; ++j) EXPECT_NEAR(few.kaa[j] / plain.kaa[j], 1, 1e-12);
    for (const double s : {0.0, 1e3, 1e5}) {
      const double wanted = yielding(all, 0, all.kaa, all.loads[0].fa, all.mxa, s);
      EXPECT_NEAR(yielding(few, 0, few.kaa, few.loads[0].fa, few.mxa, s) / wanted, 1, 1e-8);
      EXPECT_GT(std::abs(yielding(plain, 0, plain.kaa, plain.loads[0].fa, plain.mxa, s) / wanted - 1), 1e-4);
      const LeftOut &left = few.left_out; // of what these lead to: nothing yields by itself
      EXPECT_NEAR(yielding(few, 0, left.squares, left.loads[0], left.coupling, s) / wanted, 0, 1e-8);
    }
    EXPECT_GT(largest(few.left_out.with_modes), 1e-3); // but it has mass in common
  }
}

TEST(Reduction, ResidualsWithoutLoadOrRoom) {
  const ReducedModel loaded = small_reduced(40, 5, roomy(), ModeKind::residual),
                     unloaded = small_reduced(40, 5, roomy(), ModeKind::residual, 0),
                     plain = small_reduced(40, 5, roomy());
  for (PetscInt j = 0; j < 25; ++j) EXPECT_NEAR(unloaded.kaa[j] / plain.kaa[j], 1, 1e-12); // a residual fewer
  EXPECT_GT(std::abs(loaded.kaa[24] / plain.kaa[24] - 1), 1e-3);
  const ReducedModel all = small_reduced(147, 5, roomy(), ModeKind::eigen, 0);
  EXPECT_NEAR(yielding(unloaded, 0, unloaded.kaa, unloaded.loads[0].fa, unloaded.mxa, 1) /
                  yielding(all, 0, all.kaa, all.loads[0].fa, all.mxa, 1),
              1, 1e-8);
  for (const PetscInt kept : {0, 1}) { // no room for any
    const ReducedModel few = small_reduced(kept, 5, roomy(), ModeKind::residual),
                       eigen = small_reduced(kept, 5, roomy());
    for (PetscInt j = 0; j < kept; ++j) EXPECT_NEAR(few.kaa[j] / eigen.kaa[j], 1, 1e-12);
    EXPECT_EQ(few.left_out.squares.size(), eigen.left_out.squares.size());
  }
}

TEST(Reduction, LanczosRestartsAndFindsThemAll) { // a basis too narrow for one pass
  ClampedStructure parts = clamp(testing::lattice_model(PETSC_COMM_WORLD, length, width, points));
  parts.solver->factor();
  const int wanted = 60;
  ASSERT_LT(lanczos_columns(wanted, parts.elastic) + 3 * lanczos_block, parts.elastic);
  const auto found = elastic_modes(*parts.solver, parts.K.ee, parts.M.ee, parts.elastic_dofs, wanted, "lattice");
  for (int j = 1; j < wanted; ++j) EXPECT_GT(found.squares[j], found.squares[j - 1]);
  EXPECT_EQ(modes_below(parts.K.ee, parts.M.ee, found.squares.back() * (1 - 1e-9)), wanted - 1);
  EXPECT_EQ(modes_below(parts.K.ee, parts.M.ee, found.squares.back() * (1 + 1e-9)), wanted);
  EXPECT_NO_THROW(check_none_missed(parts.K.ee, parts.M.ee, found.squares));
  auto missing = found.squares;
  missing.erase(missing.begin() + 20);
  EXPECT_THROW(check_none_missed(parts.K.ee, parts.M.ee, missing), ComputeError);
  const auto G = gram(PETSC_COMM_WORLD, found.shapes, 0, wanted, multiply(parts.M.ee, found.shapes), 0, wanted);
  for (int i = 0; i < wanted; ++i)
    for (int j = 0; j < wanted; ++j) EXPECT_NEAR(G[j * wanted + i], i == j, 1e-12);
}

TEST(Reduction, AllModesOfASmallModel) { // the whole space: Lanczos ends because nothing is left
  ClampedStructure parts = clamp(testing::lattice_model(PETSC_COMM_WORLD, 3, 2, 2));
  parts.solver->factor();
  const auto found = elastic_modes(*parts.solver, parts.K.ee, parts.M.ee, parts.elastic_dofs, parts.elastic, "lattice");
  double sum = 0, trace = 0; // of K_ee^-1 M_ee
  for (const double square : found.squares) sum += 1 / square;
  for (PetscInt j = 0; j < parts.elastic; ++j) {
    Tall unit(parts.own.size(), 1);
    if (parts.own.begin <= j && j < parts.own.end) unit.values[j - parts.own.begin] = 1;
    trace += gram(PETSC_COMM_WORLD, parts.solver->solve(multiply(parts.M.ee, unit)), 0, 1, unit, 0, 1)[0];
  }
  EXPECT_NEAR(sum / trace, 1, 1e-12);
}

// `copies` identical chains of 3 masses, not connected with each other: every eigenvalue as many times.
class EqualParts : public ::testing::TestWithParam<std::pair<int, int>> {};

TEST_P(EqualParts, NoCopyIsMissed) {
  const auto [copies, wanted] = GetParam();
  const PetscInt size = 3 * copies;
  const Range own = own_share(PETSC_COMM_WORLD, size);
  UniqueMat K, M;
  for (UniqueMat *A : {&K, &M}) {
    check(MatCreateAIJ(PETSC_COMM_WORLD, own.size(), own.size(), size, size, 3, nullptr, 3, nullptr, A->out()), "test");
    for (PetscInt i = own.begin; i < own.end; ++i) {
      check(MatSetValue(*A, i, i, A == &K ? 2 : 1, INSERT_VALUES), "test");
      if (A == &K && i % 3 > 0) check(MatSetValue(*A, i, i - 1, -1, INSERT_VALUES), "test");
      if (A == &K && i % 3 < 2) check(MatSetValue(*A, i, i + 1, -1, INSERT_VALUES), "test");
    }
    check(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY), "test");
    check(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY), "test");
    check(MatSetOption(*A, MAT_SYMMETRIC, PETSC_TRUE), "test");
  }
  std::vector<long> names;
  for (PetscInt i = own.begin; i < own.end; ++i) names.push_back(i);
  ClampedSolver solver(K, "equal parts");
  solver.factor();
  const auto found = elastic_modes(solver, K, M, names, wanted, "equal parts");
  for (int j = 0; j < wanted; ++j)
    EXPECT_NEAR(found.squares[j], 2 - 2 * std::cos((1 + j / copies) * M_PI / 4), 1e-10) << "mode " << j + 1;
}

INSTANTIATE_TEST_SUITE_P(Reduction, EqualParts,
                         ::testing::Values(std::pair{24, 20}, std::pair{24, 30}, std::pair{24, 72}, std::pair{40, 60},
                                           std::pair{50, 120}));

TEST(Reduction, PartitionSharesOutEveryElasticDofOnce) {
  const FullModel model = testing::lattice_model(PETSC_COMM_WORLD, 20, 8, 60);
  const auto own = elastic_share(model.K, model.contact_dofs);
  int size;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  std::vector<int> times(model.dofs, 0);
  for (const PetscInt dof : own) ++times[dof];
  MPI_Allreduce(MPI_IN_PLACE, times.data(), model.dofs, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  for (const auto &point : model.contact_dofs)
    for (const PetscInt dof : point) times[dof] += 1;
  for (int dof = 0; dof < model.dofs; ++dof) EXPECT_EQ(times[dof], 1) << "dof " << dof;
  EXPECT_LT(static_cast<double>(own.size()), 1.1 * (model.dofs - 180) / size);
}

class Factor : public ::testing::TestWithParam<bool> {}; // whether every rank has the whole

TEST_P(Factor, TooSmallAWorkspaceIsGivenMoreRoom) {
  check(PetscOptionsSetValue(nullptr, "-kee_whole", GetParam() ? "true" : "false"), "test");
  check(PetscOptionsSetValue(nullptr, "-kee_mat_mumps_icntl_14", "-90"),
        "test"); // a tenth of what the analysis asks for
  ClampedStructure parts = clamp(testing::lattice_model(PETSC_COMM_WORLD, 20, 8, points));
  EXPECT_NO_THROW(parts.solver->factor());
  EXPECT_EQ(parts.solver->attempts(), 2);
  for (const char *option : {"-kee_mat_mumps_icntl_14", "-kee_whole"})
    check(PetscOptionsClearValue(nullptr, option), "test");
  Tall b(parts.own.size(), 5); // more columns than ranks, and not for each the same number
  for (PetscInt j = 0; j < b.columns; ++j) std::fill_n(b.column(j), b.rows, 1.0 + j);
  const Tall back = multiply(parts.K.ee, parts.solver->solve(b));
  for (std::size_t i = 0; i < b.values.size(); ++i) EXPECT_NEAR(back.values[i], b.values[i], 1e-10);
  Tall few(parts.own.size(), 1);
  std::fill(few.values.begin(), few.values.end(), 1.0);
  for (const double value : multiply(parts.K.ee, parts.solver->solve(few)).values) EXPECT_NEAR(value, 1, 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Reduction, Factor, ::testing::Bool());

TEST(Reduction, DampingThatIsASumOfStiffnessAndMassStaysThatSum) {
  constexpr double of_k = 2e-3, of_m = 5;
  for (const auto &plan : {roomy(), roomy(false, 4)}) {
    FullModel full = testing::lattice_model(PETSC_COMM_WORLD, length, width, points);
    check(MatDuplicate(full.M, MAT_COPY_VALUES, full.C.out()), "test");
    check(MatScale(full.C, of_m), "test");
    check(MatAXPY(full.C, of_k, full.K, DIFFERENT_NONZERO_PATTERN), "test");
    check(MatDuplicate(full.M, MAT_COPY_VALUES, full.K_structural.out()), "test");
    ClampedStructure parts = clamp(std::move(full));
    ReductionSettings settings{ModeKind::eigen, modes, false, std::vector<char>(parts.elastic_dofs.size(), 0)};
    Stages stages;
    const ReducedModel model = craig_bampton(std::move(parts), settings, plan, stages).model;
    for (const auto &[matrix, k, m] : {std::tuple{&model.viscous, of_k, of_m}, {&model.structural, 0.0, 1.0}}) {
      ASSERT_TRUE(matrix->given);
      for (int i = 0; i < modes; ++i)
        for (int j = 0; j < modes; ++j)
          EXPECT_NEAR(matrix->aa[i * modes + j], i == j ? k * model.kaa[i] + m : 0, 1e-9 * (k * model.kaa.back() + m));
      for (std::size_t i = 0; i < model.mxa.size(); ++i)
        EXPECT_NEAR(matrix->xa[i], m * model.mxa[i], 1e-9 * m * largest(model.mxa));
      for (std::size_t i = 0; i < model.mxx.size(); ++i)
        EXPECT_NEAR(matrix->xx[i], k * model.kxx[i] + m * model.mxx[i],
                    1e-9 * (k * largest(model.kxx) + m * largest(model.mxx)));
    }
  }
}

TEST(Reduction, PlanGivesUpSpeedBeforeItGivesUp) {
  const ClampedStructure parts = clamp(testing::lattice_model(PETSC_COMM_WORLD, 20, 8, 60));
  const MemoryPlan roomy = plan_memory(parts, modes, 0, 0);
  EXPECT_TRUE(roomy.keep_psi);
  EXPECT_NO_THROW(refuse_if_too_large(parts, roomy));
  MemoryPlan tight = plan_memory(parts, modes, 0, roomy.machine_bytes - 1e3);
  EXPECT_LT(tight.machine_bytes, roomy.machine_bytes);
  const MemoryPlan hopeless = plan_memory(parts, modes, 0, 1e3);
  EXPECT_FALSE(hopeless.keep_psi);
  EXPECT_THROW(refuse_if_too_large(parts, hopeless), ComputeError);
}

// Where nothing but factors counts, as in large models.
TEST(Reduction, PlanCountsASecondFactorisationAndItsCopiesOfTheMatrix) {
  ClampedStructure parts = clamp(testing::lattice_model(PETSC_COMM_WORLD, 20, 8, points));
  parts.own = {0, 1};
  MatInfo info;
  check(MatGetInfo(parts.K.ee, MAT_LOCAL, &info), "test");
  const double factor = parts.solver->forecast_bytes(), copies = (8 + 4 + 8) * info.nz_used,
               more = 4 / 3.0 * factor + copies, before = resident_bytes(),
               planned = plan_memory(parts, 1, 0, 0, true).bytes;
  EXPECT_GE(planned, before + more);
  EXPECT_LE(planned, resident_bytes() + more + 0.1 * copies);
}

} // namespace
} // namespace dovetail
