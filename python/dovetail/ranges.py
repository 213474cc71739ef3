"""What ranges of parameters make of a peak: first order, curves over one parameter, samples of all of them."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .case_changes import CONTACT, FACTORS, NAMES, Range, contact_values, need, need_damping, split
from .case_runs import CaseRuns, CurveCase, has_peak, largest_at, largest_peak
from .curves import is_reduced
from .peak_tracks import follow
from .ranges_report import write
from .slider_states import slider_states, sticking
from .sobol import sobol
from .study_runs import Program, RunFailed

SAMPLES = 128  # a power of two suits Sobol's points
ALONG = 9  # points of a curve over one parameter, both ends included
FREQUENCIES = 201  # at which the band of the curves is drawn
STEP = 0.02  # of xi, for slopes by differences
NOISE = 1e-6  # relative, beneath which differences of peaks say nothing


@dataclass
class FirstOrder:
    """Slopes of the largest peak by xi at the middle of all ranges.

    amplitude, omega : dicts name -> slope, or (N_x,) where every point has its own number
    by : dict name -> "sensitivity" or "differences"
    change, second : of the amplitude from the middle to the farthest corner along the gradient, by first order, and half the second
        difference of the peaks there and opposite; NaN where one of them is no peak, and where the gradient is 0
    seconds : dict name -> half the second difference of the peaks at both ends of this range alone
    noise : of an amplitude, as far as peaks are computed
    """

    amplitude: dict = field(default_factory=dict)
    omega: dict = field(default_factory=dict)
    by: dict = field(default_factory=dict)
    change: float = np.nan
    second: float = np.nan
    seconds: dict = field(default_factory=dict)
    noise: float = 0.0

    def at(self, middle, places, of="amplitude"):
        """Of the peak, for a dict of places xi."""
        return middle + sum(float(np.sum(slope * places[name])) for name, slope in getattr(self, of).items())

    def deviation(self, of="amplitude"):
        """Standard deviation for places evenly spread from -1 to 1."""
        return float(np.sqrt(sum(np.sum(np.square(slope)) for slope in getattr(self, of).values()) / 3))

    @property
    def meaningless(self):
        return bool(self.second > abs(self.change) or self.bent)

    @property
    def flat(self):
        """Whether there are slopes, and all are 0."""
        return bool(self.amplitude) and max(np.abs(slope).max() for slope in self.amplitude.values()) == 0

    @property
    def bent(self):
        """Names of the parameters whose own second difference exceeds their slope."""
        return [name for name, slope in self.amplitude.items() if self.seconds[name] > max(abs(np.sum(slope)), self.noise)]


@dataclass
class Found:
    """All that `range` finds. `middle`, and entries of `curves` (name -> [(number, record), ...]) and `samples` are records as
    `case_runs.largest_peak` makes them; `places` a dict of xi for each sample; `frequencies` and their `curve`s in rad per time.
    `tracks`: name -> `peak_tracks.Track`, where peaks were followed; `sliders`: (name, record) of other states of the preload."""

    case: object
    ranges: list
    each_point: bool
    seed: int
    dof: str
    unit: object
    length: str
    frequencies: np.ndarray
    middle: dict
    first: FirstOrder
    curves: dict
    places: list
    samples: list
    tracks: dict = field(default_factory=dict)
    sliders: list = field(default_factory=list)

    @property
    def good(self):
        """Numbers of the samples that have a peak."""
        return [i for i, record in enumerate(self.samples) if has_peak(record)]


def ranges(arguments):
    """The command: refuses wrong input, runs what has not been run, writes and prints the report."""
    given = [Range.read(name, words) for name in NAMES if (words := getattr(arguments, name))]
    if not given and not arguments.sliders:
        raise ValueError(f"nothing to vary; give two numbers to at least one of {', '.join(f'--{name}' for name in NAMES)}")
    _need_distinct(given)
    for option, least in (("samples", 0), ("along", 0), ("jobs", 1), ("until_peak", 1), ("sliders", 1)):
        if (number := getattr(arguments, option)) is not None and number < least:
            raise ValueError(f"--{option.replace('_', '-')} {number}: must be at least {least}")
    if 0 < arguments.along < 2:
        raise ValueError("--along 1: a curve has at least 2 points")
    from .ranges_mode import follows_mode, mode_ranges

    if follows_mode(arguments.case):
        return mode_ranges(arguments, given, Program(arguments.binary))
    case = CurveCase(arguments.case, arguments.omega, arguments.watch, arguments.until_peak)
    if any(wanted.name == "damping" for wanted in given):
        need_damping(case.content)
    program = Program(arguments.binary)
    program.check(case.path)
    out = Path(arguments.out) if arguments.out else case.path.with_name(case.path.stem + "_range")
    try:
        found = computed(CaseRuns(case, program, out, arguments.jobs), given, arguments.samples, arguments.along, arguments.seed,
                         arguments.each_point, arguments.track, arguments.sliders)
    except KeyboardInterrupt:
        raise RunFailed(f"broken off; what was computed is in {out}, and the same command goes on from there") from None
    write(found, out)


def computed(runs, given, samples, along, seed, each_point=False, track=False, sliders=None):
    """The Found of a CaseRuns; `given`: Ranges. `track`: peaks over one parameter are followed where they can be. `sliders`: so many
    states of residual friction besides those that have a name, or None."""
    results = runs.begin()
    if sliders:
        runs.need_unknown("--sliders")
        if not sticking(results).any():
            raise ValueError("--sliders: no contact point with friction is pressed in the preload state")
    for wanted in given:
        need(wanted.name, runs.contact)
        if wanted.name == "preload":
            runs.need_preload()
    size = len(runs.contact["law"])
    sweep = [results.unit.from_hertz(end) if runs.case.content["continuation"].get("unit") == "Hz" else end
             for end in sorted(runs.case.content["continuation"]["omega"])]
    frequencies = np.linspace(*sweep, FREQUENCIES)

    def digest(results):
        curve = [] if runs.case.content["continuation"].get("stop_after_peaks") else largest_at(results, runs.dof, frequencies).tolist()
        return largest_peak(results, runs.dof) | {"curve": [None if np.isnan(value) else value for value in curve]}

    def changes(places):
        return {wanted.name: (wanted.kind, wanted.at(places.get(wanted.name, 0.0))) for wanted in given}

    middle = runs.each([changes({})], digest, "middle of the ranges")[0]
    if not has_peak(middle):
        raise RunFailed(f"{runs.case.path}: in the middle of the ranges "
                        + (f"{runs.dof} has no peak inside the sweep" if middle["status"] == 0 else f"it failed: {middle['reason']}"))
    first = first_order(runs, given, changes, digest, middle, each_point) if given else FirstOrder()
    states = _residual_friction(runs, results, given, changes, digest, sliders, seed) if sliders else []
    curves, tracks = {}, {}
    for wanted in given if along else ():
        xi = np.linspace(-1, 1, along)
        if track:
            tracks[wanted.name] = follow(runs, wanted, changes, xi, digest)
        records = tracks[wanted.name].at(xi) if track else [None] * along
        missing = [place for place, record in zip(xi, records) if record is None]
        rest = iter(runs.each([changes({wanted.name: place}) for place in missing], digest, f"over {wanted.name}"))
        curves[wanted.name] = [(wanted.at(place), record or next(rest)) for place, record in zip(xi, records)]
    places = spread(given, samples if given else 0, seed, size if each_point else 0)
    drawn = runs.each([changes(place) for place in places], digest, "samples")
    return Found(runs.case, given, each_point, seed, runs.dof, results.unit, results.unit_of(runs.dof), frequencies, middle, first, curves,
                 places, drawn, tracks, states)


def _residual_friction(runs, results, given, changes, digest, count, seed):
    """(name, record) of peaks with the sliders of other states of the preload, all ranges in the middle."""
    middle = changes({})
    if given:
        _, results = runs.whole("middle", middle, sensitivity=has_slopes(runs))
        if results is None:
            raise RunFailed(f"{runs.case.path}: in the middle of the ranges it failed")
    found = slider_states(results, runs.reduced, count, seed, middle.get("preload", (None, 1.0))[1])
    records = runs.each([middle | {"sliders": ("offset", w_0)} for _, w_0 in found], digest, "sliders")
    return [(name, record) for (name, _), record in zip(found, records)]


def spread(given, samples, seed, points=0):
    """`samples` places within the ranges, dicts name -> xi; Sobol's points, the first ones of which are the same for any number.

    points : contact points that have a number each, 0 for one common to all
    """
    width = {wanted.name: points if points and wanted.name in CONTACT else 1 for wanted in given}
    if not samples:
        return []
    parts = np.split(sobol(sum(width.values()), samples, seed), np.cumsum(list(width.values()))[:-1], axis=1)
    return [{name: part[i] if width[name] > 1 else float(part[i, 0]) for name, part in zip(width, parts)} for i in range(samples)]


def has_slopes(runs):
    """Whether the program knows derivatives: not of nodes, nor where damping is made of the joint as it is."""
    if not is_reduced(runs.dof):
        return False
    damping = runs.case.content.get("damping", {})
    return not (damping.get("contact") or damping.get("ratios") and damping.get("of", "stuck") == "stuck")


def first_order(runs, given, changes, digest, middle, each_point):
    """Slopes from [sensitivity] where it knows them, else by differences; two runs more for each parameter, and two along the gradient,
    say how far they reach."""
    first = FirstOrder(noise=NOISE * middle["amplitude"])
    known = None
    if has_slopes(runs):
        run, results = runs.whole("middle", changes({}), sensitivity=True)
        known = results.sensitivity if results is not None else None
    row = None if known is None or not len(known) else int(np.argmin(np.abs(known.omega - middle["omega"])))
    if row is not None and abs(known.omega[row] / middle["omega"] - 1) > 1e-2:
        row = None  # of another peak
    for wanted in given:
        if row is not None:
            for of, size in (("amplitude", middle["amplitude"] / known.amplitude[row]), ("omega", 1.0)):
                slope = size * slope_of(wanted, getattr(known, f"{of}_by"), row, runs.contact, each_point)
                getattr(first, of)[wanted.name] = slope
            first.by[wanted.name] = "sensitivity"
        else:
            _by_differences(first, runs, wanted, changes, digest, each_point)
    for wanted in given:
        ends = runs.each([changes({wanted.name: sign}) for sign in (1.0, -1.0)], digest, f"ends of {wanted.name}")
        first.seconds[wanted.name] = second_difference(middle, *ends)
    largest = max((np.abs(slope).max() for slope in first.amplitude.values()), default=0.0)
    if largest > 0:
        corner = {name: slope / largest for name, slope in first.amplitude.items()}
        up, down = runs.each([changes({name: sign * place for name, place in corner.items()}) for sign in (1, -1)], digest,
                             "along the gradient")
        first.change = sum(float(np.sum(slope * corner[name])) for name, slope in first.amplitude.items())
        first.second = second_difference(middle, up, down)
    return first


def second_difference(middle, up, down):
    """Half of it; NaN where one of them is no peak."""
    if not (has_peak(up) and has_peak(down)):
        return np.nan
    return abs(up["amplitude"] - 2 * middle["amplitude"] + down["amplitude"]) / 2


def slope_of(wanted, slopes, row, contact, each_point):
    """Slope by xi of a peak, from derivatives by the parameters themselves: a number, or (N_x,) for one per point."""
    if wanted.name in FACTORS:
        return float(slopes[wanted.name][row]) * wanted.half  # by the factor on what the middle has
    key, directions = split(wanted.name)
    by = np.nan_to_num(slopes[key][row])
    if wanted.kind == "factor":
        size = contact_values(contact, {wanted.name: ("factor", wanted.at(0.0))})[key] * wanted.half
    else:
        size = np.full(by.shape, wanted.half)
    product = np.atleast_2d(by * size) if by.ndim == 2 else (by * size)[:, None]
    total = product[:, directions].sum(axis=1)
    return total if each_point else float(total.sum())


def _by_differences(first, runs, wanted, changes, digest, each_point):
    count = len(runs.contact["law"]) if each_point and wanted.name in CONTACT else 1
    steps = [STEP * unit if count > 1 else STEP for unit in np.eye(count)]
    records = runs.each([changes({wanted.name: sign * step}) for step in steps for sign in (1, -1)], digest, f"slopes by {wanted.name}")
    if all(map(has_peak, records)):
        for of in ("amplitude", "omega"):
            values = np.array([record[of] for record in records]).reshape(count, 2)
            slope = (values[:, 0] - values[:, 1]) / (2 * STEP)
            getattr(first, of)[wanted.name] = slope if count > 1 else float(slope[0])
        first.by[wanted.name] = "differences"


def _need_distinct(given):
    """Two ranges must not change the same number."""
    seen = {}
    for wanted in given:
        key, directions = split(wanted.name)
        for direction in range(2)[directions]:
            if (other := seen.setdefault((key, direction), wanted.name)) != wanted.name:
                raise ValueError(f"--{wanted.name} and --{other} change the same numbers; give one of them")
