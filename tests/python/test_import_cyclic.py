"""Sectors of a disk by import: [cyclic] of the set-up file, cards of each program, and CalculiX's own cyclic analysis."""

import re

import numpy as np
import pytest
import ring
from brick_deck import bar, material, matrices_step, mesh_text, on, rows, run_ccx

from dovetail import Joint, Model
from dovetail.importers import calculix, convert, setup_file
from dovetail.reference import sector_frequencies

N = 8
ANGLE = 2 * np.pi / N
CARDS = "*TIE, CYCLIC SYMMETRY, NAME=T1, POSITION TOLERANCE=0.01\nSRIGHT, SLEFT\n"
MODEL = f"*CYCLIC SYMMETRY MODEL, N={N}, NGRAPH=1, TIE=T1\n0, 0, -5, 0, 0, 7\n"
CYCLIC = '[cyclic]\nsectors = 5\nleft = "LEFT"\nright = "right"\naxis = [0, 0, 1]\n'
JOINT = '[[joint]]\nbetween = ["over_right", "over_left"]\nnormal_stiffness = 1e3\ntangential_stiffness = 1e3\nfriction = 0.3\n'
NEXT = JOINT + "next_sector = true\n"
GROUNDED = re.sub("between.*", 'ground = "over_left"', JOINT)


def written(folder, text):
    path = folder / "joints.toml"
    path.write_text(text)
    return path


def applied(folder, text, structure=None):
    return setup_file.apply(structure or ring.sector(), written(folder, text))


def test_the_same_model_as_by_hand(tmp_path):
    ours = applied(tmp_path, CYCLIC + "origin = [0, 0, 3]\ntolerance = 1e-5\n" + NEXT)
    theirs = ring.sector().cyclic(5, "left", "right", (0, 0, 1), origin=(0, 0, 3))
    joint = Joint.between(theirs.surface("over_right"), theirs.surface("over_left"), normal_stiffness=1e3, tangential_stiffness=1e3,
                          friction=0.3, next_sector=True)
    theirs = theirs.join(joint)
    for key in ("left", "right", "next_sector", "nodes", "axis", "origin"):
        np.testing.assert_array_equal(ours.cyclic[key], theirs.cyclic[key])
    np.testing.assert_array_equal(ours.joint["axes"], theirs.joint["axes"])
    said = "\n".join(ours.notes)
    assert "one of 5 sectors about the axis (0, 0, 1) through (0, 0, 3): 9 pairs of nodes of left and right, at most" in said
    assert "6 contact points, pairs of matching nodes, to the next sector" in said


@pytest.mark.parametrize("text, message", [
    (CYCLIC.replace("sectors", "sector") + NEXT, r"\[cyclic\]: unknown key 'sector'; did you mean 'sectors'\?"),
    ("[" + CYCLIC.replace("]", "]]", 1) + NEXT, r"wanted \[cyclic\] in single brackets, once"),
    (CYCLIC.replace("axis", "origin") + NEXT, r"\[cyclic\]: wanted sectors, left, right, axis, found in the set-up file: left, origin"),
    (CYCLIC.replace('"LEFT"', '"LEFTY"') + NEXT, r"\[cyclic\]: there is no set 'LEFTY'; did you mean 'left'"),
    (CYCLIC.replace('"LEFT"', "3") + NEXT, r"\[cyclic\]: left must be the name of a set, or a list of names, found 3"),
    (CYCLIC.replace("[0, 0, 1]", "3") + NEXT, r"\[cyclic\]: axis must be three finite numbers, found 3"),
    (CYCLIC.replace("5", "5.0") + NEXT, r"\[cyclic\]: sectors must be a whole number from 2 on, .* found 5.0"),
    (CYCLIC + 'tolerance = "x"\n' + NEXT, r"\[cyclic\]: tolerance must be a finite number"),
    (CYCLIC.replace("5", "6") + NEXT, r"\[cyclic\]: 'left' and 'right' are 72 degrees apart, 6 sectors need 60; sectors = 5\?"),
    (NEXT, r"\[\[joint\]\] number 1: surface 'over_left' is that of a structure that is not cyclic"),
    (CYCLIC + NEXT.replace("true", "1"), r"\[\[joint\]\] number 1: next_sector must be true or false, found 1"),
    (CYCLIC + GROUNDED + "next_sector = true\n", r"next_sector has no meaning for a joint with the ground"),
    (CYCLIC + NEXT + "[[gravity]]\nvector = [0, 1, -9.81]\n", r"joints.toml: the weight under .* along the axis, \(0, 0, 1\)"),
    (CYCLIC + NEXT + "[[base]]\ndirection = [1, 0, 0]\n", r"joints.toml: the base motion 'base' along .* along the axis, \(0, 0, 1\)"),
    (CYCLIC + NEXT + '[[bolt]]\nbetween = ["over_left", "bore"]\nforce = 1\nthen = "lock"\n',
     r"\[\[bolt\]\]: a bolt of a cyclic sector keeps its force"),
])
def test_wrong_entries_are_refused(tmp_path, text, message):
    with pytest.raises(ValueError, match=message):
        applied(tmp_path, text)


def test_weight_along_the_axis_is_taken(tmp_path):
    along = "[[gravity]]\nvector = [0, 0, -9.81]\n[[base]]\ndirection = [0, 0, -2]\n"
    model = applied(tmp_path, CYCLIC + NEXT + along)
    assert model.preload[2::3].max() < 0 < model.forces["base"][2::3].min()


def test_supports_are_those_of_all_sectors(tmp_path):
    """Free, the ring can spin and move along its axis; a blade that only joints hold keeps all of its motions."""
    said = "\n".join(applied(tmp_path, CYCLIC + NEXT).notes)
    assert "1 body; rigid motions that only joints can hold: 2" in said
    assert "1 body, all held" in "\n".join(applied(tmp_path, CYCLIC + NEXT + '[[clamp]]\nset = "bore"\n').notes)
    pull = '[[preload]]\nset = "over_left"\nvector = [0, 0, 1]\n'
    assert "preload on it (0, 0, 1)" in "\n".join(applied(tmp_path, CYCLIC + NEXT + pull).notes)
    assert "rigid motions that only joints can hold: 6" in "\n".join(applied(tmp_path, GROUNDED).notes)


def test_a_bolt_that_keeps_its_force(tmp_path):
    model = applied(tmp_path, CYCLIC + NEXT + '[[bolt]]\nbetween = ["over_left", "bore"]\nforce = 3\n')
    plain = applied(tmp_path, CYCLIC + NEXT)
    pulls = (model.preload - plain.preload).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(pulls[ring.sector().node_sets["bore"]].sum(axis=0)), 3)
    np.testing.assert_allclose(pulls.sum(axis=0), 0, atol=1e-12)


def deck(cards="", step=None, joint_faces=False):
    """A sector of C3D20 from radius 40 to 100, held at the bore, its sides above that in surfaces SLEFT and SRIGHT."""
    plain, elements = bar(size=(60.0, ANGLE, 10.0), cells=(3, 2, 1), origin=(40.0, 0.0, 0.0))
    nodes = {label: (r * np.cos(t), r * np.sin(t), z) for label, (r, t, z) in plain.items()}
    low, high = 40 + 1e-9, (60 + 1e-9 if joint_faces else 1e9)
    sets = {"BORE": on(plain, 0, 40.0)}
    for name, angle in (("LEFT", 0), ("RIGHT", ANGLE)):
        sets[name] = [label for label in on(plain, 1, angle) if low < plain[label][0] < high]
        if joint_faces:
            sets["OVER_" + name] = [label for label in on(plain, 1, angle) if plain[label][0] > 80 - 1e-9]
    text = mesh_text(nodes, elements, "C3D20")
    text += "".join(f"*NSET, NSET={name}\n{rows(members)}\n" for name, members in sets.items())
    text += "".join(f"*SURFACE, NAME=S{name}, TYPE=NODE\n{name}\n" for name in ("LEFT", "RIGHT"))
    return text + cards + material() + "*BOUNDARY\nBORE, 1, 3\n" + (step or matrices_step())


GROUND = '[[joint]]\nground = "TOP"\nnormal = [1, 0, 0]\n'


def tip(text):
    """The deck with a set of the outer nodes between both sides, for a joint."""
    plain, _ = bar(size=(60.0, ANGLE, 10.0), cells=(3, 2, 1), origin=(40.0, 0.0, 0.0))
    members = [label for label in on(plain, 0, 100.0) if 1e-9 < plain[label][1] < ANGLE - 1e-9]
    return text.replace("*SURFACE", f"*NSET, NSET=TOP\n{rows(members)}\n*SURFACE", 1)


def cyclic_frequencies(path):
    """omega [rad/s] of a cyclic analysis by nodal diameter, each once: CalculiX gives waves of both directions."""
    found = {}
    for h, omega in re.findall(r"^ +(\d+) +\d+ +\S+ +(\S+) +\S+ +\S+ *$", path.with_suffix(".dat").read_text(), re.M):
        found.setdefault(int(h), []).append(float(omega))
    return {h: np.array(values[::2]) for h, values in found.items()}


def test_frequencies_are_those_of_the_cyclic_analysis_of_calculix(tmp_path):
    """The same deck, once for its matrices and once for CalculiX's own cyclic symmetry; it prints seven digits."""
    text = tip(deck(CARDS))
    path = run_ccx(tmp_path, "sector", text)
    select = f"*SELECT CYCLIC SYMMETRY MODES, NMIN=0, NMAX={N // 2}\n"
    own = tip(deck(CARDS + MODEL, f"*STEP\n*FREQUENCY, SOLVER=SPOOLES\n16\n{select}*END STEP\n"))
    theirs = cyclic_frequencies(run_ccx(tmp_path, "own", own))
    path.write_text(text.replace("*MATERIAL", MODEL + "*MATERIAL", 1))  # which tells the import number and axis
    structure = calculix.read([path])
    model = setup_file.apply(structure, written(tmp_path, GROUND))
    assert model.cyclic["sectors"] == N and f"*CYCLIC SYMMETRY MODEL ({path}, line" in "\n".join(model.notes)
    assert sorted(theirs) == list(range(N // 2 + 1))
    for h, wanted in theirs.items():
        assert len(wanted) == 8
        np.testing.assert_allclose(sector_frequencies(model, h, len(wanted), "open"), wanted, rtol=1e-6)


def test_matrices_with_the_constraint_are_refused(tmp_path):
    path = run_ccx(tmp_path, "sector", tip(deck(CARDS + MODEL)))
    with pytest.raises(ValueError, match=r"sector.sti: node \d+ of '(LEFT|SLEFT|SRIGHT)' is no unknown .* plain sector, without it"):
        calculix.read([path])


def test_what_the_deck_leaves_open_comes_from_the_set_up_file(tmp_path):
    path = run_ccx(tmp_path, "sector", tip(deck(CARDS)))
    structure = calculix.read([path])
    model = setup_file.apply(structure, written(tmp_path, GROUND))
    assert model.cyclic is None and "leaves open sectors, axis; [cyclic] in the set-up file" in "\n".join(model.notes)
    again = setup_file.apply(structure, written(tmp_path, f"[cyclic]\nsectors = {N}\naxis = [0, 0, -1]\n" + GROUND))
    assert again.cyclic["sectors"] == N and "nodes of SRIGHT and SLEFT" in "\n".join(again.notes)
    with pytest.raises(ValueError, match=r"\[cyclic\]: wanted sectors, left, right, axis, found in the set-up file and \*TIE"):
        setup_file.apply(structure, written(tmp_path, "[cyclic]\nsectors = 8\n" + GROUND))


def test_an_axis_that_is_nowhere_near_is_refused(tmp_path):
    path = run_ccx(tmp_path, "sector", tip(deck(CARDS)))
    path.write_text(path.read_text().replace("*MATERIAL", MODEL.replace("0, 0, -5", "1e300, 1e300, -5") + "*MATERIAL", 1))
    with pytest.raises(ValueError, match=r"\[cyclic\]: origin must be a point on the axis near the mesh"):
        setup_file.apply(calculix.read([path]), written(tmp_path, GROUND))


def test_an_import_writes_model_and_case(tmp_path):
    path = run_ccx(tmp_path, "sector", deck(step=matrices_step(), joint_faces=True))
    setup = written(tmp_path, f'units = "t, mm, s, N"\n[cyclic]\nsectors = {N}\nleft = "LEFT"\nright = "RIGHT"\naxis = [0, 0, 1]\n'
                    '[[joint]]\nbetween = ["OVER_RIGHT", "OVER_LEFT"]\nnext_sector = true\nnormal_stiffness = 1e3\n'
                    "tangential_stiffness = 1e3\nfriction = 0.3\n")
    said = convert("calculix", [str(path)], str(tmp_path / "model.h5"), str(setup))
    model = Model.read(tmp_path / "model.h5")
    assert model.cyclic["next_sector"].all() and f"{model.contact_points} contact points" in said
    case = (tmp_path / "case.toml").read_text()
    assert "engine_order = 1" in case and "nodal diameter 1:" in case
    named = float(re.search(r"#   1  (\S+) rad/s", case)[1])
    assert named == pytest.approx(sector_frequencies(model, 1, 1)[0], rel=1e-5)


@pytest.mark.parametrize("cards, words", [
    (MODEL + MODEL, "several sectors are not read"),
    (MODEL.replace("0, 0, 7", "0"), "wanted two points of the axis, six numbers, found 4"),
    (MODEL.replace("N=8, ", ""), "wanted the parameter N=..."),
    (MODEL.replace("N=8", "N=8.5"), "wanted a whole number, found '8.5'"),
    (CARDS + MODEL.replace("T1", "T2"), "there is no *TIE, CYCLIC SYMMETRY, NAME=T2"),
    (CARDS.replace("SRIGHT, ", ""), "wanted two surfaces"),
    (CARDS.replace("SRIGHT", "SRIHT"), "there is no surface 'SRIHT'"),
])
def test_wrong_cards_are_refused(tmp_path, cards, words):
    path = tmp_path / "job.inp"
    path.write_text(tip(deck(cards)))
    for kind in ("sti", "mas", "dof"):
        (tmp_path / f"job.{kind}").write_text("1\n")
    with pytest.raises(ValueError, match=r"job.inp, line \d+, \*(CYCLIC SYMMETRY MODEL|TIE): " + re.escape(words)):
        calculix.read([path])
