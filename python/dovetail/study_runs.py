"""The runs of a study: each a changed copy of the case in a folder of its own, computed once and kept."""

import copy
import hashlib
import json
import math
import os
import shutil
import subprocess
import tempfile
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .checked import whole_number

FREQUENCIES = 40  # at which curves are compared, evenly over the sweep
NEWTON_DEFAULT = 1e-8  # both tolerances of [newton]
TAIL = 40  # words of what was said, where no message of the program is among them
PAUSE = 0.02  # between looks at the runs under way [s]
PATHS = (("model",), ("reduced",), ("continuation", "start"))  # keys of the case that name files


class RunFailed(Exception):
    """A run has failed, one without which a study cannot go on, or the user has broken the study off.

    `status` is the exit status of the program, where it is known: 2 for wrong input, 3 where the computation could not go on.
    """

    def __init__(self, message, status=None):
        super().__init__(message)
        self.status = status


@dataclass(frozen=True)
class Setting:
    """What is varied: harmonics (None: by `tolerance`) and samples, N or "exact"; `modes` is None for a reduced model, which is
    used as it stands."""

    harmonics: int | None
    samples: int | str
    modes: int | None
    solver: str
    tolerance: float | None = None

    @property
    def folder(self):
        samples = self.samples if self.samples == "exact" else f"N{self.samples}"
        modes = "" if self.modes is None else f"_{self.modes}modes"
        harmonics = f"H{self.harmonics}_{samples}" if self.tolerance is None else f"tolerance{self.tolerance:g}"
        return f"{harmonics}{modes}_{self.solver}"

    @property
    def values(self):
        """The same as keys of the case file: section -> key -> value."""
        if self.tolerance is None:
            sections = {"harmonic_balance": {"harmonics": self.harmonics, "samples": self.samples, "solver": self.solver}}
        else:
            sections = {"accuracy": {"tolerance": self.tolerance}, "harmonic_balance": {"solver": self.solver}}
        return sections if self.modes is None else sections | {"reduction": {"modes": self.modes}}

    def __str__(self):
        samples = "exact" if self.samples == "exact" else f"N {self.samples}"
        modes = "" if self.modes is None else f", {self.modes} modes"
        harmonics = f"H {self.harmonics}, {samples}" if self.tolerance is None else f"tolerance {self.tolerance:g}"
        return f"{harmonics}{modes}, {self.solver}"


class CaseFile:
    """A case of any kind, as parsed: `content`, whose files are named from the folder of `path`."""

    def __init__(self, path):
        self.path = Path(path)
        try:
            self.content = tomllib.loads(self.path.read_text(encoding="utf-8-sig"))
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise ValueError(f"{path}: {error}") from None

    def files(self):
        """The files that the case names, by the keys that do."""
        found = {}
        for keys in PATHS:
            value = self.content
            for key in keys:
                value = value.get(key) if isinstance(value, dict) else None
            if value and isinstance(value, (str, os.PathLike)):
                found[keys] = (self.path.parent / value).resolve()
        return found

    def moved(self, folder):
        """A copy of `content` whose files are named from `folder`."""
        content = copy.deepcopy(self.content)
        for keys, file in self.files().items():
            section = content if len(keys) == 1 else content[keys[0]]
            section[keys[-1]] = os.path.relpath(file, Path(folder).resolve())
        return content


class UserCase(CaseFile):
    """A case over the frequency, or of a mode, and changed copies of it.

    Attributes
    ----------
    MODE : bool
        Whether the case follows a nonlinear mode, in place of curves over the frequency.
    frequencies : list of float
        Where curves are compared, in the unit of the case and the order of the sweep: evenly spaced ones strictly inside it, and
        those of `continuation.at`.
    """

    MODE = False

    def __init__(self, path):
        super().__init__(path)
        if self.content.pop("path", None):  # the template has an empty one
            raise ValueError(f"{path}: follows another parameter ([path]); curves over the frequency are wanted")
        if self.MODE and not self.content.get("mode"):
            raise ValueError(f"{path}: has no section [mode]")
        if not self.MODE and self.content.pop("mode", None):
            raise ValueError(f"{path}: follows a nonlinear mode ([mode]); curves over the frequency are wanted")
        self.content.pop("sensitivity", None)  # peaks alone are compared

    @property
    def frequencies(self):
        first, last = self.content["continuation"]["omega"]
        if first == last:
            raise ValueError(f"{self.path}: continuation.omega = [{first}, {last}]: a study compares curves and needs a range")
        inside = np.linspace(first, last, FREQUENCIES + 2)[1:-1].tolist()
        return sorted({*inside, *map(float, self.content["continuation"].get("at", []))}, reverse=last < first)

    def compared(self, results):
        """The same as results have them."""
        hertz = self.content["continuation"].get("unit") == "Hz"
        return [results.unit.from_hertz(value) if hertz else value for value in self.frequencies]

    def changed(self, setting, folder, watch=None, tight=False):
        """Text of the copy for one setting that lies in `folder`; lean, and with the common frequencies.

        `watch` is the unknown whose peaks are located; `tight` leaves no Newton tolerance looser than the default.
        """
        content = self.moved(folder)
        for name, key in (("harmonic_balance", "harmonics"), ("harmonic_balance", "samples"), ("accuracy", "tolerance")):
            content.get(name, {}).pop(key, None)
        for name, values in setting.values.items():
            content.setdefault(name, {}).update(values)
        if setting.tolerance is None:  # a tolerance cannot do without; fixed settings are timed as they are
            content.setdefault("accuracy", {})["estimates"] = False
        content["continuation"]["at"] = self.frequencies
        if watch:
            content["continuation"]["watch"] = watch
        if tight:
            newton = content.setdefault("newton", {})
            for key in ("step_tolerance", "residual_tolerance"):
                newton[key] = min(newton.get(key, NEWTON_DEFAULT), NEWTON_DEFAULT)
        content["stability"] = {"enabled": False}
        content.pop("output", None)
        if "model" in content:
            content["output"] = {"motion": []}
        return toml(content)


def toml(content):
    """A case as text: keys first, then sections one level deep, which is all a case file has."""
    lines = [f"{key} = {value_text(value, key)}" for key, value in content.items() if not isinstance(value, dict)]
    for name, section in content.items():
        if isinstance(section, dict):
            lines += ["", f"[{name}]"] + [f"{key} = {value_text(value, f'{name}.{key}')}" for key, value in section.items()]
    return "\n".join(lines) + "\n"


def value_text(value, key=""):
    """A value in TOML; words, numbers and truth values are written as in JSON, tables within brackets, as in excitation.load.

    Paths and NumPy's numbers and arrays are taken, too. Raises ValueError by the name `key` for what no case file holds.
    """
    value = value.tolist() if hasattr(value, "tolist") else os.fspath(value) if isinstance(value, os.PathLike) else value
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(value_text(inner, key) for inner in value)}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{name} = {value_text(inner, key)}' for name, inner in value.items())}}}"
    if not isinstance(value, (str, bool, int, float)) or isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{key}: wanted are words, finite numbers, true or false, or lists of them; found {value!r}")
    return json.dumps(value, ensure_ascii=False)


class Program:
    """The binary: the one named, else build/dovetail of this source tree, else dovetail on the path. `ranks`: under mpirun."""

    def __init__(self, named=None, ranks=None):
        self.ranks = None if ranks is None else whole_number(ranks, "ranks", 1)
        built = Path(__file__).resolve().parents[2] / "build" / "dovetail"
        found = named or (built if built.is_file() else shutil.which("dovetail"))
        if not found or not os.access(found, os.X_OK) or Path(found).is_dir():
            raise ValueError(f"{found}: is no program" if found else "found no program: neither build/dovetail nor dovetail on the "
                             "path; name it with --binary")
        self.path = Path(found).resolve()
        self.hash = hash_of(self.path)
        self._sessions = tempfile.TemporaryDirectory(prefix="dovetail-mpi-") if ranks else None

    def start(self, case, log, *options):
        surroundings = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
                        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
                        "PRTE_MCA_hwloc_default_binding_policy": "none"} | os.environ
        mpirun = ["mpirun", "-n", str(self.ranks)] if self.ranks else []
        if self.ranks:  # runs that start together do not share Open MPI's folder, which one may remove while another makes it
            surroundings.setdefault("OMPI_MCA_orte_tmpdir_base", tempfile.mkdtemp(dir=self._sessions.name))
        return subprocess.Popen([*mpirun, str(self.path), "run", str(case), *options], env=surroundings, stdin=subprocess.DEVNULL,
                                stdout=log, stderr=subprocess.STDOUT)

    def check(self, case):
        """Refuses a case as the program itself does, before anything is computed."""
        process = self.start(case, subprocess.PIPE, "--dry-run")
        said = process.communicate()[0].decode(errors="replace")
        if process.returncode != 0:
            raise ValueError(reason_in(said))


def hash_of(path):
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def reason_in(said):
    """The last message of the program in what it said, without its name."""
    messages = said.split("dovetail: ")
    return messages[-1].partition("\n")[0].strip() if len(messages) > 1 else " ".join(said.split()[-TAIL:]) or "no message"


@dataclass
class Run:
    """One setting, its folder and how it ended: `status` None (not run), 0, 3 (could not go on) or what ended it.

    `seconds` is the wall time of the whole run, `reason` why it failed, `fingerprint` a hash of all that bears on its numbers.
    """

    setting: Setting
    folder: Path
    text: str
    fingerprint: str
    status: int | None = None
    seconds: float = 0.0
    reason: str = ""

    @property
    def summary(self):
        return json.loads((self.folder / "summary.json").read_text())

    @property
    def seconds_per_point(self):
        """Processor time of the branch over its points [s]."""
        stages = {stage["name"]: sum(stage["cpu"]) for stage in self.summary["stages"]}
        return stages["5 branch"] / self.summary["points"]

    def recall(self):
        """Takes over an earlier end of the same run; says whether there was one."""
        try:
            record = json.loads((self.folder / "run.json").read_text())
        except (OSError, ValueError):
            return False
        complete = record["status"] == 3 or all((self.folder / name).is_file() for name in ("summary.json", "results.h5"))
        if record["fingerprint"] != self.fingerprint or not complete:
            return False
        self.status, self.seconds, self.reason = record["status"], record["seconds"], record["reason"]
        return True

    def keep(self):
        """Remembers an end that would come again; a run that something killed is repeated."""
        if self.status in (0, 3):
            record = {"fingerprint": self.fingerprint, "status": self.status, "seconds": self.seconds, "reason": self.reason}
            (self.folder / "run.json").write_text(json.dumps(record, indent=2) + "\n")

    def prepare(self, reduced=None):
        """Writes the folder. `reduced`: the reduced file of another run with as many modes; the program uses it if it fits."""
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "run.json").unlink(missing_ok=True)
        (self.folder / "case.toml").write_text(self.text, encoding="utf-8")
        if reduced and reduced.is_file() and not (self.folder / "reduced.h5").exists():
            shutil.copy(reduced, self.folder)

    def ended(self, status, seconds):
        self.status, self.seconds = status, seconds
        if status != 0:
            said = (self.folder / "run.log").read_text(errors="replace")
            self.reason = f"ended by signal {-status}" if status < 0 else reason_in(said)
        self.keep()


def compute(runs, program, jobs, reduced_of):
    """Does the runs, `jobs` at a time, and yields each as it ends; reduced_of(setting) is a reduced file to start from, or None.

    When the caller breaks off, runs under way are killed, and done again next time.
    """
    waiting, going = list(runs), []
    try:
        while waiting or going:
            while waiting and len(going) < jobs:
                run = waiting.pop(0)
                run.prepare(reduced_of(run.setting))
                with open(run.folder / "run.log", "wb") as log:
                    going.append((run, program.start(run.folder / "case.toml", log), time.monotonic()))
            time.sleep(PAUSE)
            for entry in [entry for entry in going if entry[1].poll() is not None]:
                going.remove(entry)
                run, process, began = entry
                run.ended(process.returncode, time.monotonic() - began)
                yield run
    finally:
        for _, process, _ in going:
            process.kill()
            process.wait()
