#include "support/stage.hpp"

#include <algorithm>
#include <ctime>

#include "support/error.hpp"
#include "support/memory.hpp"

namespace dovetail {
namespace {

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

} // namespace

Stages::Guard::Guard(Stages &stages, const char *name)
    : stages_(stages), name_(name), begin_(MPI_Wtime()), cpu_begin_(cpu_seconds()) {
  PetscLogStage stage = -1;
  check(PetscLogStageGetId(name, &stage), "beginning a stage");
  if (stage < 0) check(PetscLogStageRegister(name, &stage), "beginning a stage");
  check(PetscLogStagePush(stage), "beginning a stage");
  if (stages_.begins) stages_.begins(name);
}

Stages::Guard::~Guard() {
  PetscLogStagePop();
  const double seconds = MPI_Wtime() - begin_, cpu = cpu_seconds() - cpu_begin_, peak = peak_bytes() / (1 << 20);
  auto &records = stages_.records_;
  const auto known = std::find_if(records.begin(), records.end(), [&](const Record &r) { return r.name == name_; });
  if (known == records.end())
    records.push_back({name_, seconds, cpu, peak});
  else
    known->seconds += seconds, known->cpu += cpu, known->peak_mib = peak;
}

} // namespace dovetail
