#pragma once
#include "case/case.hpp"
#include "case/document.hpp"

namespace dovetail {

/// The [excitation] section: load patterns and their courses over the period, padded to the case's harmonics.
void read_excitation(const Document &document, Case &study);

} // namespace dovetail
