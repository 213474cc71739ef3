"""Attempts of an adversary (tests/fuzz/adversary.py): what once ended badly, and some of every kind."""

import os
import random
import subprocess
from concurrent.futures import ThreadPoolExecutor

import pytest
from adversary import all_attempts
from attempt import BAD, Adversary

from launch import BINARY, SURROUNDINGS

ONCE_WRONG = ["case file: its text: a mark of the encoding first", "options of PETSc: behind the case: -options_file",
              "options of PETSc: behind the case: -prefix_push a -prefix_pop -prefix_pop",
              "options of PETSc: behind the case: -malloc_debug",
              "options of PETSc: behind the case: -saws_options", "output folder: no space beyond 1000 bytes",
              "output folder: no space beyond 100000 bytes, --restart", "command line: 'run case.toml --out a --out b'"]
EACH = 3  # of every kind


@pytest.fixture(scope="module")
def adversary(tmp_path_factory):
    return Adversary(BINARY, tmp_path_factory.mktemp("adversary"))


@pytest.fixture(scope="module")
def attempts(adversary):
    return {f"{attempt.kind}: {attempt.name}": attempt for attempt in all_attempts(adversary, seed=2, scale=0.1)}


def check(adversary, chosen):
    with ThreadPoolExecutor(2) as threads:
        done = list(threads.map(adversary.attempt, chosen))
    bad = [f"{attempt.kind}: {attempt.name}: {BAD[attempt.outcome]}: {attempt.why}" for attempt in done if attempt.outcome in BAD]
    assert not bad, "\n".join(bad)


def test_what_once_was_wrong(adversary, attempts):
    check(adversary, [attempts[name] for name in ONCE_WRONG])


@pytest.mark.slow
def test_some_of_every_kind(adversary, attempts):
    dice, of_kind = random.Random(2), {}
    for attempt in attempts.values():
        of_kind.setdefault(attempt.kind, []).append(attempt)
    check(adversary, [attempt for some in of_kind.values() for attempt in dice.sample(some, min(EACH, len(some)))])


def test_a_screen_that_goes_ends_no_run(adversary):
    """As with `| head`: nobody reads the lines any more."""
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "w") as closed:
        done = subprocess.run([BINARY, "run", "case.toml", "--out", "unread"], cwd=adversary.start, env=SURROUNDINGS, stdout=closed,
                              stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (adversary.start / "unread/results.h5").exists()
