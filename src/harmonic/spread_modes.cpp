// A dense eigenproblem on all ranks, by ScaLAPACK: matrices lie in square blocks that are dealt out over a grid of
// ranks.
#include <algorithm>
#include <string>

#include "harmonic/dense_modes.hpp"
#include "support/error.hpp"

extern "C" { // ScaLAPACK has no header
int Csys2blacs_handle(MPI_Comm);
void Cfree_blacs_system_handle(int);
void Cblacs_gridinit(int *, const char *, int, int);
void Cblacs_gridexit(int);
int numroc_(const int *, const int *, const int *, const int *, const int *);
void descinit_(int *, const int *, const int *, const int *, const int *, const int *, const int *, const int *,
               const int *, int *);
void pdpotrf_(const char *, const int *, double *, const int *, const int *, const int *, int *);
void pdsygst_(const int *, const char *, const int *, double *, const int *, const int *, const int *, const double *,
              const int *, const int *, const int *, double *, int *);
void pdsyevd_(const char *, const char *, const int *, double *, const int *, const int *, const int *, double *,
              double *, const int *, const int *, const int *, double *, const int *, int *, const int *, int *);
void pdtrtrs_(const char *, const char *, const char *, const int *, const int *, const double *, const int *,
              const int *, const int *, double *, const int *, const int *, const int *, int *);
}

namespace dovetail {
namespace {

constexpr int block = 64, zero = 0, one = 1;

class Grid { // of ranks, row by row
public:
  Grid(const Layout &layout) : layout_(layout), n_(layout.dofs()) {
    int sides[2] = {0, 0};
    MPI_Dims_create(layout.size, 2, sides);
    rows_ = sides[0], columns_ = sides[1], row_ = layout.rank / columns_, column_ = layout.rank % columns_;
    context_ = handle_ = Csys2blacs_handle(layout.comm);
    Cblacs_gridinit(&context_, "Row", rows_, columns_);
    own_rows_ = std::max(1, numroc_(&n_, &block, &row_, &zero, &rows_));
    own_columns_ = numroc_(&n_, &block, &column_, &zero, &columns_);
    int info;
    descinit_(descriptor, &n_, &n_, &block, &block, &zero, &zero, &context_, &own_rows_, &info);
  }
  ~Grid() {
    Cblacs_gridexit(context_);
    Cfree_blacs_system_handle(handle_);
  }
  Grid(const Grid &) = delete;
  Grid &operator=(const Grid &) = delete;

  int descriptor[9];
  std::vector<double> matrix() const { return std::vector<double>(std::size_t(own_rows_) * std::max(1, own_columns_)); }

  /// For pdormtr and pdlasrt, which pdsyevd leaves out of what it says it wants: one blocked row and column of this
  /// rank each, with a block to spare, and some vectors. Too little gives wrong modes, without an error, on small
  /// matrices; with this all sizes up to 1400 on 1 to 12 ranks were right.
  std::size_t more_room() const { return 4 * n_ + 2 * block * (std::size_t(own_rows_) + own_columns_ + 2 * block); }

  /// The lower half of a matrix given by rows, which become empty.
  std::vector<double> take(std::vector<double> &rows) const {
    std::vector<double> local = matrix(), sent, got;
    const auto [here, there] = plan(true);
    sent.resize(here.total());
    std::vector<int> next = here.starts;
    each_piece(layout_.rank, true, [&](std::size_t i, int, int first, int count, int owner) {
      std::copy_n(&rows[i * n_ + first], count, &sent[next[owner]]), next[owner] += count;
    });
    rows = {};
    got.resize(there.total());
    MPI_Alltoallv(sent.data(), here.counts.data(), here.starts.data(), MPI_DOUBLE, got.data(), there.counts.data(),
                  there.starts.data(), MPI_DOUBLE, layout_.comm);
    const double *value = got.data();
    for (int r = 0; r < layout_.size; ++r)
      each_piece(r, true, [&](std::size_t, int number, int first, int count, int owner) {
        if (owner != layout_.rank) return;
        for (int j = first; j < first + count; ++j) local[place(number, j)] = *value++;
      });
    return local;
  }

  /// The own rows of a whole matrix.
  std::vector<double> give(const std::vector<double> &local) const {
    const auto [here, there] = plan(false);
    std::vector<double> sent, got(here.total()), rows(std::size_t(layout_.own_dofs()) * n_);
    sent.reserve(there.total());
    for (int r = 0; r < layout_.size; ++r)
      each_piece(r, false, [&](std::size_t, int number, int first, int count, int owner) {
        if (owner != layout_.rank) return;
        for (int j = first; j < first + count; ++j) sent.push_back(local[place(number, j)]);
      });
    MPI_Alltoallv(sent.data(), there.counts.data(), there.starts.data(), MPI_DOUBLE, got.data(), here.counts.data(),
                  here.starts.data(), MPI_DOUBLE, layout_.comm);
    std::vector<int> next = here.starts;
    each_piece(layout_.rank, false, [&](std::size_t i, int, int first, int count, int owner) {
      std::copy_n(&got[next[owner]], count, &rows[i * n_ + first]), next[owner] += count;
    });
    return rows;
  }

private:
  struct Counts {
    std::vector<int> counts, starts;
    std::size_t total() const { return std::size_t(starts.back()) + counts.back(); }
    void sum_up() {
      starts.assign(counts.size(), 0);
      for (std::size_t r = 1; r < counts.size(); ++r) starts[r] = starts[r - 1] + counts[r - 1];
    }
  };

  // f(which row of that rank, its number, first column, columns, who has them in the grid), block by block.
  template <class F> void each_piece(int rank, bool lower, F f) const {
    std::size_t i = 0;
    for (const PetscInt number : numbers_of(layout_, rank)) {
      const int row = static_cast<int>(number), end = lower ? row + 1 : n_, across = row / block % rows_ * columns_;
      for (int first = 0; first < end; first += block)
        f(i, row, first, std::min(block, end - first), across + first / block % columns_);
      ++i;
    }
  }

  std::size_t place(int i, int j) const {
    const auto local = [](int at, int ranks) { return std::size_t(at / (block * ranks)) * block + at % block; };
    return local(j, columns_) * own_rows_ + local(i, rows_);
  }

  // What goes from own rows to each rank of the grid, and what comes here from the rows of each rank.
  std::pair<Counts, Counts> plan(bool lower) const {
    Counts here{std::vector<int>(layout_.size), {}}, there = here;
    for (int r = 0; r < layout_.size; ++r)
      each_piece(r, lower, [&](std::size_t, int, int, int count, int owner) {
        if (r == layout_.rank) here.counts[owner] += count;
        if (owner == layout_.rank) there.counts[r] += count;
      });
    here.sum_up(), there.sum_up();
    return {here, there};
  }

  const Layout &layout_;
  int n_, rows_, columns_, row_, column_, own_rows_, own_columns_, handle_, context_;
};

void succeed(int info, const char *routine) {
  if (info != 0)
    throw ComputeError("the modes of the stuck structure were not found (" + std::string(routine) + ": " +
                       std::to_string(info) + ")");
}

} // namespace

// M = L L^T, L^-1 K L^-T = Z diag(lambda) Z^T, Phi = L^-T Z.
std::vector<double> dense_modes_on_all_ranks(const Layout &layout, std::vector<double> &K, std::vector<double> &M) {
  const Grid grid(layout);
  const int n = layout.dofs(), *d = grid.descriptor, ask = -1;
  std::vector<double> A = grid.take(K), L = grid.take(M), Z = grid.matrix(), lambda(n), work(1);
  int info = 0;
  pdpotrf_("L", &n, L.data(), &one, &one, d, &info);
  if (info > 0) return {};
  succeed(info, "pdpotrf");
  double scale;
  pdsygst_(&one, "L", &n, A.data(), &one, &one, d, L.data(), &one, &one, d, &scale, &info);
  succeed(info, "pdsygst");
  std::vector<int> int_work(1);
  pdsyevd_("V", "L", &n, A.data(), &one, &one, d, lambda.data(), Z.data(), &one, &one, d, work.data(), &ask,
           int_work.data(), &ask, &info);
  work.resize(static_cast<std::size_t>(work[0]) + grid.more_room()), int_work.resize(int_work[0]);
  const int room = static_cast<int>(work.size()), int_room = static_cast<int>(int_work.size());
  pdsyevd_("V", "L", &n, A.data(), &one, &one, d, lambda.data(), Z.data(), &one, &one, d, work.data(), &room,
           int_work.data(), &int_room, &info);
  succeed(info, "pdsyevd");
  pdtrtrs_("L", "T", "N", &n, &n, L.data(), &one, &one, d, Z.data(), &one, &one, d, &info);
  succeed(info, "pdtrtrs");
  K = grid.give(Z);
  return lambda;
}

} // namespace dovetail
