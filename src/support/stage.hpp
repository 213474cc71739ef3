#pragma once
// Named stages of a run: seconds and peak memory of each, on every rank; also visible in PETSc's -log_view.
#include <petscsys.h>

#include <functional>
#include <string>
#include <vector>

#include "support/error.hpp"

namespace dovetail {

class Stages {
public:
  struct Record {
    std::string name;
    double seconds;  ///< wall time on this rank
    double cpu;      ///< processor time of this rank: less than the wall time if it shared its core
    double peak_mib; ///< largest resident memory of this rank so far, at the end of the stage [MiB]
  };

  /// Runs `work` inside a stage; a stage run several times adds up.
  template <class Work> auto run(const char *name, Work &&work) {
    const Guard guard(*this, name);
    return work();
  }
  const std::vector<Record> &records() const { return records_; }

  std::function<void(const char *)> begins; ///< if set, is told the name of each stage as it begins

private:
  class Guard {
  public:
    Guard(Stages &stages, const char *name);
    ~Guard();
    Guard(const Guard &) = delete;
    Guard &operator=(const Guard &) = delete;

  private:
    Stages &stages_;
    std::string name_;
    double begin_, cpu_begin_;
  };
  std::vector<Record> records_;
};

} // namespace dovetail
