#pragma once
// How many harmonics a scene needs before anything is computed.
#include "harmonic/dense_model.hpp"

namespace dovetail {

/// The highest frequency at which the structure vibrates mainly in the normal direction of its contacts while they are
/// closed and stuck, scaled; 0 without contact. Where contacts open and close, no solution near the true one need exist
/// while H Omega is below 1.5 to 2 times this frequency.
double closed_contact_frequency(const DenseModel &model);

} // namespace dovetail
