"""What a study found: table, JSON, picture, and the cheapest setting for an error."""

import json
from dataclasses import asdict, dataclass, field

from . import study_errors
from .results import Results
from .units import with_unit

TARGETS = (1e-2, 1e-3, 1e-4)
HELP = {"harmonics": "more harmonics", "leaps": "leaps", "integrations": "time integrations"}  # counts of summary.json: there the
# numbers are not those of the setting alone


@dataclass
class Row:
    """One setting: errors as in `study_errors.errors`, or None with the reason; cost in processor time of the branch [s]; `finer`: than
    the reference, in harmonics."""

    setting: object
    errors: dict | None = None
    points: int = 0
    seconds_per_point: float | None = None
    seconds: float = 0.0
    notes: list = field(default_factory=list)
    reason: str = ""
    finer: bool = False

    @property
    def largest(self):
        return study_errors.largest(self.errors)


class Report:
    """The reference, and the rows of all settings once they are there.

    Attributes
    ----------
    reference : Run
    dof : str
        The unknown that is watched.
    curve : Curve
        Of the reference.
    rows : list of Row
    """

    def __init__(self, case, out, reference, dof, curve):
        self.case, self.out, self.reference, self.dof, self.curve = case, out, reference, dof, curve
        self.rows = []

    def row(self, run):
        """Compares one run with the reference."""
        if run.status != 0:
            return Row(run.setting, reason=run.reason)
        summary, results = run.summary, Results(run.folder / "results.h5")
        curve = study_errors.curve_of(results, self.dof, self.case.compared(results))
        notes = helped(summary)
        used = int(results.points("harmonics").max())
        finer = used > self.reference.setting.harmonics
        if finer:
            notes.append(f"up to {used} harmonics, more than the reference, whose errors these may be")
        if summary["end"] != self.reference.summary["end"]:
            notes.append(f"ended at {summary['last_omega']:.5g} {results.unit.omega}: {summary['why']}")
        if absent := study_errors.missed(curve, self.curve):
            notes.append(f"no point at {absent} of the frequencies")
        return Row(run.setting, study_errors.errors(curve, self.curve), summary["points"], run.seconds_per_point,
                   run.seconds_per_point * summary["points"], notes, finer=finer)

    @property
    def compared(self):
        return [row for row in self.rows if row.errors]

    @property
    def fixed(self):
        """Of those compared the ones with so many harmonics."""
        return [row for row in self.compared if row.setting.tolerance is None]

    def cheapest(self, target, rows=None):
        """The row with the least time per point of those (default: of all) whose errors all keep the target, or None."""
        good = [row for row in (self.compared if rows is None else rows) if row.largest <= target]
        return min(good, key=lambda row: row.seconds_per_point, default=None)

    @property
    def title(self):
        return self.case.content.get("title", self.case.path.name)

    def write(self):
        """study.json, study.txt and study.png; prints the text, and where they are."""
        from .saved_picture import save_picture
        from .study_picture import picture

        (self.out / "study.json").write_text(json.dumps(self.numbers(), indent=2) + "\n")
        text = "\n".join([*self.heading(), "", *self.table(), "", *self.advice()])
        (self.out / "study.txt").write_text(text + "\n")
        if self.compared:
            save_picture(picture(self), self.out / "study.png")
        print(text)
        print(f"\n{self.out}: study.txt, study.json" + (", study.png" if self.compared else "; no setting came through"))

    def heading(self):
        omega, amplitude = self.curve.peak
        summary = self.reference.summary
        lines = [f"study of {self.case.path}: {self.title}",
                 f"reference: {self.reference.setting}; {summary['points']} points, "
                 f"{1e3 * self.reference.seconds_per_point:.4g} ms per point",
                 f"its peak: {with_unit(f'{amplitude:.7g}', self.curve.unit)} of {self.dof} at {omega:.7g} {self.curve.omega_unit}",
                 f"curves and energies are compared at {len(self.case.frequencies)} frequencies"]
        lines += [f"caution: where no step converged the reference took {note}" for note in helped(summary)]
        if self.doubt is not None:
            lines.append(f"half its harmonics are {self.doubt:.1e} from it: errors below that may be its own")
        return lines

    @property
    def doubt(self):
        """Largest error of the setting that differs from the reference in harmonics only, a measure of the reference's own; or None."""
        best = self.reference.setting
        near = [row.largest for row in self.fixed if (row.setting.samples, row.setting.modes, 2 * row.setting.harmonics) == (
            best.samples, best.modes, best.harmonics)]
        return min(near, default=None)

    def table(self):
        lines = [f"{'':40}error of", f"{'setting':<40}{'amplitude':<11}{'frequency':<11}{'curve':<11}{'dissipation':<13}"
                 f"{'points':>6}{'ms/point':>10}{'curve [s]':>11}"]
        for row in self.rows:
            if row.errors:
                shown = "".join(f"{'-' if row.errors[kind] is None else format(row.errors[kind], '.2e'):<{width}}"
                                for kind, width in zip(study_errors.KINDS, (11, 11, 11, 13)))
                cost = f"{row.points:6d}{1e3 * row.seconds_per_point:10.3g}{row.seconds:11.3g}"
                lines.append(f"{row.setting!s:<40}{shown}{cost}" + "".join(f"  {note}" for note in row.notes))
            else:
                lines.append(f"{row.setting!s:<40}failed: {row.reason}")
        return lines

    def advice(self):
        lines = []
        for target in TARGETS:
            row = self.cheapest(target)
            if row:
                lines += [f"# all errors within {target:g}, {1e3 * row.seconds_per_point:.3g} ms per point (largest {row.largest:.1e})",
                          *self.to_paste(row.setting), ""]
            else:
                found = f"; the best has {min(row.largest for row in self.compared):.1e}" if self.compared else ""
                lines += [f"# all errors within {target:g}: no setting of this grid{found}", ""]
        return lines + self.kept() if self.kept() else lines[:-1]

    def kept(self):
        """What the runs by tolerance took, against the cheapest with fixed harmonics that is as good."""
        lines = []
        for row in self.compared:
            if row.setting.tolerance is not None:
                rival = self.cheapest(max(row.largest, row.setting.tolerance), self.fixed)
                against = f", {row.seconds_per_point / rival.seconds_per_point:.2f} times {rival.setting}" if rival else ""
                if row.finer:
                    against = f"; not to be judged by a reference of {self.reference.setting.harmonics} harmonics, which is the coarser one"
                lines.append(f"# {row.setting}: largest error {row.largest:.1e}, {1e3 * row.seconds_per_point:.3g} ms per point{against}")
        return lines

    def to_paste(self, setting):
        """Lines for the case file; modes and solver only where they were varied or differ from what is there."""
        lines = []
        for section, values in setting.values.items():
            own = self.case.content.get(section, {})
            chosen = {key: value for key, value in values.items()
                      if key in ("harmonics", "samples", "tolerance") or value != own.get(key, "modal" if key == "solver" else None)}
            if chosen:
                lines += [f"[{section}]", *(f"{key} = {json.dumps(value)}" for key, value in chosen.items())]
        return lines

    def numbers(self):
        """All of it, for study.json."""
        omega, amplitude = self.curve.peak
        return {"case": self.case.path.name, "title": self.title, "program": self.reference.summary["program"], "watched": self.dof,
                "frequencies": self.case.frequencies,
                "reference": {**asdict(self.reference.setting), "peak_omega": omega, "peak_amplitude": amplitude,
                              "points": self.reference.summary["points"], "seconds_per_point": self.reference.seconds_per_point,
                              "doubt": self.doubt, "notes": helped(self.reference.summary)},
                "runs": [{**asdict(row), "setting": asdict(row.setting), "folder": row.setting.folder} for row in self.rows],
                "cheapest": {f"{target:g}": asdict(row.setting) if (row := self.cheapest(target)) else None for target in TARGETS}}


def helped(summary):
    """How a run helped itself where plain steps did not lead on."""
    return [f"{words}: {summary[name]}" for name, words in HELP.items() if summary[name]]
