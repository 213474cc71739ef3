"""ANSYS: the full file and the archive that the reader's package ships were written by ANSYS itself; the Harwell-Boeing and mapping
files are written here, after its documentation and the published format, since the program is licensed.
"""

import importlib.util
import re
import shutil
import sys
from pathlib import Path

import imported_beam
import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh

from dovetail import Model
from dovetail.importers import ansys, convert, harwell_boeing, setup_file
from dovetail.material import Material
from launch import BINARY, words_of

if not importlib.util.find_spec("ansys"):
    pytest.skip("ansys-mapdl-reader is not installed (scripts/setup says why)", allow_module_level=True)

EXAMPLES = Path(importlib.util.find_spec("ansys.mapdl.reader").origin).parent / "examples"
FULL, ARCHIVE = EXAMPLES / "file.full", EXAMPLES / "HexBeam.cdb"  # a beam 1 x 1 x 5, held at z = 0
# the frequencies that the package's own example states for this file [Hz]
FREQUENCIES = [1283.20036921, 1283.20036921, 5781.97486169, 6919.39887714, 6919.39887714, 10172.61497694, 16497.85701889, 16497.85701889]
LABELS = ("UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ")
HEADER = 105  # word of the full file where the values of its own header begin
SETUP = imported_beam.SETUP.format(shaken="top", held="TOP")


@pytest.fixture(scope="module")
def beam():
    return ansys.read([FULL, ARCHIVE])


def frequencies(structure, count=8):
    return np.sqrt(eigsh(structure.K.tocsc(), count, structure.M.tocsc(), sigma=0)[0]) / (2 * np.pi)


def test_frequencies_of_the_full_file(beam):
    np.testing.assert_allclose(frequencies(beam), FREQUENCIES, rtol=1e-9)


def test_every_row_is_the_dof_it_says(beam):
    """Rigid motion by the coordinates of the archive needs no force at rows whose elements are not held."""
    assert beam.n == 900 and len(beam.nodes) == 321
    motion = np.zeros((beam.n, 6))
    for row, (node, direction) in enumerate(zip(beam.dof_node, beam.dof_direction)):
        motion[row, direction] = 1
        for axis in range(3):
            motion[row, 3 + axis] = np.cross(np.eye(3)[axis], beam.nodes[node])[direction]
    force = abs(beam.K @ motion)
    clear = beam.nodes[beam.dof_node, 2] > 0.51  # elements are 0.5 long
    assert clear.sum() == 3 * 270
    assert force[clear].max() < 1e-12 * abs(beam.K).max() and force[~clear].max() > 0.1 * abs(beam.K).max()


def test_constrained_dofs_are_removed_and_said(beam):
    held = np.setdiff1d(np.arange(321), beam.dof_node)
    np.testing.assert_array_equal(held, np.flatnonzero(beam.nodes[:, 2] == 0))
    said = "\n".join(beam.notes)
    assert "63 displacements of 21 nodes" in said and "element components ECOMP1, ECOMP2" in said


def test_mesh_and_components(beam):
    """Against an independent reading of the text, and the geometry of cells with straight edges."""
    text = ARCHIVE.read_text().splitlines()
    start = next(i for i, line in enumerate(text) if line.startswith("NBLOCK")) + 2
    numbers = {int(line[:9]): [float(line[27 + 21 * k:48 + 21 * k] or 0) for k in range(3)] for line in text[start:start + 321]}
    np.testing.assert_allclose(beam.nodes, [numbers[label] for label in beam.labels.tolist()], rtol=1e-15)
    assert set(beam.node_sets) == {"NCOMP2", "NODE_SELECTION"}
    for name, rows in beam.node_sets.items():
        start = next(i for i, line in enumerate(text) if line.startswith("CMBLOCK," + name)) + 2
        listed = []
        for line in text[start:]:
            words = line.split()
            if not words or not re.fullmatch(r"-?\d+", words[0]):
                break
            for number in map(int, words):
                listed += range(listed[-1] + 1, -number + 1) if number < 0 else [number]
        np.testing.assert_array_equal(beam.labels[rows], listed)
    X = beam.nodes[beam.cells["hexahedron20"]]
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    assert X.shape == (40, 20, 3)
    for k, (a, b) in enumerate(edges):
        np.testing.assert_allclose(X[:, 8 + k], (X[:, a] + X[:, b]) / 2, atol=1e-12)


def test_linear_and_degenerate_cells(tmp_path):
    from dovetail.importers import ansys_archive

    sector = ansys_archive.read(EXAMPLES / "sector.cdb", ansys._reader, [])
    assert {name: len(rows) for name, rows in sector.cells.items()} == {"hexahedron": 101, "wedge": 4}
    corners = sector.nodes[sector.cells["hexahedron"]]
    assert (np.linalg.norm(corners[:, 6] - corners[:, 0], axis=1) > 0).all() and len(sector.nodes) == 655


# Harwell-Boeing

def fortran(value):
    """As Fortran writes D25.15: a leading zero and the letter D."""
    mantissa, exponent = f"{value:.14E}".split("E")
    digits = mantissa.replace("-", "").replace(".", "")
    return f"{'-' if value < 0 else ''}0.{digits}D{int(exponent) + (value != 0):+03d}".rjust(25)


def write_hb(path, matrix, right=None, kind="RSA"):
    matrix = (sp.tril(matrix) if kind == "RSA" else matrix).tocsc()
    matrix.sort_indices()
    n, nnz = matrix.shape[0], matrix.nnz
    extra = n if right is not None else 0
    lines = ["Stiffness matrix from a FULL file".ljust(72) + "K".ljust(8),
             "".join(f"{k:14d}" for k in (n + 1 + 2 * nnz + extra, n + 1, nnz, nnz, extra)),
             kind.ljust(14) + "".join(f"{k:14d}" for k in (n, n, nnz, 0)),
             "(1I14)          (1I14)          (1D25.15)           (1D25.15)"]
    if extra:
        lines.append("F  " + " " * 11 + f"{1:14d}{0:14d}")
    lines += [f"{k + 1:14d}" for k in matrix.indptr] + [f"{k + 1:14d}" for k in matrix.indices]
    lines += [fortran(value) for value in matrix.data] + ([fortran(value) for value in right] if extra else [])
    Path(path).write_text("\n".join(lines) + "\n")


def write_mapping(path, dofs):
    rows = "".join(f"{k:12d}{node:12d}    {LABELS[direction]}\n" for k, (node, direction) in enumerate(dofs, 1))
    Path(path).write_text("    Matrix Eqn.       Node    Dof\n" + rows)


@pytest.fixture(scope="module")
def written(beam, tmp_path_factory):
    """The three files, with a right-hand side 0, 1/7, 2/7, ... in K."""
    folder = tmp_path_factory.mktemp("hb")
    write_hb(folder / "K.matrix", beam.K, np.arange(beam.n) / 7)
    write_hb(folder / "M.matrix", beam.M)
    write_mapping(folder / "K.mapping", zip(beam.labels[beam.dof_node], beam.dof_direction))
    return folder


def hb_files(folder, written):
    shutil.copytree(written, folder, dirs_exist_ok=True)
    return [f"K={folder / 'K.matrix'}", f"M={folder / 'M.matrix'}", folder / "K.mapping", ARCHIVE]


def test_harwell_boeing_with_its_mapping(tmp_path, beam, written):
    load = np.arange(beam.n) / 7
    files = hb_files(tmp_path, written)
    other = ansys.read([*files, "load=preload"])
    np.testing.assert_allclose(other.K.toarray(), beam.K.toarray(), rtol=1e-14, atol=1e-14 * abs(beam.K).max())
    np.testing.assert_allclose(other.M.toarray(), beam.M.toarray(), rtol=1e-14, atol=1e-14 * abs(beam.M).max())
    np.testing.assert_array_equal(other.dof_node, beam.dof_node)
    np.testing.assert_array_equal(other.dof_direction, beam.dof_direction)
    np.testing.assert_allclose(other.preload, load, rtol=1e-14)
    assert not other.force.any() and any("taken as preload" in note for note in other.notes)
    np.testing.assert_allclose(frequencies(other, 3), FREQUENCIES[:3], rtol=1e-8)
    plain = ansys.read(files)
    assert not plain.preload.any() and any(note.startswith("NOT taken: the load vector") for note in plain.notes)
    assert any("CE or CP" in note for note in plain.notes)


def test_rotations_are_kept(tmp_path, beam):
    turns = sp.identity(3) * 5.0
    write_hb(tmp_path / "K.matrix", sp.block_diag([beam.K, turns]))
    write_hb(tmp_path / "M.matrix", sp.block_diag([beam.M, turns]))
    node = beam.labels[beam.dof_node[-1]]
    write_mapping(tmp_path / "K.mapping", [*zip(beam.labels[beam.dof_node], beam.dof_direction), *((node, 3 + k) for k in range(3))])
    structure = ansys.read([f"K={tmp_path / 'K.matrix'}", f"M={tmp_path / 'M.matrix'}", tmp_path / "K.mapping", ARCHIVE])
    np.testing.assert_array_equal(structure.dof_direction[-3:], [3, 4, 5])
    np.testing.assert_array_equal(structure.dof_node[-3:], beam.dof_node[-1])


def test_harwell_boeing_against_scipy(tmp_path):
    matrix = sp.random(9, 9, 0.4, random_state=3, format="csc") + sp.identity(9)
    scipy.io.hb_write(str(tmp_path / "a.hb"), matrix.tocsc())
    read, symmetric, right = harwell_boeing.read(tmp_path / "a.hb")
    assert not symmetric and right is None
    np.testing.assert_array_equal(read.toarray(), scipy.io.hb_read(str(tmp_path / "a.hb")).toarray())


def test_harwell_boeing_with_numbers_that_touch(tmp_path):
    """Several numbers to a line, of fixed width and without blanks, as the format allows."""
    text = ("title".ljust(72) + "key\n" + "".join(f"{k:14d}" for k in (5, 1, 2, 2, 0)) + "\n" + "RSA".ljust(14)
            + "".join(f"{k:14d}" for k in (3, 3, 5, 0)) + "\n(4I2)           (3I2)           (1P3D11.4)\n"
            + " 1 3 5 6\n 1 2 2\n 3 3\n 2.0000D+00-1.0000D+00 2.0000D+00\n-1.0000D+00 1.5000D+00\n")
    (tmp_path / "a.hb").write_text(text)
    read, symmetric, _ = harwell_boeing.read(tmp_path / "a.hb")
    assert symmetric
    np.testing.assert_array_equal(read.toarray(), [[2, 0, 0], [-1, 2, 0], [0, -1, 1.5]])


def test_load_vector_of_the_full_file(tmp_path):
    """Every equation's load is its own number; the example has none."""
    content = np.fromfile(FULL, "<i4")
    start = content[HEADER + 38 - 1]  # ptrRHS
    assert content[start] == 2 * 963
    content[start + 2:start + 2 + 2 * 963] = np.arange(963.0).view("<i4")
    content.tofile(tmp_path / "loaded.full")
    structure = ansys.read([tmp_path / "loaded.full", ARCHIVE, "load=force"])
    free = ansys._reader("full").FullFile(FULL).load_km()[1].diagonal() != 0
    np.testing.assert_array_equal(structure.force, np.arange(963.0)[free])
    assert any(note.startswith("NOT taken: the load vector") for note in ansys.read([tmp_path / "loaded.full", ARCHIVE]).notes)


def test_forces_of_the_archive_are_the_excitation(tmp_path):
    """Real and imaginary part, as CDWRITE writes them for a harmonic analysis."""
    text = ARCHIVE.read_text()
    plain = ansys.read([FULL, ARCHIVE])
    top = plain.labels[np.argmax(plain.nodes[:, 2])]
    path = tmp_path / "loaded.cdb"
    lines = f"F,{top:8d},FX  ,  1.5000000    ,  0.5000000\nF,{top:8d},FZ  ,  -2.0    ,  0.0\nSFE,1,2,PRES,1,3.0\n"
    path.write_text(text + lines)
    structure = ansys.read([FULL, path])
    dofs = structure.dofs_of(np.searchsorted(structure.labels, top))
    np.testing.assert_array_equal(structure.force[dofs], [1.5, 0, -2])
    np.testing.assert_array_equal(structure.forces["force_sin"][dofs], [-0.5, 0, 0])
    assert np.count_nonzero(structure.force) == 2 and structure.courses["force_sin"] == [0, 0, 1]
    said = "\n".join(structure.notes)
    assert "force from 2 lines of F (" in said and "total (1.5, 0, -2)" in said and "NOT taken: SFE (" in said
    for bad in ("F,      99999,FX,1.0,0.0", "F,many,FX,1.0,0.0", f"F,{top},FX,1e999,0.0"):
        path.write_text(text + bad + "\n")
        with pytest.raises(ValueError, match=r"loaded.cdb, line \d+: wanted .*F,"):
            ansys.read([FULL, path])


# what is refused

def refused(files, *words):
    with pytest.raises(ValueError) as caught:
        ansys.read(files)
    for word in words:
        assert word in str(caught.value), str(caught.value)


def patched(folder, word, value, start=HEADER):
    """The full file with one number of its header changed."""
    content = np.fromfile(FULL, "<i4")
    content[start + word] = value
    content.tofile(folder / "changed.full")
    return [folder / "changed.full", ARCHIVE]


@pytest.mark.parametrize("word, value, said", [
    (10, 1, "lumped"), (13, 1, "unsymmetric"), (20, 4, "4 constraint equations"), (0, 4, "frontal solver"), (33, 0, "no mass matrix"),
])
def test_full_files_of_other_analyses_are_refused(tmp_path, word, value, said):
    refused(patched(tmp_path, word, value), "changed.full", said)


def test_other_degrees_of_freedom_are_refused(tmp_path):
    content = np.fromfile(FULL, "<i4")
    third = HEADER + content[HEADER - 2] + 1 + 2  # behind the header and its closing word, and the next length and flag
    assert content[third:third + 3].tolist() == [1, 2, 3]
    refused(patched(tmp_path, third + 2, 20, start=0), "changed.full", "1, 2, 20")


def test_damaged_and_foreign_files_are_refused(tmp_path):
    (tmp_path / "cut.full").write_bytes(FULL.read_bytes()[:300000])
    refused([tmp_path / "cut.full", ARCHIVE], "cut.full", "cut off", "300000")
    refused([EXAMPLES / "file.rst", ARCHIVE], "file.rst", "kind 12")
    refused([FULL], "archive", "found none")
    refused([FULL, ARCHIVE, EXAMPLES / "TetBeam.cdb"], "one archive", "HexBeam.cdb", "TetBeam.cdb")
    refused([ARCHIVE], "wanted a full file", "K=FILE")
    (tmp_path / "junk").write_bytes(bytes(range(200)))
    refused([FULL, tmp_path / "junk"], "junk", "neither an ANSYS full file")
    refused([FULL, ARCHIVE, "load=both"], "load must be force or preload, found both")
    refused([FULL, ARCHIVE, "load=force"], "file.full", "no load vector")
    refused([FULL, EXAMPLES / "TetBeam.cdb"], "TetBeam.cdb", "do not belong together")
    with pytest.raises(OSError, match="gone.full"):
        ansys.read([tmp_path / "gone.full", ARCHIVE])


@pytest.mark.parametrize("old, new, words", [
    ("NBLOCK", "NBLICK", ["has no NBLOCK"]), ("EBLOCK", "EBLICK", ["has no EBLOCK"]), ("(?s)EBLOCK.*", "", ["has no EBLOCK"]),
    (r"\n +7 +0 +0 [^\n]*", "", ["line ", "wanted 321 nodes", "found 320"]), (r"(?s)\n +-1\nCMB.*", "\n", ["cut off within EBLOCK"]),
    (r"\n +-1\nCMB", "\nCMB", ["wanted -1 at the end of EBLOCK"]), (r"(?s)(\n +9 +0 +0 [^\n]*).*", r"\1\n", ["cut off within NBLOCK"]),
    (r"(\n +9 +0 +0 [^\n]*)", r"\1 0.0000000000000E+000 3.0000000000000E+001", ["node 9", "rotated coordinate system"]),
    (r"(CMBLOCK,NCOMP2[^\n]*\n[^\n]*\n) {9}1", r"\1      9999", ["component NCOMP2", "node 9999"]),
])
def test_wrong_archives_are_refused(tmp_path, old, new, words):
    changed, count = re.subn(old, new, ARCHIVE.read_text(), count=1)
    assert count == 1
    (tmp_path / "changed.cdb").write_text(changed)
    refused([FULL, tmp_path / "changed.cdb"], "changed.cdb", *words)


@pytest.mark.parametrize("old, new, words", [
    (r"\n +3 +\d+ +U.", r"\n 4 1 UX", ["line 4", "wanted row 3, found 4"]),
    ("UY", "TEMP", ["wanted a direction", "TEMP"]),
    (r"\n +5 +\d+ ", r"\n 5 ", ["line 6", "row number, node and direction"]),
    (r"\n[^\n]*\n\Z", "\n", ["wanted 899 rows"]),
    (r"\n +1 +\d+ ", r"\n 1 77777 ", ["node 77777", "is not there"]),
])
def test_wrong_mapping_files_are_refused(tmp_path, written, old, new, words):
    files = hb_files(tmp_path, written)
    changed, count = re.subn(old, new, files[2].read_text(), count=1)
    assert count == 1
    files[2].write_text(changed)
    refused(files, *words)


@pytest.mark.parametrize("old, new, words", [
    ("RSA", "CSA", ["line 3", "real", "CSA"]), ("RSA", "???", ["line 3", "type such as RSA"]), ("RSA", "RUA", ["only the lower triangle"]),
    (r"\(1I14\)", "(list)", ["line 4", "Fortran formats"]), (r"D[+-]\d\d\n\Z", "E\n", ["K.matrix, line", "25 characters"]),
    (r"\n[^\n]*\n[^\n]*\n\Z", "\n", ["K.matrix", "cut off"]), (r"(?m)^ {13}1\n", "             7\n", ["column pointers must rise"]),
])
def test_wrong_harwell_boeing_files_are_refused(tmp_path, written, old, new, words):
    files = hb_files(tmp_path, written)
    path = tmp_path / "K.matrix"
    changed, count = re.subn(old, new, path.read_text(), count=1)
    assert count == 1
    path.write_text(changed)
    refused(files, *words)


def test_incomplete_harwell_boeing_sets_are_refused(tmp_path, beam, written):
    files = hb_files(tmp_path, written)
    refused([files[0], *files[2:]], "missing M=FILE")
    refused([*files[:2], files[3]], "mapping file", "YES")
    refused([*files, FULL], "not both")
    refused([*files, files[0]], "K is given twice")
    shutil.copy(files[2], tmp_path / "M.mapping")
    assert ansys.read([*files, tmp_path / "M.mapping"]).n == beam.n
    write_mapping(tmp_path / "M.mapping", [(1, 0)] * beam.n)
    refused([*files, tmp_path / "M.mapping"], "M.mapping", "same rows")


def test_a_missing_package_is_named(monkeypatch):
    for name in [name for name in sys.modules if name.startswith("ansys")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if "extras" not in path])
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    refused([FULL, ARCHIVE], "ansys-mapdl-reader", "pip install --no-deps ansys-mapdl-reader==", "scripts/setup")


def test_the_program_takes_the_model(tmp_path, beam):
    top = beam.labels[beam.nodes[:, 2] == 5]
    lines = "".join("".join(f"{label:10d}" for label in top[k:k + 8]) + "\n" for k in range(0, len(top), 8))
    text = re.sub(r"(?=\nCMBLOCK)", f"\nCMBLOCK,TOP     ,NODE,{len(top):8d}\n(8i10)\n{lines.rstrip()}", ARCHIVE.read_text(), count=1)
    (tmp_path / "beam.cdb").write_text(text)
    (tmp_path / "joints.toml").write_text(SETUP)
    (tmp_path / "case.toml").write_text(imported_beam.CASE)
    said = convert("ansys", [str(FULL), str(tmp_path / "beam.cdb")], tmp_path / "model.h5", str(tmp_path / "joints.toml"))
    assert "63 displacements of 21 nodes" in said and "21 contact points" in said
    model = Model.read(tmp_path / "model.h5")
    np.testing.assert_allclose(model.force.sum(), 1.0)
    np.testing.assert_allclose(model.contact["normal_stiffness"].sum(), 1e3 * 1.0, rtol=1e-12)  # per area, of the end face 1 x 1
    out, _ = words_of([str(BINARY), "run", str(tmp_path / "case.toml"), "--dry-run"])
    assert "21 contact points" in out


def test_components_of_a_cyclic_sector(tmp_path, beam):
    """Half of a square rod, so to speak: its faces x = 0 and x = 1 are half a turn apart."""
    x, _, z = beam.nodes.T
    sets = {"CYCLIC_M01H": x == 1, "CYCLIC_M01L": x == 0, "TOP": (z == 5) & (x > 0) & (x < 1)}
    added = ""
    for name, inside in sets.items():
        members = beam.labels[inside]
        lines = "".join("".join(f"{label:10d}" for label in members[k:k + 8]) + "\n" for k in range(0, len(members), 8))
        added += f"\nCMBLOCK,{name:8},NODE,{len(members):8d}\n(8i10)\n{lines.rstrip()}"
    (tmp_path / "beam.cdb").write_text(re.sub(r"(?=\nCMBLOCK)", added, ARCHIVE.read_text(), count=1))
    structure = ansys.read([FULL, tmp_path / "beam.cdb"])
    joint = '[[joint]]\nground = "TOP"\nnormal = [0, 0, 1]\n'
    (tmp_path / "joints.toml").write_text(joint)
    plain = setup_file.apply(structure, tmp_path / "joints.toml")
    assert plain.cyclic is None and "CYCLIC_M01L and CYCLIC_M01H of" in "\n".join(plain.notes)
    (tmp_path / "joints.toml").write_text("[cyclic]\nsectors = 2\naxis = [0, 0, 1]\norigin = [0.5, 0.5, 0]\n" + joint)
    model = setup_file.apply(structure, tmp_path / "joints.toml")
    assert len(model.cyclic["left"]) == np.count_nonzero((x == 0) & (z > 0))  # its foot is held
    rows = model.mesh["dof_node"]
    np.testing.assert_allclose(structure.nodes[rows[model.cyclic["right"][:, 0]]],
                               [1, 1, 0] + structure.nodes[rows[model.cyclic["left"][:, 0]]] * [-1, -1, 1], atol=1e-12)


def test_the_material_of_the_archive(beam):
    assert beam.materials == [Material(7e10, 0.35, 2700.0, "material 1")]
    assert {kind: set(numbers) for kind, numbers in beam.material.items()} == {kind: {0} for kind in beam.cells}
