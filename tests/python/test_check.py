"""`dovetail check`: refuses what a run refuses, warns of what is rarely meant, with a section of a page, and writes nothing."""

import re
import shutil
import subprocess
import sys
from types import SimpleNamespace

import brick
import pytest

from dovetail import Joint
from dovetail.__main__ import main
from launch import ROOT, SURROUNDINGS, run

STEEL = {"young": 2.1e11, "poisson": 0.3, "density": 7850.0}  # the blocks are 2 m long: 700 Hz and up
CASE = """model = "model.h5"
[reduction]
modes = 6
[damping]
stiffness = 1e-7
[excitation]
fourier = [0, 1]
[harmonic_balance]
harmonics = 3
[continuation]
omega = [3000, 9000]
[output]
directory = "out"
"""


def write(folder, text=CASE, preload=-1e5, units="SI", held=("bottom",), force=(1e3, 0, 0), material=STEEL, **joint):
    """Two blocks, one on the other, with a case; returns what `run` takes."""
    structure = brick.pair(**material).clamped(*held).with_force("top", force)
    if preload:
        structure = structure.with_preload("top", [0, 0, preload])
    springs = {"normal_stiffness": 1e12, "tangential_stiffness": 5e11, "friction": 0.3} | joint
    model = structure.join([Joint.between(structure.surface("upper"), structure.surface("lower"), **springs)])
    model.units = units
    model.write(folder / "model.h5")
    path = folder / "case.toml"
    path.write_text(text)
    return SimpleNamespace(path=path)


def check(case, **where):
    """Kinds of the warnings and what was said, after nothing was written."""
    before = {path: path.stat().st_mtime_ns for path in case.path.parent.rglob("*")}
    done = run(case, command="check", out="out", **where)
    assert before == {path: path.stat().st_mtime_ns for path in case.path.parent.rglob("*")}
    kinds = re.findall(r"^  docs/how-to/check-a-case.md#(\w+)$", done.out, re.MULTILINE)
    assert len(kinds) == len(re.findall("^warning: ", done.out, re.MULTILINE))
    last = done.out.splitlines()[-1]
    assert last.startswith(f"{case.path}: " + (f"{len(kinds)} warning" if kinds else "no warnings"))
    return kinds, done.out


def test_a_sound_case_has_no_warnings(tmp_path):
    case = write(tmp_path)
    kinds, said = check(case)
    assert not kinds and "once the model is reduced" in said
    run(case, command="reduce", out="out")
    kinds, said = check(case, ranks=2)
    assert not kinds and "once the model is reduced" not in said, said


def changed(old, new):
    assert old in CASE
    return {"text": CASE.replace(old, new)}


FAULTS = [
    ("no_damping", changed("stiffness = 1e-7", ""), r"damping.stiffness = 3.33e-07 is 0.1 % of critical at 6000 rad/s"),
    ("much_damping", changed("1e-7", "0.02"), r"6e\+03 % of critical"),
    ("few_harmonics", changed("harmonics = 3", "harmonics = 2"), "harmonic 3 above all"),
    ("contact_stiffness", {"normal_stiffness": 1e20}, r"contact.normal_stiffness = \S+ N/m is .* rigid"),
    ("contact_stiffness", {"tangential_stiffness": 1e3}, r"contact.tangential_stiffness = \S+ N/m is .* joins nothing"),
    ("not_pressed", {"preload": 0}, "nothing presses the joint"),
    ("units", {"material": STEEL | {"density": 7.85e-9}}, r"of .*e-09 kg/m\^3"),
    ("units", {"material": STEEL | {"young": 2.1e5}, "normal_stiffness": 1e6, "tangential_stiffness": 1e6}, "waves run at some"),
    ("units", {"units": "t, mm, s, N"}, 'would fit the label "kg, m, s"'),
    ("units", {"units": "none", "material": STEEL | {"density": 1e5}}, "fit no usual system of units"),
]


@pytest.mark.parametrize("kind, fault, words", FAULTS, ids=[f"{i}_{fault[0]}" for i, fault in enumerate(FAULTS)])
def test_a_fault_is_told_and_no_other(kind, fault, words, tmp_path):
    kinds, said = check(write(tmp_path, **fault))
    assert kinds == [kind] and re.search(words, said), said


@pytest.mark.parametrize("units, length, mass, time", [("kg, m, s", 1, 1, 1), ("t, mm, s", 1e3, 1e-3, 1), ("kg, mm, ms", 1e3, 1, 1e3),
                                                       ("lbf, in, s", 1 / 0.0254, 1 / 175.126835, 1), ("none", 1e3, 1e-3, 1)])
def test_no_system_of_units_is_taken_for_another(units, length, mass, time, tmp_path):
    """The same blocks in other units, with or without their label."""
    stress, stiffness, force = mass / length / time**2, mass / (length * time) ** 2, mass * length / time**2  # per area
    steel = {"young": 2.1e11 * stress, "poisson": 0.3, "density": 7850 * mass / length**3, "mapping": lambda places: length * places}
    case = write(tmp_path, CASE.replace("1e-7", f"{1e-7 * time}").replace("[3000, 9000]", f"[{3000 / time}, {9000 / time}]"), units=units,
                 material=steel, preload=-1e5 * force, normal_stiffness=1e12 * stiffness, tangential_stiffness=5e11 * stiffness)
    assert check(case)[0] == []


@pytest.fixture
def five(tmp_path):
    """inputs/dof5, with its model."""
    for name in ("model.py", "case.toml"):
        shutil.copy(ROOT / "inputs/dof5" / name, tmp_path)
    subprocess.run([sys.executable, tmp_path / "model.py"], env=SURROUNDINGS, check=True)
    return SimpleNamespace(path=tmp_path / "case.toml")


def test_more_ranks_than_points_are_told(five):
    kinds, said = check(five, ranks=2)
    assert kinds == ["idle_ranks"] and "2 ranks share 1 contact points" in said
    assert check(five)[0] == []


def test_a_sweep_in_the_wrong_unit_is_told(five):
    run(five, command="reduce", out="out")
    right = five.path.read_text()
    five.path.write_text(right.replace("[0.9, 1.3]", "[0.15, 0.2]"))
    kinds, said = check(five)
    assert kinds == ["no_resonance"] and 'continuation.unit = "Hz"' in said
    five.path.write_text(right.replace("[0.9, 1.3]", '[0.15, 0.2]\nunit = "Hz"'))
    assert check(five)[0] == []


def test_a_load_that_the_modes_leave_out_is_told(tmp_path):
    """Pulled up and down, with one mode, which sways."""
    case = write(tmp_path, CASE.replace("modes = 6", "modes = 1"), force=(0, 0, 1e3))
    run(case, command="reduce", out="out")
    kinds, said = check(case)
    assert kinds == ["load_left_out"] and "more reduction.modes than 1" in said
    case.path.write_text(CASE.replace("modes = 6", "modes = 40"))
    run(case, command="reduce", out="out")
    assert check(case)[0] == []


def test_a_joint_without_equilibrium_is_told(tmp_path):
    """The upper block, which nothing else holds, is pulled off."""
    case = write(tmp_path, preload=1e5)
    run(case, command="reduce", out="out")
    kinds, said = check(case)
    assert "no_equilibrium" in kinds and "found no equilibrium" in said


def test_what_a_run_refuses_is_refused(tmp_path):
    case = write(tmp_path, CASE.replace("harmonics = 3", "harmonic = 3"))
    assert "did you mean harmonics" in run(case, command="check", out="out", status=2).err
    case.path.write_text(CASE)
    (tmp_path / "model.h5").write_bytes(b"no model")
    run(case, command="check", out="out", status=2)
    assert not (tmp_path / "out").exists()
    assert "not an option here" in run(case, "--restart", command="check", status=2).err


def test_the_template_is_sound(tmp_path):
    main(["new", str(tmp_path / "joint")])
    subprocess.run([sys.executable, tmp_path / "joint/model.py"], env=SURROUNDINGS, check=True)
    assert check(SimpleNamespace(path=tmp_path / "joint/case.toml"))[0] == []


@pytest.mark.slow
@pytest.mark.parametrize("name, options, cases", [("two_solids", ["--size", "0.02"], ["case.toml", "mode.toml"]),
                                                  ("blade_root", ["--dofs", "16000", "--flank", "1x3"], ["case.toml"]),
                                                  ("blisk", ["--dofs", "18000", "--flank", "1x2", "--shroud", "1x1"], ["case.toml"])])
def test_shipped_inputs_are_sound(name, options, cases, tmp_path):
    subprocess.run([sys.executable, ROOT / f"inputs/{name}/model.py", *options, "-o", tmp_path / "model.h5"], env=SURROUNDINGS, check=True)
    for case in cases:
        shutil.copy(ROOT / f"inputs/{name}/{case}", tmp_path)
        assert check(SimpleNamespace(path=tmp_path / case))[0] == []
    if name == "two_solids":
        run(SimpleNamespace(path=tmp_path / "case.toml"), command="reduce", out="out")
        assert check(SimpleNamespace(path=tmp_path / "case.toml"))[0] == []
