"""Abaqus decks and matrix files.

Abaqus is licensed and does not run here. Its files are written below, in its published format, from matrices that CalculiX
computed for the same mesh without supports, and from the closed form of a beam.
"""

import numpy as np
import pytest
import ring
import scipy.sparse as sp

from brick_deck import bar, material, matrices_step, mesh_text, on, rows, run_ccx
from dovetail.importers import abaqus, calculix, setup_file

HUGE = 1e36


def mtx(matrix, names, huge=(), both=False):
    """Lines of FORMAT=MATRIX INPUT: the lower triangle column by column; names (n, 2) node and direction from 1."""
    matrix = sp.coo_matrix(matrix if both else sp.tril(matrix))
    lines = []
    for k in np.lexsort((matrix.row, matrix.col)):
        i, j = matrix.row[k], matrix.col[k]
        value = HUGE if i == j and i in huge else matrix.data[k]
        lines.append(f"{names[i][0]},{names[i][1]}, {names[j][0]},{names[j][1]}, {value:22.15e}\n")
    return "".join(lines)


def cae_deck():
    """As Abaqus/CAE writes a bar: one part, one instance, sets and surface in the assembly; one keyword line is continued."""
    nodes, elements = bar()
    left, bottom = on(nodes, 0, 0), on(nodes, 2, 0)
    body = mesh_text(nodes, elements).replace("*ELEMENT, TYPE=C3D20R, ELSET=BODY", "*Element, type=C3D20R,\n elset=Body")
    return ("*Heading\n** Job name: bar\n*Part, name=Bar\n" + body
            + f"*Nset, nset=Set-1\n{rows(left)}\n*Solid Section, elset=Body, material=Steel\n,\n*End Part\n"
            "*Assembly, name=Assembly\n*Instance, name=Bar-1, part=Bar\n0., 0., 12.\n*End Instance\n"
            f"*Nset, nset=Set-1, instance=Bar-1\n{rows(bottom)}\n*Elset, elset=_Under_S1, internal, instance=Bar-1, generate\n1, 8, 1\n"
            "*Surface, type=ELEMENT, name=Under\n_Under_S1, S1\n*End Assembly\n*Material, name=Steel\n*Elastic\n210000., 0.3\n"
            "*Boundary\nBar-1.Set-1, ENCASTRE\n*Step, name=Out, perturbation\n*Matrix Generate, stiffness, mass, load\n"
            "*Matrix Output, stiffness, mass, load, format=MATRIX INPUT\n*Cload\n265, 3, 2.5\n*End Step\n")


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    """Folder with bar.inp, bar_STIF1.mtx, bar_MASS1.mtx, bar_LOAD1.mtx, and the CalculiX import of the held bar."""
    folder = tmp_path_factory.mktemp("abaqus")
    nodes, elements = bar()
    text = mesh_text(nodes, elements) + f"*NSET, NSET=LEFT\n{rows(on(nodes, 0, 0))}\n" + material()
    free = calculix.read([run_ccx(folder, "free", text + matrices_step())])
    held = calculix.read([run_ccx(folder, "held", text + "*BOUNDARY\nLEFT, 1, 3\n" + matrices_step("*CLOAD\n265, 3, 2.5\n"))])
    names = np.stack([free.labels[free.dof_node], free.dof_direction + 1], axis=1)
    stuck = np.flatnonzero(np.isin(names[:, 0], on(nodes, 0, 0)))
    (folder / "bar.inp").write_text(cae_deck())
    (folder / "bar_STIF1.mtx").write_text(mtx(free.K, names, stuck))
    (folder / "bar_MASS1.mtx").write_text(mtx(free.M, names))
    (folder / "bar_LOAD1.mtx").write_text("** Assembled nodal loads\n*CLOAD, REAL\n265,3,  2.500000000000000e+00\n")
    return folder, held, names


def order(structure):
    """Permutation to node by node, direction by direction."""
    return np.lexsort((structure.dof_direction, structure.labels[structure.dof_node]))


def test_the_same_structure_as_from_calculix(job):
    folder, held, _ = job
    ours = abaqus.read([folder / "bar.inp"])
    mine, theirs = order(ours), order(held)
    for name in ("K", "M"):
        a, b = getattr(ours, name).toarray()[np.ix_(mine, mine)], getattr(held, name).toarray()[np.ix_(theirs, theirs)]
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12 * abs(b).max())
    np.testing.assert_array_equal(ours.force[mine], held.force[theirs])
    np.testing.assert_allclose(ours.nodes - held.nodes, np.tile([0, 0, 12.0], (len(held.nodes), 1)), atol=1e-12)
    assert any("39 displacements of 13 nodes" in note for note in ours.notes) and any("total (0, 0, 2.5)" in note for note in ours.notes)


def test_sets_of_part_and_assembly(job):
    folder, _, _ = job
    structure = abaqus.read([folder / name for name in ("bar_MASS1.mtx", "bar.inp", "bar_STIF1.mtx")])
    nodes, _ = bar()
    assert set(structure.node_sets) == {"Set-1", "Bar-1.Set-1"}
    assert sorted(structure.labels[structure.node_sets["Bar-1.Set-1"]]) == sorted(on(nodes, 0, 0))
    assert sorted(structure.labels[structure.node_sets["Set-1"]]) == sorted(on(nodes, 2, 0))
    under = structure.surface("Under")
    np.testing.assert_allclose(under.areas().sum(), 400)
    np.testing.assert_allclose(under.normals(), np.tile([0, 0, -1], (37, 1)), atol=1e-12)
    assert not structure.force.any() and any("NOT taken: *CLOAD" in note and "no _LOAD1.mtx" in note for note in structure.notes)


def test_a_pressed_surface_of_a_static_step_can_be_the_preload(job, tmp_path):
    folder, held, _ = job
    deck = (folder / "bar.inp").read_text()
    at = deck.upper().index("*STEP")
    step = "*Step, name=press\n*Static\n*Dsload\nUnder, P, 2.\n*Cload\nSet-1, 2, 1.\n*End Step\n"
    (tmp_path / "bar.inp").write_text(deck[:at] + step + deck[at:])
    for name in ("bar_STIF1.mtx", "bar_MASS1.mtx", "bar_LOAD1.mtx"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    structure = abaqus.read([tmp_path / "bar.inp"])
    pressed = structure.with_step(1).preload
    z, y = (structure.dof_direction == axis for axis in (2, 1))
    bottom = np.isin(structure.labels[structure.dof_node], structure.labels[structure.node_sets["Set-1"]])
    np.testing.assert_allclose(pressed[y], np.where(bottom[y], 1.0, 0.0))  # on each node of the set
    np.testing.assert_allclose(pressed[z].sum(), 2 * (400 - 2 * 50 * (1 / 3 - 2 / 12)), rtol=1e-12)  # without the held edge
    np.testing.assert_array_equal(structure.force, abaqus.read([folder / "bar.inp"]).force)


def test_a_square_matrix_is_read_too(job, tmp_path):
    folder, held, names = job
    free = calculix.read([folder / "free.inp"])
    for path in ("bar.inp", "bar_MASS1.mtx"):
        (tmp_path / path).write_text((folder / path).read_text())
    stuck = np.flatnonzero(np.isin(names[:, 0], on(bar()[0], 0, 0)))
    text = mtx(free.K, names, stuck, both=True)
    (tmp_path / "bar_STIF1.mtx").write_text(text)
    ours = abaqus.read([tmp_path / "bar.inp"])
    assert abs(ours.K - abaqus.read([folder / "bar.inp"]).K).max() == 0
    lines = text.splitlines(keepends=True)
    (tmp_path / "bar_STIF1.mtx").write_text(lines[0] + lines[1].replace("e+0", "e+1") + "".join(lines[2:]))
    with pytest.raises(ValueError, match=r"bar_STIF1.mtx: the matrix must be symmetric, found .* for node \d+, direction \d"):
        abaqus.read([tmp_path / "bar.inp"])


def test_beam_with_rotations_and_an_internal_node(tmp_path):
    """Closed form of a cantilever of one Euler-Bernoulli element, with a spring to a node of Abaqus' own at its tip."""
    L, EA, GJ, EI, m, spring = 2.0, 600.0, 0.5, 12.0, 3.0, 40.0
    bend = EI / L**3 * np.array([[12, 6 * L], [6 * L, 4 * L**2]])  # w, slope at one end; coupling to the other below
    across = EI / L**3 * np.array([[-12, 6 * L], [-6 * L, 2 * L**2]])
    K = np.zeros((12, 12))
    for a, other in ((0, 6), (6, 0)):
        K[a, a], K[a, other], K[a + 3, a + 3], K[a + 3, other + 3] = EA / L, -EA / L, GJ / L, -GJ / L
    for w, slope, sign in ((1, 5, 1), (2, 4, -1)):
        one, two, turn = [w, slope], [w + 6, slope + 6], np.diag([1, sign])
        flip = np.diag([1, -1])
        K[np.ix_(one, one)] = turn @ bend @ turn
        K[np.ix_(two, two)] = turn @ flip @ bend @ flip @ turn
        K[np.ix_(one, two)] = turn @ across @ turn
        K[np.ix_(two, one)] = K[np.ix_(one, two)].T
    whole = sp.block_diag([sp.csr_matrix([[spring]]), K]).tolil()
    whole[7, 7] += spring
    whole[0, 7] = whole[7, 0] = -spring
    names = [(-1, 1)] + [(node, d) for node in (1, 2) for d in range(1, 7)]
    (tmp_path / "beam.inp").write_text(f"*Node\n1, 0.\n2, {L}\n*Element, type=B33, elset=B\n1, 1, 2\n"
                                       "*Step\n*Matrix Generate, stiffness\n*End Step\n")
    (tmp_path / "beam_STIF1.mtx").write_text(mtx(whole.tocsr(), names, huge=range(1, 7)))
    (tmp_path / "beam_MASS1.mtx").write_text(mtx(sp.diags([0.0] + [m] * 12).tocsr(), names))
    (tmp_path / "beam_LOAD1.mtx").write_text("** Assembled nodal loads\n*CLOAD, REAL\n2,3,  5.4e+01\n1,2,  9.0e+00\n2,5, -2.0e+00\n"
                                            "*CLOAD, IMAGINARY\n2,2,  3.0e+00\n")
    structure = abaqus.read([tmp_path / "beam.inp"])
    np.testing.assert_array_equal(structure.forces["force_sin"], [0, 0, -3, 0, 0, 0, 0])  # Re(3i exp(i omega t)) = -3 sin
    assert structure.courses["force_sin"] == [0, 0, 1] and any('in the load pattern "force_sin"' in note for note in structure.notes)
    assert structure.dof_node.tolist() == [-1] + [1] * 6 and structure.dof_direction.tolist() == [-1, 0, 1, 2, 3, 4, 5]
    u = np.linalg.solve(structure.K.toarray(), structure.force)
    P, C = 54.0, -2.0  # tip force along z, moment about y, for which the slope is -dw/dx
    np.testing.assert_allclose(u[3], P * L**3 / (3 * EI) - C * L**2 / (2 * EI), rtol=1e-12)
    np.testing.assert_allclose(u[5], -P * L**2 / (2 * EI) + C * L / EI, rtol=1e-12)
    assert structure.K[0, 1] == -spring
    assert any("1 unknowns belong to nodes that the source program made" in note for note in structure.notes)


def change(path, old, new):
    text = path.read_text()
    assert old in text, old
    path.write_text(text.replace(old, new, 1))


def drop(path, name):
    """Without the lines of one node."""
    path.write_text("".join(line for line in path.read_text().splitlines(True) if not (line.startswith(name) or f", {name}" in line)))


STIF, MASS, LOAD = "bar_STIF1.mtx", "bar_MASS1.mtx", "bar_LOAD1.mtx"
INSTANCE = "*Instance, name=Bar-2, part=Bar\n*End Instance\n*End Assembly"
WRONG = {
    "no mass": (MASS, lambda p: p.unlink(), r"there is no bar_MASS1.mtx beside it; write them with \*MATRIX GENERATE"),
    "two steps": (STIF, lambda p: p.with_name("bar_STIF2.mtx").write_text("1"),
        "bar_STIF1.mtx and bar_STIF2.mtx lie beside it; name the files"),
    "coordinate": (STIF, lambda p: p.write_text("1 1 3.0\n2 1 4.0\n"),
        "found '1 1 3.0', as FORMAT=COORDINATE writes it.*FORMAT=MATRIX INPUT"),
    "elements": (STIF, lambda p: p.write_text("1, 1,1, 1,1, 3.0\n"),
        r"bar_STIF1.mtx, line 1: wanted row node, .*of global matrices\), .*found '1, 1,1"),
    "cut": (STIF, lambda p: p.write_text(p.read_text()[:-3]), "bar_STIF1.mtx: the last line does not end.*cut short"),
    "cut at a line": (STIF, lambda p: p.write_text("".join(p.read_text().splitlines(True)[:4000])), r"bar_(STIF|MASS)1.mtx.*cut short"),
    "mass cut at a line": (MASS, lambda p: p.write_text("".join(p.read_text().splitlines(True)[:500])),
                           r"bar_MASS1.mtx: the mass of node \d+, direction \d must be positive, found 0 .*cut short"),
    "not finite": (MASS, lambda p: change(p, "e-", "e-x"), r"bar_MASS1.mtx, line 1: wanted row node"),
    "stranger": (STIF, lambda p: p.write_text(p.read_text() + "999,1, 999,1, 5.0\n"),
        r"bar_STIF1.mtx: node 999 is not in the mesh of .*bar.inp"),
    "temperature": (STIF, lambda p: p.write_text(p.read_text() + "4,11, 4,11, 5.0\n"),
        r"wanted displacements and rotations.*found directions 11 and 11"),
    "twice": (STIF, lambda p: p.write_text(p.read_text() + p.read_text().splitlines(True)[0]),
        r"line \d+: the entry of node \d+, .* is given twice"),
    "mass without stiffness": (STIF, lambda p: drop(p, "4,3,"),
        r"bar_MASS1.mtx: node 4, direction 3 has mass, but no entry in .*bar_STIF1.mtx"),
    "two load cases": (LOAD, lambda p: p.write_text(p.read_text() * 2), r"bar_LOAD1.mtx, line 5, \*CLOAD: several load cases are not read"),
    "load elsewhere": (LOAD, lambda p: change(p, "265,", "9999,"), r"bar_LOAD1.mtx, line 3, \*CLOAD: node 9999 is not in the mesh"),
    "two instances": ("bar.inp", lambda p: change(p, "*End Assembly", INSTANCE),
        r"bar.inp, line \d+, \*INSTANCE: decks with several parts.*flat deck"),
    "rotated": ("bar.inp", lambda p: change(p, "0., 0., 12.", "0., 0., 12.\n0,0,0,0,0,1,90."),
        r"\*INSTANCE: a rotated instance is not read"),
    "local axes": ("bar.inp", lambda p: change(p, "*Material", "*Transform, nset=Set-1\n0,1,0,1,0,0\n*Material"),
        r"\*TRANSFORM: .*global directions"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_files_are_refused(job, tmp_path, name):
    for path in ("bar.inp", STIF, MASS, LOAD):
        (tmp_path / path).write_text((job[0] / path).read_text())
    path, spoil, message = WRONG[name]
    spoil(tmp_path / path)
    with pytest.raises(ValueError, match=message):
        abaqus.read([tmp_path / "bar.inp"])


@pytest.mark.parametrize("first, second", [("RIGHT", "LEFT"), ("left", "right")])
def test_a_cyclic_sector(tmp_path, first, second):
    """Which side is left follows from the axis, here against z."""
    sector = ring.sector()
    cards = f"*TIE, NAME=Sides, CYCLIC SYMMETRY\nS_{first}, S_{second}\n*CYCLIC SYMMETRY MODEL, N={ring.N}\n0., 0., 1., 0., 0., -1.\n"
    (tmp_path / "job.inp").write_text(ring.deck(sector, cards))
    for name, matrix in (("STIF", sector.K), ("MASS", sector.M)):
        (tmp_path / f"job_{name}1.mtx").write_text(mtx(matrix, ring.names(sector)))
    (tmp_path / "joints.toml").write_text('[[joint]]\nbetween = ["over_left", "over_right"]\nnext_sector = true\n')
    structure = abaqus.read([tmp_path / "job.inp"])
    model = setup_file.apply(structure, tmp_path / "joints.toml")
    assert model.cyclic["sectors"] == ring.N and model.cyclic["axis"].tolist() == [0, 0, -1]
    nodes = structure.labels[model.mesh["dof_node"][model.cyclic["left"]]]
    assert set(nodes.ravel()) == set(sector.labels[sector.node_sets["right"]])
    assert "nodes of S_right and S_left" in "\n".join(model.notes)
