#include "reduction/exact_modes.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/error.hpp"
#include "support/gathered.hpp"

namespace dovetail {
namespace {

using Complex = std::complex<double>;

struct Vectors {     // p complex ones, real parts and then imaginary ones
  Tall inside, held; // own elastic rows, own rows of b
};

Tall own_rows_of(const ComplexDense &A, Range own) {
  Tall rows(3 * own.size(), 2 * A.columns);
  for (int j = 0; j < A.columns; ++j)
    for (PetscInt i = 0; i < rows.rows; ++i) {
      const Complex value = A(3 * own.begin + i, j);
      rows.column(j)[i] = value.real(), rows.column(A.columns + j)[i] = value.imag();
    }
  return rows;
}

// All rows of b on every rank.
ComplexDense whole(const ClampedStructure &parts, const Tall &own) {
  const MPI_Comm comm = parts.full.comm;
  int size;
  MPI_Comm_size(comm, &size);
  const int n = 3 * static_cast<int>(parts.full.contact_dofs.size()), p = own.columns / 2;
  const std::vector<double> all = gathered(comm, MPI_DOUBLE, own.values);
  ComplexDense out(n, p);
  for (int rank = 0; rank < size; ++rank) {
    const Range range = share_of(n / 3, rank, size);
    const int rows = 3 * range.size();
    const double *part = all.data() + std::size_t(6) * range.begin * p;
    for (int j = 0; j < p; ++j)
      for (int i = 0; i < rows; ++i)
        out(3 * range.begin + i, j) = {part[std::size_t(j) * rows + i], part[std::size_t(p + j) * rows + i]};
  }
  return out;
}

void add(Tall &sum, const Tall &term, double factor = 1) {
  for (std::size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += factor * term.values[i];
}

Vectors mass_times(const ClampedStructure &parts, const Vectors &v) {
  Vectors out{multiply(parts.M.ee, v.inside), multiply(parts.M.cc, v.held)};
  add(out.inside, multiply(parts.M.ec, v.held));
  add(out.held, multiply(parts.M.ce, v.inside));
  return out;
}

// The motion that follows b: inside += - K_ee^-1 K_ec b.
void follow(const ClampedStructure &parts, Vectors &v) {
  add(v.inside, parts.solver->solve(multiply(parts.K.ec, v.held)), -1);
}

// What b feels of forces f: f_b + Psi^T f_e; `inside` becomes K_ee^-1 f_e.
ComplexDense felt(const ClampedStructure &parts, const Vectors &f, Tall &inside) {
  inside = parts.solver->solve(f.inside);
  Tall held = f.held;
  add(held, multiply(parts.K.ce, inside), -1);
  return whole(parts, held);
}

ComplexDense product(const ClampedStructure &parts, const Vectors &v, const Vectors &f) { // v^H f
  const int p = v.inside.columns / 2;
  std::vector<double> G = own_gram(v.inside, 0, 2 * p, f.inside, 0, 2 * p);
  const std::vector<double> of_held = own_gram(v.held, 0, 2 * p, f.held, 0, 2 * p);
  for (std::size_t i = 0; i < G.size(); ++i) G[i] += of_held[i];
  MPI_Allreduce(MPI_IN_PLACE, G.data(), static_cast<int>(G.size()), MPI_DOUBLE, MPI_SUM, parts.full.comm);
  ComplexDense out(p, p);
  const auto g = [&](int i, int j) { return G[static_cast<std::size_t>(j) * 2 * p + i]; };
  for (int j = 0; j < p; ++j)
    for (int i = 0; i < p; ++i) out(i, j) = {g(i, j) + g(p + i, p + j), g(i, p + j) - g(p + i, j)};
  return out;
}

// Columns become combinations of themselves.
void combine(Vectors &v, const ComplexDense &Q) {
  const int p = Q.rows, n = Q.columns;
  std::vector<double> C(static_cast<std::size_t>(4) * p * n);
  const auto put = [&](int i, int j, double value) { C[static_cast<std::size_t>(j) * 2 * p + i] = value; };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < p; ++i) {
      put(i, j, Q(i, j).real()), put(p + i, j, -Q(i, j).imag());
      put(i, n + j, Q(i, j).imag()), put(p + i, n + j, Q(i, j).real());
    }
  for (Tall *part : {&v.inside, &v.held}) rotate(*part, 2 * p, 2 * n, C.data()), part->drop_columns_from(2 * n);
}

constexpr double unsteady = 1e-8; // change of a square in the last step that is no round-off

// Rank 0's on every rank: one that rounds otherwise would combine other vectors, or stop at another step.
void agree(MPI_Comm comm, ComplexDense &A) {
  int shape[] = {A.rows, A.columns};
  MPI_Bcast(shape, 2, MPI_INT, 0, comm);
  if (A.rows != shape[0] || A.columns != shape[1]) A = ComplexDense(shape[0], shape[1]);
  MPI_Bcast(A.values.data(), static_cast<int>(A.values.size()), MPI_C_DOUBLE_COMPLEX, 0, comm);
}

void agree(MPI_Comm comm, HermitianModes &modes) {
  int fault = static_cast<int>(modes.fault);
  MPI_Bcast(&fault, 1, MPI_INT, 0, comm);
  modes.fault = static_cast<HermitianModes::Fault>(fault);
  if (modes.fault != HermitianModes::Fault::none) return;
  agree(comm, modes.shapes);
  modes.squares.resize(modes.shapes.columns);
  MPI_Bcast(modes.squares.data(), modes.shapes.columns, MPI_DOUBLE, 0, comm);
}

// What makes the first large entry of each column real and positive, a diagonal.
ComplexDense phases(const ComplexDense &v) {
  ComplexDense turns(v.columns, v.columns);
  for (int j = 0; j < v.columns; ++j) turns(j, j) = phase_of(v.column(j), v.column(j) + v.rows);
  return turns;
}

} // namespace

ExactModes exact_modes(const ClampedStructure &parts, const SectorCoordinates &E, const ComplexDense &S,
                       const FirstGuess &guess, PetscInt count, int steps, double tolerance) {
  const int p = guess.held.columns, m = guess.by_modes.rows, own = static_cast<int>(parts.own.size());
  Vectors v{Tall(own, 2 * p), own_rows_of(guess.held, parts.own_points)};
  std::vector<double> less(static_cast<std::size_t>(m) * 2 * p);
  for (int j = 0; j < p; ++j)
    for (int i = 0; i < m; ++i) {
      less[static_cast<std::size_t>(j) * m + i] = -guess.by_modes(i, j).real();
      less[static_cast<std::size_t>(p + j) * m + i] = -guess.by_modes(i, j).imag();
    }
  subtract_product(guess.interior, m, less, v.inside);
  follow(parts, v);

  ExactModes out;
  out.squares = guess.squares;
  Vectors f = mass_times(parts, v);
  ComplexDense held = guess.held;
  do {
    Vectors y;
    ComplexDense s = solve_positive(S, E.own_from_held(felt(parts, f, y.inside)));
    agree(parts.full.comm, s);
    held = E.to_held(s);
    y.held = own_rows_of(held, parts.own_points);
    follow(parts, y);
    Vectors carried = mass_times(parts, y);
    HermitianModes modes = lowest_modes(product(parts, y, f), product(parts, y, carried), p);
    agree(parts.full.comm, modes);
    if (modes.fault != HermitianModes::Fault::none)
      throw ComputeError(parts.full.file.string() + ": the modes of a sector were not found: its mass is not positive");
    combine(y, modes.shapes), combine(carried, modes.shapes);
    held = product(held, modes.shapes);
    v = std::move(y), f = std::move(carried);
    out.change = 0;
    for (PetscInt j = 0; j < count; ++j)
      out.change = std::max(out.change, std::abs(modes.squares[j] / out.squares[j] - 1));
    if (out.steps == 0) out.first_change = out.change;
    out.squares = modes.squares;
    ++out.steps;
  } while (out.steps < steps && out.change > tolerance);

  if (steps > 1 && out.change > unsteady)
    throw ComputeError(parts.full.file.string() + ": the exact modes of a sector did not converge in " +
                       std::to_string(steps) + " steps; ask for fewer modes, or do without reduction.exact_modes");
  const ComplexDense turns = phases(held);
  combine(v, turns), combine(f, turns), held = product(held, turns);
  const PetscInt loads = parts.force_e.columns;
  std::vector<double> G = own_gram(v.inside, 0, 2 * p, parts.force_e, 0, loads);
  for (PetscInt l = 0; l < loads; ++l)
    for (int j = 0; j < 2 * p; ++j)
      G[static_cast<std::size_t>(l) * 2 * p + j] +=
          std::inner_product(parts.force_c[l].begin(), parts.force_c[l].end(), v.held.column(j), 0.0);
  MPI_Allreduce(MPI_IN_PLACE, G.data(), static_cast<int>(G.size()), MPI_DOUBLE, MPI_SUM, parts.full.comm);
  for (PetscInt l = 0; l < loads; ++l) {
    out.fa.emplace_back(static_cast<int>(count), 1);
    for (int j = 0; j < count; ++j) {
      const double *of = &G[static_cast<std::size_t>(l) * 2 * p];
      out.fa.back()(j, 0) = {of[j], -of[p + j]};
    }
  }
  Tall unused;
  out.carried = felt(parts, f, unused).block(0, 0, E.held(), static_cast<int>(count));
  out.squares.resize(count);
  Tall all = multiply(parts.moved.e, v.inside);
  add(all, multiply(parts.moved.c, v.held));
  out.moved = Tall(all.rows, 2 * count);
  for (int j = 0; j < count; ++j) {
    std::copy_n(all.column(j), all.rows, out.moved.column(j));
    std::copy_n(all.column(p + j), all.rows, out.moved.column(count + j));
  }
  return out;
}

} // namespace dovetail
