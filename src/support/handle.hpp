#pragma once
// Move-only owners of PETSc and SLEPc objects. Create and destroy are collective; all die before PetscFinalize.
#include <slepceps.h>

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
  ~Handle() { Destroy(&raw_); }

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
