"""What ranges of parameters make of a nonlinear mode: bands of frequency, damping ratio and force level over its amplitude."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from .case_changes import apply, need, need_damping, without_model
from .case_runs import COPY, OTHER_LOAD, PRELOADED, CaseRuns, load_in_words
from .ranges import spread
from .study_runs import RunFailed, UserCase, toml

AMPLITUDES = 201  # at which bands are drawn, evenly in the logarithm
COLUMNS = ("omega", "damping_ratio", "force_level")  # of /points, over the modal amplitude
REFUSED = ("omega", "watch", "until_peak", "track", "sliders")  # options of ranges of a peak


class ModeCase(UserCase):
    """A case with [mode], whose mode is followed again with changed parameters.

    reach : (from, to), the modal amplitudes of all runs but the first, which goes as far as the case says
    """

    MODE = True
    watch = None

    def __init__(self, path):
        super().__init__(path)
        for section in ("output", "stability", "accuracy"):
            self.content.pop(section, None)
        unit = self.content.get("continuation", {}).get("unit")
        self.content["continuation"] = {"unit": unit} if unit else {}
        self.content["mode"].pop("at", None)
        self.reach = None

    def text(self, folder, contact=None, changes=None, watch=None, sensitivity=False, at=None, path=None):
        """As `CurveCase.text`."""
        content, head = self.changed(folder, contact, changes)
        if "model" in content:
            content["output"] = {"motion": []}
        return head + toml(content)

    def changed(self, folder, contact, changes):
        """(content, what stands above it)."""
        content, head = self.moved(folder), COPY
        if self.reach is not None:
            content["mode"]["amplitude"] = [float(end) for end in self.reach]
            content["mode"].pop("to_force", None)
        if changes:
            content = apply(content, contact, changes)
        if changes and OTHER_LOAD & set(changes):
            content, head = without_model(content, contact, PRELOADED), COPY + load_in_words(changes)
        return content, head


@dataclass
class ModeRanges:
    """All that is found. alpha : (m,) modal amplitudes; `middle`, entries of `curves` (name -> [(number, record), ...]) and `samples` are
    records with `status`, `reason` and, of each of COLUMNS, a list over alpha, None where the mode does not come."""

    case: object
    ranges: list
    each_point: bool
    seed: int
    unit: object
    alpha: np.ndarray
    middle: dict
    curves: dict
    samples: list

    def values(self, name, records=None):
        """(n, m) of the samples, or of other records, that did not fail."""
        records = self.samples if records is None else records
        return np.array([record[name] for record in records if record["status"] == 0], dtype=float).reshape(-1, len(self.alpha))


def follows_mode(path):
    """Whether a case follows a nonlinear mode; what else is wrong with it is for others to say."""
    try:
        return bool(tomllib.loads(Path(path).read_text(encoding="utf-8-sig")).get("mode"))
    except (OSError, tomllib.TOMLDecodeError, UnicodeDecodeError):
        return False


def over_amplitude(results, alpha):
    """(m,) lists of each of COLUMNS at modal amplitudes, between points by cubics without overshoot over their logarithm, force levels by
    theirs; None where the mode does not come. One that turns back counts up to its fold, and from where it comes beyond."""
    own, found = results.modal_amplitude, {}
    rising = np.concatenate([[True], own[1:] > np.maximum.accumulate(own)[:-1]]) if len(own) else np.zeros(0, bool)
    own = own[rising]
    for name in COLUMNS:
        values, here = results.points(name)[rising], np.full(len(alpha), np.nan)
        if len(own) > 1 and np.all(np.isfinite(values)) and (name != "force_level" or values.min() > 0):
            known = (alpha >= own[0] * (1 - 1e-9)) & (alpha <= own[-1] * (1 + 1e-9))
            there = np.log(np.clip(alpha[known], own[0], own[-1]))
            by_log = name == "force_level"  # in proportion to the amplitude, where all sticks
            table = PchipInterpolator(np.log(own), np.log(values) if by_log else values)
            here[known] = np.exp(table(there)) if by_log else table(there)
        found[name] = [float(value) if np.isfinite(value) else None for value in here]
    return found


def mode_ranges(arguments, given, program):
    """The command for a case with [mode]: runs what has not been run, writes and prints the report."""
    from .ranges_mode_report import write

    for option in REFUSED:
        if getattr(arguments, option):
            raise ValueError(f"--{option.replace('_', '-')} is for peaks of a curve; {arguments.case} follows a nonlinear mode ([mode])")
    case = ModeCase(arguments.case)
    if any(wanted.name == "damping" for wanted in given):
        need_damping(case.content)
    program.check(case.path)
    out = Path(arguments.out) if arguments.out else case.path.with_name(case.path.stem + "_range")
    try:
        found = computed(CaseRuns(case, program, out, arguments.jobs), given, arguments.samples, arguments.along, arguments.seed,
                         arguments.each_point)
    except KeyboardInterrupt:
        raise RunFailed(f"broken off; what was computed is in {out}, and the same command goes on from there") from None
    write(found, out)


def computed(runs, given, samples, along, seed, each_point=False):
    """The ModeRanges of a CaseRuns of a ModeCase; `given`: Ranges."""
    results = runs.begin()
    runs.dof = "a1"  # nothing is watched
    for wanted in given:
        need(wanted.name, runs.contact)
        if wanted.name == "preload":
            runs.need_preload()
    runs.case.reach = results.modal_amplitude.min(), results.modal_amplitude.max()
    alpha = np.geomspace(*runs.case.reach, AMPLITUDES)

    def digest(results):
        return over_amplitude(results, alpha)

    def changes(places):
        return {wanted.name: (wanted.kind, wanted.at(places.get(wanted.name, 0.0))) for wanted in given}

    middle = runs.each([changes({})], digest, "middle of the ranges")[0]
    if middle["status"] != 0:
        raise RunFailed(f"{runs.case.path}: in the middle of the ranges it failed: {middle['reason']}")
    curves = {}
    for wanted in given if along else ():
        xi = np.linspace(-1, 1, along)
        records = runs.each([changes({wanted.name: place}) for place in xi], digest, f"over {wanted.name}")
        curves[wanted.name] = [(wanted.at(place), record) for place, record in zip(xi, records)]
    places = spread(given, samples, seed, len(runs.contact["law"]) if each_point else 0)
    drawn = runs.each([changes(place) for place in places], digest, "samples")
    return ModeRanges(runs.case, given, each_point, seed, results.unit, alpha, middle, curves, drawn)
