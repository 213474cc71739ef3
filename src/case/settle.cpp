// What a case leaves open until the size of the model is known.
#include "case/case.hpp"
#include "support/error.hpp"

namespace dovetail {

int watched_dof(const Case &study, int modes, int points) {
  const Watch &watch = study.watch;
  if (watch.name.empty()) return -1;
  const bool mode = watch.direction < 0;
  if (watch.number > (mode ? modes : points))
    throw InputError(watch.where + " = \"" + watch.name + "\": the model has " +
                     (mode ? std::to_string(modes) + " modes" : std::to_string(points) + " contact points"));
  return mode ? watch.number - 1 : modes + 3 * (watch.number - 1) + watch.direction;
}

void settle_stability(Case &study, int dofs) {
  constexpr double small = 300; // unknowns of a dense eigenproblem, solved for each point
  if (!study.stability) study.stability = double(dofs) * (2 * study.harmonics + 1) <= small;
}

} // namespace dovetail
