"""Rooms of the source and the tests that guard them: what becomes of one mutant."""

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

CPP = ["contact", "harmonic", "continuation", "recovery", "reduction"]
NEAR_CPP = ["verification/test_against_core.py", "verification/test_modal_form.py"]  # where all quick C++ tests pass
# Modules, and files of quick tests: the second ones where the first ones pass.
PYTHON = {"model": (["model*.py", "hdf5_parts.py"],
                    [["python/test_model.py"], [f"python/test_{name}.py" for name in ("cyclic", "structure", "import_matrices", "joint")]]),
          "results": (["results.py", "hdf5_read.py"],
                      [["python/test_results.py"], [f"python/test_{name}.py" for name in ("motion", "export", "wrong_input")]])}
CTEST_SECONDS, PYTEST_SECONDS = 60, 600  # of what takes a tenth of that on an idle machine


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
    """Whether a command fails or takes longer; nothing of it is left running."""
    process = subprocess.Popen(command, cwd=folder, env=os.environ | surroundings, start_new_session=True, stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        return process.wait(seconds) != 0
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


def included(file):
    """Names of the headers of src that a test includes; if none, of those that headers beside it include."""
    names = re.findall(r'^#include "(.*)"', file.read_text(), re.M)
    beside = [file.parent / name for name in names if (file.parent / name).exists()]
    return [name for name in names if "/" in name] or [name for header in beside for name in included(header)]


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
        self.judge, self.original = Judge(), {}

    def said(self, *command):
        return subprocess.run(command, cwd=self.build, capture_output=True, text=True, check=True).stdout

    def object_of(self, file, text):
        """The object that a file's text makes, or None."""
        source, made = self.scratch / file, self.scratch / "mutant.o"
        source.parent.mkdir(parents=True, exist_ok=True)
        source.write_text(text)
        made.unlink(missing_ok=True)
        words = shlex.split(self.commands[str(self.root / file)])
        words[words.index("-o") + 1], words[words.index("-c") + 1] = str(made), str(source)
        subprocess.run(words, cwd=self.build, capture_output=True)
        return made.read_bytes() if made.exists() else None

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
        """Quick tests, the likeliest first: of the file's name, of its room, these on two ranks, and of other rooms on one."""
        ordered = []
        for test in self.tests:
            stem = re.sub(r"^\w+\.|\.np\d$", "", test["name"])
            named, two = stem == Path(file).stem, test["name"].endswith("np2")
            near = named or any(name.startswith(f"{self.name}/") for name in included(self.root / "tests" / "unit" / f"test_{stem}.cpp"))
            if near and not two or not self.near and (near or not two):
                ordered.append(((not named, two or not near, not near), test))
        return [test for _, test in sorted(ordered, key=lambda entry: entry[0])]

    def verdict(self, mutant):
        """One of VERDICTS, and the name of the test that noticed."""
        if mutant.file not in self.original:
            self.original[mutant.file] = self.object_of(mutant.file, (self.root / mutant.file).read_text())
            assert self.original[mutant.file], f"{mutant.file} does not compile as it is"
        made, ready = self.object_of(mutant.file, mutant.text(self.root)), set()
        if made == self.original[mutant.file]:
            return "equivalent", ""
        if not made or not self.program("contact_tests" if self.name == "contact" else "unit_tests", ready):
            return "not compiled", ""
        for test in self.guards(mutant.file):
            settings = {entry["name"]: entry["value"] for entry in test["properties"]}
            place, surroundings = settings["WORKING_DIRECTORY"], dict(entry.split("=", 1) for entry in settings["ENVIRONMENT"])
            command = [self.program(Path(word).name, ready) if word.startswith(str(self.build)) else word for word in test["command"]]
            runs = [(words, CTEST_SECONDS, place, surroundings) for words in (command, test["command"])]
            if self.judge.notices(test["name"], *runs):
                return "killed", test["name"]
        if self.near:
            return "survived", ""
        runs = [(pytest(self.root, NEAR_CPP), PYTEST_SECONDS, self.root, {"DOVETAIL": str(program)})
                for program in (self.program("dovetail", ready), self.build / "dovetail")]
        return ("killed", "verification") if self.judge.notices("verification", *runs) else ("survived", "")


class PythonRoom:
    """Mutants of modules of the package, in a copy of it and of the tests."""

    def __init__(self, root, scratch, patterns, stages):
        self.root, self.stages, self.judge = root, stages, Judge()
        self.sources = sorted(file for pattern in patterns for file in (root / "python" / "dovetail").glob(pattern))
        self.copies = [scratch / "mutated", scratch / "unchanged"]
        for copy in self.copies:
            for folder in ("python", "tests", "inputs"):
                if (root / folder).exists():
                    shutil.copytree(root / folder, copy / folder, ignore=shutil.ignore_patterns("__pycache__"))
            (copy / "build").symlink_to(root / "build")

    def verdict(self, mutant):
        """One of VERDICTS, and the first file of the tests that noticed."""
        text, place = mutant.text(self.root), self.copies[0] / mutant.file
        try:
            compile(text, mutant.file, "exec")
        except SyntaxError:
            return "not compiled", ""
        place.write_text(text)
        try:
            for files in self.stages:
                runs = [(pytest(copy, files), PYTEST_SECONDS, copy,
                         {"PYTHONPATH": f"{copy}/python:{self.root}/build/extras", "PYTHONDONTWRITEBYTECODE": "1"})
                        for copy in self.copies]
                if self.judge.notices(files[0], *runs):
                    return "killed", files[0]
            return "survived", ""
        finally:
            shutil.copyfile(self.root / mutant.file, place)
