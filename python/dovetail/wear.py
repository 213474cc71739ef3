"""Wear that changes the joint it comes from: blocks of cycles between runs, the worn depth added to the gap of every contact point."""

import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .case_changes import need
from .case_runs import CaseRuns, CurveCase, largest_peak
from .contact_period import LEAST, contact_period
from .hdf5_read import numbers, opened
from .study_runs import Program, RunFailed
from .units import SIZES, with_unit
from .watch import span
from .wear_report import write

EQUAL = 1e-9  # frequencies, relative
NOTHING = 1e-3  # of the fastest point's rate: slower ones do not choose the block
COEFFICIENTS = {"m^3/J": 1.0, "m^3/Nm": 1.0, "mm^3/J": 1e-9, "mm^3/Nm": 1e-9, "m^2/N": 1.0, "mm^2/N": 1e-6, "1/Pa": 1.0, "1/MPa": 1e-6,
                "1/GPa": 1e-9}  # in m^3/J


@dataclass(frozen=True)
class Moment:
    """The joint after some cycles: `depth` (N_x,) worn off, `energy` (N_x,) that friction takes in a period, `rate` (N_x,) of the depth
    per cycle; `amplitude` of what is watched at frequency `omega`, `clamp`, the sum of the normal forces at rest. `block`: cycles that
    are worn off at this rate."""

    cycles: float
    block: float
    depth: np.ndarray
    energy: np.ndarray
    rate: np.ndarray
    amplitude: float
    omega: float
    clamp: float


@dataclass(frozen=True)
class Worn:
    """All that `wear` finds. `results`: of the case as it stands; area (N_x,), per_work (N_x,): volume that a unit of friction work takes
    away; `at` is None where the motion is that of the peak."""

    results: object
    dof: str
    at: float | None
    share: float
    area: np.ndarray
    per_work: np.ndarray
    moments: list

    @property
    def volume(self):
        """(n,) worn off at each moment."""
        return np.array([self.area @ moment.depth for moment in self.moments])


def wear(arguments):
    """The command: refuses wrong input, runs what has not been run, writes and prints the report."""
    if arguments.archard is None and arguments.energy_wear is None:
        raise ValueError("how much wears off is wanted: --archard K UNIT, volume per load and sliding distance, or --energy-wear K UNIT, "
                         "volume per friction work, as --archard 1e-15 1/Pa")
    option, words = ("archard", arguments.archard) if arguments.archard else ("energy-wear", arguments.energy_wear)
    number, unit = read_coefficient(option, words)
    if not arguments.cycles > 0:
        raise ValueError(f"--cycles {arguments.cycles:g}: must be greater than 0")
    if not arguments.share > 0:
        raise ValueError(f"--share {arguments.share:g}: must be greater than 0")
    case = CurveCase(arguments.case, watch=arguments.watch)
    program = Program(arguments.binary)
    program.check(case.path)
    out = Path(arguments.out) if arguments.out else case.path.with_name(case.path.stem + "_wear")
    runs, found = CaseRuns(case, program, out), None
    try:
        results = runs.begin()
        per_work = coefficients(results, option, number * in_units(unit, results.unit))
        found = Worn(results, runs.dof, arguments.at, arguments.share, areas(results), per_work, [])
        for moment in moments(runs, found, arguments.cycles):
            found.moments.append(moment)
    except KeyboardInterrupt:
        raise RunFailed(f"broken off; what was computed is in {out}, and the same command goes on from there") from None
    finally:
        if found and found.moments:  # also those before a run that failed
            write(found, out)


def read_coefficient(option, words):
    """(number, unit) of the two words behind an option."""
    try:
        number = float(words[0])
    except ValueError:
        number = np.nan
    if not (np.isfinite(number) and number > 0):
        raise ValueError(f"--{option} {' '.join(words)}: a number greater than 0 and its unit are wanted, as 1e-15 1/Pa")
    if words[1] not in COEFFICIENTS and words[1] != "model":
        raise ValueError(f"--{option} {' '.join(words)}: {words[1]} is no unit of wear; {', '.join(COEFFICIENTS)} are, and \"model\" for "
                         "that of the model, its area over its force")
    return number, words[1]


def in_units(unit, of_model):
    """One of a unit of wear, in units of the model."""
    if unit == "model":
        return 1.0
    if not of_model.known:
        raise ValueError(f"the units of the model are not known, so {unit} has no number in them; give the wear in units of the model, and "
                         "write model in place of the unit")
    length = SIZES["length"][of_model.length]
    force = SIZES["force"].get(of_model.force) or SIZES["mass"][of_model.mass] * length / of_model.seconds**2
    return COEFFICIENTS[unit] * force / length**2


def coefficients(results, option, number):
    """(N_x,) volume per friction work; of Archard's number per load and distance it is that over the friction."""
    contact = results.contact
    need("friction", contact)
    friction = np.where((contact["law"] <= 1)[:, None], contact["friction"], 0.0)
    if not friction.any():
        raise ValueError("friction is 0 at all contact points: they do no friction work, and nothing tells how far they slide")
    if option != "archard":
        return np.full(len(friction), number)
    if np.any(friction[:, 0] != friction[:, 1]):
        raise ValueError("--archard: the friction of a contact point differs between its directions, so the work does not tell the "
                         "distance; give --energy-wear, volume per friction work")
    return number / np.where(friction[:, 0] > 0, friction[:, 0], np.inf)


def areas(results):
    """(N_x,) of the contact points."""
    with opened(results.reduced) as file:
        area = numbers(file, "contact/area", (results.contact_points,)) if "contact/area" in file else np.zeros(1)
    if not np.all(area > 0):
        raise ValueError(f"{results.reduced}: the areas of its contact points are not known, so wear gives no depth")
    return area


def moments(runs, found, cycles):
    """Moment after Moment, up to so many cycles. Each is a run with the gaps of that time, which is kept."""
    hertz = runs.case.content["continuation"].get("unit") == "Hz"
    omega = found.at if found.at is None or not hertz else found.results.unit.from_hertz(found.at)
    done, depth, began = 0.0, np.zeros(len(found.area)), time.monotonic()
    while True:
        at = None if found.at is None else [found.at]
        record = runs.each([{"gap": ("offset", depth)}], lambda results: digest(results, runs.dof, omega), at=at)[0]
        if record["status"] != 0 or record["energy"] is None:
            raise RunFailed(f"{runs.case.path}: after {done:.6g} cycles: " + (record["reason"] or _nothing(runs, found)))
        energy, pressed = np.array(record["energy"]), np.array(record["pressed"])
        rate = found.per_work * energy / found.area
        wearing = rate > NOTHING * rate.max()
        if not wearing.any() and done == 0:
            raise ValueError(f"{runs.case.path}: no contact point slips at that motion, so nothing wears; a larger load, or another "
                             "frequency (--at), may make some slip")
        block = cycles - done if not wearing.any() else min(cycles - done, found.share * np.min(pressed[wearing] / rate[wearing]))
        yield Moment(done, block, depth, energy, rate, *(record[name] for name in ("amplitude", "omega", "clamp")))
        if block <= 0:
            return
        depth = depth + block * rate
        done = cycles if block == cycles - done else done + block
        seconds = time.monotonic() - began
        left = f", about {span(seconds * (cycles / done - 1))} left" if done < cycles else ""
        print(f"wear: {done:.4g} of {cycles:.4g} cycles, depth at most {with_unit(f'{depth.max():.4g}', found.results.unit.length)}, "
              f"{seconds:.1f} s{left}", file=sys.stderr, flush=True)


def _nothing(runs, found):
    return (f"{runs.dof} has no peak inside the sweep: widen continuation.omega, or name a frequency with --at" if found.at is None else
            f"the curve has no point at --at {found.at:g}; it must lie within continuation.omega")


def digest(results, dof, omega):
    """What the wear of a motion depends on, to be kept: that of the largest peak, or the largest at a frequency. `energy` is None where
    there is none. `pressed`: how far each point is pressed in at most over the period."""
    response = results.response(dof)
    if omega is None:
        there = [results.peak_point(dof)] if largest_peak(results, dof)["peak"] else []
    else:
        there = np.flatnonzero(np.abs(response.omega - omega) <= EQUAL * omega)
    if not len(there):
        return {"energy": None}
    point = int(max(there, key=lambda i: response.amplitude[i]))
    normal = contact_period(results, point, LEAST).force[:, :, 2].max(axis=1)
    return {"amplitude": float(response.amplitude[point]), "omega": float(response.omega[point]),
            "clamp": float(results.g.reshape(-1, 3)[:, 2].sum()), "pressed": (normal / results.contact["normal_stiffness"]).tolist(),
            "energy": np.maximum(results.contact_activity(point).dissipation, 0.0).tolist()}
