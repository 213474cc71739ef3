"""The blade-root example: mesh, masses and loads against the CAD model's own integrals, and the same model on one and two ranks.

Run as a program (under mpirun) this file measures one small model and prints what it found.
"""

import json
import pickle
import subprocess
import sys
from pathlib import Path

import gmsh
import numpy as np
import pytest
from scipy.spatial import cKDTree

from dovetail.meshes import blade_root
from dovetail.meshes.rounded_outline import rounding
from dovetail.meshes.tetrahedra import Tetrahedra
from launch import ROOT, SECONDS, SURROUNDINGS

EXAMPLE = ROOT / "inputs" / "blade_root"
DENSITY = 4430.0  # [kg/m^3]
OMEGA = 2 * np.pi * 1500 / 60  # [rad/s]
DOFS, DIVISIONS = 12_000, (2, 4)
RANKS = (1, 2)
STRAIN = 1e-4 * np.array([[1.0, 0.3, -0.2], [0.3, -0.5, 0.7], [-0.2, 0.7, 0.4]])


def run(ranks, *command, status=0):
    done = subprocess.run(["mpirun", "-n", str(ranks), sys.executable, *map(str, command)], env=SURROUNDINGS, text=True,
                          capture_output=True, timeout=SECONDS)
    assert (done.returncode == 0) == (status == 0), done.stderr
    return done


@pytest.fixture(scope="module")
def mesh():
    return blade_root.mesh_sector(DOFS, DIVISIONS)


@pytest.fixture(scope="module")
def measured(mesh, tmp_path_factory):
    """What `measure` finds on that mesh, by number of ranks."""
    path = tmp_path_factory.mktemp("mesh") / "mesh.pickle"
    path.write_bytes(pickle.dumps(mesh))

    class Measured(dict):
        def __missing__(self, ranks):  # the quick tests ask for one rank only
            self[ranks] = json.loads(run(ranks, __file__, path).stdout.splitlines()[-1])
            return self[ranks]
    return Measured()


@pytest.fixture(scope="module")
def cad():
    """Volume [m^3] and centre of mass [m] of blade and disk, volumes they share; area [m^2] and outline of the pressure side."""
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        bodies = blade_root.bodies(blade_root.Sector())
        airfoil = blade_root.faces(blade_root.Sector(), *bodies)["airfoil"][0]
        edges = []
        for dim, tag in gmsh.model.getBoundary([airfoil], combined=False, oriented=True):
            (low,), (high,) = gmsh.model.getParametrizationBounds(dim, abs(tag))
            points = gmsh.model.getValue(1, abs(tag), np.linspace(low, high, 2001)).reshape(-1, 3)
            edges.append(points[::int(np.sign(tag))].tolist())
        shared, _ = gmsh.model.occ.intersect([(3, bodies[0])], [(3, bodies[1])], removeObject=False, removeTool=False)
        return {"shared": [entity for entity in shared if entity[0] == 3],
                "volume": [gmsh.model.occ.getMass(3, tag) for tag in bodies],
                "centre": [gmsh.model.occ.getCenterOfMass(3, tag) for tag in bodies],
                "area": gmsh.model.occ.getMass(2, airfoil[1]), "edges": edges}
    finally:
        gmsh.finalize()


@pytest.mark.slow
def test_mass_is_that_of_the_geometry(measured, cad):
    for found, volume in zip(measured[1]["mass"], cad["volume"]):
        assert found == pytest.approx(DENSITY * volume, rel=5e-4)  # the coarse mesh rounds the outline off


@pytest.mark.slow
def test_centrifugal_force_is_that_of_the_geometry(measured, cad):
    for found, volume, centre in zip(measured[1]["preload"], cad["volume"], cad["centre"]):
        wanted = DENSITY * OMEGA**2 * volume * np.array([0, centre[1], centre[2]])
        np.testing.assert_allclose(found, wanted, atol=5e-4 * np.linalg.norm(wanted))


def test_pressure_acts_on_the_pressure_side(measured, cad):
    """The force of a pressure on a face depends on its edge alone: -p/2 times the contour integral of r x dr."""
    vector = np.zeros(3)
    for edge in np.array(cad["edges"]):
        vector += np.cross(edge[:-1], edge[1:]).sum(axis=0) / 2
    found = np.array(measured[1]["force"])
    assert found[0] < 0 < found[1]  # towards the suction side
    np.testing.assert_allclose(np.linalg.norm(found), 200 * np.linalg.norm(vector), rtol=2e-3)
    assert abs(np.dot(found, vector)) == pytest.approx(np.linalg.norm(found) * np.linalg.norm(vector), rel=1e-5)
    assert measured[1]["area"] == pytest.approx(cad["area"], rel=2e-3)


def test_rigid_motions_have_no_strain(measured):
    """Translations and rotations; K is scaled by its largest entry, motions by theirs."""
    np.testing.assert_array_less(measured[1]["rigid"], 1e-12)


def test_uniform_strain_stores_the_closed_form(measured):
    """u = E x with a constant symmetric E: the energy u.K u / 2 is V (mu E:E + lambda / 2 tr(E)^2)."""
    young, poisson = 114e9, 0.33
    mu, lame = young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    density = mu * np.sum(STRAIN**2) + lame / 2 * np.trace(STRAIN) ** 2
    assert measured[1]["energy"] == pytest.approx(density * sum(measured[1]["mass"]) / DENSITY, rel=1e-5)


@pytest.mark.slow
def test_ranks_give_the_same_model(measured):
    one, two = (measured[ranks] for ranks in RANKS)
    assert one["size"] == two["size"]
    for name in ("mass", "preload", "force", "norms"):
        np.testing.assert_allclose(two[name], one[name], rtol=1e-10, atol=1e-12 * np.abs(one[name]).max())
    np.testing.assert_allclose(two["points"], one["points"], atol=1e-12)
    np.testing.assert_allclose(two["stuck"], one["stuck"], rtol=1e-9)


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_mass_couples_no_directions(measured, ranks):
    assert measured[ranks]["mass coupling"] == 0


@pytest.mark.slow
@pytest.mark.parametrize("dofs", [DOFS, 40_000])
def test_number_of_dofs_is_met(mesh, dofs):
    made = mesh if dofs == DOFS else blade_root.mesh_sector(dofs, DIVISIONS)
    assert 3 * (len(made.nodes) - len(made.node_sets["clamped"])) == pytest.approx(dofs, rel=0.1)


def test_flanks_match(mesh):
    """Node on node, (2 * 2 + 1) x (2 * 4 + 1) of them, on the plane of the flank; and the bodies share no node."""
    sector = blade_root.Sector()
    (y0, z1), (y1, z0) = sector.flank_ends
    for side, sign in (("left", -1), ("right", 1)):
        one, two = (mesh.nodes[mesh.node_sets[f"{body}_{side}"]] for body in ("flank", "slot"))
        assert len(one) == len(two) == 5 * 9
        np.testing.assert_allclose(two[cKDTree(two).query(one)[1]], one, atol=1e-12)
        np.testing.assert_allclose((sign * one[:, 1] - y0) * (z0 - z1), (one[:, 2] - z1) * (y1 - y0), atol=1e-15)
        np.testing.assert_allclose([one[:, 0].min(), one[:, 0].max()], [-sector.length / 2, sector.length / 2], atol=1e-12)
    assert not set(mesh.node_sets["blade"]) & set(mesh.node_sets["disk"])


def test_flank_triangles_match(mesh):
    """The same triangles, not only the same nodes."""
    for side in ("left", "right"):
        found = []
        for body in ("flank", "slot"):
            inside = np.isin(mesh.cells, mesh.node_sets[f"{body}_{side}"])
            corners = [row[:4][chosen[:4]] for row, chosen in zip(mesh.cells, inside) if chosen.sum() == 6]
            found.append(sorted(tuple(sorted(map(tuple, mesh.nodes[triangle].round(9)))) for triangle in corners))
        assert len(found[0]) == 2 * 2 * 4
        assert found[0] == found[1]


def test_root_and_slot_are_apart_elsewhere(mesh, cad):
    """The bodies share no volume, and nodes of the one come near nodes of the other only at the flanks and their roundings."""
    assert cad["shared"] == []
    sector = blade_root.Sector()
    blade, disk = (mesh.nodes[mesh.node_sets[body]] for body in ("blade", "disk"))
    near = blade[cKDTree(disk).query(blade)[0] < sector.clearance / 2]
    (y0, z1), (y1, z0) = sector.flank_ends
    below = (z1 - near[:, 2]) / (z1 - z0)
    assert len(near) >= 2 * 5 * 9
    assert -0.3 < below.min() and below.max() < 1.3


def test_elements_are_not_inverted(mesh):
    assert mesh.jacobians().min() > 0


def test_jacobian_of_a_known_map():
    """A brick's tetrahedron stretched by (1, 2, 3) and bent in z by x^2: the determinant is 6 everywhere."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    straight = Tetrahedra.straight(corners, np.array([[0, 1, 2, 3]]))
    x, y, z = straight.nodes.T
    bent = Tetrahedra(np.column_stack([x, 2 * y, 3 * z + x**2]), straight.cells)
    np.testing.assert_allclose(bent.jacobians(), 6, rtol=1e-12)
    folded = Tetrahedra(np.column_stack([x - 1.2 * x**2, y, z]), straight.cells)  # slope 1 - 2.4 x, negative at x = 1
    assert folded.jacobians().min() == pytest.approx(-1.4)
    np.testing.assert_allclose(np.ptp(folded.straightened().jacobians()), 0, atol=1e-12)


def test_rounding_touches_both_sides():
    start, centre, end = rounding(np.array([3.0, 0]), np.array([0.0, 0]), np.array([0.0, 5]), 1.0)
    np.testing.assert_allclose([start, centre, end], [(1, 0), (1, 1), (0, 1)], atol=1e-12)


@pytest.mark.slow
def test_model_file(tmp_path):
    import h5py

    path = tmp_path / "model.h5"
    run(1, EXAMPLE / "model.py", "--dofs", DOFS, "--flank", "2x4", "--points", "2x3", "-o", path)
    with h5py.File(path, "r") as file:
        assert file["force"].size == pytest.approx(DOFS, rel=0.1)
        assert file["contact/dofs"].shape == (2 * 6, 3)
        area = 2 * blade_root.Sector().flank_area
        assert file["contact/normal_stiffness"][()].sum() == pytest.approx(1e12 * area)
        assert file["contact/tangential_stiffness"][()].sum(axis=0) == pytest.approx([5e11 * area] * 2)


@pytest.mark.slow
def test_wrong_sector_is_refused_on_every_rank():
    done = run(2, EXAMPLE / "model.py", "--dofs", "500", "--flank", "10x20", status=1)
    assert done.stderr.count("no size of elements gives about 500 dofs") >= 2


def measure():
    """Print, as one line of JSON, what the tests above look at. Collective."""
    import logging

    logging.disable(logging.INFO)
    sys.path.insert(0, str(EXAMPLE))
    import model
    from mpi4py import MPI

    from dovetail.eigenfrequencies import characteristic
    from dovetail.meshes import elastic_solid

    comm = MPI.COMM_WORLD
    sector = pickle.loads(Path(sys.argv[1]).read_bytes())
    free = elastic_solid.structure(sector, model.MATERIAL, comm, elastic_solid.centrifugal(model.MATERIAL, 1500.0))
    loaded = elastic_solid.with_pressure(free, "airfoil", model.PRESSURE)
    K, M = free.K, free.M
    motion, image = K.createVecRight(), K.createVecRight()
    own = slice(*K.getOwnershipRange())

    def along(field):
        """Vec of a displacement field (n_nodes, 3)."""
        motion.setArray(field[free.dof_node, free.dof_direction][own])
        return motion

    def on(body):
        field = np.zeros_like(free.nodes)
        field[free.node_sets[body]] = 1.0
        return field

    mass, preload = [], []
    for body in ("blade", "disk"):
        M.mult(along(on(body) * [0, 0, 1]), image)
        mass.append(image.sum())
        preload.append([free.preload.dot(along(on(body) * row)) for row in np.eye(3)])
    rigid = []
    largest = free.K.norm(3)  # infinity norm
    for axis in np.eye(3):
        for field in (np.tile(axis, (len(free.nodes), 1)), np.cross(axis, free.nodes)):
            K.mult(along(field), image)
            rigid.append(image.norm(3) / (largest * np.abs(field).max()))
    stretched = along(free.nodes @ STRAIN)
    K.mult(stretched, image)
    energy = image.dot(stretched) / 2
    indptr, indices, _ = M.getValuesCSR()
    row = np.repeat(np.arange(own.start, own.stop), np.diff(indptr))
    coupling = comm.allreduce(int(np.count_nonzero(row % 3 != indices % 3)))
    solid = loaded.clamped("clamped")
    made = model.joints(solid, (3, 3))
    joined = solid.join(made)
    found = {
        "size": joined.n, "mass": mass, "preload": preload, "rigid": rigid, "energy": energy, "mass coupling": coupling,
        "force": [loaded.force.dot(along(np.tile(row, (len(free.nodes), 1)))) for row in np.eye(3)],
        "area": float(free.surface("airfoil").areas().sum()),
        "norms": [matrix.norm() for matrix in (K, M, joined.K, joined.M)],
        "points": np.concatenate([joint.position for joint in made]).tolist(),
        "stuck": characteristic(joined, (1, 2, 7), below=10.0)["stuck"].tolist(),
    }
    if comm.rank == 0:
        print(json.dumps(found))


if __name__ == "__main__":
    measure()
