"""The table of peaks over the force that one nonlinear mode gives: `python3 -m dovetail peaks RESULTS.h5`."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .mode_picture import from_onset
from .modes import Backbone, Motion
from .motion import row_of
from .output_files import made
from .reference import OPEN, contact_coefficients, law, synthesis
from .results import Results
from .units import bracket

STEPS = (1, 2, 5)  # of forces in a decade, where none are given
SEARCHED = 0.5  # damping ratios to either side of a peak, where the solved one is looked for
NARROW = 1e-4  # damping ratio that counts at least, there
SHARP = 0.01  # of such a width: how closely the frequency of a solved peak is known
NOTHING = 1e-9  # of what its forces might dissipate: a point at its bound that does no more slips by round-off alone
SOLVED = 16  # frequencies, at most


@dataclass(frozen=True)
class Peak:
    """A peak under a force, a factor on the loads of the case.

    amplitude : half the peak-to-peak of the unknown; omega : excitation frequency; damping_ratio : of the mode at that amplitude
    open, slip : shares of the contact points that are open at some time of the period, and of others that slip at some time
    friction_energy : what all contacts dissipate in a period
    error : relative, of the amplitude: estimated, or, of a solved peak, what the mode alone was off by; NaN where it is not known
    separate : whether it lies on a curve apart from the one that begins at rest
    """

    force: float
    amplitude: float
    omega: float
    damping_ratio: float
    slip: float
    open: float
    friction_energy: float
    error: float
    separate: bool


def peaks(arguments):
    """The command: prints the table, and writes it as text and csv."""
    results = Results(arguments.file, arguments.model)
    path = Path(arguments.output) if arguments.output else results.path.with_name(f"{results.path.stem}_peaks.csv")
    if path.suffix != ".csv":
        raise ValueError(f"{path}: the table is written as FILE.csv, and as text beside it")
    backbone = Backbone.read(results)
    dof = arguments.dof or results.watched
    harmonic = backbone.excited if arguments.harmonic is None else arguments.harmonic
    backbone.levels(harmonic)  # refuses a load that does no work
    if wrong := [force for force in arguments.force or () if not 0 < force < np.inf]:
        raise ValueError(f"--force: factors on the loads of the case are finite and greater than 0, found {wrong[0]:g}")
    forces = sorted(set(arguments.force)) if arguments.force else usual_forces(backbone, harmonic)
    rows, missing = table(backbone, row_of(results, dof), forces, harmonic, arguments.refine)
    if not rows:
        raise ValueError(f"{results.path}: none of these forces has a peak on the mode; its peaks are those of "
                         f"{' to '.join(f'{force:.4g}' for force in reach(backbone, harmonic))} times the load")
    text = "\n".join(in_words(rows, missing, results, dof, arguments.hz, arguments.refine))
    write(rows, made(path), results, dof, arguments.hz)
    made(path.with_suffix(".txt")).write_text(text + "\n")
    print(f"{text}\n\n{path}, {path.with_suffix('.txt')}")


def reach(backbone, harmonic=1):
    """Least and largest force whose peak the backbone has."""
    levels = backbone.levels(harmonic)[1]
    return float(levels.min()), float(levels.max())


def usual_forces(backbone, harmonic=1):
    """1, 2, 5, 10, ... times a power of ten: one at which the joint still sticks, if that is known, and all above that are reached."""
    _, most = reach(backbone, harmonic)
    least = float(np.interp(from_onset(backbone), backbone.grid, backbone.levels(harmonic)[1]))
    forces = np.array([step * 10.0**decade for decade in range(int(np.floor(np.log10(least))) - 1, int(np.ceil(np.log10(most))) + 1)
                       for step in STEPS])
    begin = np.flatnonzero(forces <= least)[-1] if backbone.linear_below else np.flatnonzero(forces >= least)[0]
    return [float(f"{force:.12g}") for force in forces[begin:] if force <= most]


def table(backbone, row, forces, harmonic=1, refined=False):
    """Peaks under these forces, and those of the forces under which a curve has none on what the backbone reaches.

    `refined`: by the true equations, solved near each peak. Where that fails, the peak is the mode's, with error NaN.
    """
    found, missing = [], []
    for force in forces:
        tops = backbone.tops(row, force, harmonic)
        if all(number for number, _ in tops) or any(motion is None for _, motion in tops):
            missing.append(force)
        for number, motion in tops:
            if motion is not None:
                if refined:
                    solved, error = _refined(backbone, motion, row)
                else:
                    solved, error = motion, backbone.error(motion, row) if backbone.judges else np.nan
                found.append(Peak(force, solved.amplitude(row), solved.omega, backbone.at(motion.alpha)[1], *activity(backbone, solved),
                                  error, number > 0))
    return found, missing


def _refined(backbone, motion, row):
    """The solved peak, and by how much the mode was off; the motion itself and NaN where none is found near it."""
    backbone.under(motion.force)  # refuses equations that are too large
    try:
        solved = solved_peak(backbone, motion, row)
    except (ValueError, RuntimeError, np.linalg.LinAlgError):  # no maximum, or Newton's method leads nowhere
        return motion, np.nan
    return solved, abs(motion.amplitude(row) / solved.amplitude(row) - 1)


def activity(backbone, motion):
    """(slip, open, friction energy) of a `Peak`, of a motion."""
    system, contact, preload = backbone.system, backbone.system.contact, backbone.system.preload
    X = system.contact_part(motion.coefficients)
    x = np.swapaxes(synthesis(X, system.N), -1, -2)
    _, state = law(x, preload.xp, preload.w, contact.kn, contact.kt, contact.mu, contact.gap, contact.kind)
    opens = (state == OPEN).any(axis=(1, 2))
    G, k = contact_coefficients(X, contact, preload, system.N), np.arange(1, system.H + 1)
    energy = np.pi * np.sum(k * (G[..., 1::2] * X[..., 2::2] - G[..., 2::2] * X[..., 1::2]), axis=(1, 2))
    most = np.pi * np.sum(k * np.hypot(G[..., 1::2], G[..., 2::2]) * np.hypot(X[..., 1::2], X[..., 2::2]), axis=(1, 2))
    slips = (abs(state) == 1).any(axis=(1, 2)) & (energy > NOTHING * most) & ~opens
    points = max(contact.points, 1)
    return slips.sum() / points, opens.sum() / points, max(float(energy.sum()), 0.0)


def solved_peak(backbone, motion, row):
    """The solution of the true equations with the largest amplitude of an unknown near a motion at a peak: parabolas through the highest
    of those solved, by Newton's method, and their neighbours. Raises ValueError where the amplitude has no maximum there."""
    system, solved = backbone.under(motion.force), {}
    width = SEARCHED * max(backbone.at(motion.alpha)[1], NARROW) * motion.omega

    def solve(omega):
        near = sorted(solved, key=lambda other: abs(other - omega))[:2]
        start = solved[near[0]].coefficients if near else motion.coefficients
        if len(near) == 2:
            start = start + (omega - near[0]) / (near[1] - near[0]) * (solved[near[1]].coefficients - start)
        solved[omega] = Motion(float(omega), motion.alpha, motion.force, system.solve(omega, start))

    for i in (0, -1, 1):
        solve(motion.omega + i * width)
    for _ in range(SOLVED):
        omegas = np.array(sorted(solved))
        amplitudes = np.array([solved[omega].amplitude(row) for omega in omegas])
        i = int(np.argmax(amplitudes))
        if not 0 < i < len(omegas) - 1:
            solve(omegas[i] + (width if i else -width))
            continue
        place, size = omegas[i - 1:i + 2] - omegas[i], amplitudes[i - 1:i + 2]
        bend, slope, _ = np.polyfit(place, size, 2)
        step = -slope / (2 * bend)
        if abs(step) < SHARP * width:
            return solved[omegas[i]]
        solve(omegas[i] + step)
    raise ValueError(f"force {motion.force:g}: the amplitude has no maximum near frequency {motion.omega:g}")


def columns(results, dof, hz):
    """Headers with units, and what each shows of a `Peak`."""
    unit = results.unit
    return {"force": lambda row: row.force, "amplitude" + bracket(results.unit_of(dof)): lambda row: row.amplitude,
            "frequency" + bracket("Hz" if hz else unit.omega): lambda row: unit.hertz(row.omega) if hz else row.omega,
            "damping ratio": lambda row: row.damping_ratio, "slipping": lambda row: row.slip, "open": lambda row: row.open,
            "friction energy" + bracket(unit.energy): lambda row: row.friction_energy, "error": lambda row: row.error}


def in_words(rows, missing, results, dof, hz=False, refined=False):
    """Lines of the table."""
    shown = columns(results, dof, hz)
    in_percent = ("damping ratio", "slipping", "open", "error")
    heads = [name + " [%]" if name in in_percent else name for name in shown]
    widths = [max(len(head), 10) + 2 for head in heads]
    lines = [f"{results.path}" + (f": {results.title}" if results.title else ""),
             f"peaks of {dof} by one nonlinear mode" + (", solved from there: the error is what the mode was off by" if refined else ""),
             "".join(f"{head:>{width}}" for head, width in zip(heads, widths))]
    for row in rows:
        cells = []
        for name, value in ((name, value(row)) for name, value in shown.items()):
            if not np.isfinite(value):
                cells.append("-")
            elif name == "force":
                cells.append(f"{value:g}")
            else:
                cells.append(f"{100 * value:.3g}" if name in in_percent else f"{value:.5g}")
        lines.append("".join(f"{cell:>{width}}" for cell, width in zip(cells, widths)) + "  a separate curve" * row.separate)
    if unsolved := [f"{row.force:g}" for row in rows if refined and np.isnan(row.error)]:
        lines.append(f"not solved, and as the mode has it, without an error: no solution with a peak was found near it under "
                     f"{', '.join(unsolved)} times the load")
    shown = {row.force for row in rows}
    for forces, what in (([force for force in missing if force not in shown], "no peak on what"),
                         ([force for force in missing if force in shown], "further peaks beyond what")):
        if forces:
            lines.append(f"{what} the mode reaches under {', '.join(f'{force:g}' for force in forces)} times the load")
    return lines


def write(rows, path, results, dof, hz=False):
    """The table as csv, shares and errors as plain numbers."""
    shown = columns(results, dof, hz)
    with open(path, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow([*shown, "separate"])
        for row in rows:
            table.writerow([*(f"{value(row):.9g}" for value in shown.values()), int(row.separate)])
