"""Peaks and curves of changed copies of a case: each is run once, and what was found is kept in a file."""

import hashlib
import json
import shutil
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from . import curves
from .case_changes import apply, without_model
from .hdf5_read import opened
from .results import Results
from .slider_states import shifted_load
from .study_runs import Run, RunFailed, UserCase, compute, hash_of, toml

PRELOADED = "preloaded.h5"  # a reduced file with another preload
KEPT = "runs.jsonl"  # one line a run, with its fingerprint
COPY = "# A copy with other parameters, which may be overwritten.\n"
OTHER_LOAD = {"preload", "sliders"}  # changes of the reduced file's load
WHOLE = ("case", "middle", "fitted")  # folders of runs that are kept as they are
LINES = 25  # of progress, more or less


class CurveCase(UserCase):
    """A case whose curves over the frequency are run again with changed parameters.

    Parameters
    ----------
    path : path-like
    omega : (from, to) in the unit of the case, or None for the sweep of the case
    watch : str or None, for that of the case
    until_peak : int or None, peaks at which every sweep ends
    """

    def __init__(self, path, omega=None, watch=None, until_peak=None):
        super().__init__(path)
        sweep = self.content.setdefault("continuation", {})
        for key in ("at", "stop_after_peaks", "stop_at_amplitude", "max_points"):
            sweep.pop(key, None)
        sweep |= {"omega": list(omega)} if omega else {}
        sweep |= {"watch": watch} if watch else {}
        sweep |= {"stop_after_peaks": until_peak} if until_peak else {}
        if len(sweep.get("omega", [])) != 2 or sweep["omega"][0] == sweep["omega"][1]:
            raise ValueError(f"{path}: continuation.omega = {sweep.get('omega')}: curves need a range of frequencies")
        self.content["stability"] = {"enabled": False}
        if "tolerance" not in self.content.get("accuracy", {}):
            self.content.setdefault("accuracy", {})["estimates"] = False
        self.content.pop("output", None)

    @property
    def watch(self):
        return self.content["continuation"].get("watch")

    def text(self, folder, contact=None, changes=None, watch=None, sensitivity=False, at=None, path=None):
        """The copy that lies in `folder`; contact and changes as for `case_changes.apply`; `path`: a section [path]."""
        content = self.moved(folder)
        if changes:
            content = apply(content, contact, changes)
        if watch:
            content["continuation"]["watch"] = watch
        if at is not None:
            content["continuation"]["at"] = list(at)
        if path is not None:
            content["path"] = path
            for section in ("stability", "accuracy"):
                content.pop(section, None)
            content["continuation"].pop("stop_after_peaks", None)
        if sensitivity:
            content["sensitivity"] = {"of": content["continuation"]["watch"]}
        head = COPY
        if changes and OTHER_LOAD & set(changes):
            content, head = without_model(content, contact, PRELOADED), COPY + load_in_words(changes)
        if "model" in content:
            content["output"] = {"motion": motion_of(watch)}
        return head + toml(content)


def motion_of(watch):
    """Of whose motion results are wanted, as output.motion says it: the node that is watched, or none."""
    node = watch.rpartition(".")[0] if watch and not curves.is_reduced(watch) else ""
    return [int(node) if node.isdigit() else node] if node else []


@dataclass
class PreloadedRun(Run):
    """One that starts from the reduced file `source`, with its preload times `factor`, and sliders at `w_0` (N_x, 2), or None."""

    source: Path | None = None
    factor: float = 1.0
    w_0: np.ndarray | None = None

    def prepare(self, reduced=None):
        super().prepare()
        with h5py.File(self.source) as old, h5py.File(self.folder / PRELOADED, "w") as new:
            for name in old.keys() - {"recovery"}:
                old.copy(name, new)
            new.attrs.update(old.attrs)
            new["R"][...] *= self.factor
            if self.w_0 is not None:
                new["R"][...] += shifted_load(old, self.w_0)


def load_in_words(changes):
    """What a copy with another preload says of it, which tells it apart from others."""
    words = f"# preload times {changes['preload'][1]!r}\n" if "preload" in changes else ""
    if "sliders" in changes:
        words += f"# sliders {hashlib.sha256(np.ascontiguousarray(changes['sliders'][1]).tobytes()).hexdigest()}\n"
    return words


class CaseRuns:
    """Runs of a CurveCase in a folder, `jobs` at a time.

    `contact` (as `Results.contact`) and `dof`, the unknown that is watched, are there after `begin`.
    """

    def __init__(self, case, program, folder, jobs=1):
        self.case, self.program, self.folder, self.jobs = case, program, folder, jobs
        self.identity = [program.hash, *map(hash_of, case.files().values())]
        self.contact = self.dof = None
        self.kept = {}
        if (file := folder / KEPT).is_file():
            text = file.read_text()
            if text and not text.endswith("\n"):
                file.write_text(text + "\n")
            for line in text.splitlines():
                try:
                    record = json.loads(line)
                    self.kept[record["fingerprint"]] = record
                except (ValueError, KeyError):
                    continue  # cut off when it was written

    def whole(self, name, changes=None, sensitivity=False):
        """Results of a run that is kept in the folder `name`; its status and the reason where it failed are those of the Run."""
        folder = self.folder / name
        run = self._run(folder, changes, self.case.text(folder, self.contact, changes, self.dof or self.case.watch, sensitivity))
        if not run.recall():
            for _ in compute([run], self.program, 1, self._made):
                pass
        if run.status == 2:
            raise ValueError(f"{self.case.path}: {run.reason}")
        return run, Results(folder / "results.h5") if run.status == 0 else None

    def begin(self):
        """The case as it stands: its Results. Raises RunFailed where it could not be run."""
        for name in WHOLE:
            need_own(self.folder / name)
        run, results = self.whole("case")
        if results is None or len(results) == 0:
            raise RunFailed(f"{self.case.path}: could not be run as it stands: {run.reason}")
        self.contact, self.dof = results.contact, self.case.watch or results.watched
        return results

    def each(self, list_of_changes, digest, what="", at=None, key="", path=None, each_at=None):
        """What `digest` (a function of Results, to JSON) makes of each case with changes, a dict with `status` and `reason` besides.

        `what` names them on the screen, where nothing is said without it; `at`: frequencies wanted exactly, in the unit of the case, or
        amplitudes of a mode; `each_at`: those of each; `path`: the section [path] of cases that follow another parameter.
        digest must not depend on anything that neither the case's text nor `key`, a string, shows.
        """
        runs = []
        for number, changes in enumerate(list_of_changes):
            folder = self.folder / "under_way" / f"{number + 1}"
            own = at if each_at is None else each_at[number]
            runs.append(self._run(folder, changes, self.case.text(folder, self.contact, changes, self.dof, at=own, path=path), key))
        missing = {run.fingerprint: run for run in runs if run.fingerprint not in self.kept}
        if what and len(missing) < len({run.fingerprint for run in runs}):
            print(f"{what}: {len(runs) - len(missing)} of {len(runs)} are there from before", file=sys.stderr)
        progress = Progress(what, len(missing), self.jobs)
        try:
            for run in compute(list(missing.values()), self.program, self.jobs, self._made):
                if run.status == 2:
                    raise ValueError(f"{self.case.path}: {run.reason}")
                self._keep(run, digest)
                progress.tell(run.seconds)
        finally:
            shutil.rmtree(self.folder / "under_way", ignore_errors=True)
        return [self.kept[run.fingerprint] for run in runs]

    def _made(self, _):
        """The reduced file that runs from a model may take over."""
        return None if "reduced" in self.case.content else self.reduced

    def need_preload(self):
        """Refuses to vary the preload where there is none, or where a node is watched, which a reduced file does not know."""
        with opened(self.reduced) as file:
            if not np.any(file["R"]):
                raise ValueError("--preload: the case has no preload")
        self.need_unknown("--preload")

    def need_unknown(self, option):
        """Refuses what makes runs start from the reduced model, where a node is watched."""
        if not curves.is_reduced(self.dof):
            raise ValueError(f"{option}: runs start from the reduced model then, which knows no node: watch an unknown such as x1.t1, "
                             f"found {self.dof}")

    def _run(self, folder, changes, text, key=""):
        need_own(folder)
        fingerprint = hashlib.sha256("\n".join([text, *self.identity, key]).encode()).hexdigest()
        if changes and OTHER_LOAD & set(changes):
            return PreloadedRun(None, folder, text, fingerprint, source=self.reduced, factor=changes.get("preload", (None, 1.0))[1],
                                w_0=changes.get("sliders", (None, None))[1])
        return Run(None, folder, text, fingerprint)

    @property
    def reduced(self):
        """That of the case: the one it names, or the one it has made."""
        return self.case.files().get(("reduced",), self.folder / "case" / "reduced.h5")

    def _keep(self, run, digest):
        record = {"fingerprint": run.fingerprint, "status": run.status, "reason": run.reason}
        if run.status == 0:
            record |= digest(Results(run.folder / "results.h5"))
        if run.status in (0, 3):  # one that something killed is done again next time
            with open(self.folder / KEPT, "a") as file:
                file.write(json.dumps(record) + "\n")
        self.kept[run.fingerprint] = record
        shutil.rmtree(run.folder)


def need_own(folder):
    """Refuses a folder with a case that is not a copy written here."""
    if (file := folder / "case.toml").is_file() and not (folder / "run.json").is_file() \
            and not file.read_text(errors="replace").startswith(COPY):
        raise ValueError(f"{file}: was not written here, and would be overwritten; name another folder with --out")


class Progress:
    """A line now and then: how many are done, and the time left."""

    def __init__(self, what, total, jobs):
        self.what, self.total, self.jobs, self.done, self.began, self.told = what, total, jobs, 0, time.monotonic(), 0

    def tell(self, seconds):
        self.done += 1
        if not self.what or (self.done < self.total and (self.done - self.told) * LINES < self.total):
            return
        self.told = self.done
        left = (time.monotonic() - self.began) / self.done * (self.total - self.done)
        print(f"{self.what}: {self.done:4d} of {self.total}  {seconds:7.2f} s  {time.strftime('%H:%M:%S', time.gmtime(left))} left",
              file=sys.stderr, flush=True)


def largest_peak(results, dof):
    """The largest peak of a curve, or its largest point where it has none: a dict to be kept.

    `amplitude` is half the peak-to-peak, `rms` sqrt(sum over k >= 1 of a_k^2 + b_k^2) at the nearest point.
    """
    response = results.response(dof)
    tops = np.union1d(curves.maxima(response.amplitude, response.jumps), response.located).astype(int)  # one may be the end of a sweep
    inside = len(tops) > 0
    point = int(tops[np.argmax(response.amplitude[tops])]) if inside else response.largest_point()
    omega, amplitude = response.omega[point], response.amplitude[point]
    if inside and point not in response.located:
        omega, amplitude = curves.top(response.along, response.arclength, response.amplitude, point)
    return {"omega": float(omega), "amplitude": float(amplitude), "rms": float(np.linalg.norm(response.coefficients[point, 1:])),
            "peak": inside}


def has_peak(record):
    """Whether a run came through, and its curve has a peak inside the sweep."""
    return record["status"] == 0 and record["peak"]


def tracked_peaks(results, dof):
    """Of a run that has followed a peak: a dict to be kept, of lists over its points. `amplitude` as of `largest_peak`."""
    return {"parameter": results.parameter.tolist(), "omega": results.omega.tolist(), "rms": results.tracked_amplitude.tolist(),
            "amplitude": results.response(dof).amplitude.tolist()}


def largest_at(results, dof, frequencies):
    """(m,) largest amplitude of the branch at each frequency; NaN where it does not come."""
    response = results.response(dof)
    found = np.full(len(frequencies), np.nan)
    for piece in curves.pieces(len(response.omega), response.jumps):
        omega, amplitude = response.omega[piece], response.amplitude[piece]
        low, high = np.minimum(omega[:-1], omega[1:]), np.maximum(omega[:-1], omega[1:])
        for i, frequency in enumerate(frequencies):
            for j in np.flatnonzero((low <= frequency) & (frequency <= high) & (low < high)):
                part = (frequency - omega[j]) / (omega[j + 1] - omega[j])
                found[i] = np.fmax(found[i], amplitude[j] + part * (amplitude[j + 1] - amplitude[j]))
    return found
