#pragma once
// Files in the output directory that a run would replace must be of runs.
#include "case/case.hpp"

namespace dovetail {

/// Throws InputError if a file that a run, or a reduction alone, would write is there and is not of Dovetail's making,
/// or is a symbolic link, behind which something else may lie. Each rank on its own.
void refuse_foreign_files(const Case &study, bool reduce_only);

} // namespace dovetail
