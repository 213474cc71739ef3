"""Is a travelling wave stable against motions of any nodal diameter? `python3 -m dovetail wheel RESULTS.h5`.

By Hill's method on the sector (wave_exponents.py), and with --whole by the program too, on all sectors (wheel_runs.py).
"""

import tomllib

import numpy as np

from . import curves
from .reduced_system import equations
from .results import STABLE, UNSTABLE, Results
from .shown import contact_dofs, value_at
from .wave_contacts import KnownToTheProgram
from .wave_exponents import largest
from .wheel_runs import WholeWheel

UNSURE = 6e-4  # of a multiplier from 1: twice what samples were seen to make of it
SHOWN = 0.05  # share of a nodal diameter that is worth a word
WORDS = {STABLE: "stable", UNSTABLE: "unstable"}


def wheel(arguments):
    """The command: prints the table."""
    results = Results(arguments.file)
    need_wave(results)
    points = chosen_points(results, arguments.at, arguments.hz)
    if not arguments.whole and (arguments.out or arguments.binary):
        raise ValueError("--out and --binary are of the whole wheel; give --whole besides")
    whole = WholeWheel(results, points, arguments.out, arguments.binary) if arguments.whole else None
    print("\n".join(head(results, arguments.hz, whole)), flush=True)
    system = equations(results)
    for point in points:
        try:
            found = largest(system, results.coefficients_at(point), results.omega[point], results.wave)
        except KnownToTheProgram:
            if not whole:
                raise
            found = None
        print(row(results, point, found, arguments.hz) + (of_whole(whole.run(point)) if whole else ""), flush=True)
    if whole:
        print(f"{whole.folder}: a case of the whole wheel for every point, from which the program goes on with all sectors")


def need_wave(results):
    """Refuses results that are no forced travelling wave in time."""
    path = results.path
    if results.wave is None:
        raise ValueError(f"{path}: is not of a sector of a cyclic structure; the stability of other curves is that of [stability] in the "
                         "case file")
    if results.parameter is not None:
        raise ValueError(f"{path}: is over {results.parameter_name}; wanted is a response over the frequency, whose points are motions of "
                         "the case as it stands")
    results.need_points()
    if tomllib.loads(results.case).get("damping", {}).get("structural"):
        raise ValueError(f"{path}: damping.structural of its case has no motion in time that could be stable; use damping.stiffness")


def chosen_points(results, at, hz):
    """Points nearest to the frequencies `at`, in the unit of the model or in Hz; else those of the peaks, or the largest."""
    if not at:
        response = results.response(contact_dofs(results)[0])
        peaks = np.union1d(curves.maxima(response.amplitude, response.jumps), response.located).astype(int)
        return peaks.tolist() or [response.largest_point()]
    return [results.at(value_at(results, value, hz)) for value in at]


def head(results, hz, whole):
    """Lines above the table."""
    wave, unit = results.wave, "Hz" if hz else results.unit.omega
    return [f"{results.path}: {wave.sectors} sectors, engine order {wave.engine_order}; the wave against small motions of all nodal "
            "diameters", "  multiplier: by how much the motion grows in a period that dies out last, or grows fastest; then its nodal "
            "diameters",
            f"  {f'frequency [{unit}]':>17}  point  wave       multiplier  {'nodal diameters':<26}"
            + ("  whole wheel  multiplier  moved" if whole else "")]


def row(results, point, found, hz):
    frequency = results.frequency[point] if hz else results.omega[point]
    place = f"  {frequency:17.7g}  {point:5d}  "
    if found is None:
        return place + f"{'see whole':<9}  {'':10}  {'':<26}"
    shares = [f"{h} ({100 * found.share[h]:.0f} %)" for h in np.argsort(-found.share) if found.share[h] > SHOWN]
    return place + f"{verdict(found.multiplier):<9}  {found.multiplier:10.4f}  {', '.join(shares):<26}"


def verdict(multiplier):
    return "stable" if multiplier < 1 - UNSURE else "unstable" if multiplier > 1 + UNSURE else "uncertain"


def of_whole(told):
    if told.multiplier is None:
        return f"  {'too large':<11}  {'':10}  {told.moved:.0e}"
    return f"  {WORDS.get(told.stable, 'uncertain'):<11}  {told.multiplier:10.4f}  {told.moved:.0e}"
