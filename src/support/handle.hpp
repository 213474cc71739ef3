#pragma once
// Move-only owners of PETSc and SLEPc objects. Create and destroy are collective; all die before PetscFinalize. While
// an exception unwinds nothing is destroyed: it may unwind on one rank alone, and the run is about to end.
#include <slepceps.h>

#include <exception>
#include <utility>

namespace dovetail {

template <class T, PetscErrorCode (*Destroy)(T *)> class Handle {
public:
  Handle() = default;
  Handle(Handle &&other) noexcept : raw_(std::exchange(other.raw_, nullptr)) {}
  Handle &operator=(Handle &&other) noexcept {
    std::swap(raw_, other.raw_);
    return *this;
  }
  Handle(const Handle &) = delete;
  Handle &operator=(const Handle &) = delete;
  ~Handle() {
    if (std::uncaught_exceptions() == 0) Destroy(&raw_);
  }

  operator T() const { return raw_; }
  /// For XxxCreate(..., handle.out()): destroys what was held.
  T *out() {
    Destroy(&raw_);
    return &raw_;
  }

private:
  T raw_ = nullptr;
};

using UniqueMat = Handle<Mat, MatDestroy>;
using UniqueVec = Handle<Vec, VecDestroy>;
using UniqueIS = Handle<IS, ISDestroy>;
using UniqueScatter = Handle<VecScatter, VecScatterDestroy>;
using UniqueKSP = Handle<KSP, KSPDestroy>;
using UniqueSNES = Handle<SNES, SNESDestroy>;
using UniqueEPS = Handle<EPS, EPSDestroy>;

} // namespace dovetail
