"""Parameters of a joint from measured response curves or a backbone: least squares of relative errors, with what they leave open."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.special import stdtrit

from .case_changes import CONTACT, need, need_damping, split
from .case_runs import CaseRuns, CurveCase
from .fit_backbone import BackboneCase, BackboneToFit
from .fit_curves import CurvesToFit
from .fit_report import write
from .fit_search import Curves, Unknown, changes_of, uncertainty
from .motion import find_joint
from .ranges_mode import follows_mode
from .study_runs import Program, RunFailed

USUAL = ("friction", "tangential_stiffness")
WIDEST = np.log(100.0)  # a factor beyond is no fit
CONFIDENCE = 0.95
EVALUATIONS = 40
WEIGHINGS = 8  # searches at most, each with the weights that the one before has left
SETTLED = 0.02  # change of a weight, as a logarithm, that calls for no further search


@dataclass
class Fit:
    """What `fit` finds.

    unknowns : list of Unknown
    factor : (p,); deviation (p,) standard deviation of its logarithm, correlation (p, p)
    low, high : (p,) ends of the confidence interval of the factor
    curves : list of FittedCurve, empty where it is fitted to a backbone
    backbone : FittedBackbone, None where it is fitted to curves
    """

    case: object
    dof: str
    unit: object
    length: str
    harmonic: int | None
    contact: dict
    unknowns: list
    factor: np.ndarray
    deviation: np.ndarray
    correlation: np.ndarray
    low: np.ndarray
    high: np.ndarray
    runs: int
    converged: bool = True
    curves: list = field(default_factory=list)
    backbone: object = None

    @property
    def undetermined(self):
        """Numbers of the unknowns that the curve hardly depends on: their interval is wider than a factor of 10 to either side."""
        return [i for i in range(len(self.factor)) if self.high[i] / self.factor[i] >= 10]

    @property
    def at_limit(self):
        """Numbers of the unknowns whose search ended at the widest factor."""
        return [i for i, factor in enumerate(self.factor) if limited(np.log(factor))]

    @property
    def changes(self):
        return changes_of(self.unknowns, self.factor, len(self.contact["law"]))


def fit(arguments):
    """The command: refuses wrong input, runs, writes and prints the report."""
    names = tuple(dict.fromkeys(arguments.parameters or USUAL))
    if arguments.jobs < 1:
        raise ValueError(f"--jobs {arguments.jobs}: must be at least 1")
    if arguments.harmonic is not None and arguments.harmonic < 1:
        raise ValueError(f"--harmonic {arguments.harmonic}: must be at least 1")
    keys = [split(name)[0] for name in names]
    if len(set(keys)) < len(keys) and any(split(name)[1] == slice(None) for name in names if keys.count(split(name)[0]) > 1):
        raise ValueError(f"--parameters {' '.join(names)}: one of them is part of another")
    if follows_mode(arguments.case):
        need_no_load(arguments, names)
        forces, case = [1.0], BackboneCase(arguments.case, arguments.watch)
    else:
        forces, case = forces_of(arguments.measured, arguments.force), CurveCase(arguments.case, None, arguments.watch)
    if "damping" in names:
        need_damping(case.content)
    program = Program(arguments.binary)
    program.check(case.path)
    out = Path(arguments.out) if arguments.out else case.path.with_name(case.path.stem + "_fit")
    try:
        found = fitted(CaseRuns(case, program, out, arguments.jobs), [Path(file) for file in arguments.measured], names,
                       arguments.by_joint, arguments.harmonic, forces)
    except KeyboardInterrupt:
        raise RunFailed(f"broken off; what was computed is in {out}, and the same command goes on from there") from None
    write(found, out)


def need_no_load(arguments, names):
    """Refuses what a nonlinear mode has not."""
    mode = f"{arguments.case} follows a nonlinear mode ([mode])"
    if arguments.force is not None or "force" in names:
        raise ValueError(f"{'--force' if arguments.force is not None else '--parameters force'}: {mode}, which depends on no load")
    if len(arguments.measured) > 1:
        raise ValueError(f"{', '.join(arguments.measured)}: {mode}: wanted is one measured backbone, found {len(arguments.measured)} files")


def forces_of(files, forces):
    """Factors on the loads, one for each file; 1 of a single file without them. Raises ValueError."""
    if forces is None and len(files) == 1:
        return [1.0]
    if len(forces or []) != len(files):
        raise ValueError(f"--force: {len(files)} measured {'files want' if len(files) > 1 else 'file wants'} {len(files)} "
                         f"factor{'s' if len(files) > 1 else ''} on the loads of the case, in their order; found {len(forces or [])}")
    if not all(force > 0 for force in forces):
        raise ValueError(f"--force {' '.join(f'{force:g}' for force in forces)}: factors must be greater than 0")
    if twice := [file for file in files if files.count(file) > 1]:
        raise ValueError(f"{twice[0]}: this measured file is there twice")
    return forces


def fitted(runs, files, names, by_joint=False, harmonic=None, forces=(1.0,)):
    """The Fit of a CaseRuns to measured files, each with a factor on the loads."""
    results = runs.begin()
    for name in names:
        need(name, runs.contact)
    unknowns = unknowns_of(results, names, by_joint)
    if harmonic and harmonic > results.harmonics:
        raise ValueError(f"--harmonic {harmonic}: the case has {results.harmonics}")
    measured = BackboneToFit(runs, results, unknowns, files[0], harmonic) if runs.case.MODE else \
        CurvesToFit(runs, results, unknowns, files, harmonic, forces)
    search = Curves(measured.searches)
    solution = solved(search, len(unknowns))
    if search.failed(solution.x):
        raise RunFailed(f"{runs.case.path}: the case could not be computed with any parameters that were tried")
    errors = search.plain_errors(solution.x)
    there = np.isfinite(np.concatenate(errors))
    deviation, correlation = uncertainty(solution.fun[there], solution.jac[there])
    free = np.count_nonzero(there) - len(unknowns)
    width = stdtrit(free, (1 + CONFIDENCE) / 2) * deviation if free > 0 else deviation
    width = np.where(limited(solution.x) | (solution.status == 0), np.nan, width)
    misfits = [float(np.sqrt(np.mean(np.where(np.isfinite(found), found, one.missed) ** 2)))
               for one, found in zip(measured.searches, errors)]
    factor = np.exp(solution.x)
    outcome = measured.outcome(solution.x, changes_of(unknowns, factor, len(runs.contact["law"])), misfits)
    with np.errstate(over="ignore"):
        return Fit(runs.case, runs.dof, results.unit, results.unit_of(runs.dof), harmonic, runs.contact, unknowns, factor, deviation,
                   correlation, np.exp(solution.x - width), np.exp(solution.x + width), measured.count, bool(solution.status != 0),
                   **outcome)


def solved(search, count):
    """The least squares of `count` logarithms; of several curves, once their weights are what the fit leaves of each."""
    x = np.zeros(count)
    for _ in range(WEIGHINGS):
        solution = least_squares(search.errors, x, search.derivative, bounds=(-WIDEST, WIDEST), xtol=1e-5, ftol=1e-8,
                                 max_nfev=EVALUATIONS)
        x = solution.x
        if len(search.searches) == 1 or solution.status == 0 or search.failed(x) or search.weigh(x) < SETTLED:
            break
    return solution


def limited(x):
    """Whether logarithms of factors lie at the end of what is searched; the search stays inside by a little."""
    return np.abs(x) > 0.99 * WIDEST


def unknowns_of(results, names, by_joint):
    """An Unknown for each name, or, of the joint's parameters, for each joint."""
    if not by_joint:
        return [Unknown(name) for name in names]
    joint = find_joint(results)
    found = []
    for name in names:
        if name not in CONTACT:
            found.append(Unknown(name))
            continue
        for number in np.unique(joint["joint"]):
            found.append(Unknown(name, joint["names"][number], np.flatnonzero(joint["joint"] == number)))
    return found
