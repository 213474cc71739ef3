#pragma once

namespace dovetail {

/// SlepcInitialize. Where it fails, most often over an option that PETSc itself refuses, the program ends with status 2
/// and a message, instead of PETSc's traceback. Collective.
void begin_petsc(int *argc, char ***argv);

} // namespace dovetail
