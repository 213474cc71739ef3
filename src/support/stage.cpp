#include "support/stage.hpp"

#include <sys/resource.h>

namespace dovetail {

Stages::Guard::Guard(Stages &stages, const char *name) : stages_(stages), name_(name), begin_(MPI_Wtime()) {
  PetscLogStage stage = -1;
  PetscLogStageGetId(name, &stage);
  if (stage < 0) PetscLogStageRegister(name, &stage);
  PetscLogStagePush(stage);
}

Stages::Guard::~Guard() {
  PetscLogStagePop();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  stages_.records_.push_back({name_, MPI_Wtime() - begin_, static_cast<double>(usage.ru_maxrss) / 1024});
}

} // namespace dovetail
