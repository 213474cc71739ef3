"""Every Python reader of Dovetail's own files on every file named; says what was not as it should be, and ends with 1 then."""

import resource
import sys
import warnings
from pathlib import Path

import numpy as np
import verdict

from dovetail import Model, hdf5_read
from dovetail.info import describe
from dovetail.motion import read_model_parts
from dovetail.results import Results

GIB = 1 << 30


def results(path):
    found = Results(path)
    found.coefficients
    if not len(found):
        return
    for dof in found.dof_names()[:3]:
        found.response(dof), found.peaks(dof), found.ends(dof), found.time_history(0, dof, 8)
    if found.contact_points:
        found.located_peaks("x1.t1"), found.events.of("fold", "peak")
        found.contact_force(0, 1, 8), found.contact_activity(0), found.dissipated(-1, 1)


def from_reduced(path):
    """The full motion of good results with this file as their reduced file."""
    found = Results(path.with_name("good_results.h5"))
    found.reduced = path
    found.elastic(0, 4), found.full(0, 4), found.unknowns(0, [0, 3], 4)


def from_model(path):
    found = Results(path.with_name("good_results.h5"))
    found.reduced = path.with_name("good_reduced.h5")
    found.displacement(0, n=4, model=path)
    found.displacement(0, nodes="tip", n=4, model=path)
    found.model = path
    found.amplitude("tip.x"), found.amplitude("0.z")


READERS = {"model": Model.read, "parts": read_model_parts, "info": describe, "results": results, "elastic": from_reduced,
           "displacement": from_model}


def faults(path):
    """(reader, where, traceback) of each reader that did not do as it should."""
    for name, read in READERS.items():
        with np.errstate(all="ignore"):
            found = verdict.fault(lambda: read(path), [path.name])
        if found:
            yield name, *found


def without_patience(set_=setattr):
    """The readers wait for a run that may be writing; here none is."""
    set_(hdf5_read, "READ_ATTEMPTS", 1)


def main():
    without_patience()
    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_AS, (4 * GIB, 4 * GIB))
    failed = False
    for path in map(Path, sys.argv[1:]):
        print(f"Running: {path}", file=sys.stderr, flush=True)
        for name, where, text in faults(path):
            failed = True
            print(f"FAULT {path.name} {name}: {where}", flush=True)
            print(text, file=sys.stderr, flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
