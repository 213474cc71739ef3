#pragma once
// Physical <-> dimensionless (docs/theory/equations.md, section 7): Om = w0 Om', a = alpha a', x = beta x'.
#include "case/case.hpp"
#include "case/travelling_wave.hpp"
#include "preload/contact_preload.hpp"
#include "scaling/dynamic_stiffness.hpp"

namespace dovetail {

struct Scales {
  double frequency = 1;                            ///< w0 [rad/s]
  double modal = 1;                                ///< alpha
  double contact = 1;                              ///< beta [m]
  double of(const PathParameter &parameter) const; ///< of its values
};

/// The preloaded model in dimensionless numbers: same structure, same equations, K_aa and so on divided as in
/// section 7.
struct ScaledModel {
  PreloadedModel model;
  Damping damping; ///< b w0, a / w0, eta [-]; of_parts if the model has a structural matrix
  Scales scales;
  int engine_order = 0; ///< of a cyclic sector
  double highest = 0;   ///< frequency of the sweep [-]; 0: not known
};

/// The scales in force: given by hand, all 1, or taken from the model (first mode, its static answer; without modes the
/// friction limit). Collective. InputError: the load is far out of range.
Scales choose_scales(const Case &study, const PreloadedModel &model);

/// The model in dimensionless numbers; no communication.
ScaledModel scaled(PreloadedModel model, const Damping &damping, const Scales &scales);
/// With the damping and the engine order of the case.
ScaledModel scaled(PreloadedModel model, const Case &study, const Scales &scales);

} // namespace dovetail
