"""A measured backbone, and what a fit makes of it: runs of the mode which go exactly to the measured amplitudes."""

import copy
import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from .case_runs import motion_of
from .fit_search import MISSED, Search, changes_of
from .measured import read_backbone
from .ranges_mode import ModeCase
from .study_runs import CaseFile, RunFailed, toml
from .units import with_unit

NAMES = {"omega": "frequency", "damping_ratio": "damping"}  # in the order of passages
MET = 1e-5  # distance of a computed from a measured amplitude, as a logarithm, where nothing is left to interpolate
ROUNDS = 5  # runs of one set of factors at most, each begun with the modal amplitudes that the one before has found
SAME = 1e-9  # of two modal amplitudes, as a logarithm
ROOM = (0.5, 1.1)  # of the least and the largest of them: where a run begins and ends, so that measured ones lie inside
DRAWN = 60  # amplitudes of the curve that is drawn
LEAST_DAMPING = 0.1  # of what was measured: less is none, as of a case without damping whose points stick
USUAL = {"omega": 0.01, "damping_ratio": 1.0}  # 0.1 % of a frequency are met as well as 10 % of a damping ratio
NOT_MET = {"omega": MISSED * USUAL["omega"], "damping_ratio": -np.log(LEAST_DAMPING)}


@dataclass
class FittedBackbone:
    """A measured backbone beside the mode.

    measured : MeasuredBackbone
    model : by its quantities, (m,) values of the fit at the measured amplitudes, NaN where there are none
    misfit : by its quantities, root mean square of the relative errors
    beyond : (case, measured) amplitudes, where the second reach beyond the first, else None
    curve, start : `ModeRuns.curve` of the fit and of the case as it stands
    """

    file: Path
    measured: object
    model: dict
    misfit: dict
    beyond: tuple | None
    curve: tuple
    start: tuple


class BackboneCase(ModeCase):
    """A case with [mode] whose amplitude is watched; `at`: modal amplitudes wanted exactly, where a run is not given others."""

    def __init__(self, path, watch=None):
        super().__init__(path)
        self.watch = watch or CaseFile(path).content.get("continuation", {}).get("watch")
        self.at = None

    def text(self, folder, contact=None, changes=None, watch=None, sensitivity=False, at=None, path=None):
        """As `CurveCase.text`."""
        content, head = self.changed(folder, contact, changes)
        at = self.at if at is None else at
        if at is not None:
            content["mode"] |= {"amplitude": [ROOM[0] * min(at), ROOM[1] * max(at)], "at": list(at)}
            content["mode"].pop("to_force", None)
        if watch:
            content["continuation"]["watch"] = watch
        if "model" in content:
            content["output"] = {"motion": motion_of(watch)}
        return head + toml(content)


class ModeRuns:
    """Runs of the mode by the logarithms x of factors, with points at the measured amplitudes.

    A case names modal amplitudes, which move what is watched by as much as its parameters say: they are found round by round, begun with
    those of the nearest x.
    """

    def __init__(self, runs, unknowns, amplitude, harmonic):
        self.runs, self.unknowns, self.amplitude, self.harmonic = runs, unknowns, amplitude, harmonic
        self.key = f"fit, harmonic {harmonic}, amplitudes {hashlib.sha256(amplitude.tobytes()).hexdigest()}"
        self.first, self.seen, self.count = None, {}, 0  # `first`: modal amplitudes with which the first run begins

    def curve(self, results):
        """(n,) amplitude of what is watched, modal amplitude, omega and damping ratio of a run, where it moves."""
        response = results.response(self.runs.dof)
        size = response.amplitude if self.harmonic is None else response.harmonic(self.harmonic)
        return tuple(values[size > 0] for values in (size, results.modal_amplitude, results.omega, results.damping_ratio))

    def digest(self, results):
        return passages(self.amplitude, *self.curve(results))

    def records(self, places):
        """For some x: `passages`, with `status`."""
        keys = [tuple(np.round(x, 12).tolist()) for x in places]
        missing = [key for key in dict.fromkeys(keys) if key not in self.seen]
        at, best, left = {key: self._near(key) for key in missing}, {}, missing
        size = len(self.runs.contact["law"])
        for _ in range(ROUNDS):
            found = self.runs.each([changes_of(self.unknowns, np.exp(key), size) for key in left], self.digest,
                                   each_at=[at[key] for key in left], key=self.key)
            self.count += len(left)
            for key, record in zip(left, found):
                if record["status"] == 0 or key not in best:
                    best[key] = record
            left = [key for key, record in zip(left, found) if record["status"] == 0 and record["off"] > MET]
            at |= {key: best[key]["at"] for key in left}
            if not left:
                break
        self.seen |= best
        return [self.seen[key] for key in keys]

    def _near(self, key):
        """Modal amplitudes of the nearest x with any."""
        there = [x for x, record in self.seen.items() if record["status"] == 0 and record["at"]]
        return self.seen[min(there, key=lambda x: np.linalg.norm(np.subtract(x, key)))]["at"] if there else self.first


def passages(wanted, size, alpha, omega, zeta):
    """Of amplitudes (m,) on a curve: `passes`, for each a list of (omega, damping ratio), one wherever the curve passes it; `at`, modal
    amplitudes there, in proportion where the curve does not come; `off`, how far points are from them at most, as a logarithm.

    Between points by cubics without overshoot. Nothing is known of a curve of no point.
    """
    if not len(size):
        return {"passes": [[] for _ in wanted], "at": [], "off": 0.0}
    logs, places = np.log(size), np.log(wanted)
    table, passes, at = np.column_stack([np.log(alpha), omega, zeta]), [[] for _ in wanted], []
    for piece in monotone(logs):
        own, order = logs[piece], np.argsort(logs[piece])
        curve = PchipInterpolator(own[order], table[piece][order])
        for values, place in zip(passes, places):
            if own.min() - MET <= place <= own.max() + MET:
                there, *numbers = curve(np.clip(place, own.min(), own.max())).tolist()
                values.append(numbers)
                at.append(there)
    near = np.abs(logs - places[:, None])
    at += [table[i, 0] + place - logs[i] for i, place, values in zip(near.argmin(axis=1), places, passes) if not values]
    at = np.sort(at)
    return {"passes": passes, "at": np.exp(at[np.diff(at, prepend=-np.inf) > SAME]).tolist(), "off": float(near.min(axis=1).max())}


def monotone(values):
    """Numbers of the points of each piece that only rises or only falls."""
    points = np.flatnonzero(np.diff(values, prepend=np.nan) != 0)
    rising = np.diff(values[points]) > 0
    ends = [0, *(np.flatnonzero(rising[1:] != rising[:-1]) + 1), len(points) - 1]
    return [points[a:b + 1] for a, b in zip(ends, ends[1:]) if b > a]


class BackboneSearch(Search):
    """Of one quantity of a backbone, `omega` or `damping_ratio`."""

    def __init__(self, mode, quantity, wanted):
        super().__init__(mode.unknowns, wanted, NAMES[quantity])
        self.mode, self.quantity, self.usual, self.missed = mode, quantity, USUAL[quantity], NOT_MET[quantity]

    def records(self, places):
        return self.mode.records(places)

    def passes(self, record):
        column = list(NAMES).index(self.quantity)
        least = LEAST_DAMPING * self.wanted if self.quantity == "damping_ratio" else 0 * self.wanted
        return [[values[column] for values in each if values[column] >= low] for each, low in zip(record["passes"], least)]


class BackboneToFit:
    """The measured file, and a search for each of its quantities."""

    def __init__(self, runs, results, unknowns, file, harmonic):
        self.runs, self.file, self.measured = runs, file, read_backbone(file, results.unit)
        count = len(self.measured.amplitude) * len(self.measured.quantities)
        if count <= len(unknowns):
            raise ValueError(f"{file}: has {count} values, {len(unknowns)} parameters need more than that")
        self.mode = ModeRuns(runs, unknowns, self.measured.amplitude, harmonic)
        self.beyond = outside(file, self.measured.amplitude, runs, results, self.mode.curve(results)[0])
        self.mode.first = self.mode.digest(results)["at"]
        self.searches = [BackboneSearch(self.mode, name, values) for name, values in self.measured.quantities.items()]

    @property
    def count(self):
        """Of runs."""
        return self.mode.count

    def outcome(self, x, changes, misfits):
        """What a `Fit` has of it: `backbone`."""
        [record] = self.mode.records([x])
        return {"backbone": FittedBackbone(self.file, self.measured, {one.quantity: one.values(x) for one in self.searches},
                                           {one.quantity: misfit for one, misfit in zip(self.searches, misfits)}, self.beyond,
                                           self._drawn("fitted", changes, record["at"]), self._drawn("case_1", {}, self.mode.first))}

    def _drawn(self, name, changes, at):
        """`ModeRuns.curve` of a run that is kept, with points enough."""
        own = copy.copy(self.runs)
        own.case = copy.copy(own.case)
        own.case.at = np.geomspace(at[0], at[-1], DRAWN).tolist()
        run, results = own.whole(name, changes)
        if results is None:
            raise RunFailed(f"{own.folder / name}: the mode could not be computed: {run.reason}")
        return self.mode.curve(results)


def outside(file, measured, runs, results, size):
    """(case, measured) amplitudes where the second reach beyond what the mode of the case does, else None; refuses two without overlap.

    A mode that is linear where it begins is known below, too.
    """
    dof, unit = runs.dof, results.unit_of(runs.dof)
    if len(size) < 2:
        raise ValueError(f"{runs.case.path}: the mode does not move {dof}; watch another unknown or node, or another harmonic")
    linear = not results.contact_activity(0).events.any() and results.points("slip")[0] == 0
    low, high = 0.0 if linear else size.min(), size.max()
    if measured[0] > high or measured[-1] < low:
        raise ValueError(f"{file}: measured at amplitudes {measured[0]:.6g} to {measured[-1]:.6g}, {runs.case.path}: with mode.amplitude "
                         f"{runs.case.content['mode']['amplitude']} {dof} moves by {size.min():.6g} to "
                         f"{with_unit(f'{high:.6g}', unit)}: wanted are amplitudes that the mode of the case has")
    return None if low <= measured[0] and measured[-1] <= high else ((low, high), (measured[0], measured[-1]))
