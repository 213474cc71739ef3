#pragma once
// How n things are dealt out to ranks: contiguous, in order, the first n % size ranks get one more.
#include <petscsys.h>

#include <algorithm>

namespace dovetail {

struct Range {
  PetscInt begin = 0, end = 0;
  PetscInt size() const { return end - begin; }
};

inline Range share_of(PetscInt n, int rank, int size) {
  const PetscInt each = n / size, rest = n % size;
  const PetscInt begin = rank * each + std::min<PetscInt>(rank, rest);
  return {begin, begin + each + (rank < rest ? 1 : 0)};
}

/// The rank whose share holds thing i of n.
inline int owner_of(PetscInt n, PetscInt i, int size) {
  const PetscInt each = n / size, rest = n % size, longer = rest * (each + 1);
  return static_cast<int>(i < longer ? i / (each + 1) : rest + (i - longer) / each);
}

inline Range own_share(MPI_Comm comm, PetscInt n) {
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  return share_of(n, rank, size);
}

} // namespace dovetail
