#include "reduction/sector_left_out.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "reduction/block_lanczos.hpp"
#include "reduction/left_out.hpp"

namespace dovetail {
namespace {

using Complex = std::complex<double>;

constexpr double none = 1e-12; // of a probe's energy: rounding errors

ComplexDense times(const ElasticIndex &elastic, const ComplexDense &y) { // K y
  const int m = static_cast<int>(elastic.squares.size()), s = elastic.S.rows;
  const ComplexDense of_s = product(elastic.S, y.block(m, 0, s, y.columns));
  ComplexDense out = y;
  for (int j = 0; j < y.columns; ++j) {
    for (int i = 0; i < m; ++i) out(i, j) *= elastic.squares[i];
    std::copy_n(of_s.column(j), s, out.column(j) + m);
    for (int i = m + s; i < y.rows; ++i) out(i, j) *= elastic.beyond[i - m - s];
  }
  return out;
}

ComplexDense answer(const ElasticIndex &elastic, const ComplexDense &f) { // K^-1 f
  const int m = static_cast<int>(elastic.squares.size()), s = elastic.S.rows;
  const ComplexDense of_s = solve_positive(elastic.S, f.block(m, 0, s, f.columns));
  ComplexDense out = f;
  for (int j = 0; j < f.columns; ++j) {
    for (int i = 0; i < m; ++i) out(i, j) /= elastic.squares[i];
    std::copy_n(of_s.column(j), s, out.column(j) + m);
    for (int i = m + s; i < f.rows; ++i) out(i, j) /= elastic.beyond[i - m - s];
  }
  return out;
}

// Columns of A, or as many mixtures of them.
ComplexDense mixtures(const ComplexDense &A, int most, int first_noise) {
  if (A.columns <= most) return A;
  ComplexDense weights(A.columns, most);
  for (int j = 0; j < most; ++j)
    for (int i = 0; i < A.columns; ++i) weights(i, j) = probe_noise(i, first_noise + j);
  return product(A, weights);
}

void append(ComplexDense &A, const ComplexDense &B) {
  A.values.insert(A.values.end(), B.values.begin(), B.values.end());
  A.columns += B.columns;
}

ComplexDense probes(const ElasticIndex &elastic, int all) {
  const int n = elastic.M.rows;
  ComplexDense loads(n, static_cast<int>(elastic.loads.size()));
  for (int j = 0; j < loads.columns; ++j) { // each of the same weight, whatever its size
    double square = 0;
    for (const Complex value : elastic.loads[j].values) square += std::norm(value);
    for (int i = 0; i < n && square > 0; ++i) loads(i, j) = elastic.loads[j](i, 0) / std::sqrt(square);
  }
  ComplexDense out = mixtures(loads, all / 2, 0);
  append(out, mixtures(elastic.carried, all - out.columns, 1));
  return out;
}

std::vector<double> diagonal(const ComplexDense &A) {
  std::vector<double> out;
  for (int i = 0; i < A.rows; ++i) out.push_back(A(i, i).real());
  return out;
}

// Combinations of the columns of y whose Gram matrix is 1, where it was G, but for those with less than `least`, and
// what each had, falling.
std::pair<ComplexDense, std::vector<double>> independent(const ComplexDense &y, const ComplexDense &G, double least) {
  if (G.rows == 0) return {y, {}};
  ComplexDense one(G.rows, G.rows);
  for (int i = 0; i < G.rows; ++i) one(i, i) = 1;
  const HermitianModes found = all_modes(G, std::move(one));
  ComplexDense T(G.rows, 0);
  std::vector<double> values;
  for (int j = G.rows - 1; j >= 0 && found.squares[j] > least; --j, ++T.columns) {
    values.push_back(found.squares[j]);
    for (int i = 0; i < G.rows; ++i) T.values.push_back(found.shapes(i, j) / std::sqrt(found.squares[j]));
  }
  return {product(y, T), values};
}

// y less its part in the modes, as K weighs, without columns of which nothing is left, and dependent ones.
ComplexDense beside(const ElasticIndex &elastic, const ElasticModesOfIndex &modes, const ComplexDense &y) {
  const ComplexDense Ky = times(elastic, y);
  const std::vector<double> before = diagonal(adjoint_product(y, Ky));
  ComplexDense part = adjoint_product(modes.shapes, Ky);
  for (int j = 0; j < part.columns; ++j)
    for (int i = 0; i < part.rows; ++i) part(i, j) /= modes.squares[i];
  const ComplexDense less = product(modes.shapes, part);
  ComplexDense rest = y;
  for (std::size_t i = 0; i < rest.values.size(); ++i) rest.values[i] -= less.values[i];
  const std::vector<double> after = diagonal(adjoint_product(rest, times(elastic, rest)));
  for (int j = 0; j < y.columns; ++j) {
    const double factor = after[j] > none * before[j] ? 1 / std::sqrt(before[j]) : 0;
    std::for_each(rest.column(j), rest.column(j) + rest.rows, [&](Complex &value) { value *= factor; });
  }
  return independent(rest, adjoint_product(rest, times(elastic, rest)), none).first;
}

// Modes that y holds beyond others, by the Rayleigh-Ritz method.
ElasticModesOfIndex ritz_modes(const ElasticIndex &elastic, const ElasticModesOfIndex &others, const ComplexDense &y) {
  const ComplexDense rest = beside(elastic, others, y), H = adjoint_product(rest, product(elastic.M, rest));
  double most = 0;
  for (const double mass : diagonal(H)) most = std::max(most, mass);
  ElasticModesOfIndex out; // massless ones follow at once, and hinder no motion
  std::tie(out.shapes, out.squares) = independent(rest, H, none * most);
  for (double &square : out.squares) square = 1 / square;
  return out;
}

// Zeros for rows that are not there.
ComplexDense whole(const ComplexDense &shapes, int rows) {
  ComplexDense out(rows, shapes.columns);
  for (int j = 0; j < shapes.columns; ++j) std::copy_n(shapes.column(j), shapes.rows, out.column(j));
  return out;
}

} // namespace

int with_residuals(const ElasticIndex &elastic, ElasticModesOfIndex &modes) {
  const int n = modes.shapes.rows, all = modes.shapes.columns, most = std::min<int>(all / 2, lanczos_block);
  if (most == 0) return 0;
  ElasticIndex known{elastic.squares, {}, elastic.S, elastic.M.block(0, 0, n, n), {}, {}};
  known.carried = elastic.carried.block(0, 0, n, elastic.carried.columns);
  for (const ComplexDense &load : elastic.loads) known.loads.push_back(load.block(0, 0, n, 1));
  const ComplexDense y = answer(known, probes(known, most));
  ElasticModesOfIndex found;
  int count = most;
  for (int wanted = -1; wanted != count && count > 0;) { // of some probes nothing may be left
    wanted = count;
    const int lowest = all - count;
    found = ritz_modes(
        known, {{modes.squares.begin(), modes.squares.begin() + lowest}, modes.shapes.block(0, 0, n, lowest)}, y);
    count = std::min(count, found.shapes.columns);
  }
  for (int j = 0; j < count; ++j) {
    modes.squares[all - count + j] = found.squares[j];
    std::copy_n(found.shapes.column(j), n, modes.shapes.column(all - count + j));
  }
  return count;
}

LeftOutIndex left_out(const ElasticIndex &elastic, ElasticModesOfIndex kept, int residuals, bool exact) {
  LeftOutIndex out;
  const int n = elastic.M.rows, count = kept.shapes.columns;
  if (n == 0) return out;
  kept.shapes = whole(kept.shapes, n);
  if (exact && count > 0) { // near enough to exact modes: one step of inverse iteration
    const ComplexDense better = answer(elastic, product(elastic.M, kept.shapes));
    HermitianModes modes = lowest_modes(adjoint_product(better, times(elastic, better)),
                                        adjoint_product(better, product(elastic.M, better)), count);
    kept = {std::move(modes.squares), product(better, modes.shapes)};
  }
  ComplexDense forces = probes(elastic, lanczos_block);
  append(forces, product(elastic.M, kept.shapes.block(0, count - residuals, n, residuals))); // what these ask in turn
  const ElasticModesOfIndex rest = ritz_modes(elastic, kept, answer(elastic, forces));
  out.squares = rest.squares;
  for (const ComplexDense &load : elastic.loads) out.loads.push_back(adjoint_product(rest.shapes, load));
  out.coupling = adjoint_product(elastic.carried, rest.shapes);
  out.with_modes =
      exact ? ComplexDense(count, rest.shapes.columns) : adjoint_product(kept.shapes, product(elastic.M, rest.shapes));
  return out;
}

} // namespace dovetail
