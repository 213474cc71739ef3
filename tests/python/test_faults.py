"""One call fails: the run ends in words, what was computed can be read, and the next run gives the whole branch.

The calls that once led to something else, and some more; all of them: scripts/faults.
"""

import random
from concurrent.futures import ThreadPoolExecutor

import pytest

from launch import BINARY
from faults import attempt, told, trials_of
from trial import KINDS, Scene, Trial

LIBRARY = BINARY.parent / "tests" / "faults" / "libfault.so"
# By scene: what fails, its which-th call (from the end if negative), and the exit status.
ONCE_WRONG = {
    "fresh": [("MPI_Allgather", 20, 3),  # PETSc has errors returned: wrong numbers were written
              ("H5Aread", 3, 2), ("H5Lexists", 12, 2),  # units, and a sector: taken for not there
              ("truncate", -1, 0), ("H5Fclose", 28, 3),  # of results: a crash without a word; of a state: nobody heard
              ("H5Tset_size", 1, 3),  # an attribute was cut short, and reduced.h5 then another's
              ("bad", -10, 3),  # a dataset of a state was not written, and nobody heard
              ("full", -6, 3)],  # half a state.h5.partial stood in the way of --restart
    "restart": [("mumps", 42, 0)]}  # a frequency was missed for which a factorisation lacked room


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    if not LIBRARY.exists():
        pytest.skip("libfault.so is not built")
    folder = tmp_path_factory.mktemp("scenes")
    return lambda name, ranks=1: Scene(name, BINARY, LIBRARY, folder, ranks)


def check(trials, folder):
    with ThreadPoolExecutor(2) as threads:
        done = list(threads.map(lambda trial: attempt(trial, folder), trials))
    assert all(trial.call for trial in done), [f"{trial.kind} {trial.k} was never called" for trial in done if not trial.call]
    assert not any(trial.verdict for trial in done), "\n".join(told(trial) for trial in done if trial.verdict)
    return done


@pytest.mark.parametrize("name", ONCE_WRONG)
def test_what_once_was_wrong(scenes, tmp_path, name):
    scene = scenes(name)
    counts = scene.count(tmp_path / "count")[0]
    trials = [Trial(scene, kind, 0, k if k > 0 else counts[kind] + 1 + k) for kind, k, _ in ONCE_WRONG[name]]
    assert [trial.status for trial in check(trials, tmp_path)] == [status for _, _, status in ONCE_WRONG[name]]


@pytest.mark.slow
def test_some_of_every_kind_on_two_ranks(scenes, tmp_path):
    scene = scenes("again", ranks=2)
    counts = scene.count(tmp_path / "count")
    kinds = [kind for kind in KINDS if kind != "alloc"]  # libraries crash where memory runs out
    check(trials_of(scene, counts, kinds, 1, random.Random(1)), tmp_path)
