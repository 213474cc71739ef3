"""scripts/mutation: what it changes in a line, and that a planted change is noticed where a test looks and not where none can."""

import json
import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

import mutation
from launch import ROOT
from mutation import VERDICTS
from operators import mutants
from rooms import CppRoom, Mutant, PythonRoom

TOOL = [sys.executable, str(ROOT / "tests" / "mutation" / "mutation.py")]
needs_build = pytest.mark.skipif(not (ROOT / "build" / "build.ninja").exists(),
                                 reason="needs build/, where mutants are compiled: scripts/setup makes it")


def replacements(line, suffix, number=1):
    return {after for at, after in mutants(line, suffix) if at == number}


def test_lines_of_cpp_are_changed_by_one_thing():
    assert replacements("if (a < 2 && !b) c(1.5);", ".cpp") == {
        "if (a <= 2 && !b) c(1.5);", "if (a >= 2 && !b) c(1.5);", "if (a < 0 && !b) c(1.5);", "if (a < 1 && !b) c(1.5);",
        "if (a < -1 && !b) c(1.5);", "if (a < 2 || !b) c(1.5);", "if (a < 2 && b) c(1.5);", "if (!(a < 2 && !b)) c(1.5);",
        "if (a < 2 && !b) c(0.0);", "if (a < 2 && !b) c(1.0);", "if (a < 2 && !b) c(-1.0);"}
    assert replacements("  x = std::min(a, b);", ".cpp") == {"  x = std::max(a, b);", "  ;"}
    assert replacements("std::vector<double> x(n); // 1 < 2", ".cpp") == set()  # a declaration, a template and a comment
    assert replacements('  if (const auto *p = f("a < 1")) return p;', ".cpp") == set()
    assert replacements("f(a,\n  b);", ".cpp") == replacements("f(a,\n  b);", ".cpp", 2) == set()  # half a statement


def test_lines_of_python_are_changed_by_one_thing():
    assert replacements("x = a if not b else -c  # 1", ".py") == {
        "x = a if b else -c  # 1", "x = a if not (not b) else -c  # 1", "x = a if not b else c  # 1", "pass"}
    assert replacements("if a and f(b):\n    raise E(f'{a} < 1')", ".py") == {"if a or f(b):", "if not (a and f(b)):"}
    assert replacements("if a and f(b):\n    raise E(f'{a} < 1')", ".py", 2) == {"    pass"}
    assert replacements('"""1 < 2"""\nimport a', ".py") == set()


def test_a_change_is_noticed_or_not(tmp_path):
    root, scratch = tmp_path / "tree", tmp_path / "scratch"
    module, guard = root / "python" / "dovetail" / "small.py", root / "tests" / "python" / "test_small.py"
    for file, text in ((module, "def larger(a, b):\n    if a > b:\n        return a\n    return b\n"),
                       (guard, "from dovetail.small import larger\n\n\ndef test():\n    assert larger(1, 2) == larger(2, 1) == 2\n")):
        file.parent.mkdir(parents=True)
        file.write_text(text)
    room = PythonRoom(root, scratch, ["small.py"], ["python/test_small.py"], [])
    verdicts = {after.strip(): room.verdict(Mutant("python/dovetail/small.py", 2, "    if a > b:", after))
                for after in ("    if a <= b:", "    if a >= b:", "    if a >")}
    assert verdicts == {"if a <= b:": ("killed near", "python/test_small.py"),
                        "if a >= b:": ("survived", ""), "if a >": ("not compiled", "")}
    assert (scratch / "mutated" / "python" / "dovetail" / "small.py").read_text() == module.read_text()  # for the next one
    (guard.parent / "test_other.py").write_text("def test():\n    pass\n")
    half = PythonRoom(root, tmp_path / "half", ["small.py"], ["python/test_other.py"], None)
    whole = PythonRoom(root, tmp_path / "whole", ["small.py"], ["python/test_none.py"], ["python/test_small.py"])
    mutant = Mutant("python/dovetail/small.py", 2, "    if a > b:", "    if a <= b:")
    assert half.verdict(mutant) == ("survived near", "")
    assert whole.verdict(mutant, survived_near=True) == ("killed far", "python/test_small.py")
    guard.write_text(guard.read_text() + "    assert False\n")
    assert PythonRoom(root, tmp_path / "fails", ["small.py"], ["python/test_small.py"], []).verdict(mutant) == ("survived", "")  # anyhow


@needs_build
@pytest.mark.slow
def test_a_change_of_the_core_is_noticed(tmp_path):
    room, lines = CppRoom("recovery", ROOT, tmp_path), (ROOT / "src" / "recovery" / "elsewhere.cpp").read_text().splitlines()
    line = next(number for number, text in enumerate(lines, 1) if "sweep.from == sweep.to" in text)
    before = lines[line - 1]
    verdicts = [room.verdict(Mutant("src/recovery/elsewhere.cpp", line, before, before.replace("false", other)))
                for other in ("true", "0", "nothing")]
    assert verdicts == [("killed near", "unit.recovery.np1"), ("equivalent", ""), ("not compiled", "")]


@needs_build
def test_what_is_known_is_not_tried_again(tmp_path):
    kept, every = tmp_path / "kept", list(mutation.mutants_of(SimpleNamespace(root=ROOT, sources=[ROOT / "src/recovery/jump.cpp"])))
    entries = [{"key": mutation.key_of(mutant), "verdict": VERDICTS[i % 4]} for i, mutant in enumerate(every)]
    kept.write_text("".join(json.dumps(entry) + "\n" for entry in entries))
    command = [*TOOL, "--near", "--room", "recovery", "--mutants", "1000", "--at", "src/recovery/jump.cpp", "--kept", str(kept)]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    n = len(every)
    counts = [len(range(i, n, 4)) for i in range(4)]
    near, both = (f"{100 * killed / n:.0f} %" for killed in (counts[0], counts[0] + counts[1]))
    assert f"| recovery | {n} | {' | '.join(map(str, counts))} | 0 | 0 | {near} | {both} |" in said
    assert said.count("survived: src/recovery/jump.cpp:") == counts[2] + counts[3] and len(kept.read_text().splitlines()) == n


def test_nothing_is_left_after_an_interrupt(tmp_path):
    before = (ROOT / "python" / "dovetail" / "model.py").read_bytes()
    process = subprocess.Popen([*TOOL, "--room", "model", "--kept", str(tmp_path / "kept")], stderr=subprocess.PIPE, text=True,
                               env=os.environ | {"TMPDIR": str(tmp_path)})
    while process.poll() is None and not list(tmp_path.glob("dovetail-mutation-*/unchanged/build")):
        time.sleep(0.02)
    process.send_signal(signal.SIGTERM)
    assert "interrupted" in process.communicate()[1]
    assert process.returncode == 1 and not list(tmp_path.glob("dovetail-*"))
    assert (ROOT / "python" / "dovetail" / "model.py").read_bytes() == before
