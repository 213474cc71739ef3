"""The bladed disk of dovetail.meshes in CalculiX: frequencies by nodal diameter against CalculiX's own cyclic analysis of the same deck."""

import numpy as np
import pytest
from brick_deck import matrices_step, rows, run_ccx
from scipy.spatial import cKDTree
from test_import_cyclic import cyclic_frequencies

from dovetail import Joint, Model
from dovetail.importers import calculix, setup_file
from dovetail.reference import sector_frequencies

MPI = pytest.importorskip("mpi4py.MPI")
bladed_disk = pytest.importorskip("dovetail.meshes.bladed_disk")
elastic_solid = pytest.importorskip("dovetail.meshes.elastic_solid", reason="needs DOLFINx")

DISK, MATERIAL = bladed_disk.BladedDisk(), elastic_solid.TITANIUM
SIDES = {side: [side, f"shroud_{side}"] for side in ("left", "right")}  # shrouds are welded to those of the neighbours here
FREQUENCIES = "*STEP\n*FREQUENCY, SOLVER=SPOOLES\n12\n*SELECT CYCLIC SYMMETRY MODES, NMIN=3, NMAX=4\n*END STEP\n"
MODEL = f"*CYCLIC SYMMETRY MODEL, N={DISK.blades}, NGRAPH=1, TIE=T1\n0, 0, 0, -1, 0, 0\n"
SETUP = f'[cyclic]\nsectors = {DISK.blades}\naxis = [-1, 0, 0]\n[[joint]]\nground = "ONE"\nnormal = [0, 1, 0]\n'  # a joint has to be there


@pytest.fixture(scope="module")
def mesh():
    """A coarse one, its blade welded into the slot: nodes of the flanks are those of the slot."""
    mesh = bladed_disk.mesh_sector(8000, (1, 1), (1, 1), DISK, side_divisions=(1, 2))
    flank, slot = (np.concatenate([mesh.node_sets[f"{part}_{side}"] for side in SIDES]) for part in ("flank", "slot"))
    distance, partner = cKDTree(mesh.nodes[slot]).query(mesh.nodes[flank])
    assert distance.max() < 1e-12
    rename, row = np.arange(len(mesh.nodes)), np.full(len(mesh.nodes), -1)
    rename[flank] = slot[partner]
    used, cells = np.unique(rename[mesh.cells], return_inverse=True)
    row[used] = np.arange(len(used))
    sets = {name: np.unique(row[rename[nodes]]) for name, nodes in mesh.node_sets.items()}
    sets["one"] = np.setdiff1d(sets["airfoil"], np.concatenate([sets[name] for names in SIDES.values() for name in names]))[:1]
    return type(mesh)(mesh.nodes[used], cells.reshape(mesh.cells.shape), sets)


def deck(mesh, cards, step):
    """CalculiX cuts coordinates off behind 20 characters."""
    text = "*NODE\n" + "".join(f"{i}, {x:.12g}, {y:.12g}, {z:.12g}\n" for i, (x, y, z) in enumerate(mesh.nodes, 1))
    text += "*ELEMENT, TYPE=C3D10, ELSET=BODY\n" + "".join(f"{i}, {rows(cell + 1)}\n" for i, cell in enumerate(mesh.cells, 1))
    sets = {name: mesh.node_sets[name] for name in ("bore", "one")}
    for side, names in SIDES.items():
        sets[side] = np.setdiff1d(np.concatenate([mesh.node_sets[name] for name in names]), sets["bore"])
    text += "".join(f"*NSET, NSET={name.upper()}\n{rows(nodes + 1)}\n" for name, nodes in sets.items())
    text += "".join(f"*SURFACE, NAME=S{side}, TYPE=NODE\n{side}\n" for side in ("LEFT", "RIGHT"))
    text += "*TIE, CYCLIC SYMMETRY, NAME=T1, POSITION TOLERANCE=1e-6\nSRIGHT, SLEFT\n" + cards
    text += f"*MATERIAL, NAME=TI\n*ELASTIC\n{MATERIAL.young}, {MATERIAL.poisson}\n*DENSITY\n{MATERIAL.density}\n"
    return text + "*SOLID SECTION, ELSET=BODY, MATERIAL=TI\n*BOUNDARY\nBORE, 1, 3\n" + step


def test_frequencies_are_those_of_calculix(mesh, tmp_path):
    """With its own matrices to its digits; with those of DOLFINx, whose masses are integrated to a higher degree, to 2e-4."""
    theirs = cyclic_frequencies(run_ccx(tmp_path, "own", deck(mesh, MODEL, FREQUENCIES)))
    assert sorted(theirs) == [3, 4] and abs(theirs[4] / theirs[3] - 1).max() > 1e-3
    (tmp_path / "joints.toml").write_text(SETUP)
    matrices = calculix.read([run_ccx(tmp_path, "sector", deck(mesh, "", matrices_step()))])
    imported = setup_file.apply(matrices, tmp_path / "joints.toml")
    solid = elastic_solid.structure(mesh, MATERIAL, MPI.COMM_SELF).clamped("bore")
    solid = solid.cyclic(DISK.blades, SIDES["left"], SIDES["right"], axis=bladed_disk.AXIS)
    solid.join([Joint.ground(solid.surface("one"), normal=(0, 1, 0))]).write(tmp_path / "model.h5")
    for h, wanted in theirs.items():
        np.testing.assert_allclose(sector_frequencies(imported, h, 6, "open"), wanted, rtol=1e-6)
        np.testing.assert_allclose(sector_frequencies(Model.read(tmp_path / "model.h5"), h, 6, "open"), wanted, rtol=2e-4)
