// Counts what a program asks of MPI, by the profiling interface that the standard provides: a library to be named in
// LD_PRELOAD. Each rank writes $MPI_CALLS.RANK at the end: stage of PETSc, call, where it was called from, how often,
// bytes that this rank gave. Calls of Fortran libraries go past it.
//
// `where`: the function that called MPI, then addresses in the program itself, innermost first, less that it is loaded
// at.
#include <dlfcn.h>
#include <execinfo.h>
#include <mpi.h>
#include <sys/auxv.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace {

constexpr int deepest = 40, kept = 6; // frames of the stack, and those of the program that are written

struct Sum {
  long calls = 0;
  double bytes = 0;
};
using Site = std::tuple<std::string, std::vector<void *>>; // call, stack

std::map<int, std::string> names; // of stages
std::vector<int> stages;
std::map<int, std::map<Site, Sum>> counted; // by stage

double bytes_of(double count, MPI_Datatype type) {
  int size;
  PMPI_Type_size(type, &size);
  return count * size;
}

// What this rank gives to one in which ranks give differently much, in place or not.
double own_part(const void *send, int count, MPI_Datatype type, const int *counts, MPI_Datatype received,
                MPI_Comm comm) {
  if (send != MPI_IN_PLACE) return bytes_of(count, type);
  int rank;
  PMPI_Comm_rank(comm, &rank);
  return bytes_of(counts[rank], received);
}

double all_parts(const int *counts, MPI_Datatype type, MPI_Comm comm) {
  int size;
  double sum = 0;
  PMPI_Comm_size(comm, &size);
  for (int r = 0; r < size; ++r) sum += counts[r];
  return bytes_of(sum, type);
}

// Among one process alone nothing is exchanged.
[[gnu::noinline]] void count(const char *call, double bytes, MPI_Comm comm) {
  int size;
  PMPI_Comm_size(comm, &size);
  if (size == 1) return;
  void *frames[deepest];
  const int found = backtrace(frames, deepest);
  Sum &sum = counted[stages.empty() ? -1 : stages.back()]
                    [{call, std::vector<void *>(frames + 2, frames + std::max(found, 2))}];
  ++sum.calls, sum.bytes += bytes;
}

std::string words_of(const std::vector<void *> &stack) {
  std::string words = "?", own;
  Dl_info program, at;
  dladdr(reinterpret_cast<void *>(getauxval(AT_ENTRY)), &program);
  int places = 0;
  for (std::size_t i = 0; i < stack.size() && places < kept; ++i) {
    if (!dladdr(stack[i], &at)) continue;
    if (i == 0 && at.dli_sname) words = at.dli_sname;
    if (at.dli_fbase != program.dli_fbase) continue;
    char place[24];
    std::snprintf(place, sizeof place, "\t%zx",
                  static_cast<std::size_t>(static_cast<char *>(stack[i]) - static_cast<char *>(at.dli_fbase)));
    own += place, ++places;
  }
  return words + own;
}

void write() {
  const char *path = std::getenv("MPI_CALLS");
  int rank;
  PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
  std::FILE *file = path ? std::fopen((std::string(path) + "." + std::to_string(rank)).c_str(), "w") : nullptr;
  if (!file) return;
  for (const auto &[stage, sites] : counted)
    for (const auto &[site, sum] : sites)
      std::fprintf(file, "%s\t%s\t%ld\t%.0f\t%s\n", names.count(stage) ? names[stage].c_str() : "",
                   std::get<0>(site).c_str(), sum.calls, sum.bytes, words_of(std::get<1>(site)).c_str());
  std::fclose(file);
}

template <class Function> Function *next(const char *name) {
  return reinterpret_cast<Function *>(dlsym(RTLD_NEXT, name));
}

} // namespace

#define COUNTED(call, given, parameters, arguments)                                                                    \
  int MPI_##call parameters {                                                                                          \
    count(#call, given, comm);                                                                                         \
    return PMPI_##call arguments;                                                                                      \
  }

extern "C" {

// Stages of PETSc: what PetscLogStagePush and its like are called with.
int PetscLogStageRegister(const char *name, int *stage) {
  const int code = next<int(const char *, int *)>("PetscLogStageRegister")(name, stage);
  names[*stage] = name;
  return code;
}
int PetscLogStagePush(int stage) {
  stages.push_back(stage);
  return next<int(int)>("PetscLogStagePush")(stage);
}
int PetscLogStagePop() {
  if (!stages.empty()) stages.pop_back();
  return next<int()>("PetscLogStagePop")();
}

COUNTED(Allreduce, bytes_of(n, type), (const void *s, void *r, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm),
        (s, r, n, type, op, comm))
COUNTED(Iallreduce, bytes_of(n, type),
        (const void *s, void *r, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm, MPI_Request *q),
        (s, r, n, type, op, comm, q))
COUNTED(Reduce, bytes_of(n, type),
        (const void *s, void *r, int n, MPI_Datatype type, MPI_Op op, int root, MPI_Comm comm),
        (s, r, n, type, op, root, comm))
COUNTED(Scan, bytes_of(n, type), (const void *s, void *r, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm),
        (s, r, n, type, op, comm))
COUNTED(Exscan, bytes_of(n, type), (const void *s, void *r, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm),
        (s, r, n, type, op, comm))
COUNTED(Reduce_scatter, all_parts(n, type, comm),
        (const void *s, void *r, const int *n, MPI_Datatype type, MPI_Op op, MPI_Comm comm), (s, r, n, type, op, comm))
COUNTED(Reduce_scatter_block, bytes_of(n, type),
        (const void *s, void *r, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm), (s, r, n, type, op, comm))
COUNTED(Bcast, bytes_of(n, type), (void *b, int n, MPI_Datatype type, int root, MPI_Comm comm),
        (b, n, type, root, comm))
COUNTED(Ibcast, bytes_of(n, type), (void *b, int n, MPI_Datatype type, int root, MPI_Comm comm, MPI_Request *q),
        (b, n, type, root, comm, q))
COUNTED(Barrier, 0, (MPI_Comm comm), (comm))
COUNTED(Ibarrier, 0, (MPI_Comm comm, MPI_Request *q), (comm, q))
COUNTED(Allgather, own_part(s, n, type, &m, to, MPI_COMM_SELF),
        (const void *s, int n, MPI_Datatype type, void *r, int m, MPI_Datatype to, MPI_Comm comm),
        (s, n, type, r, m, to, comm))
COUNTED(Allgatherv, own_part(s, n, type, m, to, comm),
        (const void *s, int n, MPI_Datatype type, void *r, const int *m, const int *at, MPI_Datatype to, MPI_Comm comm),
        (s, n, type, r, m, at, to, comm))
COUNTED(Gather, s == MPI_IN_PLACE ? 0 : bytes_of(n, type),
        (const void *s, int n, MPI_Datatype type, void *r, int m, MPI_Datatype to, int root, MPI_Comm comm),
        (s, n, type, r, m, to, root, comm))
COUNTED(Gatherv, s == MPI_IN_PLACE ? 0 : bytes_of(n, type),
        (const void *s, int n, MPI_Datatype type, void *r, const int *m, const int *at, MPI_Datatype to, int root,
         MPI_Comm comm),
        (s, n, type, r, m, at, to, root, comm))
COUNTED(Scatter, bytes_of(m, to),
        (const void *s, int n, MPI_Datatype type, void *r, int m, MPI_Datatype to, int root, MPI_Comm comm),
        (s, n, type, r, m, to, root, comm))
COUNTED(Scatterv, bytes_of(m, to),
        (const void *s, const int *n, const int *at, MPI_Datatype type, void *r, int m, MPI_Datatype to, int root,
         MPI_Comm comm),
        (s, n, at, type, r, m, to, root, comm))
COUNTED(Alltoall, bytes_of(n, type),
        (const void *s, int n, MPI_Datatype type, void *r, int m, MPI_Datatype to, MPI_Comm comm),
        (s, n, type, r, m, to, comm))
COUNTED(Alltoallv, s == MPI_IN_PLACE ? 0 : all_parts(n, type, comm),
        (const void *s, const int *n, const int *at, MPI_Datatype type, void *r, const int *m, const int *from,
         MPI_Datatype to, MPI_Comm comm),
        (s, n, at, type, r, m, from, to, comm))
COUNTED(Send, bytes_of(n, type), (const void *s, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm),
        (s, n, type, to, tag, comm))
COUNTED(Isend, bytes_of(n, type),
        (const void *s, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request *q),
        (s, n, type, to, tag, comm, q))

int MPI_Finalize() {
  write();
  return PMPI_Finalize();
}

} // extern "C"
