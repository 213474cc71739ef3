#pragma once
// [path]: a sweep over another parameter than the frequency.
#include "case/case.hpp"
#include "case/document.hpp"

namespace dovetail {

/// Leaves the case as it is where the table is not given. The frequency goes to omega_from and omega_to.
void read_path(const Document &document, Case &study);

/// The values of `at`, within from .. to of `key` and in that order, into the case.
void read_wanted(const Entry &at, double from, double to, const char *key, Case &study);

} // namespace dovetail
