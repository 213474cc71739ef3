"""The bladed-disk example: its model by its options, and that the program takes it with its case."""

import argparse
import shutil
import subprocess
import sys

import numpy as np
import pytest

from dovetail import Model
from dovetail.cells import outer_faces
from dovetail.meshes.divisions import pair
from launch import BINARY, ROOT, SECONDS, SURROUNDINGS, words_of

EXAMPLE = ROOT / "inputs/blisk"


@pytest.fixture(scope="module")
def make(tmp_path_factory):
    """The model that some options make, and what was printed."""
    made = {}

    def of(*options):
        if options not in made:
            path = tmp_path_factory.mktemp("blisk") / "model.h5"
            command = [sys.executable, EXAMPLE / "model.py", "--dofs", "18000", *options, "-o", path]
            done = subprocess.run(command, env=SURROUNDINGS, text=True, capture_output=True, timeout=SECONDS)
            assert done.returncode == 0, done.stderr
            made[options] = Model.read(path), path, done.stdout
        return made[options]

    return of


@pytest.mark.parametrize("text", ["3", "3x", "3x0", "3x4x5", "axb", "-1x2"])
def test_divisions_are_two_numbers(text):
    assert pair("3x9") == (3, 9)
    with pytest.raises(argparse.ArgumentTypeError, match=f"two whole numbers from 1 on are wanted, such as 3x9, found '{text}'"):
        pair(text)


@pytest.mark.slow
def test_root_and_shroud(make):
    """Contact points by the divisions, those of the shroud to the next sector, pressed by the interference."""
    model, path, said = make("--flank", "1x2", "--shroud", "1x1", "--interference", "0.07")
    assert abs(model.n / 18000 - 1) < 0.06 and f"{path}: {model.n} dofs, 39 contact points" in said
    assert model.contact_points == 39 and model.cyclic["sectors"] == 36
    shroud = model.cyclic["next_sector"] == 1
    assert shroud.sum() == 9 and model.joint["names"] == ["left", "right", "shroud"]
    np.testing.assert_allclose(model.contact["gap"], np.where(shroud, -7e-5, 0), rtol=1e-12)
    np.testing.assert_allclose(model.joint["area"][shroud].sum(), 0.026 * 0.004 / np.cos(np.radians(10)), rtol=1e-9)
    np.testing.assert_allclose(model.contact["normal_stiffness"], 1e12 * model.joint["area"])
    surface = np.unique(np.concatenate([faces.ravel() for faces in outer_faces(model.mesh["nodes"], model.mesh["cells"])]))
    np.testing.assert_array_equal(np.sort(model.mesh["sets"]["surface"]), surface)


@pytest.mark.slow
def test_the_program_takes_the_case(make, tmp_path):
    _, path, _ = make("--flank", "1x2", "--shroud", "1x1", "--interference", "0.07")
    shutil.copy(path, tmp_path)
    shutil.copy(EXAMPLE / "case.toml", tmp_path)
    out, _ = words_of([BINARY, "run", tmp_path / "case.toml", "--dry-run"])
    assert "39 contact points" in out and "excitation.engine_order" in out


@pytest.mark.slow
def test_without_shroud(make):
    model, _, _ = make("--no-shroud", "--speed", "3000", "--flank", "1x2")
    shrouded, _, _ = make("--flank", "1x2", "--shroud", "1x1", "--interference", "0.07")
    assert model.contact_points == 30 and not model.cyclic["next_sector"].any()
    push = [np.abs(loads.preload).sum() for loads in (model, shrouded)]
    assert push[0] / push[1] == pytest.approx(4, rel=0.2)  # twice the speed, and no shroud
