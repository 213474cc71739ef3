"""What a results file says of its curve, held against the points and the equations: located peaks, and estimated errors."""

import tomllib

import numpy as np

from . import reference
from .curves import pieces
from .reduced_system import equations

ESTIMATED = ("error_harmonics", "error_sampling")  # that of modes left out is not in the reduced equations
SAME = 1e-9  # relative, of an amplitude that is stored and the same from stored coefficients
HIGHER = 1e-3  # relative, of a point beside a peak: at kinks the higher end of a short step is taken
SAMPLES = 1024  # of a period, for the solution with more harmonics: good to 1e-5 of a contact force
LARGEST = 1000  # unknowns with those harmonics: dense matrices
STEPS = 3  # of Newton's method, which is there after two
FREE = 1e3  # how much more easily means move than the rest when the nearest solution is looked for: they do not count
FACTOR = 10  # an estimate, one step of Newton's method, is good to a few tens of per cent
NEGLIGIBLE = 1e-4  # a tenth of what shows in a picture: below it, estimates are not judged, and SAMPLES are not fine enough


def peaks_judged(results):
    """Words on the located peaks of the watched amplitudes, and a list of complaints."""
    peaks, found, highest = results.events.of("peak"), [], 0.0
    if not len(peaks):
        return "peaks: none located", found
    curves = {}
    for point, told, unknown in zip(peaks.point, peaks.amplitude, peaks.unknown):
        name = results.dof_names()[unknown] if unknown >= 0 else results.watch
        try:
            curve = curves[name] = curves.get(name) or results.response(name)
        except (OSError, ValueError) as error:
            return f"peaks: not judged ({error})", found
        amplitude = curve.amplitude[point]
        if not abs(told - amplitude) <= SAME * amplitude:
            found.append(f"peak at point {point}: /events/amplitude is {told:.9g}, the amplitude of {name} there {amplitude:.9g}")
        inside = any(piece.start < point < piece.stop - 1 for piece in pieces(len(results), curve.jumps))
        if inside and not results.samples and results.points("located")[point]:  # sampled forces make teeth, each with a maximum
            higher = max(curve.amplitude[point - 1], curve.amplitude[point + 1]) / amplitude - 1
            highest = max(highest, higher)
            if not higher <= HIGHER:
                found.append(f"point {point} is no maximum of {name}: one beside it is higher by {higher:.1e}, {HIGHER:.1e} allowed")
    if results.samples:
        return f"peaks: {len(peaks)} located; with sampled forces not held against the points beside them", found
    return f"peaks: {len(peaks)} located, no point beside one is higher by more than {highest:.1e}", found


def estimates_judged(results):
    """Words on the estimated error of the largest point, and a list of complaints."""
    if reason := _not_estimated(results):
        return f"estimated errors: not judged ({reason})", []
    point = results.largest_point(results.watched)
    told, harmonics = sum(float(results.points(name)[point]) for name in ESTIMATED), _more(results, point)
    found = distance(results, point, harmonics)
    words = f"estimated errors: {told:.1e} by harmonics and samples at point {point}, {found:.1e} found with {harmonics} harmonics"
    wrong = not found <= max(FACTOR * told, NEGLIGIBLE)
    return words, [f"{words}, more than {FACTOR} times as much"] if wrong else []


def _not_estimated(results):
    if results.parameter is not None or results.wave is not None:
        return "of sweeps over the frequency alone, and not of sectors"
    if results.error is None:
        return "none are stored"
    if np.any(results.contact["law"] == reference.contact.CONE):
        return "the law cone takes too long with more harmonics"
    point = results.largest_point(results.watched)
    if not np.isfinite(sum(results.points(name)[point] for name in ESTIMATED)):
        return f"none is stored at point {point}, the largest"
    unknowns = (results.modes + 3 * results.contact_points) * (2 * _more(results, point) + 1)
    return f"{unknowns} unknowns with {_more(results, point)} harmonics, {LARGEST} at most" if unknowns > LARGEST else ""


def _more(results, point):
    """Harmonics with which the error of a point is sought."""
    return max(3, 2 * int(results.points("harmonics")[point]))


def distance(results, point, harmonics):
    """How far the nearest solution with other harmonics is: motion without means by its size, and frequency by the width of the sweep."""
    system = equations(results, SAMPLES, harmonics=harmonics)
    q = np.zeros(system.shape)
    kept = results.coefficients_at(point)[:, :system.shape[1]]
    q[:, :kept.shape[1]] = kept
    size = np.linalg.norm(q[:, 1:])
    weight = np.full(q.shape, size)
    weight[:, 0] *= FREE
    weight = np.append(weight.ravel(), max(np.ptp(tomllib.loads(results.case)["continuation"]["omega"]), 0) * _rad(results))
    start = y = np.append(q.ravel(), results.omega[point])
    for _ in range(STEPS):
        q, omega = y[:-1].reshape(system.shape), y[-1]
        matrix = np.column_stack([system.jacobian(q, omega), system.omega_derivative(q, omega).ravel()])
        y = y - weight * np.linalg.lstsq(matrix * weight, system.residual(q, omega).ravel(), rcond=None)[0]
    moved = (y - start)[:-1].reshape(system.shape)[:, 1:].ravel() / size
    return float(np.hypot(np.linalg.norm(moved), (y - start)[-1] / weight[-1] if weight[-1] > 0 else 0.0))


def _rad(results):
    """Frequencies of the model per unit of those of the case."""
    return results.unit.from_hertz(1.0) if tomllib.loads(results.case)["continuation"].get("unit") == "Hz" else 1.0
