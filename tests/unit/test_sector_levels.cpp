// The reduction of a cyclic sector, on two levels, against the whole of each index in dense complex matrices: no dof is
// left out there, and nothing is done in two steps. On any number of ranks.
#include <gtest/gtest.h>

#include <complex>
#include <functional>

#include "reduction/craig_bampton.hpp"
#include "reduction/exact_modes.hpp"
#include "reduction/sector_change.hpp"
#include "reduction/sector_coordinates.hpp"
#include "reduction/sector_elastic.hpp"
#include "reduction/sector_levels.hpp"
#include "some_sector.hpp"
#include "temporary_file.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Complex = std::complex<double>;

constexpr PetscInt dofs = 52;
constexpr int sectors = 6, contact = 15, loads = 2;

CyclicSector five_points() { // as many probes as contact dofs and a load
  CyclicSector sector = sector_of(sectors);
  sector.contacts.pop_back();
  return sector;
}

ComplexDense filled(int rows, int columns, double (*entry)(int, int)) {
  ComplexDense A(rows, columns);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) A(i, j) = entry(i, j);
  return A;
}

ComplexDense operator-(ComplexDense A, const ComplexDense &B) {
  for (std::size_t i = 0; i < A.values.size(); ++i) A.values[i] -= B.values[i];
  return A;
}

ComplexDense operator+(ComplexDense A, const ComplexDense &B) {
  for (std::size_t i = 0; i < A.values.size(); ++i) A.values[i] += B.values[i];
  return A;
}

ComplexDense operator*(double factor, ComplexDense A) {
  for (Complex &value : A.values) value *= factor;
  return A;
}

// One index in unknowns [e; x], x the relative displacements, e all that moves besides.
struct Whole {
  ComplexDense Te, Tx; // the sector's dofs by them
  ComplexDense Kee, Mee, psi, kxx, mxx, carried;
  ComplexDense fe, fx; // (e, L), (x, L)
  ComplexDense rest, r;

  explicit Whole(const CyclicSector &sector, int h) {
    const auto nodes = held_dofs(sector, dofs);
    const SectorCoordinates E(sector, 3 * static_cast<PetscInt>(nodes.size()), h);
    ComplexDense unit(E.all(), E.all());
    for (int i = 0; i < E.all(); ++i) unit(i, i) = 1;
    const ComplexDense b = E.to_held(unit);
    const int inside = dofs - E.held(), e = inside + E.own();
    std::vector<char> held(dofs, 0);
    Te = ComplexDense(dofs, e), Tx = ComplexDense(dofs, E.contact());
    for (int i = 0; i < E.held(); ++i) {
      const PetscInt dof = nodes[i / 3][i % 3];
      held[dof] = 1;
      for (int j = 0; j < E.own(); ++j) Te(dof, inside + j) = b(i, j);
      for (int j = 0; j < E.contact(); ++j) Tx(dof, j) = b(i, E.own() + j);
    }
    for (int dof = 0, at = 0; dof < dofs; ++dof)
      if (!held[dof]) Te(dof, at++) = 1;
    const ComplexDense K = filled(dofs, dofs, stiffness_of), M = filled(dofs, dofs, mass_of),
                       F = filled(dofs, loads, [](int i, int j) { return scattered(i, 901 + j); }),
                       P = filled(dofs, 1, [](int i, int) { return scattered(i, 900); });
    const auto congruent = [&](const ComplexDense &A, const ComplexDense &B, const ComplexDense &C) {
      return adjoint_product(A, product(B, C));
    };
    Kee = congruent(Te, K, Te), Mee = congruent(Te, M, Te);
    const ComplexDense Kex = congruent(Te, K, Tx), Mex = congruent(Te, M, Tx);
    psi = -1 * solve_positive(Kee, Kex);
    kxx = congruent(Tx, K, Tx) + adjoint_product(Kex, psi);
    carried = product(Mee, psi) + Mex;
    mxx = congruent(Tx, M, Tx) + adjoint_product(Mex, psi) + adjoint_product(psi, carried);
    fe = adjoint_product(Te, F), fx = adjoint_product(Tx, F) + adjoint_product(psi, fe);
    rest = solve_positive(Kee, adjoint_product(Te, P));
    r = adjoint_product(Kex, rest) - adjoint_product(Tx, P);
    rest = product(Te, rest);
  }
};

std::vector<Complex> complex(const std::vector<double> &values) { return {values.begin(), values.end()}; }

// Of an index of the reduced model what is in SectorIndex, index 0 too.
SectorIndex index_of(const ReducedModel &model, int h) {
  if (h > 0) return model.indices[h - 1];
  SectorIndex index{model.kaa, complex(model.mxa), complex(model.mxx), complex(model.kxx), {}, {}};
  for (const LoadPattern &load : model.loads) index.loads.push_back({complex(load.fa), complex(load.fx)});
  const LeftOut &left = model.left_out;
  index.left_out = {left.squares, {}, complex(left.coupling), complex(left.with_modes)};
  for (const auto &load : left.loads) index.left_out.loads.push_back(complex(load));
  return index;
}

Recovery::OfIndex motion_of(const Recovery &recovery, int h) {
  return h > 0 ? recovery.indices[h - 1] : Recovery::OfIndex{complex(recovery.phi), complex(recovery.psi)};
}

double largest(const std::vector<Complex> &values) {
  double most = 0;
  for (const Complex value : values) most = std::max(most, std::abs(value));
  return most;
}

// Own rows, row-major, of a matrix of contact dofs.
void expect_rows(const std::vector<Complex> &own, Range points, const ComplexDense &wanted, double tolerance) {
  ASSERT_EQ(own.size(), static_cast<std::size_t>(3 * points.size() * wanted.columns));
  const double scale = largest(wanted.values);
  for (int i = 0; i < 3 * points.size(); ++i)
    for (int j = 0; j < wanted.columns; ++j)
      ASSERT_NEAR(std::abs(own[i * wanted.columns + j] - wanted(3 * points.begin + i, j)), 0, tolerance * scale)
          << i << " " << j;
}

struct Wish {
  int interior, modes;
  bool exact = false, residuals = false;
  int judged = 0;
  std::vector<PetscInt> motion = {}; // or all
};

ClampedStructure clamped(const Wish &wish, const std::function<void(FullModel &)> &change = {}) {
  FullModel full = scattered_model(PETSC_COMM_WORLD, dofs, loads);
  full.cyclic = five_points();
  if (change) change(full);
  change_within_sector(full, wish.motion.empty(), wish.motion);
  full.contact_dofs = held_dofs(full.cyclic, dofs);
  return clamp(std::move(full));
}

SectorModel reduced(const Wish &wish, const std::function<void(FullModel &)> &change = {}) {
  ClampedStructure parts = clamped(wish, change);
  const ReductionSettings settings{ModeKind::eigen, wish.interior < 0 ? parts.elastic : wish.interior, false,
                                   std::vector<char>(parts.elastic_dofs.size(), 0)};
  Stages stages;
  Tall shapes;
  Reduction held = craig_bampton(parts, settings, {}, stages, shapes);
  SecondLevel second;
  second.modes = wish.modes, second.model_file = "wheel.h5", second.exact = wish.exact;
  second.residuals = wish.residuals, second.judged = wish.judged;
  return sector_model(parts, shapes, std::move(held), second);
}

void expect_statics(const SectorModel &made, const CyclicSector &sector) {
  const ReducedModel &model = made.reduction.model;
  const Recovery &recovery = made.reduction.recovery;
  const int points = static_cast<int>(sector.contacts.size());
  ASSERT_EQ(model.points, points);
  EXPECT_EQ(model.sectors, sectors);
  EXPECT_EQ(model.units, "mm-N-s");
  ASSERT_EQ(model.indices.size(), 3u);
  ASSERT_EQ(recovery.indices.size(), 3u);
  for (int h = 0; h <= sectors / 2; ++h) {
    const Whole whole(sector, h);
    const SectorIndex index = index_of(model, h);
    expect_rows(index.kxx, model.own_points, whole.kxx, 1e-11);
    expect_rows(index.mxx, model.own_points, whole.mxx, 1e-11);
    ASSERT_EQ(index.loads.size(), static_cast<std::size_t>(loads));
    for (int j = 0; j < loads; ++j) {
      EXPECT_EQ(model.loads[j].name, "load " + std::to_string(j));
      expect_rows(index.loads[j].fx, model.own_points, whole.fx.block(0, j, 3 * points, 1), 1e-11);
    }
    const auto psi = motion_of(recovery, h).psi;
    const ComplexDense wanted = whole.Tx + product(whole.Te, whole.psi);
    ASSERT_EQ(psi.size(), recovery.elastic_dofs.size() * wanted.columns);
    for (std::size_t i = 0; i < psi.size(); ++i)
      ASSERT_NEAR(std::abs(psi[i] - wanted(static_cast<int>(recovery.elastic_dofs[i / wanted.columns]),
                                           static_cast<int>(i % wanted.columns))),
                  0, 1e-11);
    if (h > 0) continue;
    expect_rows(complex(model.r), model.own_points, whole.r, 1e-11);
    for (std::size_t i = 0; i < recovery.elastic_dofs.size(); ++i)
      EXPECT_NEAR(std::abs(recovery.xe0[i] - whole.rest(static_cast<int>(recovery.elastic_dofs[i]), 0)), 0, 1e-12);
  }
}

// Dofs b of a motion of the sector's dofs with x held, joints within the sector by x and sums; and s, which makes them.
std::pair<ComplexDense, ComplexDense> held_and_own(const CyclicSector &sector, int h, std::vector<Complex> u) {
  for (const auto &point : sector.contacts)
    for (int d = 0; d < 3 && !point.next; ++d) {
      u[(point.has_a() ? point.a : point.b)[d]] = 0;
      if (point.is_pair()) u[point.b[d]] *= 2;
    }
  const auto nodes = held_dofs(changed(sector), dofs);
  const SectorCoordinates E(changed(sector), 3 * static_cast<PetscInt>(nodes.size()), h);
  ComplexDense b(E.held(), 1), unit(E.own(), E.own());
  for (int i = 0; i < E.held(); ++i) b(i, 0) = u[nodes[i / 3][i % 3]];
  for (int i = 0; i < E.own(); ++i) unit(i, i) = 1;
  const ComplexDense columns = E.to_held(unit);
  return {b, solve_positive(adjoint_product(columns, columns), adjoint_product(columns, b))};
}

// Frequencies, shapes, and what they have to do with contacts and loads, each up to a phase that they share.
void expect_modes(const SectorModel &made, const CyclicSector &sector, int modes, double tolerance,
                  double shape_tolerance) {
  const ReducedModel &model = made.reduction.model;
  const Recovery &recovery = made.reduction.recovery;
  ASSERT_EQ(model.modes, modes);
  for (int h = 0; h <= sectors / 2; ++h) {
    const Whole whole(sector, h);
    const SectorIndex index = index_of(model, h);
    const HermitianModes wanted = lowest_modes(whole.Kee, whole.Mee, modes);
    const ComplexDense shapes = product(whole.Te, wanted.shapes), max = adjoint_product(wanted.shapes, whole.carried),
                       fa = adjoint_product(wanted.shapes, whole.fe);
    const auto phi = motion_of(recovery, h).phi;
    ASSERT_EQ(index.kaa.size(), static_cast<std::size_t>(modes));
    ASSERT_EQ(phi.size(), recovery.elastic_dofs.size() * modes);
    for (int a = 0; a < modes; ++a) {
      EXPECT_NEAR(index.kaa[a] / wanted.squares[a], 1, tolerance) << "mode " << a << " of index " << h;
      std::vector<Complex> found(dofs);
      for (std::size_t i = 0; i < recovery.elastic_dofs.size(); ++i)
        found[recovery.elastic_dofs[i]] = phi[i * modes + a];
      MPI_Allreduce(MPI_IN_PLACE, found.data(), dofs, MPI_C_DOUBLE_COMPLEX, MPI_SUM, PETSC_COMM_WORLD);
      Complex turn = 0;
      for (int i = 0; i < dofs; ++i) turn += std::conj(shapes(i, a)) * found[i];
      turn /= std::abs(turn);
      for (int i = 0; i < dofs; ++i)
        ASSERT_NEAR(std::abs(found[i] - turn * shapes(i, a)), 0, shape_tolerance) << "mode " << a << " of index " << h;
      for (int j = 0; j < loads; ++j)
        EXPECT_NEAR(std::abs(index.loads[j].fa[a] - std::conj(turn) * fa(a, j)), 0, shape_tolerance);
      for (int i = 0; i < model.own_contact_dofs(); ++i) // M_xa = M_ax^H
        EXPECT_NEAR(std::abs(index.mxa[i * modes + a] - turn * std::conj(max(a, 3 * model.own_points.begin + i))), 0,
                    shape_tolerance);
      const auto [held, own] = held_and_own(sector, h, found);
      const ComplexDense &s = made.steps > 0 ? held : own;
      const double most = largest(s.values);
      const auto first =
          std::find_if(s.values.begin(), s.values.end(), [&](Complex v) { return std::abs(v) > 0.999 * most; });
      EXPECT_NEAR(std::abs(*first - most), 0, 1e-3 * most); // real and positive
    }
  }
}

// What modes kept and left out together answer to loads and moving contacts at w^2 = z, against all that there is:
// L^H (D - z G)^-1 L, G their mass.
void expect_answers(const SectorModel &made, const CyclicSector &sector, double tolerance) {
  const ReducedModel &model = made.reduction.model;
  for (int h = 0; h <= sectors / 2; ++h) {
    const Whole whole(sector, h);
    const SectorIndex index = index_of(model, h);
    const auto &left = index.left_out;
    const int na = static_cast<int>(model.modes), r = static_cast<int>(left.squares.size()), n = na + r,
              own = model.own_contact_dofs(), first = 3 * model.own_points.begin;
    ASSERT_EQ(n, whole.Kee.rows) << h;
    ASSERT_EQ(left.loads.size(), static_cast<std::size_t>(loads));
    ASSERT_EQ(left.with_modes.size(), static_cast<std::size_t>(na * r));
    ASSERT_EQ(left.coupling.size(), static_cast<std::size_t>(own * r));
    for (const double z : {0.0, -7.0, -300.0}) {
      ComplexDense A(n, n), F(n, loads), C(n, own), whole_C(whole.Kee.rows, own);
      for (int i = 0; i < n; ++i) {
        A(i, i) = (i < na ? index.kaa[i] : left.squares[i - na]) - z;
        for (int j = 0; j < loads; ++j) F(i, j) = i < na ? index.loads[j].fa[i] : left.loads[j][i - na];
        for (int j = 0; j < own; ++j)
          C(i, j) = std::conj(i < na ? index.mxa[j * na + i] : left.coupling[j * r + i - na]);
      }
      for (int i = 0; i < na; ++i)
        for (int j = 0; j < r; ++j)
          A(i, na + j) = -z * left.with_modes[i * r + j], A(na + j, i) = std::conj(A(i, na + j));
      for (int j = 0; j < own; ++j) std::copy_n(whole.carried.column(first + j), whole_C.rows, whole_C.column(j));
      const ComplexDense stiff = whole.Kee - z * whole.Mee;
      for (const auto &[found, wanted] :
           {std::pair{adjoint_product(F, solve_positive(A, F)),
                      adjoint_product(whole.fe, solve_positive(stiff, whole.fe))},
            {adjoint_product(C, solve_positive(A, F)), adjoint_product(whole_C, solve_positive(stiff, whole.fe))},
            {adjoint_product(C, solve_positive(A, C)), adjoint_product(whole_C, solve_positive(stiff, whole_C))}})
        for (std::size_t i = 0; i < wanted.values.size(); ++i)
          EXPECT_NEAR(std::abs(found.values[i] - wanted.values[i]), 0, tolerance * largest(wanted.values))
              << "z = " << z << ", index " << h;
    }
  }
}

} // namespace

TEST(SectorLevels, with_all_interior_modes_every_index_is_that_of_the_whole) {
  const CyclicSector sector = five_points();
  const SectorModel made = reduced({-1, 14});
  expect_statics(made, sector);
  expect_modes(made, sector, 14, 1e-11, 1e-9);
  expect_answers(made, sector, 1e-8);
  EXPECT_EQ(made.left_out, -1); // nothing is
  EXPECT_EQ(made.steps, 0);
  EXPECT_LT(made.reduction.backward_error, 1e-14);
}

TEST(SectorLevels, exact_modes_are_those_of_the_whole_whatever_the_interior_ones) {
  const CyclicSector sector = five_points();
  for (const int interior : {0, 4}) {
    const SectorModel made = reduced({interior, 6, true});
    expect_statics(made, sector);
    expect_modes(made, sector, 6, 1e-9, 1e-5);
    EXPECT_GT(made.steps, 2);
    EXPECT_LT(made.steps, 60);
    for (int h = 0; h <= sectors / 2; ++h) {
      const Whole whole(sector, h);
      const SectorIndex index = index_of(made.reduction.model, h);
      double yielded = 0;
      for (std::size_t i = 0; i < index.kaa.size(); ++i) yielded += std::norm(index.loads[0].fa[i]) / index.kaa[i];
      for (std::size_t i = 0; i < index.left_out.squares.size(); ++i)
        yielded += std::norm(index.left_out.loads[0][i]) / index.left_out.squares[i];
      const ComplexDense f = whole.fe.block(0, 0, whole.fe.rows, 1);
      EXPECT_NEAR(yielded / adjoint_product(f, solve_positive(whole.Kee, f))(0, 0).real(), 1,
                  interior > 0 ? 0.02 : 0.15)
          << h;
      for (const Complex value : index.left_out.with_modes) EXPECT_EQ(value, 0.0);
    }
  }
}

TEST(SectorLevels, a_step_towards_the_exact_modes_tells_what_the_interior_ones_leave_out) {
  const CyclicSector sector = five_points();
  for (const int h : {0, 2}) {
    const SectorModel made = reduced({4, 6, false, false, h});
    expect_statics(made, sector);
    const HermitianModes wanted = lowest_modes(Whole(sector, h).Kee, Whole(sector, h).Mee, 6);
    const std::vector<double> found = index_of(made.reduction.model, h).kaa;
    double most = 0;
    for (int j = 0; j < 6; ++j) most = std::max(most, std::sqrt(found[j] / wanted.squares[j]) - 1);
    EXPECT_NEAR(made.left_out / most, 1, 0.3) << h;
    EXPECT_EQ(made.steps, 1);
  }
}

TEST(SectorLevels, residuals_yield_for_all_that_is_left_out) {
  const CyclicSector sector = five_points();
  const SectorModel made = reduced({-1, 14, false, true}), plain = reduced({-1, 14});
  expect_statics(made, sector);
  expect_answers(made, sector, 1e-8);
  for (int h = 0; h <= sectors / 2; ++h) {
    const SectorIndex index = index_of(made.reduction.model, h), eigen = index_of(plain.reduction.model, h);
    for (int j = 0; j < 7; ++j) EXPECT_NEAR(index.kaa[j] / eigen.kaa[j], 1, 1e-11);
    EXPECT_GT(index.kaa[7], eigen.kaa[7] * 1.0001);
    const ComplexDense &f = Whole(sector, h).fe;
    const ComplexDense wanted = adjoint_product(f, solve_positive(Whole(sector, h).Kee, f));
    for (int j = 0; j < loads; ++j) {
      double yielded = 0;
      for (int a = 0; a < 14; ++a) yielded += std::norm(index.loads[j].fa[a]) / index.kaa[a];
      EXPECT_NEAR(yielded / wanted(j, j).real(), 1, 1e-10) << h;
    }
  }
}

TEST(SectorLevels, residuals_at_most_as_many_as_a_block_has_and_none_of_one_mode) {
  const SectorModel one = reduced({-1, 1, false, true}), same = reduced({-1, 1});
  EXPECT_EQ(one.reduction.model.kaa, same.reduction.model.kaa);
  const SectorModel many = reduced({-1, 20, false, true}), plain = reduced({-1, 20});
  for (int h = 0; h <= sectors / 2; ++h) {
    const SectorIndex index = index_of(many.reduction.model, h), eigen = index_of(plain.reduction.model, h);
    for (int j = 0; j < 10; ++j) EXPECT_NEAR(index.kaa[j] / eigen.kaa[j], 1, 1e-11);
    EXPECT_GT(index.kaa[10], eigen.kaa[10] * 1.0001);
  }
}

TEST(SectorLevels, the_motion_of_some_dofs) {
  const SectorModel all = reduced({-1, 4}), some = reduced({-1, 4, false, false, 0, {4, 30, 51}}),
                    exact = reduced({4, 4, true, false, 0, {4, 30, 51}});
  for (const SectorModel *made : {&some, &exact}) {
    const std::vector<long> own = made->reduction.recovery.elastic_dofs;
    const Range mine = own_share(PETSC_COMM_WORLD, dofs);
    std::vector<long> wanted;
    for (const long dof : {4, 30, 51})
      if (dof >= mine.begin && dof < mine.end) wanted.push_back(dof);
    EXPECT_EQ(own, wanted);
    expect_statics(*made, five_points());
    for (int h = 0; h <= sectors / 2; ++h) {
      const auto found = motion_of(made->reduction.recovery, h).phi, whole = motion_of(all.reduction.recovery, h).phi;
      ASSERT_EQ(found.size(), 4 * own.size());
      for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_NEAR(std::abs(found[i]), std::abs(whole[4 * (own[i / 4] - mine.begin) + i % 4]), 1e-6);
    }
  }
}

TEST(SectorLevels, what_moves_without_strain_or_has_no_mass_is_refused_with_its_nodal_diameter) {
  const auto with = [](UniqueMat FullModel::*matrix, double value) {
    return [=](FullModel &model) { // on a dof of a face
      const Range own = own_share(PETSC_COMM_WORLD, dofs);
      if (own.begin <= 39 && 39 < own.end) check(MatSetValue(model.*matrix, 39, 39, value, ADD_VALUES), "test");
      check(MatAssemblyBegin(model.*matrix, MAT_FINAL_ASSEMBLY), "test");
      check(MatAssemblyEnd(model.*matrix, MAT_FINAL_ASSEMBLY), "test");
    };
  };
  const std::string where = "wheel.h5: in motions of nodal diameter 0 the sector, its contact points held, ";
  EXPECT_EQ(said<InputError>([&] {
              reduced({-1, 4}, with(&FullModel::K, -500));
            }),
            where + "can move without strain; hold it, or check the faces and /K");
  EXPECT_EQ(said<InputError>([&] {
              reduced({-1, 29}, with(&FullModel::M, -30));
            }),
            where + "has a mass that is not positive definite; every dof needs mass, or reduction.modes must be less");
}

TEST(ExactModes, go_on_until_they_are_steady_or_say_that_they_are_not) {
  ClampedStructure parts = clamped({4, 6});
  const ReductionSettings settings{ModeKind::eigen, 4, false, std::vector<char>(parts.elastic_dofs.size(), 0)};
  Stages stages;
  Tall interior;
  const FirstLevel first = first_level(craig_bampton(parts, settings, {}, stages, interior).model);
  const SectorCoordinates E(parts.full.cyclic, first.held, 2);
  const ComplexDense S = E.congruent(first.stiffness).block(0, 0, E.own(), E.own());
  constexpr int p = 8, count = 3;
  ComplexDense by_modes(4, p), s(E.own(), p); // noise
  for (int j = 0; j < p; ++j) {
    for (int i = 0; i < 4; ++i) by_modes(i, j) = {scattered(i, 100 + j), scattered(i, 200 + j)};
    for (int i = 0; i < s.rows; ++i) s(i, j) = {scattered(i, 300 + j), scattered(i, 400 + j)};
  }
  const ComplexDense held = E.to_held(s);
  const FirstGuess guess{interior, std::vector<double>(p, 2.0), by_modes, held};
  const auto modes = [&](int steps, double tolerance) {
    return exact_modes(parts, E, S, guess, count, steps, tolerance);
  };
  const HermitianModes wanted = lowest_modes(Whole(five_points(), 2).Kee, Whole(five_points(), 2).Mee, count);
  const ExactModes rough = modes(60, 5e-9), fine = modes(60, 1e-11), one = modes(1, 0);
  EXPECT_LT(rough.steps, fine.steps);
  EXPECT_GT(rough.steps, 1);
  EXPECT_LE(rough.change, 5e-9);
  EXPECT_LE(fine.change, 1e-11);
  ASSERT_EQ(fine.squares.size(), std::size_t(count));
  for (int j = 0; j < count; ++j) EXPECT_NEAR(fine.squares[j] / wanted.squares[j], 1, 1e-10);
  EXPECT_EQ(one.steps, 1);
  EXPECT_EQ(one.change, one.first_change);
  double most = 0; // of the squares that were guessed
  for (int j = 0; j < count; ++j) most = std::max(most, std::abs(one.squares[j] / 2 - 1));
  EXPECT_NEAR(one.first_change / most, 1, 1e-12);
  EXPECT_NEAR(fine.first_change / most, 1, 1e-12);
  EXPECT_EQ(said<ComputeError>([&] { modes(2, 0); }),
            "scattered: the exact modes of a sector did not converge in 2 steps; ask for fewer modes, or do without "
            "reduction.exact_modes");
  EXPECT_EQ(fine.fa.size(), std::size_t(loads));
  EXPECT_EQ(fine.moved.columns, 2 * count);
  EXPECT_EQ(fine.carried.columns, count);
}
