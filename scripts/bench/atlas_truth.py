"""The judge: time integration at three points of a curve, begun there, by build/integrate."""

import json

import h5py
import numpy as np
from atlas_methods import limited
from measure import ROOT

from dovetail import fourier

PROGRAM = ROOT / "build/integrate"
PLACES = 3
HERE = 0.1  # a settled motion that differs more than this is another one: the branch is unstable there, or not the true one
LEFT = (0.02, 0.1, 0.25, 0.4, 0.6, 0.8, 0.98)  # parts of what is left of a sweep
TOLERANCE = 1e-6  # of the integration: relative change from period to period


def places(omega, coefficients):
    """Indices of three points of a curve: where it moves most, and a third and two thirds of the way along it."""
    last = len(omega) - 1
    top = int(np.argmax(np.linalg.norm(coefficients.reshape(len(omega), -1), axis=1)))
    chosen = [top] + [i for i in (last // 3, (2 * last) // 3, last // 6, last) if i != top]
    return sorted(chosen[:PLACES])


def compared(coefficients):
    """What is compared: half the peak-to-peak over the cycle of every unknown."""
    return fourier.amplitude(coefficients)


def error(found, true, modes):
    """Largest difference of amplitudes, relative to the largest: modes among themselves, contact dofs among themselves."""
    parts = [slice(0, modes), slice(modes, None)]
    return max(float(np.abs(found[part] - true[part]).max(initial=0) / (true[part].max(initial=0) or np.inf)) for part in parts)


def integrate(case, omegas, results, limit, harmonics=0):
    """What the program says at each frequency, begun at the points of `results` (None: at rest) that have it, with so many harmonics (0:
    those of the case); `limit` seconds for all."""
    start = [] if results is None else ["--from", results]
    run = limited([PROGRAM, case, *start, "--harmonics", harmonics, "--tolerance", TOLERANCE,
                   *(repr(float(omega)) for omega in omegas)], limit)
    said = [json.loads(line) for line in run.output.splitlines() if line.startswith("{")]
    why = run.complaint.strip() if run.status else f"not within {limit:g} s"
    return said + [{"settled": False, "why": why}] * (len(omegas) - len(said))


def beyond(case, run, limit):
    """Whether there is anything periodic in what a curve that stopped has left of the sweep, or the largest part of that: from rest, at
    each of LEFT.

    Returns a list of {settled, why}.
    """
    known = np.sort([*run.sweep, *run.omega])  # it may have begun at the far end, or in between
    widest = int(np.argmax(np.diff(known)))
    found = integrate(case, known[widest] + (known[widest + 1] - known[widest]) * np.array(LEFT), None, limit)
    return [{"settled": said["settled"], "why": said.get("why", "no period settled")} for said in found]


def judge(case, folder, run, modes, limit):
    """Compare a curve with integration at PLACES of its points, and find out whether there is anything periodic if there is no curve.

    Returns a list of {omega, settled, stays, found, true, error}; without a curve found, error and stays are missing.
    """
    if run.points == 0:
        first, last = run.sweep
        omegas = first + (last - first) * np.array([0.2, 0.5, 0.8])
        return [dict(omega=said["omega"], settled=said["settled"]) if "omega" in said else dict(settled=False) for said in
                integrate(case, omegas, None, limit)]
    judged = []
    chosen = places(run.omega, run.coefficients)
    with h5py.File(folder / "results.h5") as results:
        harmonics = results["points/harmonics"][:]
    for i, said in zip(chosen, integrate(case, run.omega[chosen], folder / "results.h5", limit, harmonics[chosen].max())):
        place = dict(point=i, omega=float(run.omega[i]), settled=said["settled"], multiplier=said.get("multiplier"))
        if said["settled"]:
            found, true = compared(run.coefficients[i]), compared(np.array(said["coefficients"])[:, :2 * harmonics[i] + 1])
            place |= dict(found=found.tolist(), true=true.tolist(), error=error(found, true, modes))
            place["stays"] = place["error"] < HERE
        else:
            place["why"] = said.get("why", "no period settled")
        judged.append(place)
    return judged


def at(omega, run, modes, near):
    """Amplitudes of another curve where it crosses a frequency, between its points; of several crossings, those nearest to `near`."""
    crossings = []
    for i in np.flatnonzero((run.omega[:-1] - omega) * (run.omega[1:] - omega) <= 0):
        span = run.omega[i + 1] - run.omega[i]
        part = (omega - run.omega[i]) / span if span else 0.0
        crossings.append(compared((1 - part) * run.coefficients[i] + part * run.coefficients[i + 1]))
    return min(crossings, key=lambda found: error(found, near, modes), default=None)
