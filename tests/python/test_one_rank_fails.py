"""An error that strikes one rank alone ends the run on all of them, with a message and status 3: nobody waits for ever.

The error is made by a preloaded library that stands before PETSc and lets one call fail on rank 1.
"""

import subprocess
from concurrent.futures import ThreadPoolExecutor

import pytest

import cases
from launch import SECONDS, SURROUNDINGS, line

CALLS = {"MatSetValuesCOO": "assembled", "KSPSetTolerances": "modal", "VecWAXPY": "modal"}  # and the solver that makes it

SHIM = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

static int fails(const char *name) { /* the third call of that name on rank 1 */
  static int calls = 0;
  const char *rank = getenv("OMPI_COMM_WORLD_RANK");
  return rank && !strcmp(rank, "1") && !strcmp(getenv("FAILS"), name) && ++calls == 3;
}

#define GUARD(name, declared, passed)                                        \
  int name declared {                                                        \
    int(*real) declared = (int(*) declared)dlsym(RTLD_NEXT, #name);          \
    return fails(#name) ? 55 : real passed;                                  \
  }

GUARD(MatSetValuesCOO, (void *matrix, const double *values, int mode), (matrix, values, mode))
GUARD(KSPSetTolerances, (void *solver, double relative, double absolute, double divergence, int most),
      (solver, relative, absolute, divergence, most))
GUARD(VecWAXPY, (void *w, double a, void *x, void *y), (w, a, x, y))
"""


@pytest.fixture(scope="module")
def shim(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shim")
    (folder / "shim.c").write_text(SHIM)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", folder / "shim.so", folder / "shim.c", "-ldl"], check=True)
    return folder / "shim.so"


@pytest.fixture(scope="module")
def ended(shim, tmp_path_factory):
    """By call: how the run ended. All at once: the roll call takes ten seconds, in which nothing is done. Each with a folder of its own for
    Open MPI, which makes and removes one that is shared in the way of others."""
    def fails(call):
        case = cases.several_points(tmp_path_factory.mktemp(call), solver=CALLS[call])
        own = {"LD_PRELOAD": str(shim), "FAILS": call, "OMPI_MCA_orte_tmpdir_base": str(case.path.parent)}
        return subprocess.run(line(case, ranks=2)[0], env=SURROUNDINGS | own, capture_output=True, text=True, timeout=SECONDS)
    with ThreadPoolExecutor(len(CALLS)) as threads:
        runs = {call: threads.submit(fails, call) for call in CALLS}
    return runs


@pytest.mark.slow
@pytest.mark.parametrize("call", CALLS)
def test_run_ends(ended, call):
    done = ended[call].result()
    assert done.returncode == 3, done.stderr
    assert "dovetail: while " in done.stderr
