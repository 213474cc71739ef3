"""How far a response curve is from a reference: peak, resonance, whole curve, dissipated energy."""

from dataclasses import dataclass

import numpy as np


KINDS = ("amplitude", "frequency", "curve", "dissipation")
SAME_FREQUENCY = 1e-9  # relative; the points of continuation.at lie there to rounding


@dataclass(frozen=True)
class Curve:
    """What of a run is compared.

    peak : (omega [rad/s], amplitude) of the watched unknown where it moves most, be that an end of the sweep
    passes : for every common frequency, (k, 2): amplitude and energy dissipated per cycle by all contact points together [J] each
        time the branch passes it
    unit, omega_unit : of that amplitude and of frequencies
    """

    peak: tuple
    passes: list
    unit: str = ""
    omega_unit: str = "rad/s"


def curve_of(results, dof, frequencies):
    """The Curve of a results file.

    Parameters
    ----------
    results : Results
    dof : str
    frequencies : (m,) [rad/s]
    """
    response = results.response(dof)
    amplitude, top = response.amplitude, response.largest_point()
    passes = []
    for omega in frequencies:
        points = np.flatnonzero(np.abs(results.omega - omega) <= SAME_FREQUENCY * omega)
        energy = [results.contact_activity(int(i)).dissipation.sum() for i in points]
        passes.append(np.column_stack([amplitude[points], energy]))
    largest = float(results.omega[top]), float(amplitude[top])
    return Curve(max([largest, *response.peaks()], key=lambda place: place[1]), passes, response.unit, results.unit.omega)


def errors(curve, reference):
    """Relative errors, a dict over KINDS; None where the reference gives nothing to compare with.

    Every pass of the reference is compared with the pass of the curve that is nearest to it in amplitude; where the curve has
    none, it counts as zero.
    """
    omega, amplitude = reference.peak
    ours, theirs = [], []
    for found, wanted in zip(curve.passes, reference.passes):
        for row in wanted:
            theirs.append(row)
            ours.append(found[np.argmin(np.abs(found[:, 0] - row[0]))] if len(found) else np.zeros(2))
    ours, theirs = (np.reshape(rows, (-1, 2)) for rows in (ours, theirs))
    rms = np.sqrt(np.mean((ours - theirs) ** 2, axis=0)) if len(theirs) else np.zeros(2)
    energy = theirs[:, 1].max(initial=0.0)
    return {"amplitude": abs(curve.peak[1] / amplitude - 1), "frequency": abs(curve.peak[0] / omega - 1),
            "curve": float(rms[0] / amplitude) if len(theirs) else None,
            "dissipation": float(rms[1] / energy) if energy > 0 else None}


def largest(found):
    """The largest of the errors of one run."""
    return max(error for error in found.values() if error is not None)


def missed(curve, reference):
    """At how many frequencies the reference has a point and the curve has none."""
    return sum(len(wanted) > 0 and len(found) == 0 for found, wanted in zip(curve.passes, reference.passes))


def distances(results, reference, scales, sweep, frequencies, offset):
    """How far points are from a reference's curve, in the measure of the estimates of docs/theory/error-estimates.md.

    Parameters
    ----------
    results, reference : Results
        The reference has points at every frequency and `offset` below and above it, for the tangent of its curve; its modes
        are those of `results` and maybe more.
    scales : (3,)
        Of frequency, modes and contact motion, as in state.h5.
    sweep : float
        Its width [rad/s].
    frequencies : (m,) [rad/s]

    Returns
    -------
    points : (k,) int array
        Those of `results` that lie at one of the frequencies; where a branch passes it more than once, all of them.
    distances : (k,) array
        To the nearest passage of the reference: of the motion without its means, relative to its size, and of the frequency,
        relative to the sweep, as one root of squares.
    """
    H, modes = max(results.harmonics, reference.harmonics), max(results.modes, reference.modes)

    def motion(run):
        q = run.coefficients / np.where(np.arange(run.modes + 3 * run.contact_points) < run.modes, scales[1], scales[2])[:, None]
        q = np.insert(q, [run.modes] * (modes - run.modes), 0, axis=1)  # modes left out of it
        q[:, :, 0] = 0
        return np.pad(q, ((0, 0), (0, 0), (0, 2 * (H - run.harmonics)))).reshape(len(q), -1)

    def at(run, omega):
        return np.flatnonzero(np.abs(run.omega - omega) <= SAME_FREQUENCY * omega)

    ours, theirs = motion(results), motion(reference)
    points, found = [], []
    for omega in frequencies:
        below, here, above = (at(reference, omega + shift) for shift in (-offset, 0, offset))
        if not (len(below) and len(here) and len(above)):
            continue
        for point in at(results, omega):
            best = np.inf
            for j in here:
                near = [side[np.argmin(np.linalg.norm(theirs[side] - theirs[j], axis=1))] for side in (below, above)]
                slope = (theirs[near[1]] - theirs[near[0]]) / (2 * offset)
                size, missed = np.linalg.norm(ours[point]), ours[point] - theirs[j]
                along = (missed @ slope) / size**2 / ((slope @ slope) / size**2 + 1 / sweep**2)
                best = min(best, np.hypot(np.linalg.norm(missed - along * slope) / size, along / sweep))
            points.append(point)
            found.append(best)
    return np.array(points, int), np.array(found)
