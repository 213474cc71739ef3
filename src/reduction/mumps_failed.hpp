#pragma once
// What errors of MUMPS mean where it factors K_ee or solves with it.
#include <string>

namespace dovetail {

/// Of INFOG(1) and INFOG(2), in words, with what to do.
std::string mumps_failed(const std::string &doing, int error, int detail);

} // namespace dovetail
