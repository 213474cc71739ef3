#include "reduction/sector_levels.hpp"

#include <algorithm>
#include <cmath>

#include "reduction/block_lanczos.hpp"
#include "reduction/exact_modes.hpp"
#include "reduction/sector_coordinates.hpp"
#include "reduction/sector_left_out.hpp"
#include "reduction/sector_motion.hpp"
#include "support/error.hpp"
#include "support/memory.hpp"

namespace dovetail {
namespace {

using Complex = std::complex<double>;

constexpr PetscInt guards = 8; // vectors beyond the modes wanted, which make iterations converge
constexpr int most_steps = 60;
constexpr double steady = 1e-11; // change of a square from step to step

struct Index { // everything of one index, whole
  std::vector<double> squares;
  ComplexDense max, mxx, kxx;                       // M_ax (N_a, nc), ...
  std::vector<ComplexDense> fa, fx;                 // a column each
  ComplexDense r, at_rest;                          // of index 0: R, and b at rest with x held
  ComplexDense shapes_of_modes, modes_b, contact_b; // interior modes and b by a, b by x: (N_m, ..), (n_b, ..)
  ComplexDense stiffness;                           // of s
  LeftOutIndex left_out;
};

// Turns each mode so that of `rows` its first large entry is real and positive.
void fix_phases(ComplexDense &shapes, int first_row) {
  for (int j = 0; j < shapes.columns; ++j) {
    Complex *v = shapes.column(j), *end = v + shapes.rows;
    const Complex turn = phase_of(v + first_row, end);
    std::for_each(v, end, [&](Complex &value) { value *= turn; });
  }
}

std::string in_index(const SecondLevel &settings, int h) {
  return settings.model_file.string() + ": in motions of nodal diameter " + std::to_string(h) +
         " the sector, its "
         "contact points held, ";
}

// Modes of [eta; s] with x held.
HermitianModes modes_of(const ElasticIndex &elastic, PetscInt count, const SecondLevel &settings, int h) {
  const int m = static_cast<int>(elastic.squares.size()), s = elastic.S.rows, n = m + s;
  ComplexDense stiffness(n, n), mass = elastic.M.block(0, 0, n, n);
  for (int j = 0; j < m; ++j) stiffness(j, j) = elastic.squares[j];
  for (int j = 0; j < s; ++j) std::copy_n(elastic.S.column(j), s, stiffness.column(m + j) + m);
  std::vector<double> diagonal;
  for (int i = 0; i < n; ++i) diagonal.push_back(stiffness(i, i).real());
  HermitianModes modes = lowest_modes(std::move(stiffness), std::move(mass), static_cast<int>(count));
  bool moves = modes.fault == HermitianModes::Fault::stiffness;
  for (std::size_t j = 0; j < modes.squares.size() && !moves; ++j)
    moves = is_rigid(modes.squares[j], modes.shapes.column(static_cast<int>(j)), diagonal);
  if (moves) throw InputError(in_index(settings, h) + "can move without strain; hold it, or check the faces and /K");
  if (modes.fault == HermitianModes::Fault::mass)
    throw InputError(in_index(settings, h) + "has a mass that is not positive definite; every dof needs mass, or "
                                             "reduction.modes must be less");
  fix_phases(modes.shapes, s > 0 ? m : 0);
  return modes;
}

// With `count` modes at first, of which those wanted couple with the contacts; `judged`: against exact ones, later.
Index reduced_index(const CyclicSector &sector, const FirstLevel &first, const SecondLevel &settings, PetscInt count,
                    bool judged, int h) {
  const SectorCoordinates E(sector, first.held, h);
  const int s = E.own(), nc = E.contact(), na = static_cast<int>(settings.modes), m = first.modes;
  const ComplexDense K = E.congruent(first.stiffness), M = E.congruent(first.mass), Kx = K.block(0, s, s, nc);
  ComplexDense psi = solve_positive(K.block(0, 0, s, s), Kx); // of s; interior modes take no part
  if (s > 0 && psi.rows == 0)
    throw InputError(in_index(settings, h) + "can move without strain; hold it, or check the faces and /K");
  for (Complex &value : psi.values) value = -value;
  Index out;
  const ElasticIndex elastic = elastic_index(E, first, K, M, psi);
  count = std::min<PetscInt>(count, m + s);
  HermitianModes lowest = modes_of(elastic, count, settings, h);
  ElasticModesOfIndex modes{std::move(lowest.squares), std::move(lowest.shapes)};
  const int residuals = settings.residuals ? with_residuals(elastic, modes) : 0;
  if (residuals > 0) fix_phases(modes.shapes, s > 0 ? m : 0);
  out.squares = modes.squares;
  const ElasticModesOfIndex kept{{modes.squares.begin(), modes.squares.begin() + na},
                                 modes.shapes.block(0, 0, m + s, na)};
  const auto add = [](ComplexDense &sum, const ComplexDense &term, double factor = 1) {
    for (std::size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += factor * term.values[i];
  };
  out.kxx = K.block(s, s, nc, nc);
  add(out.kxx, adjoint_product(Kx, psi)); // K_xx + K_xs Psi
  ComplexDense inertia = elastic.carried.block(m, 0, s, nc);
  add(inertia, M.block(0, s, s, nc)); // M_xx + Psi^H (M_ss Psi / 2 + M_sx) + its adjoint
  out.mxx = M.block(s, s, nc, nc);
  add(out.mxx, mutual_product(psi, inertia), 0.5);
  out.max = adjoint_product(kept.shapes, elastic.carried.block(0, 0, m + s, nc));
  for (std::size_t j = 0; j < first.fx.size(); ++j) {
    const ComplexDense F = E.from_held(first.fx[j].data(), 1);
    out.fa.push_back(adjoint_product(kept.shapes, elastic.loads[j].block(0, 0, m + s, 1)));
    out.fx.push_back(F.block(s, 0, nc, 1)), add(out.fx.back(), adjoint_product(psi, F.block(0, 0, s, 1)));
  }
  out.left_out = left_out(elastic, kept, residuals, settings.exact && judged);
  ComplexDense z(E.all(), nc);
  for (int j = 0; j < nc; ++j) std::copy_n(psi.column(j), s, z.column(j)), z(s + j, j) = 1;
  out.contact_b = E.to_held(z);
  out.shapes_of_modes = modes.shapes.block(0, 0, m, static_cast<int>(count));
  out.modes_b = E.to_held(modes.shapes.block(m, 0, s, static_cast<int>(count)));
  if (judged) out.stiffness = elastic.S;
  if (h > 0) return out;
  ComplexDense p = E.from_held(first.r.data(), 1), rest(E.all(), 1); // eq (2): the load on b is -r
  const ComplexDense answer = solve_positive(elastic.S, p.block(0, 0, s, 1));
  for (int i = 0; i < s; ++i) rest(i, 0) = -answer(i, 0);
  out.r = p.block(s, 0, nc, 1);
  add(out.r, adjoint_product(Kx, rest.block(0, 0, s, 1)));
  out.at_rest = E.to_held(rest);
  return out;
}

void share(MPI_Comm comm, int owner, std::vector<double> &values) {
  long size = static_cast<long>(values.size());
  MPI_Bcast(&size, 1, MPI_LONG, owner, comm);
  values.resize(size);
  MPI_Bcast(values.data(), static_cast<int>(size), MPI_DOUBLE, owner, comm);
}

void share(MPI_Comm comm, int owner, ComplexDense &A) {
  int shape[] = {A.rows, A.columns};
  MPI_Bcast(shape, 2, MPI_INT, owner, comm);
  if (A.rows != shape[0] || A.columns != shape[1]) A = ComplexDense(shape[0], shape[1]);
  MPI_Bcast(A.values.data(), static_cast<int>(A.values.size()), MPI_C_DOUBLE_COMPLEX, owner, comm);
}

void share(MPI_Comm comm, int owner, std::size_t loads, Index &index) {
  index.fa.resize(loads), index.fx.resize(loads);
  share(comm, owner, index.squares);
  for (ComplexDense *A : {&index.max, &index.mxx, &index.kxx, &index.r, &index.at_rest, &index.shapes_of_modes,
                          &index.modes_b, &index.contact_b, &index.stiffness})
    share(comm, owner, *A);
  LeftOutIndex &left = index.left_out;
  share(comm, owner, left.squares), share(comm, owner, left.coupling), share(comm, owner, left.with_modes);
  left.loads.resize(loads);
  for (std::size_t j = 0; j < loads; ++j)
    for (ComplexDense *A : {&index.fa[j], &index.fx[j], &left.loads[j]}) share(comm, owner, *A);
}

std::vector<Complex> own_rows(const ComplexDense &A, Range own) {
  std::vector<Complex> rows;
  for (int i = 3 * own.begin; i < 3 * own.end; ++i)
    for (int j = 0; j < A.columns; ++j) rows.push_back(A(i, j));
  return rows;
}

std::vector<double> real(const std::vector<Complex> &values) {
  std::vector<double> out;
  for (const Complex value : values) out.push_back(value.real());
  return out;
}

SectorIndex own_part(const Index &index, Range own) {
  SectorIndex part;
  part.kaa = index.squares;
  part.mxa = own_rows(adjoint(index.max), own);
  part.mxx = own_rows(index.mxx, own), part.kxx = own_rows(index.kxx, own);
  for (std::size_t j = 0; j < index.fa.size(); ++j)
    part.loads.push_back({index.fa[j].values, own_rows(index.fx[j], own)});
  const LeftOutIndex &left = index.left_out;
  if (left.squares.empty()) return part;
  part.left_out.squares = left.squares, part.left_out.coupling = own_rows(left.coupling, own);
  for (const ComplexDense &load : left.loads) part.left_out.loads.push_back(load.values);
  part.left_out.with_modes = adjoint(left.with_modes).values; // row-major, but for the signs
  for (Complex &value : part.left_out.with_modes) value = std::conj(value);
  return part;
}

} // namespace

void plan_sector(const ClampedStructure &parts, PetscInt interior_modes, const SecondLevel &settings,
                 MemoryPlan &plan) {
  const MPI_Comm comm = parts.full.comm;
  const CyclicSector &sector = parts.full.cyclic;
  const PetscInt held = 3 * static_cast<PetscInt>(parts.full.contact_dofs.size());
  const SectorCoordinates E(sector, held, 0);
  const double b = held, y = E.all(), nc = E.contact(), m = interior_modes, n = m + E.own() + lanczos_block,
               a = settings.modes + guards, rows = parts.own.size(), kept = parts.moved.dofs.size();
  const double first = 8 * b * (2 * b + m), congruent = 16 * (3 * y * y + b * y + 2 * y * m),
               search = 16 * (5 * n * n + 2 * n * a), found = 16 * (nc * (2 * nc + a) + b * (a + nc) + m * a),
               all = sector.sectors / 2 * 16 * nc * (2 * nc + a), iterated = 8 * rows * (m + 5 * 2 * a),
               motion = 16 * kept * (nc + a) * (1 + sector.sectors / 2) + 8 * kept * (b + m + 4 * nc);
  plan.bytes = std::max(plan.bytes, resident_bytes() + (parts.solver ? parts.solver->forecast_bytes() : 0) + first +
                                        congruent + search + found + all + iterated + motion);
  plan.machine_bytes = sum_on_machine(comm, plan.bytes);
  MPI_Allreduce(MPI_IN_PLACE, &plan.machine_bytes, 1, MPI_DOUBLE, MPI_MAX, comm);
  MPI_Allreduce(&plan.bytes, &plan.total_bytes, 1, MPI_DOUBLE, MPI_SUM, comm);
}

SectorModel sector_model(const ClampedStructure &parts, const Tall &interior, Reduction &&held,
                         const SecondLevel &settings) {
  SectorModel made;
  Reduction &out = made.reduction;
  ReducedModel &model = out.model;
  Recovery &recovery = out.recovery;
  const CyclicSector &sector = parts.full.cyclic;
  Recovery before = std::move(held.recovery);
  const MPI_Comm comm = model.comm = held.model.comm;
  int rank, size;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  out.backward_error = held.backward_error;
  model.file = held.model.file, model.units = held.model.units;
  model.modes = settings.modes, model.points = static_cast<PetscInt>(sector.contacts.size());
  model.own_modes = own_share(comm, model.modes), model.own_points = own_share(comm, model.points);
  model.sectors = sector.sectors;
  const Range own = model.own_points;
  std::vector<std::string> names;
  for (const LoadPattern &load : held.model.loads) names.push_back(load.name);
  const FirstLevel first = first_level(std::move(held.model));

  recovery.elastic_dofs = before.elastic_dofs, recovery.xe0 = before.xe0;
  const SectorMotion motion(SectorCoordinates(sector, first.held, 0), first.modes, before);
  const auto columns = static_cast<int>(model.modes);
  // The exact modes in place of those of the interior ones; or one step towards them, which tells what these cost.
  const bool judged = first.modes < parts.elastic && parts.solver && model.modes > 0;
  const PetscInt residuals = settings.residuals ? std::min<PetscInt>(model.modes / 2, lanczos_block) : 0,
                 wanted = model.modes + (judged && residuals == 0 ? guards : 0); // residuals do as guards
  const auto improve = [&](Index &index, int h) { // returns own rows of the motion by modes
    if (judged && (settings.exact || h == settings.judged)) {
      const SectorCoordinates E(sector, first.held, h);
      const FirstGuess guess{interior, index.squares, index.shapes_of_modes, index.modes_b};
      const ExactModes found = exact_modes(parts, E, index.stiffness, guess, model.modes - residuals,
                                           settings.exact ? most_steps : 1, settings.exact ? steady : 0);
      made.left_out = std::max(made.left_out, std::sqrt(1 + found.first_change) - 1);
      made.steps = std::max(made.steps, found.steps);
      if (settings.exact) {
        index.squares = found.squares, index.fa = found.fa;
        index.max = adjoint_product(found.carried, index.contact_b);
        std::vector<Complex> rows;
        for (PetscInt i = 0; i < found.moved.rows; ++i)
          for (int j = 0; j < columns; ++j)
            rows.emplace_back(found.moved.column(j)[i], found.moved.column(columns + j)[i]);
        return rows;
      }
    }
    index.squares.resize(columns);
    const ComplexDense by_modes = index.shapes_of_modes.block(0, 0, first.modes, columns);
    return motion.of(index.modes_b.block(0, 0, first.held, columns), &by_modes);
  };
  const int last = sector.sectors / 2;
  for (int begin = 0; begin <= last; begin += size) {
    Index mine;
    on_all_ranks(comm, [&] {
      if (begin + rank <= last) mine = reduced_index(sector, first, settings, wanted, judged, begin + rank);
    });
    for (int owner = 0; owner < size && begin + owner <= last; ++owner) {
      Index passed;
      Index &index = owner == rank ? mine : passed;
      share(comm, owner, first.fx.size(), index);
      std::vector<Complex> phi = improve(index, begin + owner), psi = motion.of_contacts(index.contact_b);
      SectorIndex part = own_part(index, own);
      if (begin + owner > 0) {
        model.indices.push_back(std::move(part)), recovery.indices.push_back({std::move(phi), std::move(psi)});
        continue;
      }
      model.kaa = part.kaa;
      model.mxa = real(part.mxa), model.mxx = real(part.mxx), model.kxx = real(part.kxx);
      model.r = real(own_rows(index.r, own));
      model.loads.clear();
      const auto &left = part.left_out;
      model.left_out = {left.squares, {}, real(left.coupling), real(left.with_modes)};
      for (const auto &load : left.loads) model.left_out.loads.push_back(real(load));
      for (std::size_t j = 0; j < names.size(); ++j)
        model.loads.push_back({names[j], real(part.loads[j].fa), real(part.loads[j].fx)});
      recovery.phi = real(phi), recovery.psi = real(psi);
      const std::vector<double> rest = real(motion.of(index.at_rest));
      for (std::size_t i = 0; i < rest.size(); ++i) recovery.xe0[i] += rest[i];
    }
  }
  return made;
}

} // namespace dovetail
