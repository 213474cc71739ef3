"""The two-solid example: its mesh, its relative contact dofs, and its eigenfrequencies against published ones.

Run as a program (under mpirun) this file measures one model and prints what it found; the tests start it on several ranks.
"""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sp

from launch import ROOT, SECONDS, SURROUNDINGS

EXAMPLE = ROOT / "inputs" / "two_solids"
PUBLISHED = {"held": [808.6, 1508.8, 2727.2, 2989.6, 4226.1], "stuck": [672.6], "open": [633.8, 634.8, 1508.7, 1517.2]}  # [Hz]
PUBLISHED_PRELOAD = 3363.0  # [N], four points closed by 1 mm
RANKS = (1, 3)  # parts of uneven size


def run(ranks, *command):
    done = subprocess.run(["mpirun", "-n", str(ranks), sys.executable, *map(str, command)], env=SURROUNDINGS, text=True,
                          capture_output=True, timeout=SECONDS)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def measured():
    """What `measure` finds, by number of ranks."""
    return {ranks: json.loads(run(ranks, __file__).splitlines()[-1]) for ranks in RANKS}


@pytest.mark.slow
@pytest.mark.parametrize("kind", PUBLISHED)
def test_frequencies_agree_with_the_published_ones(measured, kind):
    np.testing.assert_allclose(measured[1]["frequencies"][kind], PUBLISHED[kind], rtol=0.02)


@pytest.mark.parametrize("ranks", RANKS[1:])
@pytest.mark.slow
def test_frequencies_do_not_depend_on_the_ranks(measured, ranks):
    assert measured[ranks]["size"] == measured[1]["size"]
    for kind, values in measured[1]["frequencies"].items():
        np.testing.assert_allclose(measured[ranks]["frequencies"][kind], values, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_pairs_coincide(measured, ranks):
    found = np.array(measured[ranks]["pairs"])  # (N_x, 2, 3)
    np.testing.assert_allclose(found[:, 0], found[:, 1], atol=1e-12)
    corners = [(x, y, -0.015) for y in (0.13, 0.135) for x in (0.0035, 0.01)]
    np.testing.assert_allclose(found[:, 0], corners, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_relative_displacements(measured, ranks):
    relative = {name: np.array(values) for name, values in measured[ranks]["relative"].items()}  # (N_x, 3) each
    np.testing.assert_allclose(relative["both along (1, 2, 3)"], 0, atol=1e-12)
    ones = np.ones((4, 1))
    np.testing.assert_allclose(relative["post 1 along -z"], ones * [0, 0, 1], atol=1e-12)  # the upper one sinks: it closes
    np.testing.assert_allclose(relative["post 1 along x"], ones * [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(relative["post 1 along y"], ones * [0, -1, 0], atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_preload_of_one_millimetre(measured, ranks):
    assert measured[ranks]["preload"] == pytest.approx(PUBLISHED_PRELOAD, rel=0.02)


def test_mesh_fills_the_posts():
    sys.path.insert(0, str(ROOT / "python"))
    from dovetail.meshes import two_solids

    vertices, cells = two_solids.mesh_pair(0.02, (3, 2))
    edges = vertices[cells[:, 1:]] - vertices[cells[:, :1]]
    volumes = np.abs(np.linalg.det(edges)) / 6
    assert volumes.min() > 0
    assert volumes.sum() == pytest.approx(2 * (0.08 * 0.03 * 0.03 + 0.01 * 0.1 * 0.03 + 2 * 0.0225 * 0.005 * 0.015), rel=1e-9)
    assert two_solids.on_patch(vertices).sum() == 2 * 4 * 3


@pytest.mark.slow
def test_model_file(tmp_path):
    import h5py

    path = tmp_path / "model.h5"
    run(2, EXAMPLE / "model.py", "--size", "0.02", "--patch", "2x2", "-o", path)
    with h5py.File(path, "r") as file:
        n = file["force"].size
        assert file["K/jc"].size == file["M/jc"].size == n + 1
        assert file["contact/dofs"].shape == (9, 3)
        assert file["contact/normal_stiffness"][()] == pytest.approx(4e9 / 9)
        assert file["force"][()].sum() == pytest.approx(4.0)
        loaded = np.flatnonzero(file["preload"][()])
        assert np.isin(loaded, file["contact/dofs"][()]).all()


@pytest.mark.slow
def test_points_that_miss_the_nodes_are_refused():
    with pytest.raises(AssertionError, match="points - 1 must divide twice the number of its divisions"):
        run(1, EXAMPLE / "model.py", "--size", "0.02", "--patch", "2x2", "--points", "4x2", "-o", os.devnull)


def measure():
    """Print, as one line of JSON, what the tests above look at. Collective."""
    sys.path.insert(0, str(EXAMPLE))
    import model
    from dovetail.eigenfrequencies import characteristic

    posts = model.build(points=(2, 2))
    comm, changed = posts.structure.comm, posts.model.mesh["changed"]
    row = np.argsort(posts.structure.labels)
    pairs = row[np.column_stack([posts.joint.labels, posts.joint.partner_labels])]

    def whole(parts):
        return np.concatenate(comm.allgather(parts))

    rows = sp.csr_matrix((changed["value"], changed["column"], changed["begin"]), shape=(changed["dof"].size, posts.model.n))
    among = rows[:, changed["dof"]].toarray()  # the changed dofs depend on each other alone

    def relative(displacements):
        """Contact dofs (N_x, 3) that belong to displacements (nodes, 3)."""
        u = displacements[posts.structure.dof_node, posts.structure.dof_direction]
        q = u.copy()
        q[changed["dof"]] = np.linalg.solve(among, u[changed["dof"]])
        return q[posts.model.contact_dofs].tolist()

    coordinates = posts.structure.nodes

    def post_1_along(direction):
        u = np.zeros_like(coordinates)
        u[pairs[:, 0]] = direction
        return relative(u)

    preload = model.closing_preload(posts.model.K, posts.model.contact_dofs, 1e-3)
    found = {
        "size": posts.model.n,
        "frequencies": {kind: list(values) for kind, values in characteristic(posts.model, model.COUNTS).items()},
        "pairs": coordinates[pairs].tolist(),
        "relative": {"both along (1, 2, 3)": relative(np.tile([1.0, 2.0, 3.0], (len(coordinates), 1))),
                     "post 1 along -z": post_1_along([0, 0, -1]), "post 1 along x": post_1_along([1, 0, 0]),
                     "post 1 along y": post_1_along([0, 1, 0])},
        "preload": whole(preload.getArray())[posts.model.contact_dofs[:, 2]].sum(),
    }
    if comm.rank == 0:
        print(json.dumps(found))


if __name__ == "__main__":
    measure()
