// What a case leaves open until the size of the model is known.
#include "case/case.hpp"
#include "support/error.hpp"

namespace dovetail {

int watched_dof(const Case &study, int modes, int points) {
  const Watch &watch = study.watch;
  if (watch.name.empty() || !watch.node.empty()) return -1;
  const bool mode = watch.direction < 0;
  if (watch.number > (mode ? modes : points))
    throw InputError(watch.where + " = \"" + watch.name + "\": the model has " +
                     (mode ? std::to_string(modes) + " modes" : std::to_string(points) + " contact points"));
  return mode ? watch.number - 1 : modes + 3 * (watch.number - 1) + watch.direction;
}

void check_ratios(const Case &study, int dofs) {
  for (const ModeRatio &ratio : study.damping.ratios)
    if (ratio.mode > dofs)
      throw InputError(study.ratios_where + ": mode " + std::to_string(ratio.mode) + ": the reduced model has " +
                       std::to_string(dofs) + " modes, N_a + 3 N_x");
}

// Where judging a point takes hardly more time than computing it. (Measured: five dofs, one point, H = 10: 0.03 ms
// where nothing slips, 0.2 ms where it does, 1.5 ms with Hill's method, to some 1 ms for the point; 15 dofs, 4 points,
// H = 5: 0.2, 1 and 7 ms to 3.3 ms; 18 dofs, 5 points, H = 7: 20 ms to 8 ms.)
void settle_stability(Case &study, int dofs) {
  constexpr double small = 150; // unknowns
  if (!study.stability) study.stability = double(dofs) * (2 * study.harmonics + 1) <= small;
}

} // namespace dovetail
