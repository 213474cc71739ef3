"""The sector of a bladed disk: both sides and both shroud faces carry the same mesh, and a model of it on one and two ranks.

Run as a program (under mpirun) this file writes a model of a pickled mesh.
"""

import logging
import pickle
import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial import cKDTree

from dovetail import Joint, Model
from dovetail.cyclic import turn
from dovetail.meshes.bladed_disk import AXIS, BladedDisk, Shroud, mesh_sector
from launch import SECONDS, SURROUNDINGS

DOFS, DIVISIONS, SHROUD_DIVISIONS = 20_000, (2, 4), (1, 4)
DISK = BladedDisk()


@pytest.fixture(scope="module")
def mesh():
    return mesh_sector(DOFS, DIVISIONS, SHROUD_DIVISIONS)


def test_sizes(mesh):
    free = 3 * (len(mesh.nodes) - len(mesh.node_sets["bore"]))
    assert abs(free / DOFS - 1) < 0.06 and mesh.jacobians().min() > 0
    for name, divisions in (("flank_left", DIVISIONS), ("slot_right", DIVISIONS), ("shroud_left", SHROUD_DIVISIONS)):
        assert len(mesh.node_sets[name]) == (2 * divisions[0] + 1) * (2 * divisions[1] + 1)


@pytest.mark.slow
@pytest.mark.parametrize("dofs", [18_000, 30_000])
def test_sides_with_divisions_of_their_own(dofs):
    """As many nodes as they say at any size, and the sector still meets itself."""
    mesh = mesh_sector(dofs, (1, 2), (1, 1), side_divisions=(2, 3))
    left, right = (mesh.node_sets[side] for side in ("left", "right"))
    assert len(left) == len(right) == 5 * 7 and mesh.jacobians().min() > 0
    assert abs(3 * (len(mesh.nodes) - len(mesh.node_sets["bore"])) / dofs - 1) < 0.06
    distance, partner = cKDTree(mesh.nodes[right]).query(mesh.nodes[left] @ turn(AXIS, DISK.pitch).T)
    image = np.full(len(mesh.nodes), -1)
    image[left] = right[partner]
    faces = [{frozenset(corners) for corners in _triangles(mesh, rows)} for rows in (left, right)]
    assert distance.max() < 1e-12 and {frozenset(image[list(face)]) for face in faces[0]} == faces[1] and faces[1]


@pytest.mark.parametrize("name", ["{}", "shroud_{}"])
def test_right_is_left_turned(mesh, name):
    """Every node has its partner, and so has every face of the mesh between them."""
    left, right = (mesh.node_sets[name.format(side)] for side in ("left", "right"))
    distance, partner = cKDTree(mesh.nodes[right]).query(mesh.nodes[left] @ turn(AXIS, DISK.pitch).T)
    assert len(left) == len(right) and distance.max() < 1e-12 and len(set(partner)) == len(right)
    image = np.full(len(mesh.nodes), -1)
    image[left] = right[partner]
    faces = [{frozenset(corners) for corners in _triangles(mesh, rows)} for rows in (left, right)]
    assert {frozenset(image[list(face)]) for face in faces[0]} == faces[1] and faces[1]


def _triangles(mesh, rows):
    """Corners of the cells' faces all of whose corners are among some nodes."""
    inside = np.zeros(len(mesh.nodes), dtype=bool)
    inside[rows] = True
    faces = mesh.cells[:, [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]].reshape(-1, 3)
    return faces[inside[faces].all(axis=1)]


def test_sides_lie_in_planes_through_the_axis(mesh):
    for side, sign in (("left", -1), ("right", 1)):
        _, y, z = mesh.nodes[mesh.node_sets[side]].T
        np.testing.assert_allclose(np.arctan2(y, z), sign * DISK.pitch / 2, atol=1e-12)
        assert z.min() == pytest.approx(DISK.bottom) and z.max() == pytest.approx(DISK.rim)


def test_contact_faces_of_the_shroud_are_inclined(mesh):
    """Flat, as long and as high as said, their normal turned from the circumference by the slope."""
    points = mesh.nodes[mesh.node_sets["shroud_right"]] @ turn(AXIS, -DISK.pitch / 2).T
    np.testing.assert_allclose(points[:, 1], points[:, 0] * np.tan(DISK.shroud.slope), atol=1e-12)
    assert np.ptp(points[:, 0]) == pytest.approx(DISK.shroud.length) and np.ptp(points[:, 2]) == pytest.approx(DISK.shroud.thickness)


@pytest.mark.slow
def test_without_shroud_the_blade_is_that_of_blade_root():
    plain = mesh_sector(25_000, (1, 2), disk=BladedDisk(shroud=None))
    assert not {"shroud_left", "shroud_right"} & set(plain.node_sets)
    assert plain.nodes[:, 2].max() == pytest.approx(DISK.platform[1] + DISK.airfoil[-1][0])


@pytest.mark.parametrize("arguments, words", [
    ((0,), "dofs and divisions must be positive, found 0"),
    ((DOFS, (0, 3)), "dofs and divisions must be positive"),
    ((DOFS, DIVISIONS, SHROUD_DIVISIONS, BladedDisk(shroud=Shroud(overlap=-0.003))), "the blade would be 2 pieces that do not touch")])
def test_wrong_sizes_are_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        mesh_sector(*arguments)


@pytest.mark.slow
def test_a_model_of_it_on_one_and_two_ranks(mesh, tmp_path):
    """Contacts in the root and to the next sector; matrices of PETSc, which a constraint between the sides would spoil."""
    (tmp_path / "mesh.pickle").write_bytes(pickle.dumps(mesh))
    models = []
    for ranks in (1, 2):
        path = tmp_path / f"model_{ranks}.h5"
        done = subprocess.run(["mpirun", "-n", str(ranks), sys.executable, __file__, tmp_path / "mesh.pickle", path], env=SURROUNDINGS,
                              text=True, capture_output=True, timeout=SECONDS)
        assert done.returncode == 0, done.stderr
        assert done.stdout.count("the constraint between the sides is in the matrices already") == ranks, done.stdout
        models.append(Model.read(path))
    for model in models:
        sides = [model.mesh["nodes"][model.mesh["dof_node"][model.cyclic[side][:, 0]]] for side in ("left", "right")]
        np.testing.assert_allclose(sides[0] @ turn(AXIS, DISK.pitch).T, sides[1], atol=1e-12)
        held = len(np.intersect1d(mesh.node_sets["left"], mesh.node_sets["bore"]))
        assert len(sides[0]) == len(mesh.node_sets["left"]) - held
        assert model.contact_points == 2 * 45 + 27 and model.cyclic["next_sector"].sum() == 27
        for (a, b), to_next in zip(model.cyclic["nodes"], model.cyclic["next_sector"]):
            moved = turn(AXIS, DISK.pitch) if to_next else np.eye(3)
            np.testing.assert_allclose(model.mesh["nodes"][a], moved @ model.mesh["nodes"][b], atol=1e-12)
    assert models[0].n == models[1].n
    for name in "KM":
        traces = [getattr(model, name).diagonal().sum() for model in models]
        assert traces[0] == pytest.approx(traces[1], rel=1e-12)


def _write(mesh, path):
    from mpi4py import MPI

    from dovetail.meshes import elastic_solid

    logging.disable(logging.INFO)  # the form compiler's, on first use
    comm = MPI.COMM_WORLD
    sector = elastic_solid.structure(mesh, elastic_solid.TITANIUM, comm).clamped("bore").cyclic(DISK.blades, "left", "right", AXIS)
    joints = [Joint.between(sector.surface(f"flank_{side}"), sector.surface(f"slot_{side}")) for side in ("left", "right")]
    joints.append(Joint.between(sector.surface("shroud_right"), sector.surface("shroud_left"), next_sector=True))
    sector.join(joints).write(path)
    stiff = sector.K.copy()
    diagonal = stiff.getDiagonal()
    begin, end = diagonal.getOwnershipRange()
    own = np.intersect1d(sector.dofs_of(sector.cyclic_sector.right).ravel(), np.arange(begin, end))
    values = diagonal.getArray()
    values[own - begin] *= 2
    diagonal.setArray(values)
    stiff.setDiagonal(diagonal)
    try:
        sector._with_matrix("K", stiff).join(joints)
    except ValueError as error:
        print(error)


if __name__ == "__main__":
    with open(sys.argv[1], "rb") as stream:
        _write(pickle.load(stream), sys.argv[2])
