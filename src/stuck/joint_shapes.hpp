#pragma once
// The motions that a joint is about: shapes z of the stuck structure in which the springs of the contacts hold a large
// part of the strain energy, z^T Phi_c^T K_t Phi_c z / z^T Lambda z. A body that its joint alone holds has six that
// hold all of it. Where contacts slip these are softened most, and no few modes of the stuck structure make them up.
#include "stuck/layout.hpp"
#include "stuck/stuck_basis.hpp"

namespace dovetail {

/// In the modes, (n, shapes) by columns, those that hold more than a tenth, at most 24, most first; on every rank. Of a
/// complex basis real parts and then imaginary ones, (2n, shapes). Collective.
std::vector<double> joint_shapes(const StuckBasis &basis, const Layout &layout);

} // namespace dovetail
