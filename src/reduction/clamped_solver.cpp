#include "reduction/clamped_solver.hpp"

#include <dmumps_c.h>

#include <algorithm>

#include "reduction/mumps_failed.hpp"
#include "support/error.hpp"
#include "support/gathered.hpp"
#include "support/partition.hpp"

namespace dovetail {
namespace {

constexpr int begin_job = -1, end_job = -2, analyse_job = 1, factor_job = 2, solve_job = 3;
constexpr double most_whole = 4e5; // rows of the factors of all ranks together, some 2.5 GB: all shipped inputs on two

template <class Number> void broadcast(MPI_Comm comm, MPI_Datatype type, std::vector<Number> &numbers) {
  int count = static_cast<int>(numbers.size());
  MPI_Bcast(&count, 1, MPI_INT, 0, comm);
  numbers.resize(count);
  MPI_Bcast(numbers.data(), count, type, 0, comm);
}

SparseColumns columns_of(const SparseColumns &B, Range wanted) {
  SparseColumns part;
  const int from = B.begin[wanted.begin], to = B.begin[wanted.end];
  for (PetscInt j = wanted.begin; j < wanted.end; ++j) part.begin.push_back(B.begin[j + 1] - from);
  part.row.assign(B.row.begin() + from, B.row.begin() + to);
  part.value.assign(B.value.begin() + from, B.value.begin() + to);
  return part;
}

bool is_short_of_room(int error) { return error == -8 || error == -9; }

} // namespace

std::string mumps_failed(const std::string &doing, int error, int detail) {
  return "while " + doing + " K_ee: MUMPS error " + std::to_string(error) + " (" + std::to_string(detail) + ")" +
         (is_short_of_room(error)       ? "; its workspace was too small twice: try -kee_mat_mumps_icntl_14 400"
          : error == -7 || error == -13 ? "; out of memory: take more ranks or a machine with more of it"
          : error == -90 ? "; its files could not be written: out of core it needs room where MUMPS_OOC_TMPDIR points"
                         : "");
}

struct ClampedSolver::Mumps {
  mutable DMUMPS_STRUC_C id{};
  std::string model_name;
  MPI_Comm comm = MPI_COMM_NULL;
  int ranks = 1, rank = 0, attempts = 0;
  bool shared = false; // one factor over all ranks; else each has a whole one and solves for its share of the columns
  PetscInt own_rows = 0;
  Mat K = nullptr;
  std::vector<int> row, column; // entries on and right of the diagonal, from 1, until factored; own rows' if shared
  std::vector<double> value;
  std::vector<int> rhs_rows;              // own rows, from 1
  mutable std::vector<int> solution_rows; // which rows of the solution MUMPS leaves here, from 1
  mutable UniqueScatter home;             // from there to own rows
  mutable UniqueVec there, here;          // without arrays of their own

  int &icntl(int i) const { return id.icntl[i - 1]; }
  void call(int job) const {
    id.job = job;
    dmumps_c(&id);
  }
  void agree() const;
  void run(int job) const {
    call(job);
    agree();
  }
  void take_entries();
  void set_options();
  void must_have_solved() const;
  void solve_shared(Tall &X, PetscInt first, PetscInt count) const;
  void solve_whole(double *columns, PetscInt count) const;
};

// Each alone with its MUMPS, the ranks must hear of an error that strikes one of them.
void ClampedSolver::Mumps::agree() const {
  if (shared || ranks == 1) return;
  struct {
    int error, rank;
  } worst{id.infog[0], rank};
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_2INT, MPI_MINLOC, comm);
  if (worst.error < 0) MPI_Bcast(id.infog, 2, MPI_INT, worst.rank, comm);
}

void ClampedSolver::Mumps::take_entries() {
  PetscInt begin, end;
  check(MatGetOwnershipRange(K, &begin, &end), "analysing K_ee");
  for (PetscInt i = begin; i < end; ++i) {
    PetscInt count;
    const PetscInt *columns;
    const double *values;
    check(MatGetRow(K, i, &count, &columns, &values), "analysing K_ee");
    for (PetscInt at = 0; at < count; ++at)
      if (columns[at] >= i) row.push_back(i + 1), column.push_back(columns[at] + 1), value.push_back(values[at]);
    check(MatRestoreRow(K, i, &count, &columns, &values), "analysing K_ee");
    rhs_rows.push_back(i + 1);
  }
  if (shared || ranks == 1) return;
  row = gathered(comm, MPI_INT, row), column = gathered(comm, MPI_INT, column);
  value = gathered(comm, MPI_DOUBLE, value);
}

void ClampedSolver::Mumps::set_options() {
  for (int stream = 1; stream <= 4; ++stream) icntl(stream) = 0; // not a word
  icntl(14) = 20;             // room beyond the estimate [%]; there is no pivoting, so little
  icntl(18) = shared ? 3 : 0; // the matrix is where its rows are
  icntl(21) = shared ? 1 : 0; // and so is the solution
  icntl(27) = 128;            // right-hand sides taken at a time
  for (int i = 4; i <= 58; ++i) {
    const std::string name = "-mat_mumps_icntl_" + std::to_string(i);
    PetscInt given = icntl(i);
    PetscBool found = PETSC_FALSE;
    check(PetscOptionsGetInt(nullptr, "kee_", name.c_str(), &given, &found), "reading MUMPS's options");
    if (found) icntl(i) = static_cast<int>(given);
  }
  if (icntl(4) > 0)
    for (int stream = 1; stream <= 3; ++stream) icntl(stream) = 6;
}

ClampedSolver::ClampedSolver(Mat K_ee, std::string model_name) : mumps_(std::make_unique<Mumps>()) {
  Mumps &m = *mumps_;
  PetscInt n;
  m.K = K_ee, m.model_name = std::move(model_name);
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K_ee), &m.comm), "analysing K_ee");
  check(MatGetSize(K_ee, &n, nullptr), "analysing K_ee");
  check(MatGetLocalSize(K_ee, &m.own_rows, nullptr), "analysing K_ee");
  MPI_Comm_size(m.comm, &m.ranks);
  MPI_Comm_rank(m.comm, &m.rank);
  PetscBool whole = static_cast<double>(n) * m.ranks <= most_whole ? PETSC_TRUE : PETSC_FALSE;
  check(PetscOptionsGetBool(nullptr, "kee_", "-whole", &whole, nullptr), "reading the options of K_ee");
  m.shared = m.ranks > 1 && !whole;
  m.id.comm_fortran = static_cast<MUMPS_INT>(MPI_Comm_c2f(m.shared ? m.comm : MPI_COMM_SELF));
  m.id.par = 1, m.id.sym = 1; // rank 0 works as well; positive definite
  m.run(begin_job);
  if (m.id.infog[0] < 0) throw ComputeError("MUMPS does not start: error " + std::to_string(m.id.infog[0]));
  m.take_entries();
  m.set_options();
  m.id.n = static_cast<MUMPS_INT>(n);
  if (m.shared) {
    m.id.nnz_loc = static_cast<MUMPS_INT8>(m.value.size());
    m.id.irn_loc = m.row.data(), m.id.jcn_loc = m.column.data(), m.id.a_loc = m.value.data();
  } else {
    m.id.nnz = static_cast<MUMPS_INT8>(m.value.size());
    m.id.irn = m.row.data(), m.id.jcn = m.column.data(), m.id.a = m.value.data();
  }
  m.run(analyse_job);
  if (const int error = m.id.infog[0]; error < 0) throw ComputeError(mumps_failed("analysing", error, m.id.infog[1]));
}

ClampedSolver::~ClampedSolver() {
  if (std::uncaught_exceptions() == 0) mumps_->run(end_job); // collective: see support/handle.hpp
}

void ClampedSolver::factor() {
  Mumps &m = *mumps_;
  constexpr int most = 2;
  for (m.attempts = 1;; ++m.attempts) {
    m.run(factor_job);
    const int info = m.id.infog[0], detail = m.id.infog[1], negative = m.id.infog[11];
    if (info == -10 || info == -40 ||
        (info >= 0 && negative > 0)) // MUMPS goes on over negative pivots and only counts them
      throw InputError(m.model_name +
                       ": K_ee, the stiffness with the contact dofs held, is not positive definite (MUMPS " +
                       std::to_string(info) +
                       "): either constraints are missing, so that a body can still move as a whole, or K is not the "
                       "stiffness of a stable structure. Remove the clamped dofs from K and M, and check which dofs or "
                       "nodes are named in /contact.");
    if (info >= 0) break;
    if (!is_short_of_room(info) || m.attempts == most) throw ComputeError(mumps_failed("factoring", info, detail));
    m.icntl(14) = std::max(100, 2 * m.icntl(14));
  }
  for (auto *indices : {&m.row, &m.column}) indices->clear(), indices->shrink_to_fit();
  m.value.clear(), m.value.shrink_to_fit();
  m.solution_rows.resize(std::max(1, m.id.info[22]));
}

void ClampedSolver::Mumps::must_have_solved() const {
  if (id.infog[0] < 0) throw ComputeError(mumps_failed("solving with", id.infog[0], id.infog[1]));
}

// For the right-hand sides that are set, or stand in `columns`; there the solutions go, all rows of them.
void ClampedSolver::Mumps::solve_whole(double *columns, PetscInt count) const {
  id.nrhs = static_cast<MUMPS_INT>(count);
  id.lrhs = id.n;
  id.rhs = columns;
  if (count > 0) call(solve_job);
  agree();
  must_have_solved();
}

// For the right-hand sides that are set; their solutions go to columns [first, first + count) of X.
void ClampedSolver::Mumps::solve_shared(Tall &X, PetscInt first, PetscInt count) const {
  id.nrhs = static_cast<MUMPS_INT>(count);
  id.lrhs = id.n;
  id.lsol_loc = std::max(1, id.info[22]);
  std::vector<double> solution(static_cast<std::size_t>(id.lsol_loc) * count);
  id.isol_loc = solution_rows.data(), id.sol_loc = solution.data();
  run(solve_job);
  must_have_solved();
  const PetscInt local = id.info[22];
  if (!home) {
    UniqueIS from, to;
    std::vector<PetscInt> places(solution_rows.begin(), solution_rows.begin() + local);
    for (PetscInt &place : places) --place;
    check(ISCreateStride(PETSC_COMM_SELF, local, 0, 1, from.out()), "solving with K_ee");
    check(ISCreateGeneral(PETSC_COMM_SELF, local, places.data(), PETSC_COPY_VALUES, to.out()), "solving with K_ee");
    check(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, local, nullptr, there.out()), "solving with K_ee");
    check(VecCreateMPIWithArray(comm, 1, own_rows, PETSC_DECIDE, nullptr, here.out()), "solving with K_ee");
    check(VecScatterCreate(there, from, here, to, home.out()), "solving with K_ee");
  }
  for (PetscInt j = 0; j < count; ++j) {
    check(VecPlaceArray(there, solution.data() + static_cast<std::size_t>(j) * id.lsol_loc), "solving with K_ee");
    check(VecPlaceArray(here, X.column(first + j)), "solving with K_ee");
    check(VecScatterBegin(home, there, here, INSERT_VALUES, SCATTER_FORWARD), "solving with K_ee");
    check(VecScatterEnd(home, there, here, INSERT_VALUES, SCATTER_FORWARD), "solving with K_ee");
    check(VecResetArray(there), "solving with K_ee");
    check(VecResetArray(here), "solving with K_ee");
  }
}

Tall ClampedSolver::solve(const Tall &B) const {
  const Mumps &m = *mumps_;
  Tall X(m.own_rows, B.columns);
  if (m.shared) {
    m.icntl(20) = 10; // dense, where its rows are
    m.id.nloc_rhs = m.id.lrhs_loc = static_cast<MUMPS_INT>(m.own_rows);
    m.id.irhs_loc = const_cast<int *>(m.rhs_rows.data());
    m.id.rhs_loc = const_cast<double *>(B.values.data());
    m.solve_shared(X, 0, B.columns);
    return X;
  }
  m.icntl(20) = 0;
  if (m.ranks == 1) {
    X.values = B.values; // solved in place
    m.solve_whole(X.values.data(), B.columns);
  } else {
    Tall columns = whole_columns(m.comm, B);
    m.solve_whole(columns.values.data(), columns.columns);
    take_own_rows(m.comm, columns, X, 0, B.columns);
  }
  return X;
}

void ClampedSolver::solve_sparse(SparseColumns B, Tall &X, PetscInt first, PetscInt count) const {
  const Mumps &m = *mumps_;
  const bool dealt_out = m.ranks > 1 && !m.shared;
  if (dealt_out) {
    broadcast(m.comm, MPI_INT, B.begin);
    broadcast(m.comm, MPI_INT, B.row);
    broadcast(m.comm, MPI_DOUBLE, B.value);
    B = columns_of(B, own_share(m.comm, count));
  }
  for (auto *indices : {&B.begin, &B.row})
    for (int &index : *indices) ++index;       // from 1
  B.row.reserve(1), B.value.reserve(1);        // MUMPS takes columns without entries, but no null pointer
  const bool asked = !m.shared || m.rank == 0; // MUMPS minds arrays of the wrong length on other ranks
  m.icntl(20) = 1;
  m.id.nz_rhs = static_cast<MUMPS_INT>(B.row.size());
  m.id.irhs_ptr = asked ? B.begin.data() : nullptr;
  m.id.irhs_sparse = asked ? B.row.data() : nullptr;
  m.id.rhs_sparse = asked ? B.value.data() : nullptr;
  if (m.shared) {
    m.solve_shared(X, first, count);
  } else if (m.ranks == 1) {
    m.solve_whole(X.column(first), count);
  } else {
    Tall columns(m.id.n, static_cast<PetscInt>(B.begin.size()) - 1);
    m.solve_whole(columns.values.data(), columns.columns);
    take_own_rows(m.comm, columns, X, first, count);
  }
}

std::string ClampedSolver::ordering() const {
  const int used = mumps_->id.infog[6];
  const char *names[] = {"AMD", "given", "AMF", "SCOTCH", "PORD", "METIS", "QAMD"};
  return used >= 0 && used <= 6 ? names[used] : std::to_string(used);
}

double ClampedSolver::forecast_bytes() const { return 1e6 * mumps_->id.info[mumps_->icntl(22) ? 16 : 14]; }
double ClampedSolver::forecast_flops() const { return mumps_->id.rinfog[0]; }
bool ClampedSolver::shared() const { return mumps_->shared; }
int ClampedSolver::attempts() const { return mumps_->attempts; }

} // namespace dovetail
