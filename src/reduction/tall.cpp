#include "reduction/tall.hpp"

#include <petscblaslapack.h>

#include <algorithm>
#include <numeric>

#include "support/error.hpp"
#include "support/int_count.hpp"
#include "support/partition.hpp"

namespace dovetail {
namespace {

constexpr double one = 1, zero = 0, minus = -1;

PetscBLASInt stride(const Tall &S) { return std::max<PetscInt>(1, S.rows); }

// What goes to and comes from each rank when rows of all columns are exchanged for all rows of some.
struct Exchange {
  std::vector<int> rows;          // of each rank
  std::vector<int> some, some_at; // numbers of own rows, by the rank that has the columns
  std::vector<int> all, all_at;   // numbers of own columns, by the rank that has the rows
  PetscInt columns = 0;           // own ones

  Exchange(MPI_Comm comm, PetscInt own_rows, PetscInt count) {
    int size;
    const int own = int_count(own_rows, "rows of a rank");
    MPI_Comm_size(comm, &size);
    rows.resize(size);
    MPI_Allgather(&own, 1, MPI_INT, rows.data(), 1, MPI_INT, comm);
    columns = own_share(comm, count).size();
    const auto numbers = [](std::size_t lines, std::size_t each) {
      return int_count(lines * each, "numbers of columns that ranks exchange at once");
    };
    for (int rank = 0; rank < size; ++rank) {
      const Range theirs = share_of(count, rank, size);
      some.push_back(numbers(own, theirs.size())), some_at.push_back(numbers(own, theirs.begin));
      all_at.push_back(rank == 0 ? 0 : int_count(std::size_t(all_at.back()) + all.back(), "numbers of own columns"));
      all.push_back(numbers(rows[rank], columns));
    }
  }

  // work(place in the numbers of own columns, column, first row, rows) for the part of a column that one rank has
  template <class Work> void each_part(Work &&work) const {
    PetscInt first = 0;
    for (std::size_t rank = 0; rank < rows.size(); first += rows[rank++])
      for (PetscInt j = 0; j < columns; ++j)
        work(all_at[rank] + static_cast<std::size_t>(j) * rows[rank], j, first, rows[rank]);
  }
};

} // namespace

UniqueMat dense_view(MPI_Comm comm, const Tall &S, PetscInt first, PetscInt count) {
  UniqueMat view;
  check(MatCreateDense(comm, S.rows, PETSC_DECIDE, PETSC_DETERMINE, count, const_cast<double *>(S.column(first)),
                       view.out()),
        "viewing a dense block");
  check(MatAssemblyBegin(view, MAT_FINAL_ASSEMBLY), "viewing a dense block");
  check(MatAssemblyEnd(view, MAT_FINAL_ASSEMBLY), "viewing a dense block");
  return view;
}

Tall multiply(Mat A, const Tall &S, PetscInt first, PetscInt count) {
  MPI_Comm comm;
  PetscInt rows;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(A), &comm), "multiplying");
  check(MatGetLocalSize(A, &rows, nullptr), "multiplying");
  const UniqueMat B = dense_view(comm, S, first, count);
  Tall product(rows, count);
  const UniqueMat into = dense_view(comm, product, 0, count);
  Mat C = into;
  check(MatMatMult(A, B, MAT_REUSE_MATRIX, PETSC_DEFAULT, &C), "multiplying");
  return product;
}

void add_columns(Mat A, PetscInt first, Tall &S) {
  PetscInt begin, end;
  check(MatGetOwnershipRange(A, &begin, &end), "reading rows");
  for (PetscInt i = begin; i < end; ++i) {
    PetscInt count;
    const PetscInt *columns;
    const double *values;
    check(MatGetRow(A, i, &count, &columns, &values), "reading rows");
    const PetscInt *from = std::lower_bound(columns, columns + count, first);
    for (const PetscInt *at = from; at < columns + count && *at < first + S.columns; ++at)
      S.column(*at - first)[i - begin] += values[at - columns];
    check(MatRestoreRow(A, i, &count, &columns, &values), "reading rows");
  }
}

std::vector<double> own_gram(const Tall &S, PetscInt s, PetscInt m, const Tall &T, PetscInt t, PetscInt n) {
  std::vector<double> product(static_cast<std::size_t>(m) * n);
  const PetscBLASInt rows = m, columns = n, inner = S.rows, lds = stride(S), ldt = stride(T);
  if (rows > 0) // else its product would have no leading dimension
    BLASgemm_("T", "N", &rows, &columns, &inner, &one, S.column(s), &lds, T.column(t), &ldt, &zero, product.data(),
              &rows);
  return product;
}

std::vector<double> gram(MPI_Comm comm, const Tall &S, PetscInt s, PetscInt m, const Tall &T, PetscInt t, PetscInt n) {
  auto product = own_gram(S, s, m, T, t, n);
  MPI_Allreduce(MPI_IN_PLACE, product.data(), static_cast<int>(product.size()), MPI_DOUBLE, MPI_SUM, comm);
  return product;
}

void subtract_product(const Tall &S, PetscInt m, const std::vector<double> &C, Tall &T) {
  const PetscBLASInt rows = S.rows, inner = m, columns = T.columns, ld = stride(S);
  if (inner > 0)
    BLASgemm_("N", "N", &rows, &columns, &inner, &minus, S.values.data(), &ld, C.data(), &inner, &one, T.values.data(),
              &ld);
}

void rotate(Tall &S, PetscInt m, PetscInt n, const double *C) {
  constexpr PetscInt panel = 2048;
  std::vector<double> part(static_cast<std::size_t>(panel) * n);
  const PetscBLASInt inner = m, columns = n, lds = stride(S), ldp = panel;
  for (PetscInt first = 0; first < S.rows; first += panel) {
    const PetscBLASInt rows = std::min(panel, S.rows - first);
    BLASgemm_("N", "N", &rows, &columns, &inner, &one, S.values.data() + first, &lds, C, &inner, &zero, part.data(),
              &ldp);
    for (PetscInt j = 0; j < n; ++j)
      std::copy_n(part.data() + static_cast<std::size_t>(j) * panel, rows, S.column(j) + first);
  }
}

Tall whole_columns(MPI_Comm comm, const Tall &S) {
  const Exchange exchange(comm, S.rows, S.columns);
  std::vector<double> parts(exchange.all_at.back() + exchange.all.back());
  MPI_Alltoallv(S.values.data(), exchange.some.data(), exchange.some_at.data(), MPI_DOUBLE, parts.data(),
                exchange.all.data(), exchange.all_at.data(), MPI_DOUBLE, comm);
  Tall whole(std::accumulate(exchange.rows.begin(), exchange.rows.end(), 0), exchange.columns);
  exchange.each_part([&](std::size_t at, PetscInt j, PetscInt first, PetscInt rows) {
    std::copy_n(&parts[at], rows, whole.column(j) + first);
  });
  return whole;
}

void take_own_rows(MPI_Comm comm, const Tall &whole, Tall &S, PetscInt first, PetscInt count) {
  const Exchange exchange(comm, S.rows, count);
  std::vector<double> parts(whole.values.size());
  exchange.each_part([&](std::size_t at, PetscInt j, PetscInt row, PetscInt rows) {
    std::copy_n(whole.column(j) + row, rows, &parts[at]);
  });
  MPI_Alltoallv(parts.data(), exchange.all.data(), exchange.all_at.data(), MPI_DOUBLE, S.column(first),
                exchange.some.data(), exchange.some_at.data(), MPI_DOUBLE, comm);
}

} // namespace dovetail
