#pragma once
#include "case/case.hpp"
#include "case/document.hpp"

namespace dovetail {

/// The [damping] section.
void read_damping(const Document &document, Case &study);

/// Turns off what needs motions in time where the damping has none, or refuses it where the case asks for it.
void leave_out_motions_in_time(const Document &document, Case &study);

} // namespace dovetail
