// Damping that is not proportional to K and M, as matrices by hand, on any number of ranks.
#include <gtest/gtest.h>

#include <cmath>

#include "harmonic/assembled.hpp"
#include "modal/dampers.hpp"
#include "norms.hpp"
#include "small_model.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Reals = std::vector<double>;
constexpr std::size_t n = 11;

// Of the small model's points at rest: stuck; slipping along t1; open.
Standstill at_rest(PetscInt point) {
  const std::array<double, 3> forces[] = {{0.1, 0.1, 5}, {2.5, -1, 5}, {0, 0, 0}};
  return {{}, forces[point], {}};
}

Reals dense(const DampingMatrix &matrix) { // of one rank
  Reals out(n * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      out[i * n + j] = i < 2 && j < 2 ? matrix.aa[i * 2 + j]
                       : i < 2        ? matrix.xa[(j - 2) * 2 + i]
                       : j < 2        ? matrix.xa[(i - 2) * 2 + j]
                                      : matrix.xx[(i - 2) * 9 + j - 2];
  return out;
}

struct Scene {
  explicit Scene(const Damping &damping) : kind(damping) {
    add_damping_matrices(kind, model), add_damping_matrices(kind, whole);
    for (PetscInt p = model.own_points.begin; p < model.own_points.end; ++p) standstill.push_back(at_rest(p));
    dampers.emplace(model, contact, standstill, kind, layout);
    basis = stuck_basis(model, stuck_springs(contact), layout);
    const Assembled part_of(
        list_couplings<double>(layout, model.kaa,
                               [&](PetscInt i) {
                                 const std::size_t at = i;
                                 return ContactRow<double>{&model.mxa[at * 2], &model.mxx[at * 9], &model.kxx[at * 9]};
                               }),
        layout, false);
    if (kind.has_stuck_ratios()) {
      auto part = part_of.like(layout);
      dampers->take_ratios(*part, basis, kind.ratios);
    }
    by_hand();
  }
  void by_hand() {
    const Layout alone_(whole, 0);
    const std::vector<ContactPoint> points = small_contact(whole);
    const StuckBasis modes = stuck_basis(whole, stuck_springs(points), alone_);
    C.assign(n * n, 0), S.assign(n * n, 0);
    const Reals M = SmallMatrices().M;
    for (const ModeRatio &ratio : kind.ratios) {
      const std::size_t mode = ratio.mode - 1;
      if (kind.of_fixed) {
        C[mode * (n + 1)] += 2 * ratio.ratio * std::sqrt(whole.kaa[mode]);
        continue;
      }
      Reals V(n);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) V[i] += M[i * n + j] * modes.exact.row(j)[mode];
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
          C[i * n + j] += 2 * ratio.ratio * std::sqrt(modes.lambda[mode]) * V[i] * V[j];
    }
    for (std::size_t p = 0; kind.contact && p < 2; ++p) // the third is open
      for (std::size_t d = 0; d < 3; ++d)
        if (p == 0 || d > 0) C[(2 + 3 * p + d) * (n + 1)] += kind.stiffness * (d == 2 ? points[p].kn : points[p].kt[d]);
    if (kind.matrix) {
      const Reals given = dense(whole.viscous);
      for (std::size_t i = 0; i < n * n; ++i) C[i] += given[i];
    }
    if (kind.of_parts) S = dense(whole.structural);
  }
  double of_modes(const Reals &A, std::size_t a, std::size_t b) const { // phi_a^T A phi_b
    Reals u(n), v(n);
    for (PetscInt d = 0; d < layout.own_dofs(); ++d)
      u[layout.number(d)] = basis.exact.row(d)[a], v[layout.number(d)] = basis.exact.row(d)[b];
    for (Reals *of : {&u, &v}) MPI_Allreduce(MPI_IN_PLACE, of->data(), n, MPI_DOUBLE, MPI_SUM, layout.comm);
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) sum += u[i] * A[i * n + j] * v[j];
    return sum;
  }

  Damping kind;
  ReducedModel model = small_reduced(PETSC_COMM_WORLD), whole = small_reduced(PETSC_COMM_SELF);
  Layout layout{model, 0};
  std::vector<ContactPoint> contact = small_contact(model);
  std::vector<Standstill> standstill;
  std::optional<Dampers> dampers;
  StuckBasis basis;
  Reals C, S;
};

Damping of(std::vector<ModeRatio> ratios, bool fixed, bool matrix, bool springs, bool parts) {
  Damping damping(0.05, 0, parts ? 0.1 : 0);
  damping.ratios = std::move(ratios), damping.of_fixed = fixed, damping.matrix = matrix, damping.contact = springs,
  damping.of_parts = parts;
  return damping;
}

const std::vector<Damping> kinds{of({{1, 0.03}, {5, 0.01}}, false, false, false, false),
                                 of({{2, 0.03}}, true, false, false, false),
                                 of({}, false, true, false, false),
                                 of({}, false, false, true, false),
                                 of({}, false, false, false, true),
                                 of({{1, 0.02}, {2, 0.04}}, true, true, true, true),
                                 of({{3, 0.02}}, false, true, true, true)};

} // namespace

TEST(Dampers, forces_are_those_of_the_matrices) {
  for (const Damping &kind : kinds) {
    const Scene scene(kind);
    EXPECT_EQ(scene.dampers->is_viscous(), !kind.ratios.empty() || kind.matrix || kind.contact);
    EXPECT_EQ(scene.dampers->is_hysteretic(), kind.of_parts);
    for (const int width : {1, 3, 7}) {
      const auto motion = [&](std::size_t number, int i) { return wave(static_cast<int>(number), i); };
      const PetscInt own = scene.layout.own_dofs();
      Reals q, viscous(own * width, 7.0), hysteretic(own * width, 7.0);
      for (PetscInt d = 0; d < own; ++d)
        for (int i = 0; i < width; ++i) q.push_back(motion(scene.layout.number(d), i));
      scene.dampers->viscous_force(q.data(), width, viscous.data());
      scene.dampers->hysteretic_force(q.data(), width, hysteretic.data());
      for (PetscInt d = 0; d < own; ++d)
        for (int i = 0; i < width; ++i) {
          double by_C = 0, by_S = 0;
          for (std::size_t j = 0; j < n; ++j) {
            by_C += scene.C[scene.layout.number(d) * n + j] * motion(j, i);
            by_S += scene.S[scene.layout.number(d) * n + j] * motion(j, i);
          }
          EXPECT_NEAR(viscous[d * width + i], by_C, 1e-12);
          EXPECT_NEAR(hysteretic[d * width + i], by_S, 1e-12);
        }
    }
  }
}

TEST(Dampers, entries_are_those_of_the_matrices) {
  for (const Damping &kind : kinds) {
    const Scene scene(kind);
    const Layout &layout = scene.layout;
    std::vector<PetscInt> number(n); // of each row of the harmonic system
    for (PetscInt i = 0; i < static_cast<PetscInt>(n); ++i)
      number[i < layout.modes ? layout.mode_row(i) : layout.contact_row(i - layout.modes)] = i;
    Reals C(n * n), S(n * n), wanted_C(n * n), wanted_S(n * n);
    for (const Dampers::Entry &entry : scene.dampers->entries()) {
      EXPECT_TRUE(entry.viscous != 0 || entry.hysteretic != 0);
      EXPECT_GE(entry.row, layout.first_dof());
      EXPECT_LT(entry.row, layout.first_dof() + layout.own_dofs());
      C[number[entry.row] * n + number[entry.column]] += entry.viscous;
      S[number[entry.row] * n + number[entry.column]] += entry.hysteretic;
    }
    for (PetscInt d = 0; d < layout.own_dofs(); ++d)
      for (std::size_t j = 0; j < n; ++j) {
        const std::size_t at = layout.number(d) * n + j;
        EXPECT_NEAR(C[at], scene.C[at], 1e-13);
        EXPECT_NEAR(S[at], scene.S[at], 1e-13);
      }
  }
}

// But for ratios of the stuck structure.
TEST(Dampers, in_the_modes_are_products_with_them) {
  for (const Damping &kind : kinds) {
    if (kind.has_stuck_ratios()) continue;
    Scene scene(kind);
    StuckBasis basis = stuck_basis(scene.model, stuck_springs(scene.contact), scene.layout);
    basis.rates.assign(n, 0.5), basis.losses.assign(n, 0.25); // are added to
    scene.dampers->project(basis);
    const Range own = own_share(scene.layout.comm, n);
    EXPECT_EQ(basis.viscous.columns(), scene.dampers->is_viscous() ? n : 0);
    EXPECT_EQ(basis.hysteretic.columns(), kind.of_parts ? n : 0);
    for (std::size_t a = 0; a < n; ++a) {
      EXPECT_NEAR(basis.rates[a], 0.5 + scene.of_modes(scene.C, a, a), 1e-12);
      EXPECT_NEAR(basis.losses[a], 0.25 + scene.of_modes(scene.S, a, a), 1e-12);
      for (std::size_t b = 0; b < n; ++b) {
        const double in_C = scene.of_modes(scene.C, a, b), in_S = scene.of_modes(scene.S, a, b);
        const PetscInt i = static_cast<PetscInt>(a) - own.begin;
        if (i < 0 || i >= own.size()) continue;
        if (scene.dampers->is_viscous()) {
          EXPECT_NEAR(basis.viscous.row(i)[b], a == b ? 0 : in_C, 1e-6);
        }
        if (kind.of_parts) {
          EXPECT_NEAR(basis.hysteretic.row(i)[b], a == b ? 0 : in_S, 1e-6);
        }
      }
    }
  }
}

// Where their factor is 0 they are not there; and a point that slips to within rounding errors does.
TEST(Dampers, are_none_where_nothing_damps) {
  Damping damping(0.2);
  damping.of_parts = damping.contact = true;
  for (const double stiffness : {0.2, 0.0}) {
    damping.stiffness = stiffness;
    const Scene scene(damping);
    EXPECT_FALSE(scene.dampers->is_hysteretic());
    EXPECT_EQ(scene.dampers->is_viscous(), stiffness != 0);
  }
}

TEST(Dampers, of_springs_that_slip_are_none) {
  Damping damping(0.2);
  damping.contact = true;
  for (const Law law : {Law::coulomb, Law::cone})
    for (const auto &[part, slips] : {std::pair{1.0, true}, {1 - 1e-10, true}, {1 - 1e-8, false}}) {
      ReducedModel model = small_reduced(PETSC_COMM_WORLD);
      std::vector<ContactPoint> contact = small_contact(model);
      for (ContactPoint &point : contact) point.law = law, point.mu = {0.3, 0.3};
      const Standstill at{{}, {0.3 * 5 * part, 0, 5}, {}};
      const std::vector<Standstill> standstill(contact.size(), at);
      const Layout layout(model, 0);
      const Dampers dampers(model, contact, standstill, damping, layout);
      const Reals ones(layout.own_dofs(), 1);
      Reals force(ones.size());
      dampers.viscous_force(ones.data(), 1, force.data());
      for (std::size_t p = 0; p < contact.size(); ++p)
        for (int d = 0; d < 3; ++d) {
          const bool held = d == 2 || !slips || (d == 1 && law == Law::coulomb);
          const double spring = d == 2 ? contact[p].kn : contact[p].kt[d];
          EXPECT_EQ(force[layout.own_modes.size() + 3 * p + d], held ? 0.2 * spring : 0) << part << " " << d;
        }
    }
}
