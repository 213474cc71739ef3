"""--restart on a results.h5 or state.h5 with something wrong in it: a short real run is continued, edited copy by edited copy.

The program goes on, or ends with status 2 or 3 and one message; anything else is a finding.
"""

import argparse
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import hdf5_edits

CASE = """model = "model.h5"
[reduction]
modes = 2
[damping]
stiffness = 0.05
[excitation]
fourier = [0, 0, 1]
[harmonic_balance]
harmonics = 2
samples = 32
[continuation]
omega = [0.9, 1.3]
max_points = {}
[output]
directory = "out"
"""
FILES = ("results.h5", "state.h5")
SECONDS = 60  # for a run that takes a tenth of one
FOREIGN = re.compile(r"std::|vector::|basic_string|bad_alloc|PETSC ERROR|Sanitizer|runtime error|_M_")


def run(program, folder, *options):
    done = subprocess.run([program, "run", folder / "case.toml", *options], capture_output=True, text=True, errors="replace",
                          timeout=SECONDS)
    return done.returncode, done.stderr


def prepare(program, folder):
    """The folder of a run that can be continued, and all edits of its files: (file, label, function of the open file)."""
    hdf5_edits.write(folder / "model.h5", "model", [])
    (folder / "case.toml").write_text(CASE.format(4))
    status, said = run(program, folder)
    assert status == 0, said
    (folder / "case.toml").write_text(CASE.format(6))
    edits = []
    for name in FILES:
        with h5py.File(folder / "out" / name) as file:
            edits += [(name, label, edit) for label, edit in hdf5_edits.edits_of(file)]
    return edits


def fault(program, folder, edits):
    """What is wrong with how the program continues a copy of the run with edits, or None."""
    with tempfile.TemporaryDirectory(dir=folder.parent) as copy:
        copy = Path(copy)
        shutil.copytree(folder, copy, dirs_exist_ok=True)
        for name, _, edit in edits:
            with h5py.File(copy / "out" / name, "r+") as file:
                hdf5_edits.apply(file, [edit])
        try:
            status, said = run(program, copy, "--restart")
        except subprocess.TimeoutExpired:
            return f"more than {SECONDS} s"
        foreign = FOREIGN.search(said)
        if status not in (0, 2, 3) or foreign:
            return f"ended with {status}: {said.strip()[-300:] if not foreign else said[max(0, foreign.start() - 100):][:400]}"
        if status == 2 and str(copy) not in said:
            return f"message without its file: {said.strip()}"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("program")
    chosen = parser.parse_args()
    dice, count, found = random.Random(chosen.seed), 0, set()
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
        folder = Path(folder) / "good"
        folder.mkdir()
        edits = prepare(chosen.program, folder)
        end = time.monotonic() + chosen.seconds
        while time.monotonic() < end:
            some = dice.sample(edits, dice.choice((1, 1, 1, 2, 3)))
            what = fault(chosen.program, folder, some)
            count += 1
            if what and what not in found:
                found.add(what)
                print(f"{what}\n    " + "; ".join(f"{name} {label}" for name, label, _ in some), flush=True)
    print(f"restart: {count} runs, {len(found)} findings")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
