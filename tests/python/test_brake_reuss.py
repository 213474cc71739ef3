"""The Brake-Reuss beam: its mesh against closed forms, its frequencies and preload against what others found, its backbone's energies.

Run as a program this file measures coarse models and prints what it found.
"""

import importlib.util
import json
import shutil
import subprocess
import sys

import numpy as np
import pytest

from dovetail import Results
from launch import BINARY, ROOT, SECONDS, SURROUNDINGS

EXAMPLE = ROOT / "inputs/brake_reuss"
COARSE, FINER = 0.020, 0.010  # edges on the lap [m]
TIED = 204.6  # published, for E = 200 GPa and 7800 kg/m^3 [Hz]
PRELOADED = (168.503, 580.408, 1177.650)  # of others, first three bendings about the joint [Hz]; their material
BOLT_FORCE = 12249.0  # [N]


def load(name):
    """A module of the example under a name of its own: other examples have a model.py, too."""
    spec = importlib.util.spec_from_file_location(f"brake_reuss_{name}", EXAMPLE / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def beam():
    return load("beam")


@pytest.fixture(scope="module")
def mesh(beam):
    return beam.mesh(COARSE)


def test_volume_is_that_of_beam_and_bolts(mesh):
    """Straight edges cut a little off what is round."""
    halves = 0.0254 * (0.6 * 0.0254 + 2 * 0.12 * 0.0127)
    round_parts = np.pi / 4 * (0.0254 * (0.0069**2 - 2 * 0.5 * 0.0085**2) + 2 * (0.01746**2 * 0.00159 + 0.01334**2 * 0.00516))
    assert mesh.jacobians().mean(axis=1).sum() / 6 == pytest.approx(halves + 3 * round_parts, rel=2e-3)
    assert mesh.jacobians().min() > 0


def test_halves_touch_node_on_node_and_share_none(mesh):
    one, two = (mesh.node_sets[f"lap {side}"] for side in "AB")
    np.testing.assert_array_equal(mesh.nodes[one], mesh.nodes[two])
    assert not set(one) & set(two)
    np.testing.assert_allclose(np.abs(mesh.nodes[one, :2]).max(axis=0), [0.06, 0.0127])
    for rows, side in ((one, -1), (two, 1)):  # A lies below the lap, B above it
        x, _, z = mesh.nodes[mesh.cells[np.isin(mesh.cells, rows).any(axis=1), :4]].mean(axis=1).T
        assert (side * z[np.abs(x) < 0.06]).min() > 0


def test_tied_halves_share_the_lap_but_not_the_steps(beam, mesh):
    tied = beam.mesh(COARSE, tied=True)
    assert len(np.unique(tied.cells)) == len(np.unique(mesh.cells)) - len(mesh.node_sets["lap A"])
    at_step = tied.nodes[np.unique(tied.cells)]
    at_step = at_step[(np.abs(at_step[:, 0] - 0.06) < 1e-9) & (at_step[:, 2] < -1e-9)]
    assert len(np.unique(at_step.round(9), axis=0)) == len(at_step) / 2


@pytest.fixture(scope="module")
def measured():
    done = subprocess.run([sys.executable, __file__], env=SURROUNDINGS, text=True, capture_output=True, timeout=SECONDS)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.slow
def test_tied_frequency_falls_towards_the_published_one(measured):
    coarse, finer = measured["tied"]
    assert TIED < finer < coarse < 1.06 * TIED


@pytest.mark.slow
def test_frequencies_at_the_preload_are_those_of_others(measured):
    np.testing.assert_allclose(np.array(measured["preloaded"])[[0, 2, 4]], PRELOADED, rtol=0.03)
    assert measured["preloaded"][0] < measured["tied own"]


@pytest.fixture(scope="module")
def backbone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("beam") / "brake_reuss"
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns("*.h5", "out"))
    case = folder / "case.toml"
    case.write_text(case.read_text().replace("amplitude = [1e-7, 7e-5]", "amplitude = [1e-7, 9e-6]"))
    for command in ([sys.executable, "model.py", "--size", str(COARSE)], [BINARY, "run", case]):
        subprocess.run(command, cwd=folder, env=SURROUNDINGS, check=True, capture_output=True, timeout=SECONDS)
    return Results(folder / "out/results.h5")


@pytest.mark.slow
def test_joint_bears_what_the_bolts_press(backbone):
    """In the program's own preload state, which is where displacements count from: nothing moves, and there is no friction."""
    forces = backbone.g.reshape(-1, 3)
    assert forces[:, 2].sum() == pytest.approx(3 * BOLT_FORCE, rel=1e-9)
    assert np.abs(forces[:, :2]).max() < 1e-6 * BOLT_FORCE
    assert np.abs(backbone.xp).max() < 1e-12
    assert 0.7 < np.mean(forces[:, 2] > 0) < 0.95  # the ends of the lap stand open


@pytest.mark.slow
def test_energies_of_the_backbone_balance(backbone):
    """2 pi zeta omega^2 alpha^2 per period is what the mass-proportional damping takes, pi a omega alpha^2, and what friction does."""
    assert np.abs(backbone.energy_error).max() < 1e-6 * backbone.damping_ratio.min()
    omega, alpha, viscous = backbone.omega, backbone.modal_amplitude, 1.8436 / 2 / backbone.omega
    rubbed = backbone.friction_energy / (2 * np.pi * omega**2 * alpha**2)
    np.testing.assert_allclose(backbone.damping_ratio, viscous + rubbed, rtol=1e-4)
    assert rubbed[0] < 1e-9 and rubbed[-1] > viscous[-1]
    assert omega[-1] < 0.998 * omega[0]


@pytest.mark.slow
def test_backbone_lies_beside_that_of_others(backbone):
    """Of another law and mesh: the frequency, relative to that at rest, to a hundredth; both soften."""
    compare = load("compare")
    (amplitude, frequency, _), (theirs, reference, _) = compare.run(backbone.path), compare.peer()
    at = amplitude[-1]
    assert 8e-6 < at < 1e-5  # at the tip [m], a little less than the modal amplitude
    softened = np.interp(at, theirs, reference / reference[0])
    assert softened < 0.995
    assert frequency[-1] / frequency[0] == pytest.approx(softened, abs=0.01)


def measure():
    """Print, as one line of JSON, frequencies [Hz] of coarse models."""
    import logging

    logging.disable(logging.INFO)
    sys.path.insert(0, str(EXAMPLE))
    import model

    from dovetail.material import Material

    tied = []
    for size in (COARSE, FINER):
        solid = model.structure(size, tied=True, material=Material(200e9, 0.29, 7800.0, "steel"))
        tied.append(model.elastic(solid.K, solid.M, 1)[0])
    solid = model.structure(COARSE, tied=True)
    found = {"tied": tied, "tied own": model.elastic(solid.K, solid.M, 1)[0]}
    solid = model.structure(COARSE)
    made, _, g = model.tightened(solid, model.lap(solid))
    found["preloaded"] = model.at_preload(made, g, 5).tolist()
    print(json.dumps(found))


if __name__ == "__main__":
    measure()
