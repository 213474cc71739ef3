"""Contact stiffness per area in the case file: that of each point, times its area, which the model or the reduced file has."""

from types import SimpleNamespace

import brick
import h5py
import numpy as np
import pytest

from dovetail import Joint
from launch import line, words_of
from launch import run as launched

CASE = """{model}
damping.stiffness = 0.02
excitation.fourier = [0, 1]
harmonic_balance.harmonics = 2
continuation.omega = [0.2, 0.2]
{contact}
contact.friction = 0.3
"""
PER_AREA = "contact.normal_stiffness_per_area = 3.0\ncontact.tangential_stiffness_per_area = [2.0, 1.0]"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A model with areas of three sizes and without stiffnesses."""
    folder = tmp_path_factory.mktemp("per_area")
    structure = brick.pair(poisson=0.3).clamped("bottom").with_force("top", [0, 1e-6, 0]).with_preload("top", [0, 0, -1e-3])
    joint = Joint.between(structure.surface("upper"), structure.surface("lower"))
    assert len(np.unique(joint.area.round(9))) == 3
    structure.join([joint]).write(folder / "model.h5")
    np.save(folder / "area.npy", joint.area)
    return folder


def case(folder, out, contact, model='model = "model.h5"\nreduction.modes = 4'):
    (folder / f"{out}.toml").write_text(CASE.format(model=model, contact=contact))
    return SimpleNamespace(path=folder / f"{out}.toml")


def run(folder, out, contact, **model):
    done = launched(case(folder, out, contact, **model), out=out)
    with h5py.File(done.folder / "results.h5") as file:
        return {name: file[name][()] for name in ("points/omega", "points/coefficients", "contact/normal_stiffness")}


def test_it_is_the_stiffness_of_each_point_divided_by_its_area(folder):
    area = np.load(folder / "area.npy")
    ours = run(folder, "per_area", PER_AREA)
    np.testing.assert_allclose(ours["contact/normal_stiffness"], 3 * area, rtol=1e-15)
    by_hand = f"contact.normal_stiffness = {(3 * area).tolist()}\ncontact.tangential_stiffness = {np.outer(area, [2.0, 1.0]).tolist()}"
    theirs = run(folder, "by_hand", by_hand)
    for name, values in theirs.items():
        np.testing.assert_array_equal(ours[name], values, err_msg=name)


def test_a_reduced_file_keeps_the_areas(folder):
    run(folder, "first", PER_AREA)
    reduced = 'reduced = "first/reduced.h5"'
    again = run(folder, "again", PER_AREA, model=reduced)
    np.testing.assert_array_equal(again["contact/normal_stiffness"], 3 * np.load(folder / "area.npy"))
    with h5py.File(folder / "first" / "reduced.h5", "a") as file:
        del file["contact/area"]
    said = launched(case(folder, "without", PER_AREA, reduced), status=2).err
    assert "without.toml:6: contact.normal_stiffness_per_area: the area of the contact points is not known" in said


def test_the_dry_run_shows_both(folder):
    command, _ = line(case(folder, "dry", PER_AREA), "--dry-run")
    said, _ = words_of(command)
    lines = [line.split() for line in said.splitlines()]
    assert ["contact.normal_stiffness_per_area", "3", "[N/m^3]", "given"] in lines
    assert ["contact.normal_stiffness", "0.375", "..", "1.5", "[N/m]", "per", "area,", "below"] in lines
