#pragma once
// Dense matrices of the reduced model's size by rows: each rank has those of its own dofs, n numbers each.
#include <mpi.h>

#include <vector>

#include "stuck/layout.hpp"
#include "stuck/slab.hpp"

namespace dovetail {

/// Numbers of the dofs that a rank owns, in order.
inline std::vector<PetscInt> numbers_of(const Layout &layout, int rank) {
  const Range modes = share_of(layout.modes, rank, layout.size), points = share_of(layout.points, rank, layout.size);
  std::vector<PetscInt> numbers;
  for (PetscInt i = modes.begin; i < modes.end; ++i) numbers.push_back(i);
  for (PetscInt i = 3 * points.begin; i < 3 * points.end; ++i) numbers.push_back(layout.modes + i);
  return numbers;
}

/// (own modes, 3 N_x) from the ranks that hold the columns of that as rows: xa (3 own, N_a). Collective.
Slab<double> rows_of_modes(const std::vector<double> &xa, const Layout &layout);

/// Whole rows as messages: their numbers alone would soon be more than an int counts.
class RowMessages {
public:
  /// `length` of a row, unless it has a number for each dof.
  explicit RowMessages(const Layout &layout, std::size_t length = 0)
      : layout_(layout), n_(length > 0 ? length : layout.dofs()) {
    MPI_Type_contiguous(static_cast<int>(n_), MPI_DOUBLE, &row_);
    MPI_Type_commit(&row_);
  }
  ~RowMessages() { MPI_Type_free(&row_); }
  RowMessages(const RowMessages &) = delete;
  RowMessages &operator=(const RowMessages &) = delete;

  void send(const std::vector<double> &rows, int to) const {
    MPI_Send(rows.data(), static_cast<int>(rows.size() / n_), row_, to, 0, layout_.comm);
  }
  /// The rows of `owner`, sent by `from`.
  void receive(std::vector<double> &rows, int owner, int from) const {
    const std::size_t count =
        share_of(layout_.modes, owner, layout_.size).size() + 3 * share_of(layout_.points, owner, layout_.size).size();
    rows.resize(count * n_);
    MPI_Recv(rows.data(), static_cast<int>(count), row_, from, 0, layout_.comm, MPI_STATUS_IGNORE);
  }

private:
  const Layout &layout_;
  std::size_t n_;
  MPI_Datatype row_;
};

} // namespace dovetail
