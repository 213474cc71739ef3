#pragma once
// What the program says on the screen: rank 0 speaks.
#include <mpi.h>

#include <cstdio>
#include <string>

#include "support/printable.hpp"

namespace dovetail {

class Voice {
public:
  explicit Voice(MPI_Comm comm) { MPI_Comm_rank(comm, &rank_); }
  bool speaks() const { return rank_ == 0; }
  void say(const std::string &line) const {
    if (!speaks() || line.empty()) return;
    std::printf("%s\n", printable(line).c_str());
    std::fflush(stdout);
  }

private:
  int rank_ = 0;
};

} // namespace dovetail
