#pragma once
// What fails on one rank is told to all where they meet anyway, not at once: one message for many things that may fail.
#include <mpi.h>

#include "support/error.hpp"

namespace dovetail {

class Agreement {
public:
  explicit Agreement(MPI_Comm comm) : comm_(comm) {}

  /// Runs what may fail on this rank; after a failure nothing, until all ranks agree.
  template <class Work> void hold(Work &&work) {
    if (failed_) return;
    try {
      work();
    } catch (...) {
      failed_ = std::current_exception();
    }
  }
  /// Throws on this rank what has failed here.
  void rethrow() const {
    if (failed_) std::rethrow_exception(failed_);
  }
  /// Throws on all ranks what has failed on any of them. Returns the largest of their numbers, which is not negative.
  /// Collective.
  int agree(int number) const {
    int largest[] = {failed_ != nullptr, number};
    MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPI_INT, MPI_MAX, comm_);
    if (largest[0]) on_all_ranks(comm_, [&] { rethrow(); });
    return largest[1];
  }

private:
  MPI_Comm comm_;
  std::exception_ptr failed_;
};

} // namespace dovetail
