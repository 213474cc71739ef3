#pragma once

#include <string>

namespace dovetail {

/// Dovetail and the libraries that it works with, one in a line; needs none of them initialised.
std::string versions();

} // namespace dovetail
