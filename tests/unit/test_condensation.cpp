// Parts of the condensation by themselves, and all of it on a model in which every dof is coupled with every other,
// against dense matrices. On any number of ranks.
#include <gtest/gtest.h>

#include "reduction/condense.hpp"
#include "reduction/factors_pc.hpp"
#include "reduction/left_out.hpp"
#include "some_sector.hpp"
#include "support/dense.hpp"
#include "support/gathered.hpp"
#include "temporary_file.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr PetscInt dofs = 26, loads = 2;
constexpr int nc = 9;
const std::vector<std::array<PetscInt, 3>> points = {{4, 2, 0}, {10, 11, 9}, {25, 7, 18}}; // in no order

UniqueMat scattered_matrix(int size, int seed, const std::function<double(int, int)> &entry = {}) {
  UniqueMat A;
  const Range own = own_share(PETSC_COMM_WORLD, size);
  check(MatCreateAIJ(PETSC_COMM_WORLD, own.size(), own.size(), size, size, size, nullptr, size, nullptr, A.out()),
        "test");
  for (int i = own.begin; i < own.end; ++i)
    for (int j = 0; j < size; ++j)
      if (const double value = entry ? entry(i, j) : scattered(i, seed + j); value != 0)
        check(MatSetValue(A, i, j, value, INSERT_VALUES), "test");
  check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY), "test");
  check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY), "test");
  check(MatSetOption(A, MAT_SYMMETRIC, PETSC_TRUE), "test");
  return A;
}

double damping_of(int i, int j) {
  return 0.1 * stiffness_of(i, j) + 0.3 * scattered(std::min(i, j), 300 + std::max(i, j));
}
double hysteresis_of(int i, int j) { return scattered(std::min(i, j), 400 + std::max(i, j)); }

FullModel model_with(bool damped, std::vector<std::array<PetscInt, 3>> contact = points) {
  FullModel full = scattered_model(PETSC_COMM_WORLD, dofs, loads);
  full.contact_dofs = std::move(contact);
  if (damped)
    full.C = scattered_matrix(dofs, 0, damping_of), full.K_structural = scattered_matrix(dofs, 0, hysteresis_of);
  return full;
}

Dense transposed_times(const Dense &A, const Dense &B) { // A^T B
  Dense out(A.columns, B.columns);
  for (int i = 0; i < out.rows; ++i)
    for (int j = 0; j < out.columns; ++j)
      for (int l = 0; l < A.rows; ++l) out(i, j) += A(l, i) * B(l, j);
  return out;
}

Dense times(const Dense &A, const Dense &B) {
  Dense out(A.rows, B.columns);
  multiply(1, A, B, 0, out);
  return out;
}

Dense solved(const Dense &A, Dense B) { // A^-1 B
  Factors factors;
  EXPECT_TRUE(factors.factor(A));
  for (int j = 0; j < B.columns; ++j) factors.solve(B.column(j));
  return B;
}

// The model in full, elastic dofs ascending.
struct Whole {
  std::vector<int> e, c;
  Dense Kee, Mee, Te{dofs, dofs - nc},
      Tx{dofs, nc}; // motions of elastic dofs alone, and of each contact dof with what follows it

  Whole() {
    std::vector<char> held(dofs, 0);
    for (const auto &point : points)
      for (const PetscInt dof : point) c.push_back(dof), held[dof] = 1;
    for (int dof = 0; dof < dofs; ++dof)
      if (!held[dof]) e.push_back(dof);
    for (std::size_t i = 0; i < e.size(); ++i) Te(e[i], static_cast<int>(i)) = 1;
    for (int i = 0; i < nc; ++i) Tx(c[i], i) = 1;
    Kee = between(Te, stiffness_of, Te), Mee = between(Te, mass_of, Te);
    const Dense psi = solved(Kee, between(Te, stiffness_of, Tx));
    for (int j = 0; j < nc; ++j)
      for (std::size_t i = 0; i < e.size(); ++i) Tx(e[i], j) = -psi(static_cast<int>(i), j);
  }
  static Dense filled(double (*entry)(int, int)) {
    Dense A(dofs, dofs);
    for (int i = 0; i < dofs; ++i)
      for (int j = 0; j < dofs; ++j) A(i, j) = entry(i, j);
    return A;
  }
  static Dense between(const Dense &S, double (*entry)(int, int), const Dense &T) {
    return transposed_times(S, times(filled(entry), T));
  }
  static Dense load(int seed) {
    Dense F(dofs, 1);
    for (int i = 0; i < dofs; ++i) F(i, 0) = scattered(i, seed);
    return F;
  }
  static Dense forces() {
    Dense F(dofs, loads);
    for (int j = 0; j < loads; ++j) std::copy_n(load(901 + j).column(0), dofs, F.column(j));
    return F;
  }
};

void expect_rows(const std::vector<double> &own, Range range, const Dense &wanted, double tolerance) {
  ASSERT_EQ(own.size(), static_cast<std::size_t>(3 * range.size() * wanted.columns));
  for (int i = 0; i < 3 * range.size(); ++i)
    for (int j = 0; j < wanted.columns; ++j)
      ASSERT_NEAR(own[i * wanted.columns + j], wanted(3 * range.begin + i, j), tolerance) << i << " " << j;
}

ReducedModel reduced(ModeKind kind, PetscInt modes, bool damped, const MemoryPlan &plan, Recovery *recovery = nullptr) {
  ClampedStructure parts = clamp(model_with(damped));
  ReductionSettings settings{kind, modes, false, {}};
  for (const long dof : parts.elastic_dofs) settings.wanted.push_back(dof % 3 == 0);
  Stages stages;
  Reduction made = craig_bampton(std::move(parts), settings, plan, stages);
  EXPECT_LT(made.backward_error, 1e-14);
  EXPECT_GE(made.backward_error, 0);
  if (recovery) *recovery = made.recovery;
  return made.model;
}

MemoryPlan plan_of(bool keep, PetscInt block) {
  MemoryPlan plan;
  plan.keep_psi = keep, plan.block = block;
  return plan;
}

} // namespace

TEST(Condense, rows_of_a_sparse_matrix_and_blocks_on_top) {
  const UniqueMat A = scattered_matrix(7, 0, [](int i, int j) { return (i + j) % 2 ? 0.0 : scattered(i, j); });
  const Range own = own_share(PETSC_COMM_WORLD, 7);
  std::vector<double> rows = dense_rows(A);
  ASSERT_EQ(rows.size(), 7u * own.size());
  for (int i = 0; i < own.size(); ++i)
    for (int j = 0; j < 7; ++j) EXPECT_EQ(rows[7 * i + j], (own.begin + i + j) % 2 ? 0 : scattered(own.begin + i, j));
  const std::vector<double> before = rows;
  Tall block(own.size(), 2);
  for (std::size_t i = 0; i < block.values.size(); ++i) block.values[i] = 3.0 + static_cast<double>(i);
  add_block(rows, 7, 4, -0.5, block);
  for (int i = 0; i < own.size(); ++i)
    for (int j = 0; j < 7; ++j)
      EXPECT_EQ(rows[7 * i + j], before[7 * i + j] - (j == 4 || j == 5 ? 0.5 * block.column(j - 4)[i] : 0));
}

TEST(Condense, right_hand_sides_are_on_the_first_rank) {
  const auto entry = [](int i, int j) { return i == 3 || (i + j) % 3 == 0 ? 0.0 : scattered(i, j); };
  const UniqueMat A = scattered_matrix(8, 0, entry), host = on_host(A);
  const SparseColumns sides = right_hand_sides(host, 2, 4);
  if (rank_here() > 0) {
    EXPECT_EQ(sides.begin.size(), 1u);
    EXPECT_TRUE(sides.row.empty() && sides.value.empty());
    return;
  }
  ASSERT_EQ(sides.begin.size(), 5u);
  for (int k = 0; k < 4; ++k) {
    std::vector<double> row(8, 0.0);
    for (int at = sides.begin[k]; at < sides.begin[k + 1]; ++at) row[sides.row[at]] = sides.value[at];
    for (int j = 0; j < 8; ++j) EXPECT_EQ(row[j], -entry(2 + k, j));
  }
  EXPECT_EQ(sides.begin[1], sides.begin[2]); // of row 3
  EXPECT_EQ(static_cast<std::size_t>(sides.begin[4]), sides.row.size());
}

TEST(Condense, what_is_below_the_diagonal_follows) {
  for (const PetscInt many : {1, 3, 5}) {
    const Range own = own_share(PETSC_COMM_WORLD, many);
    std::vector<double> rows;
    for (int i = 3 * own.begin; i < 3 * own.end; ++i)
      for (int j = 0; j < 3 * many; ++j) rows.push_back(j >= i ? scattered(i, j) : 99);
    mirror_upper(PETSC_COMM_WORLD, many, rows);
    for (int i = 3 * own.begin; i < 3 * own.end; ++i)
      for (int j = 0; j < 3 * many; ++j)
        EXPECT_EQ(rows[(i - 3 * own.begin) * 3 * many + j], scattered(std::min(i, j), std::max(i, j))) << i << " " << j;
  }
}

TEST(Clamp, every_number_of_the_model_is_in_one_of_its_parts) {
  const ClampedStructure parts = clamp(model_with(true));
  EXPECT_EQ(parts.elastic, dofs - nc);
  ASSERT_EQ(static_cast<std::size_t>(parts.own.size()), parts.elastic_dofs.size());
  const auto all = gathered(PETSC_COMM_WORLD, MPI_LONG, parts.elastic_dofs);
  ASSERT_EQ(all.size(), std::size_t(dofs - nc));
  for (int i = 0; i < parts.own.size(); ++i) EXPECT_EQ(all[parts.own.begin + i], parts.elastic_dofs[i]);
  std::vector<long> contact;
  for (const auto &point : points) contact.insert(contact.end(), point.begin(), point.end());
  const auto expect_block = [&](Mat A, const std::vector<long> &rows, const std::vector<long> &columns, auto &&entry) {
    PetscInt begin, end, width;
    check(MatGetOwnershipRange(A, &begin, &end), "test");
    check(MatGetSize(A, nullptr, &width), "test");
    ASSERT_EQ(std::size_t(width), columns.size());
    for (PetscInt i = begin; i < end; ++i)
      for (PetscInt j = 0; j < width; ++j) {
        double value;
        check(MatGetValue(A, i, j, &value), "test");
        ASSERT_EQ(value, entry(static_cast<int>(rows[i]), static_cast<int>(columns[j])));
      }
  };
  const auto expect_blocks = [&](const Blocks &blocks, auto &&entry) {
    expect_block(blocks.ee, all, all, entry), expect_block(blocks.ec, all, contact, entry);
    expect_block(blocks.ce, contact, all, entry), expect_block(blocks.cc, contact, contact, entry);
  };
  expect_blocks(parts.K, stiffness_of), expect_blocks(parts.M, mass_of);
  expect_blocks(parts.C, damping_of), expect_blocks(parts.K_structural, hysteresis_of);
  ASSERT_EQ(parts.force_e.columns, loads);
  ASSERT_EQ(parts.force_c.size(), std::size_t(loads));
  for (int i = 0; i < parts.own.size(); ++i) {
    for (int j = 0; j < loads; ++j)
      EXPECT_EQ(parts.force_e.column(j)[i], scattered(static_cast<int>(parts.elastic_dofs[i]), 901 + j));
    EXPECT_EQ(parts.preload_e[i], scattered(static_cast<int>(parts.elastic_dofs[i]), 900));
  }
  for (int i = 0; i < 3 * parts.own_points.size(); ++i) {
    const int dof = static_cast<int>(contact[3 * parts.own_points.begin + i]);
    for (int j = 0; j < loads; ++j) EXPECT_EQ(parts.force_c[j][i], scattered(dof, 901 + j));
    EXPECT_EQ(parts.preload_c[i], scattered(dof, 900));
  }
  EXPECT_FALSE(parts.full.K || parts.full.M || parts.full.C || parts.full.K_structural || parts.full.preload);
  const ClampedStructure plain = clamp(model_with(false));
  EXPECT_FALSE(plain.C.cc || plain.K_structural.cc || plain.moved.e);
}

TEST(Condensation, of_every_matrix_with_eigenmodes_and_with_residuals) {
  const Whole whole;
  const Dense P = Whole::load(900), fx = transposed_times(whole.Tx, Whole::forces()),
              moved = times(whole.Te, solved(whole.Kee, transposed_times(whole.Te, P)));
  Dense R(nc, 1);
  for (int i = 0; i < nc; ++i) {
    R(i, 0) = -P(whole.c[i], 0);
    for (int l = 0; l < dofs; ++l) R(i, 0) += stiffness_of(whole.c[i], l) * moved(l, 0);
  }
  for (const ModeKind kind : {ModeKind::eigen, ModeKind::residual})
    for (const auto &plan : {plan_of(true, 256), plan_of(true, 4), plan_of(false, 256), plan_of(false, 4)}) {
      Recovery recovery;
      const ReducedModel model = reduced(kind, 8, true, plan, &recovery);
      const Range own = model.own_points;
      expect_rows(model.kxx, own, Whole::between(whole.Tx, stiffness_of, whole.Tx), 1e-11);
      expect_rows(model.mxx, own, Whole::between(whole.Tx, mass_of, whole.Tx), 1e-12);
      expect_rows(model.viscous.xx, own, Whole::between(whole.Tx, damping_of, whole.Tx), 1e-11);
      expect_rows(model.structural.xx, own, Whole::between(whole.Tx, hysteresis_of, whole.Tx), 1e-12);
      expect_rows(model.r, own, R, 1e-12);
      ASSERT_EQ(recovery.elastic_dofs.size(), recovery.xe0.size());
      for (std::size_t i = 0; i < recovery.elastic_dofs.size(); ++i) {
        const auto dof = static_cast<int>(recovery.elastic_dofs[i]);
        EXPECT_EQ(dof % 3, 0);
        EXPECT_NEAR(recovery.xe0[i], moved(dof, 0), 1e-13);
        for (int j = 0; j < nc; ++j) EXPECT_NEAR(recovery.psi[i * nc + j], whole.Tx(dof, j), 1e-13);
      }
      std::size_t all = 0;
      for (const int dof : whole.e) all += dof % 3 == 0;
      EXPECT_EQ(gathered(PETSC_COMM_WORLD, MPI_LONG, recovery.elastic_dofs).size(), all);
      for (int j = 0; j < loads; ++j) {
        Dense column(nc, 1);
        std::copy_n(fx.column(j), nc, column.column(0));
        expect_rows(model.loads[j].fx, own, column, 1e-12);
        EXPECT_EQ(model.loads[j].name, "load " + std::to_string(j));
      }
    }
}

TEST(Condensation, modes_carry_what_their_shapes_say) {
  const Whole whole;
  for (const ModeKind kind : {ModeKind::eigen, ModeKind::residual}) {
    ClampedStructure parts = clamp(model_with(true));
    const ReductionSettings settings{kind, 8, false, std::vector<char>(parts.elastic_dofs.size(), 1)};
    Stages stages;
    const Reduction made = craig_bampton(std::move(parts), settings, {}, stages);
    const ReducedModel &model = made.model;
    Dense phi(dofs, 8);
    for (std::size_t i = 0; i < made.recovery.elastic_dofs.size(); ++i)
      for (int j = 0; j < 8; ++j)
        phi(static_cast<int>(made.recovery.elastic_dofs[i]), j) = made.recovery.phi[8 * i + j];
    MPI_Allreduce(MPI_IN_PLACE, phi.values.data(), 8 * dofs, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    const Dense fa = transposed_times(phi, Whole::forces()), kaa = Whole::between(phi, stiffness_of, phi),
                maa = Whole::between(phi, mass_of, phi);
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j < 8; ++j) {
        EXPECT_NEAR(kaa(i, j), i == j ? model.kaa[i] : 0, 1e-8);
        EXPECT_NEAR(maa(i, j), i == j, 1e-10);
      }
      for (int j = 0; j < loads; ++j) EXPECT_NEAR(model.loads[j].fa[i], fa(i, j), 1e-12);
      double most = 0; // the largest entry is positive
      for (int dof = 0; dof < dofs; ++dof)
        if (std::abs(phi(dof, i)) > std::abs(most)) most = phi(dof, i);
      EXPECT_GT(most, 0);
    }
    expect_rows(model.mxa, model.own_points, Whole::between(whole.Tx, mass_of, phi), 1e-11);
    for (const auto &[matrix, entry] : {std::pair{&model.viscous, damping_of}, {&model.structural, hysteresis_of}}) {
      expect_rows(matrix->xa, model.own_points, Whole::between(whole.Tx, entry, phi), 1e-11);
      const Dense aa = Whole::between(phi, entry, phi);
      for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) EXPECT_NEAR(matrix->aa[8 * i + j], aa(i, j), 1e-11);
    }
    Dense K = whole.Kee, M = whole.Mee;
    const std::vector<double> eigen = symmetric_modes(K, M);
    for (int j = 0; j < 8; ++j)
      if (kind == ModeKind::eigen || j < 4) EXPECT_NEAR(model.kaa[j] / eigen[j], 1, 1e-11) << j;
    if (kind == ModeKind::residual) EXPECT_GT(model.kaa[4], eigen[4] * 1.0001);
  }
}

// Kept and left out, they are all there is: L^T (D - z G)^-1 L, G their mass, L what loads and moving contacts ask.
TEST(Condensation, modes_kept_and_left_out_answer_together_like_all) {
  const Whole whole;
  const Dense F = transposed_times(whole.Te, Whole::forces()), C = Whole::between(whole.Te, mass_of, whole.Tx);
  for (const ModeKind kind : {ModeKind::eigen, ModeKind::residual}) {
    const ReducedModel model = reduced(kind, 8, false, {});
    const LeftOut &left = model.left_out;
    const int na = 8, r = static_cast<int>(left.squares.size()), all = na + r;
    ASSERT_EQ(all, dofs - nc);
    ASSERT_EQ(left.with_modes.size(), std::size_t(na * r));
    for (std::size_t j = 1; j < left.squares.size(); ++j) EXPECT_GE(left.squares[j], left.squares[j - 1]);
    const auto mxa = gathered(PETSC_COMM_WORLD, MPI_DOUBLE, model.mxa),
               coupling = gathered(PETSC_COMM_WORLD, MPI_DOUBLE, left.coupling);
    Dense L(all, loads + nc), wanted_L(dofs - nc, loads + nc);
    for (int i = 0; i < all; ++i)
      for (int j = 0; j < loads + nc; ++j) {
        wanted_L(i, j) = j < loads ? F(i, j) : C(i, j - loads);
        L(i, j) = j < loads ? (i < na ? model.loads[j].fa[i] : left.loads[j][i - na])
                            : (i < na ? mxa[(j - loads) * na + i] : coupling[(j - loads) * r + i - na]);
      }
    for (const double z : {0.0, -10.0, -400.0}) {
      Dense A(all, all), whole_A = whole.Kee;
      for (std::size_t i = 0; i < whole_A.values.size(); ++i) whole_A.values[i] -= z * whole.Mee.values[i];
      for (int i = 0; i < all; ++i) A(i, i) = (i < na ? model.kaa[i] : left.squares[i - na]) - z;
      for (int i = 0; i < na; ++i)
        for (int j = 0; j < r; ++j) A(i, na + j) = A(na + j, i) = -z * left.with_modes[i * r + j];
      const Dense found = transposed_times(L, solved(A, L)),
                  wanted = transposed_times(wanted_L, solved(whole_A, wanted_L));
      for (std::size_t i = 0; i < wanted.values.size(); ++i) EXPECT_NEAR(found.values[i], wanted.values[i], 1e-10) << z;
    }
  }
}

TEST(Condensation, where_every_dof_is_in_contact_nothing_changes) {
  FullModel full = scattered_model(PETSC_COMM_WORLD, 6, 1);
  full.contact_dofs = {{3, 1, 0}, {2, 5, 4}};
  ClampedStructure parts = clamp(std::move(full));
  EXPECT_FALSE(parts.solver);
  EXPECT_EQ(parts.elastic, 0);
  Stages stages;
  const Reduction made = craig_bampton(std::move(parts), {}, {}, stages);
  const int order[] = {3, 1, 0, 2, 5, 4};
  const ReducedModel &model = made.model;
  for (int i = 0; i < model.own_contact_dofs(); ++i) {
    const int dof = order[3 * model.own_points.begin + i];
    for (int j = 0; j < 6; ++j) {
      EXPECT_EQ(model.kxx[6 * i + j], stiffness_of(dof, order[j]));
      EXPECT_EQ(model.mxx[6 * i + j], mass_of(dof, order[j]));
    }
    EXPECT_EQ(model.loads[0].fx[i], scattered(dof, 901));
    EXPECT_EQ(model.r[i], -scattered(dof, 900));
  }
  EXPECT_EQ(model.units, "mm-N-s");
  EXPECT_TRUE(made.recovery.xe0.empty());
}

TEST(LeftOut, weights_of_mixtures) {
  double sum = 0, squares = 0;
  for (int row = 0; row < 100; ++row)
    for (int column = 0; column < 16; ++column) {
      const double value = probe_noise(row, column);
      EXPECT_EQ(value, 1 - 2 * static_cast<double>(mix(64 * (row + 1) + column) >> 11) / 9007199254740992.0);
      sum += value, squares += value * value;
    }
  EXPECT_LT(std::abs(sum), 100);
  EXPECT_NEAR(squares / 1600, 1 / 3.0, 0.03);
}

TEST(LeftOut, probes_are_the_loads_or_mixtures_of_them) {
  const PetscInt own = 4 + rank_here();
  const auto forces = [&](int count) {
    Tall F(own, count);
    for (int j = 0; j < count; ++j)
      for (PetscInt i = 0; i < own && j != 5; ++i)
        F.column(j)[i] = (j + 1) * scattered(100 * rank_here() + static_cast<int>(i), j);
    return F; // the sixth is zero
  };
  EXPECT_EQ(load_probes(PETSC_COMM_WORLD, forces(8)).values, forces(8).values);
  EXPECT_EQ(load_probes(PETSC_COMM_WORLD, forces(0)).columns, 0);
  const Tall F = forces(9), probes = load_probes(PETSC_COMM_WORLD, F);
  ASSERT_EQ(probes.columns, 8);
  const std::vector<double> G = gram(PETSC_COMM_WORLD, F, 0, 9, F, 0, 9);
  for (int column = 0; column < 8; ++column)
    for (PetscInt i = 0; i < own; ++i) {
      double wanted = 0;
      for (int j = 0; j < 9; ++j)
        if (j != 5) wanted -= probe_noise(j, column) / std::sqrt(G[10 * j]) * F.column(j)[i];
      EXPECT_NEAR(probes.column(column)[i], wanted, 1e-13);
    }
}

TEST(LeftOut, probes_of_moving_contacts_are_those_or_mixtures_of_them) {
  const PetscInt own = 5;
  Tall carried(own, 3), few(own, 7), many(own, 7);
  for (std::size_t i = 0; i < carried.values.size(); ++i) carried.values[i] = scattered(static_cast<int>(i), 3);
  mix_probes(carried, 2, 5, 2, few); // of five contact dofs the third to the fifth, behind two loads
  mix_probes(carried, 2, 6, 2, many);
  for (PetscInt i = 0; i < own; ++i)
    for (int j = 0; j < 7; ++j) {
      EXPECT_EQ(few.column(j)[i], j < 4 ? 0 : carried.column(j - 4)[i]);
      double wanted = 0;
      for (int k = 0; k < 3 && j >= 2; ++k) wanted -= probe_noise(2 + k, j - 1) * carried.column(k)[i];
      EXPECT_NEAR(many.column(j)[i], wanted, 1e-15);
    }
}

TEST(LeftOut, what_contacts_carry_of_many_motions) {
  const Whole whole;
  ClampedStructure parts = clamp(model_with(false));
  parts.solver->factor();
  Tall motions(parts.own.size(), 21);
  Dense all(dofs, 20);
  for (int j = 0; j < 21; ++j)
    for (int i = 0; i < parts.own.size(); ++i)
      motions.column(j)[i] = scattered(static_cast<int>(parts.elastic_dofs[i]), 50 + j);
  for (int j = 0; j < 20; ++j)
    for (const int dof : whole.e) all(dof, j) = scattered(dof, 51 + j);
  expect_rows(carried_by(parts, parts.M, motions, 1), parts.own_points, Whole::between(whole.Tx, mass_of, all), 1e-12);
}

TEST(FactorsPc, solve_a_vector_or_a_block) {
  const UniqueMat K = scattered_matrix(12, 0, stiffness_of);
  ClampedSolver solver(K, "test");
  solver.factor();
  Inverse inverse{solver, {}};
  UniqueKSP ksp;
  PC pc;
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "test");
  check(KSPSetOperators(ksp, K, K), "test");
  check(KSPSetType(ksp, KSPPREONLY), "test");
  check(KSPGetPC(ksp, &pc), "test");
  precondition_by(inverse, pc);
  const char *name;
  check(PCShellGetName(pc, &name), "test");
  EXPECT_STREQ(name, "the factors of K_ee");
  UniqueVec b, x, back;
  check(MatCreateVecs(K, b.out(), x.out()), "test");
  check(VecDuplicate(b, back.out()), "test");
  check(VecSet(b, 2.5), "test");
  check(KSPSolve(ksp, b, x), "test");
  check(MatMult(K, x, back), "test");
  check(VecAXPY(back, -1, b), "test");
  PetscReal off;
  check(VecNorm(back, NORM_INFINITY, &off), "test");
  EXPECT_LT(off, 1e-13);
  const PetscInt own = own_share(PETSC_COMM_WORLD, 12).size();
  Tall sides(own, 3), found(own, 3);
  for (int j = 0; j < 3; ++j)
    for (PetscInt i = 0; i < own; ++i) sides.column(j)[i] = scattered(static_cast<int>(i) + 20 * rank_here(), j);
  {
    const UniqueMat B = dense_view(PETSC_COMM_WORLD, sides, 0, 3), X = dense_view(PETSC_COMM_WORLD, found, 0, 3);
    check(KSPMatSolve(ksp, B, X), "test");
  }
  const Tall product = multiply(K, found);
  for (std::size_t i = 0; i < product.values.size(); ++i) EXPECT_NEAR(product.values[i], sides.values[i], 1e-13);
}
