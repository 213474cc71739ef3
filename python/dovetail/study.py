"""Speed against accuracy on the user's own case: a grid of settings, each compared with a reference made for it."""

import hashlib
import itertools
import sys
import time
from pathlib import Path

from . import study_errors
from .results import Results
from .study_report import Report, Row
from .study_runs import Program, Run, RunFailed, Setting, UserCase, compute, hash_of

HARMONICS = (1, 3, 5, 7, 10, 15, 20, 30, 40)  # by default those up to twice the case's own
USUAL = 10  # harmonics of a case that leaves them to a tolerance
USUAL_MODES = 20  # likewise
TOLERANCES = (1e-2, 1e-3, 1e-4)
SAMPLES = (64, 256, "exact")
LEAST = 10  # harmonics of a reference; twice 1 would be 2, which with friction is no better


def study(arguments):
    """The command: refuses wrong input, runs what has not been run, writes and prints the report."""
    case, program = UserCase(arguments.case), Program(arguments.binary)
    program.check(case.path)
    settings = grid(case, arguments)
    out = Path(arguments.out) if arguments.out else case.path.with_name(case.path.stem + "_study")
    identity = [program.hash, *map(hash_of, case.files().values())]

    def run_of(setting, folder, watch, tight=False):
        text = case.changed(setting, out / folder, watch, tight)
        return Run(setting, out / folder, text, hashlib.sha256("\n".join([text, *identity]).encode()).hexdigest())

    watch = case.content["continuation"].get("watch")
    setting = reference_of(settings)
    reference = run_of(setting, f"reference_{setting.folder}", watch, tight=True)
    try:
        results = computed_reference(reference, program)
        dof = results.watched
        curve = study_errors.curve_of(results, dof, case.compared(results))
        if curve.peak[1] == 0:
            raise RunFailed(f"{results.path}: nothing moves, so that there is nothing to compare")
        report = Report(case, out, reference, dof, curve)
        report.rows = compared([run_of(s, s.folder, dof) for s in settings], program, arguments.jobs, reference, report)
    except KeyboardInterrupt:
        raise RunFailed(f"broken off; what was computed is in {out}, and the same command goes on from there") from None
    report.write()


def grid(case, arguments):
    """All settings, those with few harmonics first, then those by tolerance; without those that have fewer than 2H+1 samples."""
    own = case.content.get("harmonic_balance", {})
    usual = own.get("harmonics", USUAL)
    harmonics = arguments.harmonics or [usual, *(h for h in HARMONICS if h <= 2 * usual)]
    tolerances = TOLERANCES if arguments.tolerances is None else arguments.tolerances
    samples = arguments.samples or [own.get("samples", "exact"), *SAMPLES]
    if arguments.modes and "reduced" in case.content:
        raise ValueError(f"{case.path}: names a reduced model, which is used as it stands: --modes has nothing to vary")
    usual = None if "reduced" in case.content else USUAL_MODES  # of a case that leaves them to a tolerance
    modes = arguments.modes or [case.content.get("reduction", {}).get("modes", usual)]
    solvers = arguments.solvers or [own.get("solver", "modal")]
    for option, values, least in (("--harmonics", harmonics, 1), ("--samples", samples, 1), ("--modes", modes, 0),
                                  ("--jobs", [arguments.jobs], 1)):
        for value in values:
            if isinstance(value, int) and value < least:
                raise ValueError(f"{option} {value}: must be at least {least}")
    for value in tolerances:
        if not 0 < value < 1:
            raise ValueError(f"--tolerances {value}: must lie between 0 and 1")
    order = itertools.product(sorted(set(modes)), sorted(set(harmonics)), sorted(set(samples), key=lambda n: (n == "exact", n)),
                              dict.fromkeys(solvers))
    settings = [Setting(h, n, m, solver) for m, h, n, solver in order if n == "exact" or n >= 2 * h + 1]
    if not settings:
        raise ValueError(f"--samples {max(samples)}: {min(harmonics)} harmonics need at least {2 * min(harmonics) + 1}")
    by_tolerance = itertools.product(sorted(set(modes)), sorted(set(tolerances), reverse=True), dict.fromkeys(solvers))
    return settings + [Setting(None, "exact", m, solver, tolerance) for m, tolerance, solver in by_tolerance]


def reference_of(settings):
    """Twice the harmonics of the finest setting or more, exact contact forces, the most modes."""
    return Setting(max(LEAST, *(2 * s.harmonics for s in settings if s.harmonics)), "exact", settings[-1].modes, "modal")


def computed_reference(reference, program):
    """Results of the reference, from an earlier study if it is the same; before it is run, the program has a look at its case."""
    if not reference.recall():
        reference.prepare()
        program.check(reference.folder / "case.toml")
        print(f"reference: {reference.setting}", file=sys.stderr)
        for run in compute([reference], program, 1, lambda setting: None):
            print(f"  {run.seconds:.1f} s", file=sys.stderr)
    if reference.status != 0:
        raise RunFailed(f"the reference, {reference.setting}, could not be computed: {reference.reason}")
    return Results(reference.folder / "results.h5")


def compared(runs, program, jobs, reference, report):
    """A Row for every run, in their order; tells each on stderr as it ends."""
    progress = Progress(len(runs), jobs)
    reduced = {reference.setting.modes: reference.folder / "reduced.h5"}
    waiting = [run for run in runs if not run.recall()]
    if len(waiting) < len(runs):
        print(f"{len(runs) - len(waiting)} of {len(runs)} runs are there from an earlier study", file=sys.stderr)
    rows = {run.setting: report.row(run) for run in runs if run not in waiting}
    progress.left = [run.setting for run in waiting]
    for run in compute(waiting, program, jobs, lambda setting: reduced.get(setting.modes)):
        if run.status == 2:
            raise ValueError(f"{run.setting}: {run.reason}")
        reduced.setdefault(run.setting.modes, run.folder / "reduced.h5")
        rows[run.setting] = report.row(run)
        progress.tell(run, rows[run.setting])
    return [rows[run.setting] for run in runs]


class Progress:
    """One line per run. Time left goes by the harmonics still to do: a run is taken to cost in proportion to 2H+1, with H = USUAL
    where a tolerance chooses."""

    def __init__(self, total, jobs):
        self.total, self.jobs, self.left, self.seconds, self.width = total, jobs, [], 0.0, 0

    def tell(self, run, row: Row):
        self.left.remove(run.setting)
        self.seconds += run.seconds
        self.width += self.size(run.setting)
        rest = self.seconds / self.width * sum(map(self.size, self.left)) / self.jobs
        said = f"error {study_errors.largest(row.errors):.1e}" if row.errors else f"failed: {row.reason}"
        left = time.strftime("%H:%M:%S", time.gmtime(rest))
        print(f"{self.total - len(self.left):4d} of {self.total}  {run.setting!s:<36}{run.seconds:8.1f} s  {said}  {left} left",
              file=sys.stderr, flush=True)

    @staticmethod
    def size(setting):
        return 2 * (setting.harmonics or USUAL) + 1
