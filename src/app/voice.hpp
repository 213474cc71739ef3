#pragma once
// What the program says on the screen: rank 0 speaks.
#include <mpi.h>

#include <string>

#include "results/summary.hpp"
#include "support/json.hpp"
#include "support/log.hpp"

namespace dovetail {

class Voice {
public:
  explicit Voice(MPI_Comm comm) { MPI_Comm_rank(comm, &rank_); }
  bool speaks() const { return rank_ == 0; }
  /// `kind` and `members` as in log_message.
  void say(const std::string &line, const char *kind = "message", const std::string &members = "") const {
    if (speaks()) log_message(line, kind, members);
  }
  void warn(const Warning &warning) const {
    say("warning: " + warning.text, "warning", member("warning", quoted(warning.kind)));
  }

private:
  int rank_ = 0;
};

} // namespace dovetail
