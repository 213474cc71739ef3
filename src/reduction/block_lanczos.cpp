#include "reduction/block_lanczos.hpp"

#include <slepc/private/epsimpl.h>
#include <slepcblaslapack.h> // needs petscsys.h before it

#include <algorithm>
#include <cmath>

#include "reduction/block_search.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr PetscInt most_restarts = 200;

struct Lanczos {
  BV start = nullptr; // the initial space as it was given
};

Lanczos &data_of(EPS eps) { return *static_cast<Lanczos *>(eps->data); }

// What a look at the Ritz pairs has found.
struct Look {
  Ritz ritz;
  PetscInt good = 0;    // pairs that have converged, from the first one on without a gap
  bool crowded = false; // as many equal values as there were start vectors: there may be more of them
};

PetscErrorCode look(EPS eps, const Search &search, PetscInt count, PetscInt seen, Look &found) {
  PetscFunctionBegin;
  PetscCall(search.ritz_pairs(found.ritz));
  const std::vector<double> &value = found.ritz.value;
  for (PetscInt i = 0; i < count; ++i) {
    eps->eigr[i] = value[i], eps->eigi[i] = 0;
    PetscCall((*eps->converged)(eps, value[i], 0, search.residual(found.ritz, i), &eps->errest[i], eps->convergedctx));
  }
  while (found.good < count && eps->errest[found.good] < eps->tol) ++found.good;
  for (PetscInt i = 0; i + seen <= count; ++i)
    found.crowded = found.crowded || std::abs(value[i + seen - 1]) > (1 - 1e-6) * std::abs(value[i]);
  PetscFunctionReturn(0);
}

PetscErrorCode iterate(EPS eps, Search &search) {
  PetscFunctionBegin;
  const PetscInt wanted = eps->nev;
  PetscCall(search.begin());
  const PetscInt widest = search.block;
  PetscInt starts = 1, enough = wanted; // columns before it is worth looking
  for (;;) {
    const PetscInt old = search.block;
    PetscCall(search.expand());
    ++eps->its;
    const PetscInt k = search.known, fresh = search.block;
    const bool full = k + std::max(fresh, widest) + widest > search.most;
    if (fresh > 0 && !full && k < enough + old && eps->its < eps->max_it) continue;
    const PetscInt count = std::min(wanted, k);
    Look found;
    PetscCall(look(eps, search, count, widest * starts, found));
    const bool done = found.good == wanted;
    eps->nconv = found.good;
    PetscCall(EPSMonitor(eps, eps->its, eps->nconv, eps->eigr, eps->eigi, eps->errest, count));
    PetscCall((*eps->stopping)(eps, eps->its, eps->max_it, done && found.crowded ? wanted - 1 : found.good, wanted,
                               &eps->reason, eps->stoppingctx));
    if (eps->reason != EPS_CONVERGED_ITERATING) {
      PetscCall(search.keep_only(found.ritz, count));
      break;
    }
    if (done || fresh == 0) { // with another start, for what the first could not see
      if (done || full) PetscCall(search.keep_only(found.ritz, count));
      const bool whole = search.known == k; // not yet rotated
      PetscCall(search.begin_with_other_noise());
      ++starts;
      enough = search.known + 3 * widest; // a few steps, for what is new to show
      if (search.block > 0) continue;
      if (whole) PetscCall(search.keep_only(found.ritz, count));
      eps->nconv = count;
      eps->reason = count == wanted ? EPS_CONVERGED_TOL : EPS_DIVERGED_BREAKDOWN;
      break;
    }
    if (full) PetscCall(search.restart(found.ritz, std::min(wanted + widest, k - widest)));
  }
  PetscFunctionReturn(0);
}

PetscErrorCode solve(EPS eps) {
  PetscFunctionBegin;
  Search search;
  PetscCall(search.create(eps->st, eps->V, data_of(eps).start));
  PetscCall(iterate(eps, search));
  PetscFunctionReturn(0);
}

PetscErrorCode set_up(EPS eps) {
  PetscFunctionBegin;
  EPSCheckHermitianDefinite(eps);
  EPSCheckSinvert(eps);
  if (!eps->which) eps->which = EPS_TARGET_MAGNITUDE;
  PetscCheck(eps->which == EPS_TARGET_MAGNITUDE && eps->target == 0,
             PetscObjectComm(reinterpret_cast<PetscObject>(eps)), PETSC_ERR_SUP,
             "blocklanczos finds the eigenvalues that are next to 0");
  EPSCheckUnsupported(eps, EPS_FEATURE_BALANCE | EPS_FEATURE_ARBITRARY | EPS_FEATURE_REGION | EPS_FEATURE_EXTRACTION |
                               EPS_FEATURE_TWOSIDED);
  Lanczos &data = data_of(eps);
  const PetscInt given = std::max<PetscInt>(0, -eps->nini); // negative: not copied into V yet
  PetscInt block = given;
  if (given == 0 && data.start) PetscCall(BVGetSizes(data.start, nullptr, nullptr, &block));
  PetscCheck(block > 0, PetscObjectComm(reinterpret_cast<PetscObject>(eps)), PETSC_ERR_ORDER,
             "blocklanczos wants an initial space: as many vectors as a block has");
  if (eps->ncv <= 0) eps->ncv = lanczos_columns(eps->nev, eps->n, block);
  const PetscInt least = std::min(eps->n, eps->nev + block);
  PetscCheck(eps->ncv >= least, PetscObjectComm(reinterpret_cast<PetscObject>(eps)), PETSC_ERR_ARG_OUTOFRANGE,
             "blocklanczos wants -eps_ncv %d at least, and %d is given", static_cast<int>(least),
             static_cast<int>(eps->ncv));
  eps->mpd = eps->ncv;
  if (eps->max_it <= 0) eps->max_it = most_restarts * (eps->ncv / block + 1);
  PetscCall(EPSAllocateSolution(eps, 3 * block));
  if (given > 0) { // V's inner product stays the usual one: those with B are formed where needed
    PetscCall(BVDestroy(&data.start));
    PetscCall(BVDuplicateResize(eps->V, block, &data.start));
    for (PetscInt j = 0; j < block; ++j) PetscCall(BVInsertVec(data.start, j, eps->IS[j]));
  }
  PetscFunctionReturn(0);
}

PetscErrorCode set_up_sort(EPS eps) {
  PetscFunctionBegin;
  eps->sc->comparison = SlepcCompareTargetMagnitude, eps->sc->comparisonctx = &eps->target;
  eps->sc->map = nullptr, eps->sc->mapobj = nullptr;
  PetscFunctionReturn(0);
}

PetscErrorCode set_default_st(EPS eps) {
  PetscFunctionBegin;
  if (!(reinterpret_cast<PetscObject>(eps->st))->type_name) PetscCall(STSetType(eps->st, STSINVERT));
  PetscFunctionReturn(0);
}

PetscErrorCode back_transform(EPS eps) {
  PetscFunctionBegin;
  PetscCall(STBackTransform(eps->st, eps->nconv, eps->eigr, eps->eigi));
  PetscFunctionReturn(0);
}

PetscErrorCode view(EPS eps, PetscViewer viewer) {
  PetscFunctionBegin;
  PetscBool text;
  PetscInt width = 0;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(viewer), PETSCVIEWERASCII, &text));
  if (data_of(eps).start) PetscCall(BVGetSizes(data_of(eps).start, nullptr, nullptr, &width));
  if (text) PetscCall(PetscViewerASCIIPrintf(viewer, "  block of %d vectors\n", static_cast<int>(width)));
  PetscFunctionReturn(0);
}

PetscErrorCode reset(EPS eps) {
  PetscFunctionBegin;
  PetscCall(BVDestroy(&data_of(eps).start));
  PetscFunctionReturn(0);
}

PetscErrorCode destroy(EPS eps) {
  PetscFunctionBegin;
  PetscCall(reset(eps));
  delete &data_of(eps);
  eps->data = nullptr;
  PetscFunctionReturn(0);
}

PetscErrorCode create(EPS eps) {
  PetscFunctionBegin;
  eps->data = new Lanczos;
  eps->categ = EPS_CATEGORY_KRYLOV;
  eps->useds = PETSC_FALSE;
  eps->ops->solve = solve;
  eps->ops->setup = set_up;
  eps->ops->setupsort = set_up_sort;
  eps->ops->setdefaultst = set_default_st;
  eps->ops->backtransform = back_transform;
  eps->ops->view = view;
  eps->ops->reset = reset;
  eps->ops->destroy = destroy;
  PetscFunctionReturn(0);
}

} // namespace

PetscInt lanczos_columns(PetscInt count, PetscInt n, PetscInt width) {
  return std::min(n, std::max(3 * count, count + 8 * width));
}

void register_block_lanczos() { check(EPSRegister(block_lanczos, create), "registering block Lanczos"); }

} // namespace dovetail
