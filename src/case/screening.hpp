#pragma once
#include <string>

namespace dovetail {

/// Refuses, with InputError "FILE:LINE: ...", what no case file needs and toml11 reads outside of its buffers, without
/// bound on the stack, or in a time that grows with the square of the size.
void screen(const std::string &file, const std::string &text);

} // namespace dovetail
