#pragma once
// What harmonic balance left out: the harmonics H+1..2H of the contact forces, and the motion they make.
#include "stability/contact_reading.hpp"

namespace dovetail {

/// Coefficients (n, 4H+1) of a motion with its harmonics up to 2H, from a `reading` of it with these set to zero: the
/// answer of the structure, its contacts at their mean stiffness, to the forces beyond H. `change`: the size of what
/// was added over that of the motion without its mean. For a converged H this is the error of harmonic balance.
std::vector<double> finer_motion(const DenseModel &model, const ContactReading &reading,
                                 const std::vector<double> &motion, double omega, double &change);

} // namespace dovetail
