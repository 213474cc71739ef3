#pragma once
// Square matrices dealt out over a grid of ranks in square blocks, as ScaLAPACK wants them. They are given, and
// returned, by the rows that each rank owns. And factors of them.
#include <mpi.h>

#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>

namespace dovetail {

class BlockCyclic {
public:
  /// Of order n. `rows_of`: (ranks) numbers of the rows that each rank owns, the same on all ranks. `grid_rows`: of
  /// ranks; 0: about as many as columns. Collective.
  BlockCyclic(MPI_Comm comm, int n, std::vector<std::vector<int>> rows_of, int grid_rows = 0);
  ~BlockCyclic();
  BlockCyclic(const BlockCyclic &) = delete;
  BlockCyclic &operator=(const BlockCyclic &) = delete;

  MPI_Comm comm() const { return comm_; }
  int order() const { return n_; }
  const int *descriptor() const { return descriptor_; } ///< for ScaLAPACK
  std::vector<double> matrix() const;                   ///< this rank's part of one, zero
  /// For pdormtr and pdlasrt, which pdsyevd leaves out of what it says it wants: one blocked row and column of this
  /// rank each, with a block to spare, and some vectors. Too little gives wrong modes, without an error, on small
  /// matrices; with this all sizes up to 1400 on 1 to 12 ranks were right.
  std::size_t more_room() const;

  enum class Part { whole, lower };
  using Row = std::function<const double *(std::size_t)>; ///< n numbers of own row i, good until it is asked again
  /// This rank's part of a matrix of those rows. A few rows travel at a time. Collective.
  std::vector<double> take(Part part, const Row &row) const;
  void take(Part part, const Row &row, double *local) const; ///< own_size() numbers, which were zero
  std::size_t own_size() const { return std::size_t(own_rows_) * std::max(1, own_columns_); }
  /// The own rows of a whole matrix, likewise. Collective.
  std::vector<double> give(const std::vector<double> &local) const;
  /// The same piece by piece: f(own row, first column, columns, their numbers).
  template <class Real>
  void give(const Real *local, const std::function<void(std::size_t, int, int, const Real *)> &f) const;

  /// This rank's part of some columns, (n, count) on every rank, and back. Collective.
  std::vector<double> take_columns(const double *all, int count) const;
  void give_columns(const std::vector<double> &local, int count, double *all) const;
  std::array<int, 9> columns_descriptor(int count) const;
  std::array<int, 9> pivots_descriptor() const;

private:
  struct Counts;
  template <class F> void each_piece(int rank, std::size_t round, Part part, F f) const;
  template <class F> void each_own(F f) const;
  std::pair<Counts, Counts> plan(std::size_t round, Part part) const;
  std::size_t rounds() const;
  std::size_t place(int i, int j) const;

  MPI_Comm comm_;
  std::vector<std::vector<int>> rows_of_;
  int rank_, size_, n_, rows_, columns_, row_, column_, own_rows_, own_columns_, handle_, context_;
  std::size_t at_a_time_; // rows of each rank
  int descriptor_[9];
};

/// LU of such a matrix, with partial pivoting.
class SpreadFactors {
public:
  explicit SpreadFactors(const BlockCyclic &grid) : grid_(grid) {}
  /// False where it is singular. Collective.
  bool factor(const BlockCyclic::Row &row);
  bool good() const { return good_; } ///< to solve with
  void drop() { lu_ = {}, good_ = false; }
  /// In place; b (n, columns) on every rank, column by column. Collective.
  void solve(double *b, int columns = 1) const;

private:
  const BlockCyclic &grid_;
  std::vector<double> lu_;
  std::vector<int> pivots_;
  bool good_ = false;
};

/// Cholesky factors of one that is symmetric: half the work.
class SpreadCholesky {
public:
  explicit SpreadCholesky(const BlockCyclic &grid) : grid_(grid) {}
  /// False where it is not positive definite. Collective.
  bool factor(const BlockCyclic::Row &row);
  /// As SpreadFactors::solve.
  void solve(double *b, int columns = 1) const;

private:
  const BlockCyclic &grid_;
  std::vector<double> lower_;
};

} // namespace dovetail
