#pragma once
// Contact preload: the joint pressed together before anything vibrates (docs/theory/equations.md, section 4).
#include <string>
#include <vector>

#include "contact/law.hpp"
#include "reduction/reduced_model.hpp"

namespace dovetail {

/// A reduced model with its contact law and the state the vibration starts from; contact data of own points only.
struct PreloadedModel {
  ReducedModel reduced;
  std::vector<ContactPoint> contact;  ///< (own)
  std::vector<Standstill> standstill; ///< (own) x_p, g(x_p), w_p
};

/// Solves K_xx x_p + g(x_p) = -R (eq 7) from `initial` (3 own) [m]. `contact`: own points. Collective.
/// When plain Newton fails it starts from the joint held closed and stuck: at once, loaded in steps, with friction
/// lowered in steps.
/// ComputeError if nothing helps. `note` receives a line in words when more than plain Newton was needed.
PreloadedModel contact_preload(ReducedModel reduced, std::vector<ContactPoint> contact,
                               const std::vector<double> &initial, std::string &note);

} // namespace dovetail
