#include <algorithm>
#include <cmath>
#include <numeric>

#include "reduction/condense.hpp"
#include "reduction/craig_bampton.hpp"
#include "reduction/elastic_modes.hpp"
#include "reduction/left_out.hpp"
#include "reduction/reduced_model.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

// Adds to columns [first, first + Y.columns) of own rows (row-major, `width` columns) the rows below first + Y.columns
// of S^T Y: what is beyond them follows from symmetry.
void add_upper(MPI_Comm comm, PetscInt points, const Tall &S, const Tall &Y, PetscInt first,
               std::vector<double> &rows) {
  int size, rank;
  MPI_Comm_size(comm, &size);
  MPI_Comm_rank(comm, &rank);
  const PetscInt end = first + Y.columns, width = 3 * points;
  const auto part = own_gram(Y, 0, Y.columns, S, 0, end); // transposed: what goes to one rank is contiguous
  std::vector<int> counts(size);
  for (int owner = 0; owner < size; ++owner) {
    const Range range = share_of(points, owner, size);
    counts[owner] = Y.columns * std::max<PetscInt>(0, std::min(end, 3 * range.end) - 3 * range.begin);
  }
  std::vector<double> own(counts[rank]);
  MPI_Reduce_scatter(part.data(), own.data(), counts.data(), MPI_DOUBLE, MPI_SUM, comm);
  for (std::size_t at = 0; at < own.size(); ++at) rows[at / Y.columns * width + first + at % Y.columns] += own[at];
}

double backward_error(Mat K, const Tall &psi, Mat K_ec) {
  MPI_Comm comm;
  PetscReal norm;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K), &comm), "checking Psi");
  check(MatNorm(K, NORM_INFINITY, &norm), "checking Psi");
  Tall residual = multiply(K, psi, 0, 1), load(psi.rows, 1);
  add_columns(K_ec, 0, load);
  double largest[3] = {0, 0, 0};
  for (PetscInt i = 0; i < psi.rows; ++i) {
    largest[0] = std::max(largest[0], std::abs(residual.values[i] + load.values[i]));
    largest[1] = std::max(largest[1], std::abs(psi.values[i]));
    largest[2] = std::max(largest[2], std::abs(load.values[i]));
  }
  MPI_Allreduce(MPI_IN_PLACE, largest, 3, MPI_DOUBLE, MPI_MAX, comm);
  return largest[0] > 0 ? largest[0] / (norm * largest[1] + largest[2]) : 0;
}

// What is wanted later of elastic motions S, columns [from, from + count): rows `kept`, or those of a sector.
Tall wanted_rows(const MovedRows &moved, const std::vector<PetscInt> &kept, const Tall &S, PetscInt from,
                 PetscInt count) {
  if (moved.e) return multiply(moved.e, S, from, count);
  Tall rows(static_cast<PetscInt>(kept.size()), count);
  for (PetscInt j = 0; j < count; ++j)
    for (std::size_t i = 0; i < kept.size(); ++i) rows.column(j)[i] = S.column(from + j)[kept[i]];
  return rows;
}

// Into a row-major array of `width` columns, from column `first` on.
void keep_rows(const Tall &S, std::vector<double> &rows, PetscInt width, PetscInt first) {
  for (PetscInt i = 0; i < S.rows; ++i)
    for (PetscInt j = 0; j < S.columns; ++j) rows[static_cast<std::size_t>(i) * width + first + j] = S.column(j)[i];
}

} // namespace

Reduction craig_bampton(ClampedStructure &&parts, const ReductionSettings &settings, const MemoryPlan &plan,
                        Stages &stages) {
  Tall shapes;
  return craig_bampton(parts, settings, plan, stages, shapes);
}

Reduction craig_bampton(ClampedStructure &parts, const ReductionSettings &settings, const MemoryPlan &plan,
                        Stages &stages, Tall &shapes) {
  const MPI_Comm comm = parts.full.comm;
  Reduction out;
  ReducedModel &model = out.model;
  Recovery &recovery = out.recovery;
  const PetscInt modes = settings.modes, own_rows = parts.own.size();
  model.comm = comm;
  model.units = parts.full.units;
  model.modes = modes;
  model.points = static_cast<PetscInt>(parts.full.contact_dofs.size());
  model.own_points = parts.own_points;
  model.own_modes = own_share(comm, modes);
  const PetscInt nc = model.contact_dofs(), first_own = 3 * model.own_points.begin, own_nc = model.own_contact_dofs();
  model.kxx = dense_rows(parts.K.cc);
  model.mxx = dense_rows(parts.M.cc);
  model.mxa.resize(static_cast<std::size_t>(own_nc) * modes);
  model.loads.clear();
  for (std::size_t j = 0; j < parts.force_c.size(); ++j)
    model.loads.push_back({parts.full.forces[j].name, std::vector<double>(modes), parts.force_c[j]});
  model.r = parts.preload_c;
  for (double &value : model.r) value = -value;
  std::vector<std::pair<const Blocks *, DampingMatrix *>> damped;
  for (const auto &[C, matrix] : {std::pair{&parts.C, &model.viscous}, {&parts.K_structural, &model.structural}})
    if (C->cc) damped.emplace_back(C, matrix), matrix->given = true, matrix->xx = dense_rows(C->cc);
  recovery.elastic_dofs = parts.moved.dofs;
  if (parts.elastic == 0) { // every dof in contact: nothing to condense
    recovery.xe0.resize(parts.moved.dofs.size());
    if (parts.moved.c) recovery.psi = dense_rows(parts.moved.c);
    return out;
  }

  const ClampedSolver &solver = *parts.solver;
  stages.run("2c factorisation", [&] { parts.solver->factor(); });

  Tall load(own_rows, 1); // eq (2)
  load.values = parts.preload_e;
  const Tall xe0 = solver.solve(load);
  const auto held = multiply(parts.K.ce, xe0).values;
  for (std::size_t i = 0; i < held.size(); ++i) model.r[i] += held[i]; // R = K_ce x_e0 - P_c

  ElasticModes found = stages.run("2d modes", [&] { // eq (15)
    return elastic_modes(solver, parts.K.ee, parts.M.ee, parts.elastic_dofs, modes, parts.full.file.string());
  });
  const std::vector<double> lowest = found.squares;
  const Tall &phi = found.shapes;

  std::vector<PetscInt> kept;
  for (PetscInt i = 0; i < own_rows && !parts.moved.e; ++i)
    if (settings.wanted[i]) kept.push_back(i), recovery.elastic_dofs.push_back(parts.elastic_dofs[i]);
  recovery.xe0 = wanted_rows(parts.moved, kept, xe0, 0, 1).values;
  recovery.psi.resize(recovery.xe0.size() * nc);

  const Tall &force = parts.force_e, of_loads = load_probes(comm, force);
  const PetscInt loads = force.columns;
  Tall probes(own_rows, std::min(nc + of_loads.columns, lanczos_block));
  std::copy(of_loads.values.begin(), of_loads.values.end(), probes.values.begin());
  const UniqueMat sides = on_host(parts.K.ce);
  Tall psi(own_rows, plan.keep_psi ? nc : std::min(plan.block, nc));
  for (PetscInt first = 0; first < nc; first += plan.block) {
    const PetscInt count = std::min(plan.block, nc - first), at = plan.keep_psi ? first : 0;
    const auto carry = [&](const Blocks &A, std::vector<double> &rows) { // A_ee Psi + A_ec; A_cc + A_ce Psi + ...
      add_block(rows, nc, first, 1, multiply(A.ce, psi, at, count));
      Tall carried = multiply(A.ee, psi, at, count);
      add_columns(A.ec, first, carried);
      return carried;
    };
    const auto close = [&](const Tall &carried, std::vector<double> &rows) { // ... + Psi^T (A_ee Psi + A_ec)
      if (plan.keep_psi)
        stages.run("2f projections", [&] { add_upper(comm, model.points, psi, carried, first, rows); });
      else // Psi^T Y = -K_ce K_ee^-1 Y
        stages.run("2e constraint modes",
                   [&] { add_block(rows, nc, first, -1, multiply(parts.K.ce, solver.solve(carried))); });
    };
    stages.run("2e constraint modes",
               [&] { solver.solve_sparse(right_hand_sides(sides, first, count), psi, at, count); }); // eq (16)
    const auto inertia_of_block = [&] {
      Tall seen = wanted_rows(parts.moved, kept, psi, at, count);
      if (parts.moved.c) add_columns(parts.moved.c, first, seen);
      keep_rows(seen, recovery.psi, nc, first);
      if (first == 0) out.backward_error = backward_error(parts.K.ee, psi, parts.K.ec);
      add_block(model.kxx, nc, first, 1, multiply(parts.K.ce, psi, at, count)); // K_xx = K_cc + K_ce Psi
      Tall inertia = carry(parts.M, model.mxx);
      mix_probes(inertia, first, nc, of_loads.columns, probes);
      const auto coupling = gram(comm, phi, 0, modes, inertia, 0, count); // M_ax = Phi^T (M_ee Psi + M_ec)
      const auto loaded = gram(comm, psi, at, count, force, 0, loads);    // F_x = Psi^T F_e + F_c, eq (18)
      for (PetscInt j = std::max(first, first_own); j < std::min(first + count, first_own + own_nc); ++j) {
        std::copy_n(coupling.data() + static_cast<std::size_t>(j - first) * modes, modes,
                    model.mxa.data() + static_cast<std::size_t>(j - first_own) * modes);
        for (PetscInt pattern = 0; pattern < loads; ++pattern)
          model.loads[pattern].fx[j - first_own] += loaded[pattern * count + j - first];
      }
      return inertia;
    };
    // What is carried is as large as a block of Psi: one at a time.
    close(stages.run("2f projections", inertia_of_block), model.mxx);
    for (const auto &[C, matrix] : damped)
      close(stages.run("2f projections", [&, C = C, matrix = matrix] { return carry(*C, matrix->xx); }), matrix->xx);
  }
  psi = Tall(); // no longer needed, and a count of modes takes a factorisation
  if (probes.columns > 0 && modes < parts.elastic)
    stages.run("2f projections", [&] {
      probes = solver.solve(probes);
      if (settings.kind == ModeKind::residual)
        if (const PetscInt count = with_residuals(parts, found, probes)) {
          const auto coupling = carried_by(parts, parts.M, phi, modes - count);
          for (PetscInt i = 0; i < own_nc; ++i)
            std::copy_n(&coupling[static_cast<std::size_t>(i) * count], count,
                        &model.mxa[static_cast<std::size_t>(i + 1) * modes - count]);
        }
      model.left_out = left_out(parts, found, probes);
    });
  model.kaa = found.squares;
  stages.run("2f projections", [&] {
    for (const auto &[C, matrix] : damped) {
      matrix->aa = gram(comm, phi, 0, modes, multiply(C->ee, phi), 0, modes);
      matrix->xa = carried_by(parts, *C, phi);
      mirror_upper(comm, model.points, matrix->xx);
    }
  });
  const auto modal = gram(comm, phi, 0, modes, force, 0, loads); // eq (17)
  for (PetscInt pattern = 0; pattern < loads; ++pattern)
    model.loads[pattern].fa.assign(modal.begin() + pattern * modes, modal.begin() + (pattern + 1) * modes);
  recovery.phi.resize(recovery.xe0.size() * modes);
  keep_rows(wanted_rows(parts.moved, kept, phi, 0, modes), recovery.phi, modes, 0);
  mirror_upper(comm, model.points, model.kxx);
  mirror_upper(comm, model.points, model.mxx);
  if (settings.check_modes && modes > 0) {
    parts.solver.reset();
    stages.run("2g count of modes", [&] { check_none_missed(parts.K.ee, parts.M.ee, lowest); });
  }
  shapes = std::move(found.shapes);
  return out;
}

} // namespace dovetail
