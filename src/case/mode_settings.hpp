#pragma once
// [mode]: a nonlinear mode over its amplitude, in place of a sweep.
#include "case/case.hpp"
#include "case/document.hpp"

namespace dovetail {

/// Leaves the case as it is where the table is not given.
void read_mode(const Document &document, Case &study);

/// What a nonlinear mode has no use for is refused, and what is on by default is left out. After all other keys.
void refuse_beside_mode(const Document &document, Case &study);

} // namespace dovetail
