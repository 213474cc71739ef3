"""Wear fed back into the gap: against the closed form of one slider, and what holds of any joint."""

import csv
import shutil
import sys

import numpy as np
import pytest
import scipy.sparse as sp

from dovetail import Model
from dovetail.__main__ import main
from dovetail.wear import in_units
from dovetail.units import parse
from launch import BINARY, ROOT, words_of

MU, KN, KT, SOFT, STIFF, PRESS, DRIVEN, AREA = 0.5, 1e6, 1e6, 1e4, 1e7, 100.0, 1e5, 1e-4
ARCHARD = 1e-12  # [1/Pa]
SLIDER = f"""model = "model.h5"
reduction.modes = 1
damping.stiffness = 1e-6
excitation.fourier = [0, {DRIVEN}]
harmonic_balance.harmonics = 5
contact.normal_stiffness = {KN}
contact.tangential_stiffness = {KT}
contact.friction = {MU}
continuation.omega = [1.0, 1.2]
continuation.watch = "x1.t1"
"""


def slider(folder, units="SI", joint=True, more="", text=SLIDER):
    """A mass on a stiff spring along t1 that is driven far below its resonance, pressed by a soft one; the case file."""
    folder.mkdir(exist_ok=True)
    force, press = np.array([1.0, 0, 0, 0]), np.array([0.0, 0, PRESS, 0])
    place = {"position": np.zeros((1, 3)), "axes": np.eye(3)[None], "area": np.array([AREA]), "joint": np.zeros(1, int), "names": ["pad"]}
    Model(sp.diags([STIFF, STIFF, SOFT, STIFF]), sp.identity(4), np.array([[0, 1, 2]]), force=force, preload=press, units=units,
          joint=place if joint else None).write(folder / "model.h5")
    (folder / "case.toml").write_text(text + more)
    return folder / "case.toml"


def wear(case, *options, status=0, cycles=2e5, k=(ARCHARD, "1/Pa"), at=(1.0,)):
    given = ["--archard", *k] if k else []
    at = ["--at", *at] if at else []
    assert main(["wear", case, "--cycles", cycles, *given, *at, "--binary", BINARY, *options]) == status
    return case.with_name("case_wear")


def table(file):
    with open(file) as stream:
        head, *rows = csv.reader(stream)
    return {name.partition(" [")[0]: np.array([float(row[i]) for row in rows]) for i, name in enumerate(head)}


def closed_form(cycles):
    """Depth of the slider: N = N_0 - kappa h, and 4 mu N (X - mu N / k_t) of work per cycle make a logistic equation in N."""
    start, kappa, swing = KN * PRESS / (KN + SOFT), KN * SOFT / (KN + SOFT), DRIVEN / STIFF
    c, rate = MU / (KT * swing), kappa * ARCHARD / MU / AREA * 4 * MU * swing
    normal = 1 / (c + (1 / start - c) * np.exp(rate * np.asarray(cycles)))
    return (start - normal) / kappa


@pytest.fixture(scope="module")
def worn(tmp_path_factory):
    """Tables of a share of 20 and of half of it, and the folders."""
    found = {}
    for share in (20, 10):
        out = wear(slider(tmp_path_factory.mktemp("wear") / "slider"), "--share", share)
        found[share] = table(out / "wear.csv"), out
    return found


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Table of three blocks, and the folder."""
    out = wear(slider(tmp_path_factory.mktemp("wear") / "slider"), "--share", 10, cycles=6e4)
    return table(out / "wear.csv"), out


@pytest.mark.slow
def test_depth_goes_the_way_of_the_closed_form(worn):
    """The error is of first order in the share, and extrapolation to 0 leaves little of it."""
    curves = {share: found["largest_depth"][-1] for share, (found, _) in worn.items()}
    exact = closed_form(worn[10][0]["cycles"][-1])
    assert 0.3 < exact * SOFT / PRESS < 0.99  # the wear matters
    coarse, fine = curves[20] - exact, curves[10] - exact
    assert 1.7 < coarse / fine < 2.4 and 0 < fine < 0.05 * exact
    assert 2 * curves[10] - curves[20] == pytest.approx(exact, rel=1e-2)


def test_volume_is_that_of_the_friction_work_and_load_goes_with_the_depth(short):
    found, out = short
    work = found["power"] * 2 * np.pi / 1.0  # in a cycle, at 1 rad/s
    volume = np.concatenate([[0], np.cumsum(ARCHARD / MU * work[:-1] * np.diff(found["cycles"]))])
    np.testing.assert_allclose(found["volume"], volume, rtol=1e-8)
    np.testing.assert_allclose(found["volume"], AREA * found["largest_depth"], rtol=1e-8)
    np.testing.assert_allclose(found["clamp_load"], KN / (KN + SOFT) * (PRESS - SOFT * found["largest_depth"]), rtol=1e-6)
    assert table(out / "depth.csv")["depth"] == pytest.approx(found["largest_depth"][-1])
    np.testing.assert_allclose(np.diff(found["largest_depth"])[:-1], 10 * found["clamp_load"][:-2] / KN, rtol=1e-6)  # the block's rule
    assert (out / "wear.png").stat().st_size > 20000 and "linear from the unworn state" in (out / "wear.txt").read_text()


def test_a_wear_that_was_broken_off_goes_on(short, tmp_path, capsys):
    """What was computed is taken over: with half of its runs lost, the others are not done again."""
    shutil.copytree(short[1].parent, tmp_path / "slider")
    case, out = tmp_path / "slider/case.toml", tmp_path / "slider/case_wear"
    kept, before = out / "runs.jsonl", table(out / "wear.csv")
    lines = kept.read_text().splitlines(keepends=True)
    kept.write_text("".join(lines[:len(lines) // 2]) + lines[-1][:40])  # killed while it wrote
    wear(case, "--share", 10, cycles=6e4)
    again = table(out / "wear.csv")
    assert all(np.array_equal(again[name], before[name]) for name in before)
    assert kept.read_text().startswith("".join(lines[:len(lines) // 2]))
    lines = capsys.readouterr().err.splitlines()
    assert lines[-1].startswith("wear: 6e+04 of 6e+04 cycles") and "left" not in lines[-1]
    assert len(lines) > 1 and all(" s, about " in line and line.endswith(" left") for line in lines[:-1])


@pytest.mark.parametrize("options, message", [
    ({"k": None}, "how much wears off is wanted"),
    ({"k": ("1e-12", "1/s")}, "1/s is no unit of wear"),
    ({"k": ("-1", "1/Pa")}, "a number greater than 0 and its unit"),
    ({"k": ("none", "1/Pa")}, "a number greater than 0 and its unit"),
    ({"cycles": 0}, "--cycles 0: must be greater than 0")])
def test_wrong_options_are_refused_before_anything_is_run(tmp_path, capsys, options, message):
    out = wear(slider(tmp_path / "slider"), status=2, **options)
    assert message in capsys.readouterr().err and not out.exists()


@pytest.mark.parametrize("change, message", [
    (("friction = 0.5", "friction = 0.0"), "friction is 0 at all contact points"),
    (("friction = 0.5", "friction = [0.5, 0.4]"), "differs between its directions"),
    ((f"contact.tangential_stiffness = {KT}\ncontact.friction = {MU}", 'contact.law = "unilateral"'),
     "no contact point of this case has friction"),
    (("[0, 100000.0]", "[0, 1.0]"), "no contact point slips at that motion")])
def test_joints_that_do_not_wear_are_refused(tmp_path, capsys, change, message):
    assert change[0] in SLIDER
    wear(slider(tmp_path / "slider", text=SLIDER.replace(*change)), status=2)
    assert message in capsys.readouterr().err


def test_areas_and_units_must_be_known(tmp_path, capsys):
    wear(slider(tmp_path / "bare", joint=False), status=2)
    assert "the areas of its contact points are not known" in capsys.readouterr().err
    wear(slider(tmp_path / "unnamed", units="none"), status=2)
    assert "write model in place of the unit" in capsys.readouterr().err


def test_without_a_peak_a_frequency_is_asked_for(tmp_path, capsys):
    assert not (wear(slider(tmp_path / "slider"), at=(), status=3) / "wear.csv").exists()
    assert "name a frequency with --at" in capsys.readouterr().err


def test_units_of_wear():
    """1 mm^3/Nm is 1e-9 m^3/J, 1e-3 of 1/MPa: in N and mm it is 1e-3 mm^2/N."""
    assert in_units("mm^3/Nm", parse("SI")) == pytest.approx(1e-9)
    assert in_units("mm^3/Nm", parse("t, mm, s, N")) == pytest.approx(1e-3)
    assert in_units("1/Pa", parse("mm, ms, kg")) == pytest.approx(1e9)  # kN
    assert in_units("model", parse("none")) == 1.0


@pytest.mark.slow
def test_a_lap_joint_loses_clamp_load_where_it_slips(tmp_path):
    """At the peak of every moment; places and joints are known."""
    shutil.copytree(ROOT / "python/dovetail/template", tmp_path / "joint", ignore=shutil.ignore_patterns("__pycache__"))
    words_of([sys.executable, str(tmp_path / "joint/model.py")])
    out = wear(tmp_path / "joint/case.toml", at=(), cycles=1.2e7, k=("1e-15", "1/Pa"), status=0)
    found, depth = table(out / "wear.csv"), table(out / "depth.csv")
    assert (np.diff(found["largest_depth"]) > 0).all() and found["clamp_load"][-1] < found["clamp_load"][0]
    assert {"x", "y", "z"} <= depth.keys() and depth["depth"].max() == pytest.approx(found["largest_depth"][-1])
