#include "reduction/block_lanczos.hpp"

#include <slepcblaslapack.h>

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr double tolerance = 1e-12; // of a Ritz pair's residual, relative to its value: shapes then agree between ranks
constexpr double vanishing = 1e-13; // a direction this much smaller than it was before orthogonalisation is round-off
constexpr int most_restarts = 200;

struct Search {
  MPI_Comm comm;
  const ClampedSolver &solver;
  Mat M;
  const std::string &model_name;
  Tall V;                // (n, most) basis; the first `known` columns have been through K^-1 M
  Tall MV;               // M times the next block
  PetscInt known = 0;    // columns of H that are filled
  PetscInt block = 0;    // columns behind them: the next block
  PetscInt most;         // columns V can hold
  std::vector<double> H; // (most, most) column-major: V^T M K^-1 M V

  double &h(PetscInt i, PetscInt j) { return H[static_cast<std::size_t>(j) * most + i]; }

  std::vector<double> orthonormalise(Tall &W, double size);
  std::vector<double> by_cholesky(std::vector<double> G, Tall &W, double least);
  std::vector<double> by_gram_schmidt(Tall &W, double least);
  void begin(Tall start);
  std::vector<double> expand();
};

// W = Q R with W becoming Q and MV becoming M Q; what vanishes beside `size` is left out. Returns R (Q.columns,
// W.columns) column-major.
std::vector<double> Search::orthonormalise(Tall &W, double size) {
  MV = multiply(M, W);
  const double least = vanishing * size;
  const auto G = gram(comm, W, 0, W.columns, MV, 0, W.columns);
  for (PetscInt j = 0; j < W.columns; ++j)
    if (G[static_cast<std::size_t>(j) * (W.columns + 1)] < -1e-8 * size * size)
      throw InputError(model_name + ": /M is not positive definite on the elastic dofs");
  const auto R = by_cholesky(G, W, least);
  return R.empty() ? by_gram_schmidt(W, least) : R;
}

// In three sweeps over W. Returns nothing, W untouched, if its columns are too nearly dependent for that.
std::vector<double> Search::by_cholesky(std::vector<double> G, Tall &W, double least) {
  constexpr double independent = 1e-4; // what is left of a unit column beside those before it
  const PetscInt n = W.columns;
  const PetscBLASInt order = n, rows = W.rows, ld = std::max<PetscInt>(1, W.rows);
  std::vector<double> norm(n);
  for (PetscInt j = 0; j < n; ++j) {
    const double square = G[static_cast<std::size_t>(j) * (n + 1)];
    if (!(square > least * least)) return {};
    norm[j] = std::sqrt(square);
  }
  for (PetscInt j = 0; j < n; ++j)
    for (PetscInt i = 0; i < n; ++i) G[static_cast<std::size_t>(j) * n + i] /= norm[i] * norm[j];
  PetscBLASInt info = 0;
  LAPACKpotrf_("U", &order, G.data(), &order, &info);
  MPI_Bcast(&info, 1, MPI_INT, 0, comm);
  MPI_Bcast(G.data(), static_cast<int>(G.size()), MPI_DOUBLE, 0, comm);
  if (info != 0) return {};
  for (PetscInt j = 0; j < n; ++j) {
    if (G[static_cast<std::size_t>(j) * (n + 1)] < independent) return {};
    for (PetscInt i = 0; i < n; ++i) G[static_cast<std::size_t>(j) * n + i] *= i <= j ? norm[j] : 0;
  }
  const double one = 1;
  if (rows > 0)
    for (Tall *S : {&W, &MV})
      BLAStrsm_("R", "U", "N", "N", &rows, &order, &one, G.data(), &order, S->values.data(), &ld);
  return G;
}

// Column by column, each twice.
std::vector<double> Search::by_gram_schmidt(Tall &W, double least) {
  const PetscInt n = W.columns;
  std::vector<double> R(static_cast<std::size_t>(n) * n);
  PetscInt kept = 0;
  for (PetscInt j = 0; j < n; ++j) {
    double *w = W.column(j), *mw = MV.column(j), *r = &R[static_cast<std::size_t>(j) * n];
    for (int pass = 0; pass < 2 && kept > 0; ++pass) {
      const auto c = gram(comm, W, 0, kept, MV, j, 1);
      for (PetscInt i = 0; i < kept; ++i) {
        r[i] += c[i];
        for (PetscInt at = 0; at < W.rows; ++at) w[at] -= c[i] * W.column(i)[at], mw[at] -= c[i] * MV.column(i)[at];
      }
    }
    const double square = gram(comm, W, j, 1, MV, j, 1)[0];
    if (!(square > least * least)) continue;
    r[kept] = std::sqrt(square);
    for (PetscInt at = 0; at < W.rows; ++at)
      W.column(kept)[at] = w[at] / r[kept], MV.column(kept)[at] = mw[at] / r[kept];
    ++kept;
  }
  W.drop_columns_from(kept);
  MV.drop_columns_from(kept);
  std::vector<double> upper(static_cast<std::size_t>(kept) * n);
  for (PetscInt j = 0; j < n; ++j)
    std::copy_n(R.begin() + static_cast<std::ptrdiff_t>(j) * n, kept,
                upper.begin() + static_cast<std::ptrdiff_t>(j) * kept);
  return upper;
}

// A next block from `start`, orthogonal to all before; empty if nothing is left that has mass.
void Search::begin(Tall start) {
  start = solver.solve(multiply(M, start)); // without what has no mass
  const Tall weighted = multiply(M, start);
  const auto G = gram(comm, start, 0, start.columns, weighted, 0, start.columns);
  double largest = 0;
  for (PetscInt j = 0; j < start.columns; ++j)
    largest = std::max(largest, G[static_cast<std::size_t>(j) * (start.columns + 1)]);
  double size = std::sqrt(largest);
  for (int pass = 0; pass < 2 && start.columns > 0; ++pass, size = 1) {
    if (known > 0) subtract_product(V, known, gram(comm, V, 0, known, multiply(M, start), 0, start.columns), start);
    orthonormalise(start, size);
  }
  block = start.columns;
  if (block == 0 && known == 0) throw InputError(model_name + ": /M is not positive definite on the elastic dofs");
  std::copy(start.values.begin(), start.values.end(), V.column(known));
}

// One block further: V gets what is new in K^-1 M V_block, orthogonal to all before. Returns the coupling R of
// K^-1 M V_block = V C + V_new R, (new, old) column-major; empty if nothing is new.
std::vector<double> Search::expand() {
  Tall W = solver.solve(MV);
  const PetscInt all = known + block, old = block;
  const auto C = gram(comm, V, 0, all, multiply(M, W), 0, old);
  subtract_product(V, all, C, W);
  double size = 0;
  for (PetscInt j = 0; j < old; ++j) {
    double sum = 0;
    for (PetscInt i = 0; i < all; ++i) {
      const double value = C[static_cast<std::size_t>(j) * all + i];
      sum += value * value;
      h(i, known + j) = h(known + j, i) =
          i < known ? value : 0.5 * (value + C[static_cast<std::size_t>(i - known) * all + known + j]);
    }
    size = std::max(size, std::sqrt(sum));
  }
  if (!std::isfinite(size)) throw ComputeError("while computing modes: the solution with K_ee is not finite");
  known = all, block = 0;
  const auto first = orthonormalise(W, size);
  const PetscInt between = W.columns;
  if (between == 0) return {};
  subtract_product(V, all, gram(comm, V, 0, all, MV, 0, between), W); // again: twice is enough
  const auto second = orthonormalise(W, 1);
  block = W.columns;
  std::copy(W.values.begin(), W.values.end(), V.column(known));
  std::vector<double> coupling(static_cast<std::size_t>(block) * old); // second * first
  for (PetscInt j = 0; j < old; ++j)
    for (PetscInt l = 0; l < between; ++l)
      for (PetscInt i = 0; i < block; ++i)
        coupling[static_cast<std::size_t>(j) * block + i] +=
            second[static_cast<std::size_t>(l) * block + i] * first[static_cast<std::size_t>(j) * between + l];
  return coupling;
}

struct Ritz {
  std::vector<double> value, vector; // (k), (k, k) column-major; largest magnitude first
};

Ritz ritz(MPI_Comm comm, const std::vector<double> &H, PetscInt stride, PetscInt k) {
  std::vector<double> A(static_cast<std::size_t>(k) * k), w(k), work(1);
  for (PetscInt j = 0; j < k; ++j)
    std::copy_n(&H[static_cast<std::size_t>(j) * stride], k, &A[static_cast<std::size_t>(j) * k]);
  const PetscBLASInt n = k;
  PetscBLASInt lwork = -1, info = 0;
  LAPACKsyev_("V", "L", &n, A.data(), &n, w.data(), work.data(), &lwork, &info);
  lwork = static_cast<PetscBLASInt>(work[0]);
  work.resize(lwork);
  LAPACKsyev_("V", "L", &n, A.data(), &n, w.data(), work.data(), &lwork, &info);
  MPI_Bcast(&info, 1, MPI_INT, 0, comm); // the same on all ranks to the last bit: decisions hang on it
  MPI_Bcast(A.data(), static_cast<int>(A.size()), MPI_DOUBLE, 0, comm);
  MPI_Bcast(w.data(), k, MPI_DOUBLE, 0, comm);
  if (info != 0) throw ComputeError("while computing modes: LAPACK's syev failed (" + std::to_string(info) + ")");
  std::vector<PetscInt> order(k);
  for (PetscInt i = 0; i < k; ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](PetscInt a, PetscInt b) { return std::abs(w[a]) > std::abs(w[b]); });
  Ritz sorted;
  for (const PetscInt i : order) {
    sorted.value.push_back(w[i]);
    sorted.vector.insert(sorted.vector.end(), &A[static_cast<std::size_t>(i) * k],
                         &A[static_cast<std::size_t>(i) * k] + k);
  }
  return sorted;
}

} // namespace

LanczosPairs block_lanczos(const ClampedSolver &solver, Mat M, Tall start, PetscInt wanted, PetscInt most,
                           const std::string &model_name) {
  MPI_Comm comm;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(M), &comm), "computing modes");
  Search search{comm, solver, M, model_name, Tall(start.rows, most),
                {},   0,      0, most,       std::vector<double>(static_cast<std::size_t>(most) * most)};
  search.begin(start);
  const PetscInt widest = search.block;
  PetscInt starts = 1, enough = wanted; // columns before it is worth looking
  for (int restarts = 0; restarts < most_restarts;) {
    const PetscInt old = search.block;
    const auto coupling = search.expand();
    const PetscInt k = search.known, fresh = search.block;
    const bool full = k + std::max(fresh, widest) + widest > most;
    if (fresh > 0 && !full && k < enough + old) continue;
    const Ritz found = ritz(comm, search.H, most, k);
    const auto converged = [&](PetscInt pair) { // || R s ||, s the last rows of the eigenvector
      const double *s = &found.vector[static_cast<std::size_t>(pair) * k + k - old];
      double squares = 0;
      for (PetscInt i = 0; i < fresh; ++i) {
        double sum = 0;
        for (PetscInt j = 0; j < old; ++j) sum += coupling[static_cast<std::size_t>(j) * fresh + i] * s[j];
        squares += sum * sum;
      }
      return std::sqrt(squares) <= tolerance * std::abs(found.value[pair]);
    };
    const PetscInt count = std::min(wanted, k), seen = widest * starts;
    PetscInt good = 0;
    while (good < count && converged(good)) ++good;
    bool crowded = false; // as many equal values as there were start vectors: there may be more of them
    for (PetscInt i = 0; i + seen <= count; ++i)
      crowded = crowded || std::abs(found.value[i + seen - 1]) > (1 - 1e-6) * std::abs(found.value[i]);
    const auto keep_only = [&](PetscInt kept) { // the best Ritz vectors instead of the basis
      rotate(search.V, k, kept, found.vector.data());
      std::fill(search.H.begin(), search.H.end(), 0.0);
      for (PetscInt i = 0; i < kept; ++i) search.h(i, i) = found.value[i];
      search.known = kept;
    };
    const auto answer = [&] {
      search.V.drop_columns_from(count);
      search.V.values.shrink_to_fit();
      return LanczosPairs{{found.value.begin(), found.value.begin() + count}, std::move(search.V)};
    };
    const bool done = good == wanted;
    if (done && !crowded) {
      keep_only(count);
      return answer();
    }
    if (done || fresh == 0) { // with another start, for what the first could not see
      if (done || full) keep_only(count);
      for (double &x : start.values) x = 2 * x * x - 1; // other noise in [-1, 1], whatever the partition
      const bool whole = search.known == k;             // not yet rotated
      search.block = 0;
      search.begin(start);
      ++starts, ++restarts;
      enough = search.known + 3 * widest; // a few steps, for what is new to show
      if (search.block > 0) continue;
      if (whole) keep_only(count);
      return answer();
    }
    if (!full) continue;
    ++restarts; // with the best Ritz vectors, and the next block behind them
    const std::vector<double> next(search.V.column(k), search.V.column(k + fresh));
    keep_only(std::min(wanted + widest, k - widest));
    std::copy(next.begin(), next.end(), search.V.column(search.known));
  }
  throw ComputeError("while computing modes: not all of " + std::to_string(wanted) +
                     " fixed-interface modes converged; ask for fewer in reduction.modes");
}

} // namespace dovetail
