"""The wheel that is exported from results of one sector, against the same wheel computed whole, one load pattern per sector."""

import numpy as np
import pytest
import ring
from ring import N
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from dovetail import Joint, Results
from dovetail.__main__ import main
from dovetail.cyclic import turn
from launch import BINARY, words_of

STIFF = {"normal_stiffness": 1e3, "tangential_stiffness": 5e2, "friction": 0.3, "gap": -1e-3}
FORCE, PRELOAD, OMEGA, FRAMES = np.array([0.4, 1.0, 0.6]), np.array([0.0, 0.0, 1.0]), 2.5, 3
ELASTIC, INTERIOR = 72, 36  # dofs of a sector besides its contact points, and those of them that are not contact nodes or sides
CASE = """model = "model.h5"
damping.stiffness = 5e-3
harmonic_balance = {{ harmonics = 3, samples = 960 }}
newton = {{ step_tolerance = 1e-10, residual_tolerance = 1e-10 }}
continuation.omega = [{omega}, {omega}]
stability.enabled = false
accuracy.estimates = false
output.motion = "all"
{further}"""


def run(folder, structure, joints, further):
    folder.mkdir()
    structure.join(joints).write(folder / "model.h5")
    (folder / "case.toml").write_text(CASE.format(omega=OMEGA, further=further))
    words_of([BINARY, "run", folder / "case.toml", "--out", folder])
    return Results(folder / "results.h5")


def of_a_sector(folder, order):
    structure = ring.sector().clamped("bore").with_force("over_right", FORCE)
    structure = structure.with_preload("over_right", PRELOAD).with_preload("over_left", -PRELOAD).cyclic(N, "left", "right", (0, 0, 1))
    joint = Joint.between(structure.surface("over_right"), structure.surface("over_left"), next_sector=True, **STIFF)
    return run(folder, structure, joint, f"reduction = {{ modes = {ELASTIC}, interior_modes = {INTERIOR} }}\n"
               f"excitation = {{ fourier = [0, 1], engine_order = {order} }}\n")


def of_the_whole(folder, order):
    structure, loads = ring.whole().clamped("bore"), ""
    for j in range(N):
        angle, phase = 2 * np.pi * j / N, 2 * np.pi * j * order / N
        structure = structure.with_force(f"over_right_{j}", turn((0, 0, 1), angle) @ FORCE, name=f"sector_{j}")
        structure = structure.with_preload(f"over_right_{j}", PRELOAD).with_preload(f"over_left_{j}", -PRELOAD)
        loads += f'[[excitation.load]]\npattern = "sector_{j}"\nfourier = [0, {float(np.cos(phase))!r}, {float(np.sin(phase))!r}]\n'
    joints = [Joint.between(structure.surface(f"over_right_{j}"), structure.surface(f"over_left_{(j + 1) % N}"), name=str(j), **STIFF)
              for j in range(N)]
    return run(folder, structure, joints, f"reduction.modes = {N * ELASTIC}\n{loads}")


def exported(folder, results, *options):
    """Point data (instants) of motion and contact points."""
    assert main(["export", str(results.path), "--frames", str(FRAMES), "-o", str(folder), *options]) == 0
    found = []
    for name in ("motion", "contact"):
        found.append([])
        for i in range(FRAMES):
            reader = vtkXMLUnstructuredGridReader()
            reader.SetFileName(str(folder / f"{name}_{i:03d}.vtu"))
            reader.Update()
            data = reader.GetOutput().GetPointData()
            found[-1].append({data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())})
    return found


@pytest.mark.parametrize("order", [2, pytest.param(-1, marks=pytest.mark.slow)])
def test_a_wheel_moves_as_the_one_computed_whole(tmp_path, order):
    sector, whole = of_a_sector(tmp_path / "sector", order), of_the_whole(tmp_path / "whole", order)
    assert sector.points("slip")[-1] + sector.points("open")[-1] > 0.3  # else the contacts would not be seen
    motion, contact = exported(tmp_path / "wheel", sector, "--wheel", "--solid")
    same, contact_too = exported(tmp_path / "all", whole)
    sets = ring.whole().node_sets
    one = ring.sector().node_sets
    for i in range(FRAMES):
        for name in ("displacement", "vibration"):
            found, wanted = motion[i][name].reshape(N, -1, 3), same[i][name]
            for j in range(N):
                for side in ("over_left", "over_right"):
                    np.testing.assert_allclose(found[j, one[side]], wanted[sets[f"{side}_{j}"]], rtol=0, atol=2e-6 * np.abs(wanted).max())
        for name, close in (("normal_force", 5e-6), ("gap", 5e-6), ("relative_displacement", 5e-6), ("friction_force", 1e-4)):
            wanted = contact_too[i][name]  # friction by samples that are not the same ones
            np.testing.assert_allclose(contact[i][name], wanted, rtol=0, atol=close * np.abs(wanted).max())
        np.testing.assert_allclose(contact[i]["friction_energy"], contact_too[i]["friction_energy"], rtol=1e-4,
                                   atol=1e-6 * contact_too[i]["friction_energy"].max())
        assert np.mean(contact[i]["state"] == contact_too[i]["state"]) > 0.9  # but where an instant is that of a change
