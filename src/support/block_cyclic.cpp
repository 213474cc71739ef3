#include "support/block_cyclic.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "support/int_count.hpp"

extern "C" { // ScaLAPACK has no header
int Csys2blacs_handle(MPI_Comm);
void Cfree_blacs_system_handle(int);
void Cblacs_gridinit(int *, const char *, int, int);
void Cblacs_gridexit(int);
int numroc_(const int *, const int *, const int *, const int *, const int *);
void descinit_(int *, const int *, const int *, const int *, const int *, const int *, const int *, const int *,
               const int *, int *);
void pdgetrf_(const int *, const int *, double *, const int *, const int *, const int *, int *, int *);
void pdgetrs_(const char *, const int *, const int *, const double *, const int *, const int *, const int *,
              const int *, double *, const int *, const int *, const int *, int *);
void pdlapiv_(const char *, const char *, const char *, const int *, const int *, double *, const int *, const int *,
              const int *, const int *, const int *, const int *, const int *, int *);
void pdpotrf_(const char *, const int *, double *, const int *, const int *, const int *, int *);
void pdpotrs_(const char *, const int *, const int *, const double *, const int *, const int *, const int *, double *,
              const int *, const int *, const int *, int *);
void pdtrsv_(const char *, const char *, const char *, const int *, const double *, const int *, const int *,
             const int *, double *, const int *, const int *, const int *, const int *);
}

namespace dovetail {
namespace {

constexpr int block = 64, zero = 0, one = 1;
constexpr std::size_t message = std::size_t(1) << 22; // numbers that a rank sends at a time: 32 MiB

} // namespace

BlockCyclic::BlockCyclic(MPI_Comm comm, int n, std::vector<std::vector<int>> rows_of, int grid_rows)
    : comm_(comm), rows_of_(std::move(rows_of)), n_(n), at_a_time_(std::max<std::size_t>(1, message / std::max(1, n))) {
  MPI_Comm_rank(comm, &rank_);
  MPI_Comm_size(comm, &size_);
  int sides[2] = {grid_rows, 0}, info;
  MPI_Dims_create(size_, 2, sides);
  rows_ = sides[0], columns_ = sides[1], row_ = rank_ / columns_, column_ = rank_ % columns_;
  const std::size_t most_rows = numroc_(&n_, &block, &zero, &zero, &rows_), // on the first rank
      most_columns = numroc_(&n_, &block, &zero, &zero, &columns_);
  int_count(most_rows * most_columns, "numbers of a dense matrix that ScaLAPACK has on one rank; take more ranks");
  context_ = handle_ = Csys2blacs_handle(comm);
  Cblacs_gridinit(&context_, "Row", rows_, columns_);
  own_rows_ = std::max(1, numroc_(&n_, &block, &row_, &zero, &rows_));
  own_columns_ = numroc_(&n_, &block, &column_, &zero, &columns_);
  descinit_(descriptor_, &n_, &n_, &block, &block, &zero, &zero, &context_, &own_rows_, &info);
}

BlockCyclic::~BlockCyclic() {
  Cblacs_gridexit(context_);
  Cfree_blacs_system_handle(handle_);
}

std::vector<double> BlockCyclic::matrix() const { return std::vector<double>(own_size()); }

std::size_t BlockCyclic::more_room() const {
  return 4 * n_ + 2 * block * (std::size_t(own_rows_) + own_columns_ + 2 * block);
}

struct BlockCyclic::Counts {
  std::vector<int> counts, starts;
  std::size_t total() const { return std::size_t(starts.back()) + counts.back(); }
  void sum_up() {
    starts.assign(counts.size(), 0);
    for (std::size_t r = 1; r < counts.size(); ++r) starts[r] = starts[r - 1] + counts[r - 1];
  }
};

std::size_t BlockCyclic::rounds() const {
  std::size_t most = 0;
  for (const auto &rows : rows_of_) most = std::max(most, rows.size());
  return (most + at_a_time_ - 1) / at_a_time_;
}

// f(which row of that rank, its number, first column, columns, who has them in the grid), block by block.
template <class F> void BlockCyclic::each_piece(int rank, std::size_t round, Part part, F f) const {
  const auto &rows = rows_of_[rank];
  for (std::size_t i = round * at_a_time_; i < std::min(rows.size(), (round + 1) * at_a_time_); ++i) {
    const int row = rows[i], end = part == Part::lower ? row + 1 : n_, across = row / block % rows_ * columns_;
    for (int first = 0; first < end; first += block)
      f(i, row, first, std::min(block, end - first), across + first / block % columns_);
  }
}

std::size_t BlockCyclic::place(int i, int j) const {
  const auto local = [](int at, int ranks) { return std::size_t(at / (block * ranks)) * block + at % block; };
  return local(j, columns_) * own_rows_ + local(i, rows_);
}

// What goes from own rows to each rank of the grid, and what comes here from the rows of each rank.
std::pair<BlockCyclic::Counts, BlockCyclic::Counts> BlockCyclic::plan(std::size_t round, Part part) const {
  Counts here{std::vector<int>(size_), {}}, there = here;
  for (int r = 0; r < size_; ++r)
    each_piece(r, round, part, [&](std::size_t, int, int, int count, int owner) {
      if (r == rank_) here.counts[owner] += count;
      if (owner == rank_) there.counts[r] += count;
    });
  here.sum_up(), there.sum_up();
  return {here, there};
}

std::vector<double> BlockCyclic::take(Part part, const Row &row) const {
  std::vector<double> local = matrix();
  take(part, row, local.data());
  return local;
}

void BlockCyclic::take(Part part, const Row &row, double *local) const {
  std::vector<double> sent, got;
  for (std::size_t round = 0; round < rounds(); ++round) {
    const auto [here, there] = plan(round, part);
    sent.resize(here.total()), got.resize(there.total());
    std::vector<int> next = here.starts;
    const double *values = nullptr;
    each_piece(rank_, round, part, [&](std::size_t i, int, int first, int count, int owner) {
      if (first == 0) values = row(i);
      std::copy_n(values + first, count, &sent[next[owner]]), next[owner] += count;
    });
    MPI_Alltoallv(sent.data(), here.counts.data(), here.starts.data(), MPI_DOUBLE, got.data(), there.counts.data(),
                  there.starts.data(), MPI_DOUBLE, comm_);
    const double *value = got.data();
    for (int r = 0; r < size_; ++r)
      each_piece(r, round, part, [&](std::size_t, int number, int first, int count, int owner) {
        if (owner != rank_) return;
        for (int j = first; j < first + count; ++j) local[place(number, j)] = *value++;
      });
  }
}

std::vector<double> BlockCyclic::give(const std::vector<double> &local) const {
  std::vector<double> rows(rows_of_[rank_].size() * n_);
  give<double>(local.data(), [&](std::size_t i, int first, int count, const double *values) {
    std::copy_n(values, count, &rows[i * n_ + first]);
  });
  return rows;
}

template <class Real>
void BlockCyclic::give(const Real *local, const std::function<void(std::size_t, int, int, const Real *)> &f) const {
  const MPI_Datatype type = std::is_same_v<Real, float> ? MPI_FLOAT : MPI_DOUBLE;
  std::vector<Real> sent, got;
  for (std::size_t round = 0; round < rounds(); ++round) {
    const auto [here, there] = plan(round, Part::whole);
    sent.clear(), got.resize(here.total());
    for (int r = 0; r < size_; ++r)
      each_piece(r, round, Part::whole, [&](std::size_t, int number, int first, int count, int owner) {
        if (owner != rank_) return;
        for (int j = first; j < first + count; ++j) sent.push_back(local[place(number, j)]);
      });
    MPI_Alltoallv(sent.data(), there.counts.data(), there.starts.data(), type, got.data(), here.counts.data(),
                  here.starts.data(), type, comm_);
    std::vector<int> next = here.starts;
    each_piece(rank_, round, Part::whole, [&](std::size_t i, int, int first, int count, int owner) {
      f(i, first, count, &got[next[owner]]), next[owner] += count;
    });
  }
}

template void BlockCyclic::give(const float *, const std::function<void(std::size_t, int, int, const float *)> &) const;

// f(number of a row, its place): of the rows of a column that are here.
template <class F> void BlockCyclic::each_own(F f) const {
  for (int i = row_ * block; i < n_ && column_ == 0; i += rows_ * block)
    for (int k = i; k < std::min(n_, i + block); ++k) f(k, place(k, 0));
}

std::vector<double> BlockCyclic::take_columns(const double *all, int count) const {
  std::vector<double> local(std::size_t(own_rows_) * count);
  for (std::size_t j = 0; j < std::size_t(count); ++j)
    each_own([&](int number, std::size_t at) { local[j * own_rows_ + at] = all[j * n_ + number]; });
  return local;
}

void BlockCyclic::give_columns(const std::vector<double> &local, int count, double *all) const {
  for (std::size_t j = 0; j < std::size_t(count); ++j) {
    std::fill_n(all + j * n_, n_, 0.0);
    each_own([&](int number, std::size_t at) { all[j * n_ + number] = local[j * own_rows_ + at]; });
    MPI_Allreduce(MPI_IN_PLACE, all + j * n_, n_, MPI_DOUBLE, MPI_SUM, comm_);
  }
}

std::array<int, 9> BlockCyclic::columns_descriptor(int count) const { // all of them in the grid's first column
  std::array<int, 9> descriptor;
  int info;
  descinit_(descriptor.data(), &n_, &count, &block, &count, &zero, &zero, &context_, &own_rows_, &info);
  return descriptor;
}

std::array<int, 9> BlockCyclic::pivots_descriptor() const { // each column of the grid has all of its rows'
  std::array<int, 9> descriptor;
  const int n = n_ + block * rows_, own = own_rows_ + block;
  int info;
  descinit_(descriptor.data(), &n, &one, &block, &one, &zero, &column_, &context_, &own, &info);
  return descriptor;
}

bool SpreadFactors::factor(const BlockCyclic::Row &row) {
  const int n = grid_.order();
  int info = 0;
  drop();
  lu_ = grid_.take(BlockCyclic::Part::whole, row);
  pivots_.resize(n + block);
  pdgetrf_(&n, &n, lu_.data(), &one, &one, grid_.descriptor(), pivots_.data(), &info);
  MPI_Allreduce(MPI_IN_PLACE, &info, 1, MPI_INT, MPI_MAX, grid_.comm());
  return good_ = info == 0;
}

void SpreadFactors::solve(double *b, int columns) const {
  const int n = grid_.order();
  int info = 0;
  std::vector<double> local = grid_.take_columns(b, columns);
  const auto of_columns = grid_.columns_descriptor(columns);
  const int *of_matrix = grid_.descriptor();
  if (columns > 1) {
    pdgetrs_("N", &n, &columns, lu_.data(), &one, &one, of_matrix, pivots_.data(), local.data(), &one, &one,
             of_columns.data(), &info);
  } else { // of one column pdgetrs makes products of matrices, each copied first: up to twice the time
    const auto of_pivots = grid_.pivots_descriptor();
    pdlapiv_("Forward", "Row", "Col", &n, &one, local.data(), &one, &one, of_columns.data(), pivots_.data(), &one, &one,
             of_pivots.data(), &info);
    for (const bool lower : {true, false})
      pdtrsv_(lower ? "L" : "U", "N", lower ? "U" : "N", &n, lu_.data(), &one, &one, of_matrix, local.data(), &one,
              &one, of_columns.data(), &one);
  }
  grid_.give_columns(local, columns, b);
}

bool SpreadCholesky::factor(const BlockCyclic::Row &row) {
  const int n = grid_.order();
  int info = 0;
  lower_ = grid_.take(BlockCyclic::Part::lower, row);
  pdpotrf_("L", &n, lower_.data(), &one, &one, grid_.descriptor(), &info);
  MPI_Allreduce(MPI_IN_PLACE, &info, 1, MPI_INT, MPI_MAX, grid_.comm());
  return info == 0;
}

void SpreadCholesky::solve(double *b, int columns) const {
  const int n = grid_.order();
  int info = 0;
  std::vector<double> local = grid_.take_columns(b, columns);
  const auto of_columns = grid_.columns_descriptor(columns);
  const int *of_matrix = grid_.descriptor();
  if (columns > 1)
    pdpotrs_("L", &n, &columns, lower_.data(), &one, &one, of_matrix, local.data(), &one, &one, of_columns.data(),
             &info);
  for (const char *form : {"N", "T"})
    if (columns == 1)
      pdtrsv_("L", form, "N", &n, lower_.data(), &one, &one, of_matrix, local.data(), &one, &one, of_columns.data(),
              &one);
  grid_.give_columns(local, columns, b);
}

} // namespace dovetail
