"""CalculiX decks and matrices: frequencies, mass, loads and surfaces against CalculiX itself, and what is said about wrong files."""

import re
import subprocess
import sys

import h5py
import numpy as np
import pytest
import scipy.sparse.linalg as sla

from brick_deck import (DENSITY, bar, deck, frequencies, held_end, material, matrices_step, mesh_text, on, rows, run_ccx, solved,
                        static_displacement)
from dovetail import Joint, Model
from dovetail.importers import calculix, deck_damping, inp, setup_file
from dovetail.importers.elements import cell_of
from launch import BINARY, SURROUNDINGS, words_of

CASE = """model = "model.h5"
[reduction]
modes = 6
[excitation]
fourier = [0, 0, 1]
[contact]
normal_stiffness = 1e6
tangential_stiffness = [1e6, 1e6]
friction = [0.3, 0.3]
[harmonic_balance]
harmonics = 1
[continuation]
omega = [1.0, 2.0]
"""
GROUND = 'units = "t, mm, s, N"\n[[joint]]\nground = "bottom"\nnormal_stiffness = 1e3\ntangential_stiffness = 1e3\nfriction = 0.3\n'
PAIR = '[[joint]]\nbetween = ["UPPER", "LOWER"]\nname = "middle"\n'


def test_contact_pairs_of_calculix_are_refused_by_name(tmp_path):
    """Their springs are in the stiffness: the joint would count twice."""
    text = two_bars().replace("*STEP", "*CONTACT PAIR, INTERACTION=HARD, TYPE=SURFACE TO SURFACE\nUPPER, LOWER\n*STEP", 1)
    (tmp_path / "job.inp").write_text(text)
    for kind in ("sti", "mas", "dof"):
        (tmp_path / f"job.{kind}").write_text("1\n")
    line = text[:text.index("*CONTACT PAIR")].count("\n") + 1
    with pytest.raises(ValueError, match=rf"job.inp, line {line}, \*CONTACT PAIR: CalculiX puts contact springs .* \[\[joint\]\]"):
        calculix.read([tmp_path / "job.inp"])


def two_bars():
    """Bars one on the other, nodes of the interface doubled, both held at x = 0."""
    lower, upper = bar(cells=(4, 2, 1)), bar(cells=(4, 2, 1), origin=(0, 0, 5), first=10002)
    text = mesh_text(*lower, elset="LOW") + mesh_text(*upper, elset="UP") + "*ELSET, ELSET=ALL\nLOW, UP\n"
    text += f"*NSET, NSET=FIXED\n{rows(held_end(lower[0], 5) + held_end(upper[0], 5))}\n"
    text += f"*NSET, NSET=LOWER\n{rows(on(lower[0], 2, 5))}\n*SURFACE, NAME=UPPER\nUP, S1\n"
    return text + material("ALL") + "*BOUNDARY\nFIXED, 1, 3\n" + matrices_step()


def reduced_frequencies(folder, path, setup):
    """Frequencies with the contact points fixed, by the command line: import, then reduce; and what import said."""
    (folder / "joints.toml").write_text(setup)
    (folder / "case.toml").write_text(CASE)
    said, _ = words_of([sys.executable, "-m", "dovetail", "import", "calculix", path, "--setup", folder / "joints.toml",
                        "-o", folder / "model.h5"])
    words_of([BINARY, "reduce", folder / "case.toml", "--out", folder])
    with h5py.File(folder / "reduced.h5") as file:
        return np.sqrt(file["Kaa"][()]), said


@pytest.fixture(scope="module")
def held_bar(tmp_path_factory):
    return run_ccx(tmp_path_factory.mktemp("held_bar"), "bar", deck())


@pytest.mark.parametrize("kind", ["C3D20R", "C3D20"])
@pytest.mark.slow
def test_frequencies_on_the_ground_are_those_of_calculix(tmp_path, kind):
    path = run_ccx(tmp_path, "bar", deck(kind=kind))
    ours, said = reduced_frequencies(tmp_path, path, GROUND)
    theirs = frequencies(run_ccx(tmp_path, "fixed", solved(deck(extra="BOTTOM, 1, 3\n", kind=kind))))
    assert len(theirs) == 6
    np.testing.assert_allclose(ours, theirs, rtol=1e-6)
    assert "full model" in said and "held by the boundary conditions" in said and "area       400" in said
    assert Model.read(tmp_path / "model.h5").units == "t, mm, s, N"


def test_two_bodies_with_a_closed_joint_move_like_one(tmp_path):
    ours, said = reduced_frequencies(tmp_path, run_ccx(tmp_path, "pair", two_bars()), PAIR)
    one = deck(size=(40.0, 10.0, 10.0), cells=(4, 2, 2), level=5)
    theirs = frequencies(run_ccx(tmp_path, "one", solved(one)))
    np.testing.assert_allclose(ours, theirs, rtol=1e-6)
    assert "joint middle: 37 contact points, pairs of matching nodes" in said


def test_mass_of_a_free_body(tmp_path):
    structure = calculix.read([run_ccx(tmp_path, "free", deck().replace("*BOUNDARY\nLEFT, 1, 3\n", ""))])
    for axis in range(3):
        along = (structure.dof_direction == axis).astype(float)
        np.testing.assert_allclose(along @ structure.M @ along, 40 * 10 * 5 * DENSITY, rtol=1e-10)
        assert abs(structure.K @ along).max() < 1e-7 * abs(structure.K).max()


def test_concentrated_forces_bend_it_as_in_calculix(tmp_path):
    held = held_end(bar()[0], 0)[0]
    text = deck(inside=f"*CLOAD\nTIP, 3, 2.5\n{held}, 2, 7\nTIP, 3, 1.0\n*CLOAD\nTIP, 2, -1\n265, 3, 0.5\n")
    text = text.replace("*MATERIAL", "*NSET, NSET=TIP\n265,\n*MATERIAL", 1)
    structure = calculix.read([run_ccx(tmp_path, "bar", text)])
    static = text.replace("*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n", "*STATIC\n") \
                 .replace("*END STEP", "*NODE PRINT, NSET=TIP\nU\n*END STEP")
    printed = run_ccx(tmp_path, "static", static).with_suffix(".dat").read_text()
    theirs = np.array(re.search(r"^\s+265\s+(\S+)\s+(\S+)\s+(\S+)", printed, re.M).groups(), dtype=float)
    u = sla.spsolve(structure.K.tocsc(), structure.force)
    tip = structure.dof_node == np.searchsorted(structure.labels, 265)
    np.testing.assert_allclose(u[tip], theirs, rtol=1e-5)
    assert any("total (0, -1, 4); 1 forces on held directions" in note for note in structure.notes)


def test_imaginary_forces_are_a_pattern_of_their_own(tmp_path):
    """Re(F exp(i omega t)): an imaginary part goes with -sin(omega t)."""
    path = run_ccx(tmp_path, "bar", deck(inside="*CLOAD\n265, 3, 2\n"))
    path.write_text(path.read_text().replace("*CLOAD\n265, 3, 2\n", "*CLOAD\n265, 3, 2\n*CLOAD, LOAD CASE=2\n265, 2, 5\n265, 3, 1\n", 1))
    structure = calculix.read([path])
    tip = structure.dofs_of(np.searchsorted(structure.labels, 265))
    np.testing.assert_array_equal(structure.force[tip], [0, 0, 2])
    np.testing.assert_array_equal(structure.forces["force_sin"][tip], [0, -5, -1])
    assert structure.courses["force_sin"] == [0, 0, 1]


TWO_STEPS = """*STEP
*STATIC
*CLOAD
265, 3, 1
*DLOAD
BODY, P2, 3.0
*END STEP
*STEP
*STATIC
*CLOAD
265, 3, 4
265, 2, 1
*END STEP
*STEP
*FREQUENCY, SOLVER=MATRIXSTORAGE"""


def test_loads_of_static_steps_can_be_the_preload(tmp_path):
    """A later step has those of the earlier ones, too, but for what it gives anew."""
    path = run_ccx(tmp_path, "bar", deck().replace("*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE", TWO_STEPS, 1))
    structure = calculix.read([path])
    assert not structure.force.any() and not structure.preload.any() and set(structure.steps) == {1, 2}
    top = [label for label, place in bar()[0].items() if abs(place[2] - 5) < 1e-9]
    assert len(top) == 37
    taken = 3 * (400 - 2 * 50 * (-1 / 12 + 1 / 3 - 1 / 12))  # the pressure times the area, without the shares of the held edge
    for step, total in ((1, f"(0, 0, {1 - taken:.6g})"), (2, f"(0, 1, {4 - taken:.6g})")):
        assert any(re.search(rf"NOT taken: force from \d lines of \*CLOAD, \*DLOAD \(.*bar.inp, line \d+\), of step {step}, which "
                             rf"\[\[preload\]\] step = {step} .*total {re.escape(total)}", note) for note in structure.notes)
    (tmp_path / "joints.toml").write_text(GROUND + "[[preload]]\nstep = 2\n")
    model = setup_file.apply(structure, tmp_path / "joints.toml")
    np.testing.assert_array_equal(model.preload, structure.with_step(2).join([Joint.ground(structure.surface("Bottom"))]).preload)
    (tmp_path / "joints.toml").write_text(GROUND + "[[preload]]\nstep = 3\n")
    with pytest.raises(ValueError, match=r"\[\[preload\]\] number 1: there is no step 3 with loads .*; there are: 1, 2"):
        setup_file.apply(structure, tmp_path / "joints.toml")


@pytest.mark.parametrize("kind", ["C3D20R", "C3D20", "C3D8", "C3D8I"])
def test_pressure_bends_it_as_in_calculix(tmp_path, kind):
    """Distributed loads of the matrix step are its amplitude; internal unknowns of C3D8I change nothing."""
    text = deck(kind=kind, inside="*DLOAD\nBODY, P2, 3.0\n1, P4, -2\n", cells=(4, 2, 2))
    structure = calculix.read([run_ccx(tmp_path, "bar", text)])
    theirs = static_displacement(tmp_path, text, structure)
    u = sla.spsolve(structure.K.tocsc(), structure.force)
    np.testing.assert_allclose(u, theirs, rtol=0, atol=2e-6 * abs(theirs).max())


def test_weight_is_that_of_all_masses(tmp_path):
    """Of a body that the deck holds, the matrices do not have the share of the held nodes, and it is not taken."""
    text = deck(inside="*DLOAD\nBODY, GRAV, 9.81e3, 0, 3, -4\n")
    structure = calculix.read([run_ccx(tmp_path, "free", text.replace("*BOUNDARY\nLEFT, 1, 3\n", ""))])
    weight = 40 * 10 * 5 * DENSITY * 9.81e3
    assert any("*DLOAD, GRAV (" in note and f"total (0, {0.6 * weight:.6g}, {-0.8 * weight:.6g})" in note for note in structure.notes)
    structure = calculix.read([run_ccx(tmp_path, "held", text)])
    assert not structure.force.any()
    assert any(re.search(r"NOT taken: the weight \(.*held.inp, line \d+\), .*\[\[clamp\]\]", note) for note in structure.notes)
    (tmp_path / "joints.toml").write_text(GROUND + "[[gravity]]\nvector = [0, 0, -9810]\n")
    notes = setup_file.apply(structure, tmp_path / "joints.toml").notes
    assert any(note.startswith("CHECK: [[gravity]]") for note in notes)


def test_other_loads_are_said_to_be_left_out(tmp_path):
    text = deck(inside="*DLOAD\nBODY, CENTRIF, 100., 0, 0, 0, 0, 0, 1\n1, GRAV, 1, 0, 0, 1\n")
    structure = calculix.read([run_ccx(tmp_path, "bar", text.replace("*BOUNDARY\nLEFT, 1, 3\n", ""))])
    assert not structure.force.any()
    assert any(re.search(r"NOT taken: \*DLOAD with CENTRIF \(.*bar.inp, line \d+\)", note) for note in structure.notes)
    assert any(re.search(r"NOT taken: the weight of a part \(.*bar.inp, line \d+\)", note) for note in structure.notes)


def test_damping_that_all_materials_have_is_taken(tmp_path):
    text = deck().replace("*DENSITY", "*DAMPING, ALPHA=2.5, BETA=1d-6\n*DENSITY", 1)
    structure = calculix.read([run_ccx(tmp_path, "bar", text)])
    note, = (note for note in structure.notes if "DAMPING" in note)
    assert "mass = 2.5; stiffness = 1e-06" in note and structure.damping == {"mass": 2.5, "stiffness": 1e-6}


THROUGH_TIME = """*STEP, INC=100
*DYNAMIC, DIRECT, ALPHA=0
1e-5, 2e-4
*CLOAD
BOTTOM, 3, 1.0
*NODE PRINT, NSET=BOTTOM, FREQUENCY=20
U
*END STEP
"""


def displacements(path):
    """(n,) along z of what *NODE PRINT has printed."""
    return np.array(re.findall(r"^ +\d+ +\S+ +\S+ +(\S+)$", path.with_suffix(".dat").read_text(), re.M), dtype=float)


OF_PARTS = [("*DAMPING, STRUCTURAL=0.1", "*MATERIAL, NAME=UNDAMPED\n"), ("*DAMPING, ALPHA=2.5, COMPOSITE=0.1", ""),
            ("*DAMPING, STRUCTURAL=0.1", "*MATERIAL, NAME=OTHER\n*DAMPING, STRUCTURAL=0.2\n")]
OF_ABAQUS = [("*DAMPING, ALPHA=2.5, BETA=1e-6", "*MATERIAL, NAME=UNDAMPED\n"),
             ("*DAMPING, ALPHA=2.5, BETA=1e-6", "*MATERIAL, NAME=OTHER\n*DAMPING, ALPHA=2\n")]


@pytest.mark.parametrize("in_calculix, card, other", [*[(True, *cards) for cards in OF_PARTS],
                                                      *[(False, *cards) for cards in OF_PARTS + OF_ABAQUS]])
def test_damping_of_parts_is_said_to_be_left_out(tmp_path, in_calculix, card, other):
    path = tmp_path / "bar.inp"
    path.write_text(deck().replace("*DENSITY", f"{card}\n*DENSITY", 1) + other)
    read = inp.read(path, rayleigh_of_all=in_calculix)
    note, = deck_damping.notes_of(read.damping, read.damping_named)
    assert re.search(rf"NOT taken: {re.escape(card)} \(.*bar.inp, line \d+\)", note)
    assert "damping.mass is ALPHA, damping.stiffness BETA" in note and read.damping == {}


@pytest.mark.parametrize("first, second, taken, overruled", [
    ("ALPHA=4000, BETA=1e-6", "", {"mass": 4000, "stiffness": 1e-6}, 0), ("ALPHA=4000", "BETA=1e-6", {"mass": 4000, "stiffness": 1e-6}, 0),
    ("ALPHA=4000, BETA=1e-6", "ALPHA=0, BETA=0", {}, 1), ("ALPHA=4000, BETA=1e-6", "ALPHA=8000", {"mass": 8000, "stiffness": 1e-6}, 1),
    ("STRUCTURAL=0.1, ALPHA=4000", "STRUCTURAL=0.1", {"mass": 4000, "structural": 0.1}, 0)])
def test_the_last_rayleigh_damping_is_of_all_materials_as_in_calculix(tmp_path, first, second, taken, overruled):
    """The end of a held bar after 20 steps through time, beside one with a single card of what the import takes."""
    def damped(words, after=""):
        return deck(cells=(2, 1, 1)).replace("*DENSITY", f"*DAMPING, {words}\n*DENSITY", 1).replace("*BOUNDARY", after + "*BOUNDARY", 1)

    text = damped(first, "*MATERIAL, NAME=OTHER\n*ELASTIC\n1, 0.3\n" + (f"*DAMPING, {second}\n" if second else ""))
    structure = calculix.read([run_ccx(tmp_path, "bar", text)])
    assert structure.damping == taken
    assert sum("as CalculiX takes the last such card" in note and re.search(r"bar.inp, line \d+\)", note) is not None
               for note in structure.notes) == overruled
    one = damped(f"ALPHA={taken.get('mass', 0)}, BETA={taken.get('stiffness', 0)}")
    two, same, undamped = (displacements(run_ccx(tmp_path, "through_time", some.replace(matrices_step(), THROUGH_TIME)))
                           for some in (text, one, damped("ALPHA=0")))
    np.testing.assert_allclose(two, same, rtol=1e-4)
    assert (np.abs(two / undamped - 1).max() > 0.01) == bool({"mass", "stiffness"} & taken.keys())


def test_displacements_given_at_supports_are_said_to_be_left_out(tmp_path):
    text = deck().replace("LEFT, 1, 3\n", "LEFT, 1, 2\nLEFT, 3, 3, 0.001\n", 1)
    structure = calculix.read([run_ccx(tmp_path, "bar", text)])
    assert any(re.search(r"NOT taken: \*BOUNDARY with a displacement other than zero \(.*bar.inp, line \d+\)", note)
               for note in structure.notes)


EQUATION = "*EQUATION\n2\n265, 3, 1.0, 259, 3, -1.0\n*NSET, NSET=TIED\n265, 259\n*NSET, NSET=APART\n259,\n"


def test_equations_stay_in_the_matrices_and_tied_sets_are_for_loads_only(tmp_path):
    text = deck(extra=EQUATION)
    structure = calculix.read([run_ccx(tmp_path, "tied", text)])
    values = sla.eigsh(structure.K.tocsc(), 6, structure.M.tocsc(), sigma=0, return_eigenvectors=False)
    np.testing.assert_allclose(np.sqrt(np.sort(values)), frequencies(run_ccx(tmp_path, "modes", solved(text))), rtol=1e-6)
    assert set(structure.node_sets) == {"Left", "Bottom", "APART"} and set(structure.tied_sets) == {"TIED"}
    assert any("first node 265" in note and "for loads only, which go through the equations: TIED" in note for note in structure.notes)
    (tmp_path / "joints.toml").write_text('[[joint]]\nground = "TIED"\n')
    with pytest.raises(ValueError, match="there is no set 'TIED'"):
        setup_file.apply(structure, tmp_path / "joints.toml")


def test_forces_on_tied_nodes_go_through_their_equations(tmp_path):
    """*CLOAD on a node that follows, and a load of the set-up file on its set, bend the bar as in CalculiX."""
    chain = "*EQUATION\n3\n265, 3, 2.0, 259, 3, -1.5, 256, 2, 0.5\n2\n259, 3, 1.0, 253, 3, -1.0\n*NSET, NSET=TIED\n265, 259\n"
    text = deck(extra=chain, inside="*CLOAD\n265, 3, 3\n259, 3, 3\n265, 2, -1\n259, 2, -1\n")
    structure = calculix.read([run_ccx(tmp_path, "bar", text)])
    theirs = static_displacement(tmp_path, text, structure)
    for loaded in (structure.force, structure.with_preload("TIED", [0, -2, 6]).preload):
        np.testing.assert_allclose(sla.spsolve(structure.K.tocsc(), loaded), theirs, rtol=0, atol=2e-6 * abs(theirs).max())


def test_forces_on_nodes_tied_in_another_way_are_refused(tmp_path):
    path = run_ccx(tmp_path, "loaded", deck(extra=EQUATION, inside="*CLOAD\n265, 3, 1\n"))
    path.write_text(path.read_text().replace("*EQUATION\n2\n265, 3, 1.0, 259, 3, -1.0\n", ""))  # as a *TIE would leave it
    with pytest.raises(ValueError, match=r"loaded.inp, line \d+: the force acts on node 265, direction 3, .*tied"):
        calculix.read([path])


def notes_of(path):
    return "\n".join(calculix.read([path]).notes)


def test_what_holds_a_free_body_is_named(tmp_path):
    """Nothing; an equation that rigid motion does not satisfy; a spring to the ground."""
    free = deck().replace("*BOUNDARY\nLEFT, 1, 3\n", "")
    path = run_ccx(tmp_path, "free", free)
    said = notes_of(path)
    assert "x 0, y 0, z 0, about x 0, about y 0, about z 0: nothing in the deck holds the mesh" in said and "CHECK" not in said
    lines = path.with_suffix(".sti").read_text().splitlines()
    row = path.with_suffix(".dof").read_text().split().index("265.3") + 1
    at = next(i for i, line in enumerate(lines) if line.split()[:2] == [str(row)] * 2)
    lines[at] = f"{row} {row} {float(lines[at].split()[2]) + 0.05:.13e}"  # 0.05 N/mm, a millionth of the stiffness of an element
    path.with_suffix(".sti").write_text("\n".join(lines) + "\n")
    said = notes_of(path)
    assert re.search(r"x 0, y 0, z \S+e-1\d, ", said)
    assert re.search(r"CHECK: 1 node away from all boundary conditions resists rigid motion \(z.*\), most of all node 265, "
                     "direction 3", said)
    wrong = deck(extra="*EQUATION\n2\n265, 1, 1.0, 259, 1, 1.0\n").replace("LEFT, 1, 3\n", "LEFT, 1, 1\n")
    said = notes_of(run_ccx(tmp_path, "equation", wrong))
    assert re.search(r"CHECK: \*EQUATION \(.*equation.inp, line \d+\) is not true when the whole mesh moves rigidly, x", said)


def test_right_equations_hold_nothing(tmp_path):
    """A node in the middle between two others that follows them."""
    nodes, _ = bar()
    label = next(label for label, place in nodes.items() if np.allclose(place, [40, 5, 5]))
    ends = [other for other, place in nodes.items() if np.allclose(place, [40, 0, 5]) or np.allclose(place, [40, 10, 5])]
    assert len(ends) == 2
    text = "".join(f"*EQUATION\n3\n{label}, {d}, 1.0, {ends[0]}, {d}, -0.5, {ends[1]}, {d}, -0.5\n" for d in (1, 2, 3))
    said = notes_of(run_ccx(tmp_path, "right", deck(extra=text).replace("*BOUNDARY\nLEFT, 1, 3\n", "")))
    assert "nothing in the deck holds the mesh" in said and "CHECK" not in said


# One sheared element each: number of faces, corners, mid-side edges; and the part of a face's load that each of its nodes takes.
TETRA = [(0, 0, 0), (3, 0, 0.2), (0.3, 2, 0), (0.5, 0.4, 4)]
BRICK = [(0, 0, 0), (3, 0, 0), (3, 2, 0), (0, 2, 0), (0.5, 0, 4), (3.5, 0, 4), (3.5, 2, 4), (0.5, 2, 4)]
WEDGE = [(0, 0, 0), (3, 0, 0), (0.5, 2, 0), (0.4, 0.3, 4), (3.4, 0.3, 4), (0.9, 2.3, 4)]
SHAPES = {"C3D4": (4, TETRA, ""), "C3D10": (4, TETRA, "12 23 31 14 24 34"), "C3D8": (6, BRICK, ""),
          "C3D20": (6, BRICK, "12 23 34 41 56 67 78 85 15 26 37 48"),
          "C3D15": (5, WEDGE, "12 23 31 45 56 64 14 25 36")}
PARTS = {3: [1 / 3] * 3, 4: [1 / 4] * 4, 6: [0] * 3 + [1 / 3] * 3, 8: [-1 / 12] * 4 + [1 / 3] * 4}


@pytest.mark.parametrize("kind", SHAPES)
def test_faces_are_those_that_calculix_loads(tmp_path, kind):
    """Pressure on face k in CalculiX moves every node as the load on our face Sk, against its outward area, does with our K."""
    count, corners, edges = SHAPES[kind]
    places = [np.array(place, dtype=float) for place in corners]
    places += [(places[int(a) - 1] + places[int(b) - 1]) / 2 for a, b in edges.split()]
    numbers = range(1, len(places) + 1)
    text = "*NODE, NSET=ALL\n" + "".join(f"{k}, {x}, {y}, {z}\n" for k, (x, y, z) in zip(numbers, places))
    text += f"*ELEMENT, TYPE={kind}, ELSET=BODY\n1, {rows(numbers[:10])}" + (f",\n{rows(numbers[10:])}" if len(numbers) > 10 else "") + "\n"
    text += "".join(f"*SURFACE, NAME=FACE{k}\n1, S{k}\n" for k in range(1, count + 1))
    text += material() + "*BOUNDARY\n1, 1, 3\n2, 2, 3\n3, 3\n"
    steps = "".join(f"*STEP\n*STATIC\n*DLOAD, OP=NEW\nBODY, P{k}, 1.0\n*NODE PRINT, NSET=ALL\nU\n*END STEP\n" for k in range(1, count + 1))
    printed = run_ccx(tmp_path, "loaded", text + steps).with_suffix(".dat").read_text()
    theirs = np.array(re.findall(r"^ +\d+ +(\S+) +(\S+) +(\S+)$", printed, re.M), dtype=float).reshape(count, len(places), 3)
    structure = calculix.read([run_ccx(tmp_path, "one", text + matrices_step())])
    for k in range(1, count + 1):
        (face,), = structure.surfaces[f"FACE{k}"]
        parts = PARTS[len(face)]
        ring = structure.nodes[face[:len(face) if len(face) < 5 else len(face) // 2]]
        area = sum(np.cross(a, b) for a, b in zip(ring, np.roll(ring, -1, axis=0))) / 2
        force = np.zeros((len(places), 3))
        force[face] = -np.outer(parts, area)
        u = sla.spsolve(structure.K.tocsc(), force[structure.dof_node, structure.dof_direction])
        scale = abs(theirs[k - 1]).max()
        np.testing.assert_allclose(u, theirs[k - 1][structure.dof_node, structure.dof_direction], rtol=0, atol=2e-6 * scale)


def test_faces_of_the_six_node_wedge():
    """As those of the wedge with 15 nodes: CalculiX 2.20 itself does not load the sides of C3D6 reproducibly."""
    linear, quadratic = cell_of("C3D6"), cell_of("C3D15")
    assert linear.faces == {name: nodes[:len(nodes) // 2] for name, nodes in quadratic.faces.items()}


def test_sets_and_surfaces(held_bar):
    structure = calculix.read([held_bar.with_suffix(".sti"), held_bar.with_suffix(".dof")])
    nodes, _ = bar()
    for name, labels in (("Left", held_end(nodes, 0)), ("Bottom", on(nodes, 2, 0))):
        assert sorted(structure.labels[structure.node_sets[name]]) == sorted(labels)
    np.testing.assert_allclose(structure.nodes, [nodes[label] for label in structure.labels], atol=1e-9)
    under, bottom = structure.surface("UNDER"), structure.surface("Bottom")
    for surface in (under, bottom):
        np.testing.assert_allclose(surface.areas().sum(), 400, rtol=1e-12)
        np.testing.assert_allclose(surface.normals(), np.tile([0, 0, -1], (37, 1)), atol=1e-12)
        place = [(structure.labels[structure.dof_node[dofs]].tolist(), structure.dof_direction[dofs].tolist()) for dofs in surface.dofs]
        assert place == [([label] * 3, [0, 1, 2]) for label in surface.labels]
    assert (structure.dofs_of(structure.node_sets["Left"]) == -1).all()
    assert [name for name in structure.cells] == ["hexahedron20"]


def test_orthography_changes_nothing(tmp_path, held_bar):
    """Includes, comments, upper and lower case, GENERATE, sets of sets, several node blocks: CalculiX and we read the same."""
    nodes, elements = bar()
    half = len(nodes) // 2
    labels = list(nodes)
    parts = [{label: nodes[label] for label in labels[:half]}, {label: nodes[label] for label in labels[half:]}]
    block = ["".join(f"{label} , {x:.12g}, {y:.12g}, {z:.12g}\n" for label, (x, y, z) in part.items()) for part in parts]
    (tmp_path / "more.txt").write_text("** the rest\n*node\n" + block[1])
    text = "*Heading\n a bar\n*node, nset=nall\n" + block[0] + "** between\n*INCLUDE, INPUT=more.txt\n"
    text += "*Element, type = C3D20R , elset=body\n" + mesh_text(nodes, elements).split("ELSET=BODY\n")[1].lower()
    left, bottom = held_end(nodes, 0), on(nodes, 2, 0)
    text += f"*NSET, NSET=one\n{rows(left[:4], 2)}\n*nset, nset=LEFT\none,\n{rows(left[4:])}\n*NSET,NSET=bottom\n{rows(bottom)}\n"
    text += "*ELSET, ELSET=some, GENERATE\n1, 5\n6, 8, 2\n*ELSET, ELSET=rest\n7\n*SURFACE, NAME=under, TYPE=ELEMENT\nSOME, S1\nrest, s1\n"
    text += material("body") + "*BOUNDARY\nleft, 1, 3\n" + matrices_step()
    path = run_ccx(tmp_path, "odd", text)
    ours, plain = calculix.read([path]), calculix.read([held_bar])
    np.testing.assert_array_equal(ours.K.toarray(), plain.K.toarray())
    np.testing.assert_array_equal(ours.nodes, plain.nodes)
    np.testing.assert_array_equal(np.sort(ours.node_sets["bottom"]), np.sort(plain.node_sets["Bottom"]))
    np.testing.assert_array_equal(np.sort(ours.node_sets["LEFT"]), np.sort(plain.node_sets["Left"]))
    assert sorted(map(tuple, ours.surfaces["under"][0])) == sorted(map(tuple, plain.surfaces["UNDER"][0]))


def change(path, old, new):
    text = path.read_text()
    assert old in text, old
    path.write_text(text.replace(old, new, 1))


def cut(path, keep):
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:keep]))


WRONG = {
    "no deck file": (".inp", lambda p: p.unlink(), r"bar.inp: no such file"),
    "no mass file": (".mas", lambda p: p.unlink(), r"bar.mas: no such file; CalculiX writes .*MATRIXSTORAGE"),
    "empty": (".sti", lambda p: p.write_text(""), r"bar.sti: the file is empty"),
    "cut within a line": (".sti", lambda p: p.write_text(p.read_text()[:-5]), r"bar.sti: the last line does not end.*cut short"),
    "cut at a line": (".sti", lambda p: cut(p, 500), r"bar.sti: row \d+ of 243 has no diagonal entry.*cut short"),
    "line without value": (".mas", lambda p: change(p, "\n3 3 ", "\n3 "),
        r"bar.mas, line 6: wanted row, column, value, all finite, found '3 "),
    "not a number": (".sti", lambda p: p.write_text(re.sub(r"\n2 3 .*\n", "\n2 3 abc\n", p.read_text(), count=1)),
                     r"bar.sti, line 5: wanted row, column, value, all finite, found '2 3 abc'"),
    "infinite": (".sti", lambda p: p.write_text(re.sub(r"\n2 3 .*\n", "\n2 3 inf\n", p.read_text(), count=1)),
                 r"bar.sti, line 5: .* all finite, found '2 3 inf'"),
    "fraction as row": (".sti", lambda p: change(p, "\n2 3 ", "\n2.5 3 "), r"bar.sti, line 5: wanted row, column, value"),
    "row too large": (".sti", lambda p: change(p, "\n2 3 ", "\n2 999 "),
        r"bar.sti, line 5: wanted rows and columns from 1 to 243, .*found 2 and 999"),
    "twice": (".sti", lambda p: change(p, "\n2 3 ", "\n1 3 "),
        r"bar.sti, line 5: the entry of row 1 \(node \d+, direction 1\) and row 3 .* is given twice"),
    "other triangle": (".sti", lambda p: change(p, "\n2 3 ", "\n3 2 1e5\n2 3 "),
        r"bar.sti: the matrix must be symmetric, found .* for row"),
    "entry fewer": (".mas", lambda p: p.write_text(re.sub(r"\n2 3 .*\n", "\n", p.read_text(), count=1)),
                    r"bar.mas: wanted \d+ entries as in .*bar.sti, found \d+"),
    "no density": (".mas", lambda p: p.write_text(re.sub(r"\n(5) (5) .*\n", "\n5 5 0\n", p.read_text(), count=1)),
                   r"bar.mas: the mass of node \d+, direction 2 must be positive, found 0 .*\*DENSITY"),
    "dof file shorter": (".dof", lambda p: cut(p, 200),
        r"bar.sti, line \d+: wanted rows and columns from 1 to 200, as many as the .dof file"),
    "dof file longer": (".dof", lambda p: p.write_text(p.read_text() + "9999.1\n"), r"bar.sti: row 244 of 244 has no diagonal"),
    "dof no number": (".dof", lambda p: change(p, "\n7.3\n", "\n7,3\n"),
        r"bar.dof, line \d+: wanted node.direction such as 12.3, found '7,3'"),
    "dof direction": (".dof", lambda p: change(p, "\n7.3\n", "\n7.5\n"), r"bar.dof, line \d+: wanted a direction from 1 to 3, found 5"),
    "dof twice": (".dof", lambda p: change(p, "\n7.3\n", "\n7.2\n"), r"bar.dof, line \d+: 7.2 is given twice"),
    "other mesh": (".inp", lambda p: p.write_text(re.sub(r"(?m)^(\d+, )(\S+), (\S+), (\S+)$", r"\1\4, \2, \3", p.read_text())),
                   r"bar.inp and .*bar.sti do not belong together: \d+ of \d+ rows"),
    "node missing": (".inp", lambda p: change(p, "\n7, ", "\n777, "),
        r"bar.inp, line \d+, \*ELEMENT: element 1 has node 7, which is not in the mesh"),
    "node twice": (".inp", lambda p: change(p, "\n7, ", "\n4, "),
        r"bar.inp, line 4, \*NODE: node 4 is there already, in .*bar.inp, line 3"),
    "node number": (".inp", lambda p: change(p, "\n7, ", "\nseven, "), r"bar.inp, line 4, \*NODE: wanted a number, found 'seven'"),
    "node nan": (".inp", lambda p: change(p, "\n7, ", "\n7, nan, "), r"bar.inp, line 4, \*NODE: wanted at most 4 numbers, found 5"),
    "coordinate nan": (".inp", lambda p: change(p, "\n1, 0,", "\n1, nan,"), r"bar.inp, line 2, \*NODE: wanted a finite number, found nan"),
    "element short": (".inp", lambda p: p.write_text(re.sub(r"(\nELSET=BODY\n|BODY\n1, \d+, )(\d+, )", r"\1", p.read_text(), count=1)),
                      r"bar.inp, line 92, \*ELEMENT: wanted 21 numbers"),
    "set missing": (".inp", lambda p: change(p, "LEFT, 1, 3", "LOFT, 1, 3"),
        r"bar.inp, line \d+, \*BOUNDARY: there is no node set 'LOFT' above; there are: Left, Bottom"),
    "set with strange node": (".inp", lambda p: change(p, "nset=Bottom\n", "nset=Bottom\n9999, "),
        r"bar.inp, line \d+, \*NSET: node 9999 is not in the mesh"),
    "element set missing": (".inp", lambda p: change(p, "BODY, S1", "BUDDY, S1"),
        r"\*SURFACE: there is no element set 'BUDDY' above; there are: BODY"),
    "no such face": (".inp", lambda p: change(p, "BODY, S1", "BODY, S7"), r"\*SURFACE: element 1 has no face S7; its faces are S1, S2"),
    "generated nodes": (".inp", lambda p: change(p, "*SURFACE", "*NGEN\n1, 4\n*SURFACE"),
        r"bar.inp, line \d+, \*NGEN: nodes or elements that .* write the deck out"),
    "local directions": (".inp", lambda p: change(p, "*SURFACE", "*TRANSFORM, NSET=Left\n1,0,0,0,1,0\n*SURFACE"),
        r"\*TRANSFORM: .*use global directions"),
    "cyclic": (".inp", lambda p: change(p, "*SURFACE", "*CYCLIC SYMMETRY MODEL, N=3, TIE=X\n*SURFACE"),
        r"\*CYCLIC SYMMETRY MODEL: wanted two points of the axis"),
    "include missing": (".inp", lambda p: change(p, "*SURFACE", "*INCLUDE, INPUT=no.inp\n*SURFACE"),
        r"\*INCLUDE: there is no file no.inp beside it"),
    "shell": (".inp", lambda p: change(p, "*SURFACE", "*ELEMENT, TYPE=S4, ELSET=SKIN\n900, 1, 4, 7, 10\n*SURFACE"),
        r"bar.inp: wanted solid elements only, found quad: CalculiX makes solids of shells"),
    "no deck": (".inp", lambda p: p.write_text("nothing\n"), r"bar.inp, line 1: wanted a keyword such as \*NODE"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_files_are_refused_by_name_and_line(tmp_path, held_bar, name):
    for suffix in (".inp", ".sti", ".mas", ".dof"):
        (tmp_path / f"bar{suffix}").write_text(held_bar.with_suffix(suffix).read_text())
    suffix, spoil, message = WRONG[name]
    spoil(tmp_path / f"bar{suffix}")
    with pytest.raises(ValueError, match=message):
        calculix.read([tmp_path / "bar.inp"])


@pytest.mark.slow
def test_the_command_line_refuses_in_words_and_writes_nothing(tmp_path, held_bar):
    (tmp_path / "joints.toml").write_text(GROUND.replace("bottom", "buttom"))
    command = [sys.executable, "-m", "dovetail", "import", "calculix", held_bar, "-o", tmp_path / "m.h5"]
    for options, message in (([], "hold no joints; say with --setup joints.toml"),
                             (["--setup", tmp_path / "joints.toml"], "there is no set 'buttom'; did you mean 'Bottom'?")):
        done = subprocess.run([*command, *options], env=SURROUNDINGS, capture_output=True, text=True)
        assert done.returncode == 2 and message in done.stderr and "Traceback" not in done.stderr, done.stderr
    assert not (tmp_path / "m.h5").exists()
