"""Rooms of the source and the tests that guard them: what becomes of one mutant."""

import json
import math
import os
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

CPP = ["contact", "stuck", "modal", "harmonic", "continuation", "recovery", "reduction"]
# Files of quick tests of Python's for rooms of the core: first those of every room.
FAR_CPP = {"": ["verification/test_against_core.py", "verification/test_modal_form.py"],
           "contact": ["verification/test_exact.py", "verification/test_contact_activity.py", "verification/test_derivatives.py"],
           "stuck": ["verification/test_sector.py"], "modal": ["verification/test_damping.py", "verification/test_first_points.py"],
           "harmonic": ["verification/test_damping.py", "verification/test_first_points.py", "verification/test_sector.py"],
           "continuation": ["python/test_restart.py", "verification/test_places.py", "verification/test_paths.py"],
           "recovery": ["verification/test_range_runs.py", "verification/test_hard_curves.py"],
           "reduction": ["python/test_reduction.py", "verification/test_estimates.py", "verification/test_sector_left_out.py"]}
# Modules; files of their own quick tests; those of others.
PYTHON = {"model": (["model*.py", "hdf5_parts.py"], [f"python/test_{name}.py" for name in ("model", "model_file", "model_parts")],
                    [f"python/test_{name}.py" for name in ("joint", "cyclic", "structure", "import_matrices")]),
          "results": (["results.py", "hdf5_read.py"], [f"python/test_{name}.py" for name in ("hdf5_read", "results_values", "results")],
                      [f"python/test_{name}.py" for name in ("motion", "export", "wrong_input", "wishes")] +
                      ["verification/test_sensitivity.py", "verification/test_sector_results.py"])}
CTEST_SECONDS, PYTEST_SECONDS = 20, 120  # of the processor, of what takes a fifth of that
PATIENCE = 30  # times as long as that by the clock: for what waits for ever, on a machine that is busy


@dataclass(frozen=True)
class Mutant:
    """A line of a file, named from the root of the tree, and what replaces it."""

    file: str
    line: int
    before: str
    after: str

    def text(self, root):
        """The whole file with the change."""
        lines = (root / self.file).read_text().split("\n")
        lines[self.line - 1] = self.after
        return "\n".join(lines)


def fails(command, seconds, folder, surroundings):
    """Whether a command fails or takes longer; nothing of it is left running. No new session, which would have a priority of its own."""
    surroundings = surroundings | {"OMPI_MCA_opal_signal": "10"}  # Open MPI's handler of crashes may wait for ever in a broken heap
    process = subprocess.Popen(command, cwd=folder, env=os.environ | surroundings, process_group=0, stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                               preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds)))
    try:
        return process.wait(PATIENCE * seconds) != 0
    except subprocess.TimeoutExpired:
        return True
    finally:
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait()


class Judge:
    """Whom to believe: a test that fails without the change, too, notices nothing."""

    def __init__(self):
        self.passed = {}

    def notices(self, name, mutated, unchanged):
        """Whether a test fails of the mutant and passes without; both are arguments of fails()."""
        if not fails(*mutated):
            return False
        if name not in self.passed:
            self.passed[name] = not fails(*unchanged)
        return self.passed[name]


def pytest(root, files):
    return [sys.executable, "-W", "ignore", "-m", "pytest", "-x", "-q", "-m", "not slow", "-p", "no:cacheprovider",
            *(str(root / "tests" / file) for file in files)]


def distance(file, room):
    """1 where a test includes a header of the room, 2 where a header beside it does, and so on; infinity where none does."""
    names = re.findall(r'^#include "(.*)"', file.read_text(), re.M)
    if any(name.startswith(f"{room}/") for name in names):
        return 1
    return 1 + min((distance(file.parent / name, room) for name in names if (file.parent / name).exists()), default=math.inf)


class CppRoom:
    """Mutants of src/NAME: the object of one file is compiled, and linked in front of the library."""

    def __init__(self, name, root, scratch, near=False):
        self.name, self.root, self.scratch, self.build, self.near = name, root, scratch, root / "build", near
        self.sources = sorted((root / "src" / name).glob("*.cpp"))
        self.commands = {entry["file"]: entry["command"] for entry in json.loads((self.build / "compile_commands.json").read_text())}
        self.tests = [test for test in json.loads(self.said("ctest", "-L", "quick", "--show-only=json-v1"))["tests"]
                      if re.match(r"contact\.|unit\.", test["name"])]
        self.links = {target: self.said("ninja", "-t", "commands", target).splitlines()[-1]
                      for target in ("contact_tests", "unit_tests", "dovetail")}
        self.judge = Judge()

    def said(self, *command):
        return subprocess.run(command, cwd=self.build, capture_output=True, text=True, check=True).stdout

    def objects_of(self, file, text):
        """The object that a file's text makes, or None, and that of the build."""
        source, made = self.scratch / file, self.scratch / "mutant.o"
        source.parent.mkdir(parents=True, exist_ok=True)
        source.write_text(text)
        made.unlink(missing_ok=True)
        words = shlex.split(self.commands[str(self.root / file)])
        built = self.build / words[words.index("-o") + 1]
        words[words.index("-o") + 1], words[words.index("-c") + 1] = str(made), str(source)
        subprocess.run(words, cwd=self.build, capture_output=True)
        return made.read_bytes() if made.exists() else None, built.read_bytes()

    def program(self, target, ready):
        """The mutant's program, made at first use, or None if it cannot be."""
        made = self.scratch / target
        if target not in ready:
            made.unlink(missing_ok=True)
            command = re.sub(r" -o \S+", f" -o {shlex.quote(str(made))}", self.links[target])
            command = command.replace(" libdovetail_core.a", f" {shlex.quote(str(self.scratch / 'mutant.o'))} libdovetail_core.a", 1)
            if shutil.which("ld.gold"):  # in a quarter of the time, which is more than that of compiling
                command = command.replace(" -o ", " -fuse-ld=gold -o ", 1)
            subprocess.run(command, shell=True, cwd=self.build, capture_output=True)
            ready.add(target)
        return str(made) if made.exists() else None

    def guards(self, file):
        """(whether near, test), the likeliest first. Near: of the file's name, or its room. Far: these on two ranks, and of other rooms."""
        ordered = []
        for test in self.tests:
            stem = re.sub(r"^\w+\.|\.np\d$", "", test["name"])
            named, two = stem == Path(file).stem, test["name"].endswith("np2")
            far = 0 if named else distance(self.root / "tests" / "unit" / f"test_{stem}.cpp", self.name)
            near = far < math.inf and not two
            ordered.append(((not near, far, two), (near, test)))
        return [guard for _, guard in sorted(ordered, key=lambda entry: entry[0])]

    def notices(self, test, ready):
        """Whether a C++ test does. On one rank it needs no `mpiexec`."""
        settings = {entry["name"]: entry["value"] for entry in test["properties"]}
        place, surroundings = settings["WORKING_DIRECTORY"], dict(entry.split("=", 1) for entry in settings["ENVIRONMENT"])
        words = test["command"]
        at = next(i for i, word in enumerate(words) if word.startswith(str(self.build)))
        launcher = words[:at] if test["name"].endswith("np2") else []
        runs = [([*launcher, program, *words[at + 1:]], CTEST_SECONDS, place, surroundings)
                for program in (self.program(Path(words[at]).name, ready), words[at])]
        return self.judge.notices(test["name"], *runs)

    def verdict(self, mutant, survived_near=False):
        """One of VERDICTS, and the name of the test that noticed."""
        (made, built), ready = self.objects_of(mutant.file, mutant.text(self.root)), set()
        if made == built:
            return "equivalent", ""
        if not made or not self.program("contact_tests" if self.name == "contact" else "unit_tests", ready):
            return "not compiled", ""
        for near, test in self.guards(mutant.file):
            if not (survived_near if near else self.near) and self.notices(test, ready):
                return "killed near" if near else "killed far", test["name"]
        if self.near:
            return "survived near", ""
        for file in FAR_CPP[""] + FAR_CPP[self.name]:
            runs = [(pytest(self.root, [file]), PYTEST_SECONDS, self.root, {"DOVETAIL": str(program)})
                    for program in (self.program("dovetail", ready), self.build / "dovetail")]
            if self.judge.notices(file, *runs):
                return "killed far", file
        return "survived", ""


class PythonRoom:
    """Mutants of modules of the package, in a copy of it and of the tests."""

    def __init__(self, root, scratch, patterns, near, far):
        self.root, self.guards, self.judge = root, [(True, file) for file in near] + [(False, file) for file in far or []], Judge()
        self.near = far is None
        self.sources = sorted(file for pattern in patterns for file in (root / "python" / "dovetail").glob(pattern))
        self.copies = [scratch / "mutated", scratch / "unchanged"]
        for copy in self.copies:
            for folder in ("python", "tests", "inputs"):
                if (root / folder).exists():
                    shutil.copytree(root / folder, copy / folder)
            (copy / "build").symlink_to(root / "build")

    def verdict(self, mutant, survived_near=False):
        """One of VERDICTS, and the file of the tests that noticed."""
        text, place = mutant.text(self.root), self.copies[0] / mutant.file
        try:
            compile(text, mutant.file, "exec")
        except SyntaxError:
            return "not compiled", ""
        place.write_text(text)
        try:
            for near, file in self.guards:
                runs = [(pytest(copy, [file]), PYTEST_SECONDS, copy,
                         {"PYTHONPATH": f"{copy}/python:{self.root}/build/extras", "PYTHONDONTWRITEBYTECODE": "1"})
                        for copy in self.copies]
                if not (near and survived_near) and self.judge.notices(file, *runs):
                    return "killed near" if near else "killed far", file
            return "survived near" if self.near else "survived", ""
        finally:
            shutil.copyfile(self.root / mutant.file, place)
