#include "app/hosts.hpp"

#include <sched.h>
#include <unistd.h>

#include <climits>
#include <utility>

#include "support/blas_kernel.hpp"
#include "support/error.hpp"
#include "support/folder_lock.hpp"

namespace dovetail {
namespace {

constexpr const char *one_folder = "; all ranks need one folder: name one that all hosts share, with "
                                   "output.directory or --out";

std::string host() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

// One rank's, on all ranks.
std::string shared(MPI_Comm comm, std::string text, int from) {
  int size = static_cast<int>(text.size());
  MPI_Bcast(&size, 1, MPI_INT, from, comm);
  text.resize(size);
  MPI_Bcast(text.data(), size, MPI_CHAR, from, comm);
  return text;
}

} // namespace

int ranks_of(MPI_Comm comm) {
  int ranks;
  MPI_Comm_size(comm, &ranks);
  return ranks;
}

void refuse_unshared(MPI_Comm comm, const std::filesystem::path &folder, std::string token) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  token = shared(comm, std::move(token), 0);
  const std::string writer = shared(comm, host(), 0);
  on_all_ranks(comm, [&] {
    if (rank == 0 || token.empty() || FolderLock::sees(folder, token)) return;
    throw InputError(folder.string() + ": rank " + std::to_string(rank) + " on host " + host() +
                     " does not see what rank 0 on host " + writer + " has written there" + one_folder);
  });
}

void refuse_unshared_file(MPI_Comm comm, const std::filesystem::path &file) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::error_code unreadable;
  const int sees = std::filesystem::exists(file, unreadable);
  int first = sees;
  MPI_Bcast(&first, 1, MPI_INT, 0, comm);
  const std::string other = shared(comm, host(), 0);
  on_all_ranks(comm, [&] {
    if (sees == first) return;
    const auto in_words = [](int one) { return one ? " sees it" : " does not see it"; };
    throw InputError(file.string() + ": rank " + std::to_string(rank) + " on host " + host() + in_words(sees) +
                     ", rank 0 on host " + other + in_words(first) + one_folder);
  });
}

// A rank that is bound to some cores stands for these; together the ranks of a host show what they may use of it.
std::string note_on_cores(MPI_Comm comm) {
  MPI_Comm machine;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  cpu_set_t cores;
  CPU_ZERO(&cores);
  sched_getaffinity(0, sizeof cores, &cores);
  int ranks;
  MPI_Comm_size(machine, &ranks);
  MPI_Allreduce(MPI_IN_PLACE, &cores, sizeof cores, MPI_BYTE, MPI_BOR, machine);
  MPI_Comm_free(&machine);
  struct {
    int excess, rank;
  } most{ranks - CPU_COUNT(&cores), 0};
  MPI_Comm_rank(comm, &most.rank);
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_2INT, MPI_MAXLOC, comm);
  if (most.excess <= 0) return "";
  const int count = CPU_COUNT(&cores);
  return shared(comm,
                "note: " + std::to_string(ranks) + " ranks on " + std::to_string(count) +
                    (count == 1 ? " core" : " cores") + " of host " + host() + " take turns; take as many as it has",
                most.rank);
}

std::string note_on_arithmetic(MPI_Comm comm) {
  if (compute_alike(comm)) return "";
  const std::string here = kinds_of_arithmetic(), first = shared(comm, here, 0);
  int rank;
  MPI_Comm_rank(comm, &rank);
  int other = here == first ? INT_MAX : rank;
  MPI_Allreduce(MPI_IN_PLACE, &other, 1, MPI_INT, MPI_MIN, comm);
  return "note: rank " + std::to_string(other) + " computes with " + shared(comm, here, other) + ", rank 0 with " +
         first +
         ": their last bits differ, and linear solves take more messages; take hosts of one kind, and one "
         "OPENBLAS_CORETYPE";
}

std::string idle_ranks(int ranks, int points) {
  if (points == 0 || ranks <= points) return "";
  return std::to_string(ranks) + " ranks for " + std::to_string(points) +
         (points > 1 ? " contact points" : " contact point") +
         ": along the curve some of them have nothing to do; take " + std::to_string(points) +
         " at most, but for a large reduction";
}

} // namespace dovetail
