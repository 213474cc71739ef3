"""Nastran: decks, DMIG and OP4 files written by pyNastran (the program itself is licensed), and by hand in the layouts of its guide.

K, M and mesh are those of the beam that the ANSYS reader ships, so that its frequencies are known.
"""

import importlib.util
import re
import struct
from pathlib import Path

import imported_beam
import numpy as np
import pytest
import ring
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh

from dovetail import Model
from dovetail.importers import ansys, convert, nastran, nastran_loads, setup_file
from dovetail.material import Material
from launch import BINARY, words_of

if not importlib.util.find_spec("pyNastran"):
    pytest.skip("pyNastran is not installed (scripts/setup says why)", allow_module_level=True)
from cpylog import SimpleLogger
from pyNastran.bdf.bdf import BDF
from pyNastran.op2.result_objects.matrix import Matrix
from pyNastran.op4.op4 import OP4

EXAMPLES = Path(importlib.util.find_spec("ansys.mapdl.reader").origin).parent / "examples"
QUIET = SimpleLogger(level="error")
# mid-side nodes of CHEXA, after the quick reference guide: G9 to G12 below, G13 to G16 upright, G17 to G20 above
CHEXA = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 5), (2, 6), (3, 7), (4, 5), (5, 6), (6, 7), (7, 4)]
SMALL = """SOL 103
CEND
SET 5 = 1 THRU 3
SET 6 = 1, 99
BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,0.,1.,0.
GRID,4,,0.,0.,1.
CTETRA,1,1,1,2,3,4
SPC1,3,123,1,THRU,2
SET1,8,2,3
FORCE,11,4,,1.,0.,0.,1.
SPOINT,9
ENDDATA
"""
SETUP = '[[clamp]]\nset = "SPC 1"\n\n' + imported_beam.SETUP.format(shaken="SET 5", held="SET 5")


@pytest.fixture(scope="module")
def beam():
    return ansys.read([EXAMPLES / "file.full", EXAMPLES / "HexBeam.cdb"])


@pytest.fixture(scope="module")
def deck(beam, tmp_path_factory):
    """The beam as CHEXA with 20 grid points; SET 5 is its end, SPC 1 holds its foot."""
    path = tmp_path_factory.mktemp("deck") / "beam.bdf"
    model = BDF(log=QUIET)
    for label, position in zip(beam.labels.tolist(), beam.nodes):
        model.add_grid(label, position)
    cells = beam.cells["hexahedron20"]
    corners = {frozenset(pair): 8 + k for k, pair in enumerate([(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4),
                                                                (0, 4), (1, 5), (2, 6), (3, 7)])}  # mid-side nodes of VTK
    order = [*range(8), *(corners[frozenset(pair)] for pair in CHEXA)]
    for number, rows in enumerate(cells[:, order], start=1):
        model.add_chexa(number, 1, beam.labels[rows].tolist())
    model.add_psolid(1, 1)
    model.add_mat1(1, 7e10, None, 0.35)
    foot, end = (beam.labels[beam.nodes[:, 2] == z].tolist() for z in (0, 5))
    model.add_spc1(1, "123", foot)
    bulk = path.with_suffix(".bulk")
    model.write_bdf(str(bulk), size=16, is_double=True, write_header=False)
    lines = [f"SET 5 = {', '.join(map(str, end[k:k + 6]))}{',' if k + 6 < len(end) else ''}" for k in range(0, len(end), 6)]
    lines[1:] = [line.replace("SET 5 = ", "        ") for line in lines[1:]]
    path.write_text("SOL 103\nCEND\n" + "\n".join(lines) + "\nBEGIN BULK\n"
                    + re.sub(r"(?m)^(SOL|CEND|BEGIN BULK|ENDDATA|\$.*).*\n?", "", bulk.read_text()) + "\nENDDATA\n")
    return path


def dofs_of(structure):
    return list(zip(structure.labels[structure.dof_node].tolist(), (structure.dof_direction + 1).tolist()))


def write_dmig(path, matrices, dofs, form=6):
    model = BDF(log=QUIET)
    for name, matrix in matrices.items():
        entries = sp.triu(matrix).tocoo() if form == 6 else sp.coo_matrix(matrix)
        model.add_dmig(name, form, 2, 0, None, 0, [dofs[j] for j in entries.col], [dofs[i] for i in entries.row], entries.data.tolist())
    model.write_bdf(str(path), size=16, is_double=True, write_header=False)
    return path


def write_op4(path, matrices, form=6):
    matrices = {name: Matrix(name, form, data=matrix) for name, matrix in matrices.items()}
    OP4(log=QUIET).write_op4(str(path), matrices, name_order=list(matrices), is_binary=False)
    return path


def frequencies(structure, count=3):
    return np.sqrt(eigsh(structure.K.tocsc(), count, structure.M.tocsc(), sigma=0)[0]) / (2 * np.pi)


def same(structure, beam, digits):
    """The same matrices, whatever the order of the rows."""
    place = {dof: row for row, dof in enumerate(dofs_of(structure))}
    rows = [place[dof] for dof in dofs_of(beam)]
    assert structure.n == beam.n
    for ours, theirs in ((structure.K, beam.K), (structure.M, beam.M)):
        assert abs(ours[rows][:, rows] - theirs).max() < digits * abs(theirs).max()
    np.testing.assert_allclose(structure.nodes, beam.nodes, rtol=1e-15)


@pytest.mark.slow
def test_dmig_punch(beam, deck, tmp_path):
    """pyNastran writes nine digits, as Nastran does."""
    punch = write_dmig(tmp_path / "beam.pch", {"KAAX": beam.K, "MAAX": beam.M, "K4AAX": beam.K}, dofs_of(beam))
    structure = nastran.read([deck, punch])
    same(structure, beam, 1e-9)
    np.testing.assert_array_equal(structure.cells["hexahedron20"], beam.cells["hexahedron20"])
    np.testing.assert_allclose(frequencies(structure), [1283.20036921, 1283.20036921, 5781.97486169], rtol=1e-6)
    said = "\n".join(structure.notes)
    assert "NOT taken: matrices K4AAX" in said and "63 displacements of 21 nodes" in said
    assert structure.materials == [Material(7e10, 0.35, 0.0, "MAT1 1")] and set(structure.material["hexahedron20"]) == {0}


@pytest.mark.slow
def test_op4_of_the_g_set(beam, deck, tmp_path):
    """Six rows per grid point in rising order; those that nothing acts on go: rotations, and here what ANSYS had removed."""
    rows = [6 * node + direction for node, direction in zip(beam.dof_node, beam.dof_direction)]
    spread = sp.csr_matrix((np.ones(beam.n), (rows, range(beam.n))), shape=(6 * 321, beam.n))
    K, M = ((spread @ matrix @ spread.T).tocoo() for matrix in (beam.K, beam.M))
    path = write_op4(tmp_path / "beam.op4", {"KGG": K, "MGG": M})
    structure = nastran.read([deck, path])
    same(structure, beam, 1e-15)
    np.testing.assert_allclose(frequencies(structure), [1283.20036921, 1283.20036921, 5781.97486169], rtol=1e-9)
    assert f"removed: {6 * 321 - 900} degrees of freedom with neither stiffness nor mass ({3 * 321} of them rotations)" in structure.notes


@pytest.mark.slow
def test_op4_with_a_list_of_rows(beam, deck, tmp_path):
    order = np.random.default_rng(1).permutation(beam.n)
    K, M = (matrix[order][:, order].tocoo() for matrix in (beam.K, beam.M))
    path = write_op4(tmp_path / "beam.op4", {"KAA": K, "MAA": M})
    dofs = dofs_of(beam)
    (tmp_path / "beam.rows").write_text("$ grid component\n" + "".join(f"{dofs[i][0]} {dofs[i][1]} free\n" for i in order))
    same(nastran.read([deck, path, tmp_path / "beam.rows"]), beam, 1e-15)


def test_a_list_of_rows_with_a_scalar_point(tmp_path):
    path = write_op4(tmp_path / "s.op4", {"KAA": stiffness().tocoo(), "MAA": sp.identity(7).tocoo()})
    (tmp_path / "s.rows").write_text("".join(f"{grid} {component}\n" for grid, component in [DOFS[6], *DOFS[:6]]))
    structure = nastran.read([small(tmp_path), path, tmp_path / "s.rows"])
    np.testing.assert_array_equal(structure.dof_node, [-1, 2, 2, 2, 3, 3, 3])
    np.testing.assert_array_equal(structure.dof_direction, [-1, 0, 1, 2, 0, 1, 2])


def test_op4_of_the_a_set_that_the_deck_names(tmp_path):
    """ASET and ASET1 cards, rows by grid point and component."""
    deck = small(tmp_path, SMALL.replace("ENDDATA", "ASET1,13,3,4\nASET,2,2\nENDDATA"))
    K = sp.diags([1.0, 2, 3, 4, 5]).tocoo()
    structure = nastran.read([deck, write_op4(tmp_path / "a.op4", {"KAA": K, "MAA": K})])
    assert dofs_of(structure) == [(2, 2), (3, 1), (3, 3), (4, 1), (4, 3)]
    np.testing.assert_array_equal(structure.K.diagonal(), [1, 2, 3, 4, 5])


def small(folder, text=SMALL):
    (folder / "small.bdf").write_text(text)
    return folder / "small.bdf"


DOFS = [(3, 1), (3, 2), (3, 3), (4, 1), (4, 2), (4, 3), (9, 0)]


def stiffness():
    """Springs 3-4 along x, y, z with one grid point's direction tied to the scalar point."""
    K = np.eye(7) * 9 + np.diag(np.ones(6), 1) + np.diag(np.ones(6), -1)
    return sp.csr_matrix(K)


def test_sets_scalar_points_and_what_is_not_taken(tmp_path):
    structure = nastran.read([small(tmp_path), write_dmig(tmp_path / "s.pch", {"KAAX": stiffness(), "MAAX": sp.identity(7)}, DOFS)])
    assert {name: structure.labels[rows].tolist() for name, rows in structure.node_sets.items()} == {
        "SET 5": [1, 2, 3], "SET1 8": [2, 3], "SPC 3": [1, 2]}
    np.testing.assert_array_equal(structure.dof_node, [2, 2, 2, 3, 3, 3, -1])
    np.testing.assert_array_equal(structure.dof_direction, [0, 1, 2, 0, 1, 2, -1])
    np.testing.assert_allclose(structure.K.toarray(), stiffness().toarray(), rtol=1e-9)
    said = "\n".join(structure.notes)
    assert "NOT taken: SET 6 of the case control section" in said and "NOT taken: load set 11" in said


SHAKEN = """DAREA,20,3,1,2.,4,2,3.
FORCE,20,3,,5.,0.,0.,1.
DPHASE,30,4,2,90.
TABLED1,40
,0.,0.5,100.,0.5,ENDT
RLOAD1,50,20,,30,40
RLOAD2,51,20,,60.,2.,90.
DLOAD,60,2.,1.,50,-1.,51
"""


def excited(tmp_path, cards, selected):
    deck = SMALL.replace("BEGIN BULK\n", f"BEGIN BULK\n{cards}").replace("CEND\n", f"CEND\nDLOAD = {selected}\n")
    return nastran.read([small(tmp_path, deck), write_dmig(tmp_path / "s.pch", {"KAAX": stiffness(), "MAAX": sp.identity(7)}, DOFS)])


@pytest.mark.parametrize("selected, force", [(50, [1, 0, 2.5, 0, 1.5j, 0]),
                                             (51, np.array([2, 0, 5, 0, 3, 0]) * 2 * np.exp(1j * np.radians(150)))])
def test_dynamic_loads_with_their_phases(tmp_path, selected, force):
    """P = A (C + iD) e^(i theta) and A B e^(i phi) e^(i theta), of the quick reference guide; the motion is Re(P e^(i omega t))."""
    structure = excited(tmp_path, SHAKEN, selected)
    np.testing.assert_allclose(structure.force[:6], np.real(force), atol=1e-14)
    np.testing.assert_allclose(structure.forces["force_sin"][:6], -np.imag(force), atol=1e-14)
    assert structure.courses["force_sin"] == [0, 0, 1]
    assert f"NOT taken: load set 11, dynamic load {101 - selected}, dynamic load 60" in "\n".join(structure.notes)


def test_the_phase_of_a_scalar_point():
    """Its component is 0."""
    model = BDF(log=QUIET)
    model.add_spoint([9])
    model.add_darea(20, 9, 0, 2.0)
    model.add_dphase(30, [9], [0], [90.0])
    model.add_rload1(50, 20, dphase=30, tc=3.0)
    [[(grid, direction, value, _)]] = nastran_loads._parts(model, 50, 1.0, set())
    assert (grid, direction) == (9, 1) and value == pytest.approx(6j)


def test_a_sum_of_dynamic_loads(tmp_path):
    first, second = (excited(tmp_path, SHAKEN, selected) for selected in (50, 51))
    both = excited(tmp_path, SHAKEN, 60)
    for name in ("force", "force_sin"):
        one, two = ((each.force if name == "force" else each.forces[name]) for each in (first, second))
        np.testing.assert_allclose(both.force if name == "force" else both.forces[name], 2 * one - 2 * two, atol=1e-14)
    assert not any("dynamic load" in note for note in both.notes)


@pytest.mark.parametrize("old, new, said", [
    ("100.,0.5", "100.,0.6", "table 40, which is not one constant TABLED1"), ("RLOAD1,50,20,,30", "RLOAD1,50,20,7,30", "DELAY"),
    ("DPHASE,30", "DPHASE,31", "DPHASE 30, which is not there"), ("RLOAD1,50,20", "RLOAD1,50,21", "load set 21, which is not there"),
    ("DAREA,20,3,1", "DAREA,20,77,1", "grid point 77 is not there"),
    ("2.,4,2,3.", "2.,77,2,3.", "grid point 77 is not there"),
    ("FORCE,20,3,", "FORCE,20,3,8", "FORCE in coordinate system 8"),
    ("RLOAD1,50", "TLOAD1,50", "no force that varies as a sine"), ("RLOAD1,50", "RLOAD1,59", "there is no such card")])
def test_dynamic_loads_that_are_named_instead(tmp_path, old, new, said):
    assert old in SHAKEN
    cards = SHAKEN.replace(old, new)
    if new.startswith("TLOAD"):
        cards = cards.replace("TLOAD1,50,20,,30,40", "TLOAD1,50,20,,0,40")
    structure = excited(tmp_path, cards, 50)
    notes = "\n".join(structure.notes)
    assert "NOT taken: DLOAD 50 (" in notes and said in notes
    assert not structure.force.any() and "force_sin" not in structure.forces


def test_dmig_by_hand_and_held_rows_that_stay(tmp_path):
    """Several entries to a column, K with rows that M leaves out, fields of eight and of sixteen characters."""
    (tmp_path / "h.pch").write_text(
        "DMIG    KAAX    0       6       2       0                       6\n"
        "DMIG*   KAAX                           2               1                \n"
        "*                      2               1 4.000000000D+00\n"
        "*                      3               1-1.500000000D+00\n"
        "DMIG*   KAAX                           3               1                \n"
        "*                      3               1 4.000000000D+00\n"
        "DMIG    MAAX    0       6       2       0                       6\n"
        "DMIG    MAAX    2       1               2       1       2.5\n"
        "DMIG    MAAX    3       1               3       1       2.5     \n")
    structure = nastran.read([small(tmp_path), tmp_path / "h.pch"])
    np.testing.assert_array_equal(structure.K.toarray(), [[4, -1.5], [-1.5, 4]])
    np.testing.assert_array_equal(structure.M.toarray(), np.eye(2) * 2.5)
    assert any("1 degrees of freedom that SPC holds" in note and "clamp" in note for note in structure.notes)


def binary_op4(path, name, matrix, sparse, endian="<"):
    """As OUTPUT4 writes: Fortran records; a column is dense from its first entry on, or strings of entries."""
    def record(*parts):
        body = b"".join(parts)
        return struct.pack(endian + "i", len(body)) + body + struct.pack(endian + "i", len(body))

    n = len(matrix)
    out = [record(struct.pack(endian + "4i8s", n, n, 6, 2, name.ljust(8).encode()))]
    for column in range(n):
        rows = np.flatnonzero(matrix[:, column])
        if sparse:
            words = b"".join(struct.pack(endian + "id", row + 1 + 65536 * 3, matrix[row, column]) for row in rows)
            out.append(record(struct.pack(endian + "3i", column + 1, 0, 3 * len(rows)), words))
        else:
            values = matrix[rows[0]:rows[-1] + 1, column]
            out.append(record(struct.pack(endian + "3i", column + 1, rows[0] + 1, 2 * len(values)),
                              struct.pack(endian + f"{len(values)}d", *values)))
    out.append(record(struct.pack(endian + "3i", n + 1, 1, 2), struct.pack(endian + "d", 1.0)))
    with open(path, "ab") as stream:
        stream.write(b"".join(out))


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("endian", ["<", ">"])
def test_binary_op4(tmp_path, sparse, endian):
    deck = small(tmp_path, SMALL.replace("ENDDATA", "ASET1,123,3,4\nENDDATA"))
    K, M = stiffness().toarray()[:6, :6], np.eye(6) * 3 + np.eye(6, k=2) / 3 + np.eye(6, k=-2) / 3
    binary_op4(tmp_path / "b.op4", "KAA", K, sparse, endian)
    binary_op4(tmp_path / "b.op4", "MAA", M, sparse, endian)
    structure = nastran.read([deck, tmp_path / "b.op4"])
    np.testing.assert_array_equal(structure.K.toarray(), K)
    np.testing.assert_array_equal(structure.M.toarray(), M)


def test_cells(tmp_path):
    """Mid-side nodes of every solid lie between the corners that VTK says."""
    corners = {"CTETRA": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
               "CPENTA": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
               "CPYRAM": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)]}
    edges = {  # the guide's order of mid-side grid points, and VTK's
        "CTETRA": ("tetra10", [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)], [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]),
        "CPENTA": ("wedge15", [(0, 1), (1, 2), (2, 0), (0, 3), (1, 4), (2, 5), (3, 4), (4, 5), (5, 3)],
                   [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]),
        "CPYRAM": ("pyramid13", [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)],
                   [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)])}
    lines, number = [], 0
    for k, (kind, points) in enumerate(corners.items()):
        points = np.array(points, dtype=float) + [3 * k, 0, 0]
        everything = [*points, *((points[a] + points[b]) / 2 for a, b in edges[kind][1])]
        lines += [f"GRID,{number + i},,{x},{y},{z}" for i, (x, y, z) in enumerate(everything, start=1)]
        words = [kind, str(k + 1), "1", *(str(number + i + 1) for i in range(len(everything)))]
        lines += [",".join(["" if start else words[0], *words[1 + start:9 + start]]) for start in range(0, len(words) - 1, 8)]
        number += len(everything)
    lines += ["CBAR,9,1,1,2,0.,1.,0."]
    deck = small(tmp_path, "\n".join(lines) + "\nENDDATA\n")
    structure = nastran.read([deck, write_dmig(tmp_path / "s.pch", {"KAAX": sp.identity(1), "MAAX": sp.identity(1)}, [(1, 1)])])
    assert set(structure.cells) == {name for name, _, _ in edges.values()}
    for name, _, pairs in edges.values():
        X = structure.nodes[structure.cells[name][0]]
        for k, (a, b) in enumerate(pairs):
            np.testing.assert_allclose(X[len(X) - len(pairs) + k], (X[a] + X[b]) / 2, atol=1e-12)
    assert any("CBAR" in note and "not in the mesh" in note for note in structure.notes)


# what is refused

def refused(files, *words):
    with pytest.raises(ValueError) as caught:
        nastran.read(files)
    for word in words:
        assert word in str(caught.value), str(caught.value)


def punch(folder, name="s.pch", **matrices):
    return write_dmig(folder / name, matrices or {"KAAX": stiffness(), "MAAX": sp.identity(7)}, DOFS)


@pytest.mark.parametrize("old, new, words", [
    ("GRID,3,,0.,1.,0.", "GRID,3,,0.,1.,0.,7", ["grid point 3", "coordinate system (CD)"]),
    ("GRID,3,,0.,1.,0.", "GRID,3,77,0.,1.,0.", ["coordinate system (CP)"]),
    ("GRID,3,,0.,1.,0.", "GRID,3,,0.,what,0.", ["pyNastran cannot read it"]),
    ("GRID,4,,0.,0.,1.\nCTETRA,1,1,1,2,3,4\n", "", ["grid point 4", "is not there"]),
    ("CTETRA,1,1,1,2,3,4", "CTETRA,1,1,1,2,3,44", ["tetra cells", "grid point 44"]),
    ("CTETRA,1,1,1,2,3,4", "CTETRA,1,1,1,2,3,4,2,3", ["CTETRA 1", "mid-side"]),
])
def test_wrong_decks_are_refused(tmp_path, old, new, words):
    assert old in SMALL
    refused([small(tmp_path, SMALL.replace(old, new)), punch(tmp_path)], "small.bdf", *words)


def test_wrong_dmig_is_refused(tmp_path):
    deck = small(tmp_path)
    refused([deck, punch(tmp_path, KAAX=stiffness())], "MAAX or MGG", "found none", "M=NAME")
    refused([deck, punch(tmp_path, KAAX=stiffness(), KGG=stiffness(), MAAX=sp.identity(7))], "KAAX, KGG", "K=NAME")
    assert nastran.read([deck, punch(tmp_path, STIFF=stiffness(), MAAX=sp.identity(7)), "K=STIFF"]).n == 7
    refused([deck, punch(tmp_path), "K=KXX"], "K=KXX", "KAAX, MAAX")
    refused([deck, punch(tmp_path), punch(tmp_path, "t.pch", KAAX=stiffness())], "t.pch, DMIG KAAX", "given twice")
    half = {"KAAX": sp.tril(stiffness()), "MAAX": sp.identity(7)}
    refused([deck, write_dmig(tmp_path / "u.pch", half, DOFS, form=1)], "u.pch, DMIG KAAX", "only the lower triangle")
    text = punch(tmp_path).read_text()
    double = re.search(r"DMIG\*[^\n]*KAAX[^\n]*3               1\n\*[^\n]*\n", text)[0]
    (tmp_path / "v.pch").write_text(text + double)
    refused([deck, tmp_path / "v.pch"], "v.pch, DMIG KAAX", "given twice")
    (tmp_path / "w.rows").write_text("3 1\n")
    refused([deck, punch(tmp_path), tmp_path / "w.rows"], "w.rows", "DMIG names its own rows")


def test_rows_that_cannot_be_identified_are_refused(tmp_path):
    K = (sp.identity(6) * 2).tocoo()
    op4 = write_op4(tmp_path / "k.op4", {"KAA": K, "MAA": K})
    deck = small(tmp_path)
    refused([deck, op4], "k.op4, KAA", "6 rows", "g-set", "(25)", "(0)", "DMIG", ".rows")
    for text, words in (("3 1\n3 2\n", ["wanted 6 rows", "found 2"]), ("3 1\n3 x\n", ["line 2", "3 x"]), ("3 7\n", ["line 1", "1 to 6"]),
                        ("".join(f"3 {k}\n" for k in range(6)), ["component 0", "grid point 3"]),
                        ("3 1\n3 1\n", ["listed twice"]), ("".join(f"88 {k}\n" for k in range(1, 7)), ["grid point 88", "is not there"])):
        (tmp_path / "k.rows").write_text(text)
        refused([deck, op4, tmp_path / "k.rows"], *words)
    g_set = (sp.identity(25) * 2).tocoo()
    op4 = write_op4(tmp_path / "g.op4", {"KGG": g_set, "MGG": g_set})
    refused([small(tmp_path, SMALL.replace("ENDDATA", "RBE2,77,1,123,2\nENDDATA")), op4], "g.op4", "rigid elements", "77", "a-set")


def test_damaged_and_foreign_files_are_refused(tmp_path):
    deck, good = small(tmp_path), punch(tmp_path)
    K = (sp.identity(6) * 2).tocoo()
    whole = write_op4(tmp_path / "k.op4", {"KAA": K, "MAA": K}).read_text()
    (tmp_path / "k.op4").write_text(whole[:len(whole) * 2 // 3])
    refused([deck, tmp_path / "k.op4"], "k.op4")
    (tmp_path / "b.op4").write_bytes(b"\x18\0\0\0" + b"\1\2\3" * 30)
    refused([deck, tmp_path / "b.op4"], "b.op4", "pyNastran cannot read it")
    (tmp_path / "junk.txt").write_text("nothing\n")
    refused([deck, good, tmp_path / "junk.txt"], "junk.txt", "neither bulk data")
    refused([good], "bulk data with GRID", "found none")
    refused([deck, deck, good], "in one file")
    refused([deck], "KAAX or KGG", "found none")
    with pytest.raises(OSError, match="gone.pch"):
        nastran.read([deck, tmp_path / "gone.pch"])


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    from dovetail.importers import whole

    def absent(module):
        raise ModuleNotFoundError(f"No module named {module!r}")

    monkeypatch.setattr(whole.importlib, "import_module", absent)
    refused([small(tmp_path), tmp_path / "small.bdf"], "one file")
    refused([small(tmp_path)], "pyNastran", "pip install --no-deps pyNastran==", "scripts/setup")


@pytest.mark.slow
def test_the_program_takes_the_model(beam, deck, tmp_path):
    """The matrices of the free beam would hold the foot as well; here its rows are gone already, so nothing is left to clamp."""
    matrix_file = write_dmig(tmp_path / "beam.pch", {"KAAX": beam.K, "MAAX": beam.M}, dofs_of(beam))
    (tmp_path / "joints.toml").write_text(SETUP)
    with pytest.raises(ValueError, match="nothing to clamp"):
        convert("nastran", [str(deck), str(matrix_file)], tmp_path / "model.h5", str(tmp_path / "joints.toml"))
    (tmp_path / "joints.toml").write_text(SETUP.split("\n\n", 1)[1])
    said = convert("nastran", [str(deck), str(matrix_file)], tmp_path / "model.h5", str(tmp_path / "joints.toml"))
    assert "21 contact points" in said and "63 displacements of 21 nodes" in said
    model = Model.read(tmp_path / "model.h5")
    np.testing.assert_allclose(model.force.sum(), 1.0)
    np.testing.assert_allclose(model.contact["normal_stiffness"].sum(), 1e3, rtol=1e-6)
    (tmp_path / "case.toml").write_text(imported_beam.CASE)
    out, _ = words_of([str(BINARY), "run", str(tmp_path / "case.toml"), "--dry-run"])
    assert "21 contact points" in out


def test_cards_of_a_cyclic_sector(tmp_path):
    sector = ring.sector()
    grids = "".join(f"GRID*   {label:16d}{'':16s}{x:16.12f}{y:16.12f}\n*       {z:16.12f}\n"
                    for label, (x, y, z) in zip(sector.labels, sector.nodes))
    cells = "".join(f"CHEXA,{k},1,{','.join(map(str, row[:6]))}\n,{row[6]},{row[7]}\n"
                    for k, row in enumerate(sector.labels[sector.cells["hexahedron"]], start=1))
    cards = "GRID,901,,0.,0.,-1.\nGRID,902,,0.,0.,2.\n"
    for side, name in ((1, "right"), (2, "left")):  # the axis turns the other way round
        members = sector.labels[sector.node_sets[name]].tolist()
        cards += f"CYJOIN,{side},C,{','.join(map(str, members[:6]))}\n,{','.join(map(str, members[6:]))}\n"
    over = [f"SET1,{k},{','.join(map(str, sector.labels[sector.node_sets[name]]))}\n" for k, name in ((1, "over_right"), (2, "over_left"))]
    text = "SOL 114\nCEND\nBEGIN BULK\n" + grids + cells + cards + "".join(over) + f"CYSYM,{ring.N},ROT\nCYAX,902,901\nENDDATA\n"
    (tmp_path / "sector.bdf").write_text(text)
    matrices = write_dmig(tmp_path / "sector.pch", {"KAAX": sector.K, "MAAX": sector.M}, ring.names(sector).tolist())
    structure = nastran.read([tmp_path / "sector.bdf", matrices])
    (tmp_path / "joints.toml").write_text('[[joint]]\nbetween = ["SET1 2", "SET1 1"]\nnext_sector = true\n')
    model = setup_file.apply(structure, tmp_path / "joints.toml")
    assert model.cyclic["sectors"] == ring.N and model.cyclic["axis"].tolist() == [0, 0, -1] and len(model.cyclic["left"]) == 9
    assert "CYJOIN 1 and CYJOIN 2, at most" in "\n".join(model.notes) and model.cyclic["next_sector"].all()
    (tmp_path / "sector.bdf").write_text(text.replace("CYAX,902,901", "CYAX,902,999"))
    refused([tmp_path / "sector.bdf", matrices], "grid point 999 of CYAX is not there")
