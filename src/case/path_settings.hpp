#pragma once
// [path]: a sweep over another parameter than the frequency.
#include "case/case.hpp"
#include "case/document.hpp"

namespace dovetail {

/// Leaves the case as it is where the table is not given. The frequency goes to omega_from and omega_to.
void read_path(const Document &document, Case &study);

/// The values of `at`, within the range and in its order, into the case.
void read_wanted(const Entry &at, const CurveRange &range, Case &study);

} // namespace dovetail
