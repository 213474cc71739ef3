#pragma once
// Kinds of work that PETSc's -log_view shows with their share of the time.
#include <petscsys.h>

namespace dovetail {

enum class Work { contact, matrices, modes, exchange, factors };

/// Times the work within its scope; nothing but two calls without -log_view.
class Timed {
public:
  explicit Timed(Work work);
  ~Timed() { PetscLogEventEnd(event_, 0, 0, 0, 0); }
  Timed(const Timed &) = delete;
  Timed &operator=(const Timed &) = delete;

private:
  PetscLogEvent event_;
};

} // namespace dovetail
