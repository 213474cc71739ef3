"""The set-up file of an import: what it does, and what is said about wrong ones."""

import importer_jobs
import numpy as np
import pytest
import scipy.sparse as sp

from dovetail import Joint, Structure
from dovetail.__main__ import main
from dovetail.importers import convert, setup_file
from dovetail.material import Material

SIDE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)


def two_cubes():
    """Unit cubes, the second on the first, in a chain of springs that holds neither; sets by height, and one surface."""
    nodes = np.concatenate([SIDE + [0, 0, z] for z in (0, 1, 1, 2)])
    n = 3 * len(nodes)
    K = sp.diags([np.full(n, 2.0), np.full(n - 3, -1.0), np.full(n - 3, -1.0)], [0, 3, -3], format="csr")
    sets = {"Foot": np.arange(4), "Under": np.arange(4, 8), "OVER": np.arange(8, 12), "top": np.arange(12, 16), "corner": np.array([8])}
    return Structure(K, sp.identity(n, format="csr"), nodes, np.repeat(np.arange(len(nodes)), 3), np.tile(np.arange(3), len(nodes)),
                     cells={"hexahedron": np.arange(16).reshape(2, 8)}, node_sets=sets,
                     surfaces={"lid": [np.array([[4, 5, 6, 7]])]})


def written(folder, text):
    path = folder / "joints.toml"
    path.write_text(text)
    return path


FULL = """units = "mm, t, s"
[[clamp]]
set = "FOOT"
[[clamp]]
set = "top"
directions = "xy"
[[force]]
set = "top"
vector = [0, 0, 8]
[[preload]]
set = "corner"
vector = [0, 1, 2.5]
[[joint]]
between = ["over", "LID"]
normal_stiffness = 1e3
tangential_stiffness = [4.0, 8.0]
friction = 0.3
gap = 1e-6
t1 = [0, 1, 0]
name = "middle"
"""


def test_the_same_model_as_by_hand(tmp_path):
    ours = setup_file.apply(two_cubes(), written(tmp_path, FULL))
    structure = two_cubes().clamped("Foot").clamped("top", "xy").with_force("top", [0, 0, 8]).with_preload("corner", [0, 1, 2.5])
    joint = Joint.between(structure.surface("OVER"), structure.surface("lid"), normal_stiffness=1e3, tangential_stiffness=[4.0, 8.0],
                          friction=0.3, gap=1e-6, t1=[0, 1, 0])
    theirs = structure.join([joint])
    assert abs(ours.K - theirs.K).max() == 0 and abs(ours.M - theirs.M).max() == 0
    np.testing.assert_array_equal(ours.contact_dofs, theirs.contact_dofs)
    for name in ("force", "preload"):
        np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))
    np.testing.assert_allclose(ours.contact["tangential_stiffness"], np.tile([1.0, 2.0], (4, 1)))  # a quarter of 1 m^2 each
    assert ours.units == "mm, t, s" and ours.force.sum() == 8
    assert ours.notes[:2] == ["load pattern force: total (0, 0, 8) on 4 nodes, moment about the origin (4, -4, 0)",
                              "preload: total (0, 1, 2.5) on 1 node, moment about the origin (-1, 0, 0)"]
    assert len(ours.notes) == 4 and "joint middle: 4 contact points" in ours.notes[3]


def test_what_was_read_is_said_when_an_entry_is_refused(tmp_path):
    """Totals of the loads and the joints before the wrong one."""
    path = written(tmp_path, FULL + '[[joint]]\nbetween = ["over", "LAD"]\n')
    with pytest.raises(ValueError, match="number 2: there is no set 'LAD'") as caught:
        setup_file.apply(two_cubes(), path)
    assert "total (0, 0, 8)" in caught.value.notes[0] and "joint middle" in caught.value.notes[3]


def test_the_command_prints_the_notes_of_an_import_that_fails(tmp_path, capsys):
    (tmp_path / "scratch").mkdir()
    importer_jobs.lay_out(importer_jobs.jobs(tmp_path / "scratch")["calculix"], tmp_path)
    path = written(tmp_path, '[[preload]]\nset = "TIP"\nvector = [0, 2, 0]\n[[joint]]\nground = "NOWHERE"\n')
    assert main(["import", "calculix", str(tmp_path / "job.inp"), "--setup", str(path), "-o", str(tmp_path / "m.h5")]) == 2
    out, err = capsys.readouterr()
    assert "m.h5: not written" in out and "4 nodes, 1 tetra cells" in out and "preload: total (0, 2, 0) on 1 node" in out
    assert "there is no set 'NOWHERE'" in err and not (tmp_path / "m.h5").exists()


def loose_cubes():
    """The same without the springs to the ground at both ends of the chain."""
    held = two_cubes()
    held.K = held.K - sp.diags(np.asarray(held.K.sum(axis=1)).ravel())
    return held


LOADS = """
[[base]]
direction = [0, 0, 1]
[[clamp]]
set = "FOOT"
[[gravity]]
vector = [0, 0, -10]
[[force]]
set = "TOP"
vector = [1, 0, 0]
pattern = "shaker"
phase = 0.5
[[moment]]
set = "top"
vector = [0, 0, 2]
pattern = "twist"
[[pressure]]
set = "LID"
value = 3
fourier = [1, 0, 1]
[[joint]]
between = ["over", "LID"]
"""


def test_loads_as_by_hand(tmp_path):
    """Base motion and weight come first, wherever they stand: they are those of the whole structure."""
    ours = setup_file.apply(loose_cubes(), written(tmp_path, LOADS))
    structure = loose_cubes().with_base_acceleration([0, 0, 1]).with_gravity([0, 0, -10]).clamped("Foot")
    structure = structure.with_force("top", [1, 0, 0], name="shaker", phase=0.5).with_moment("top", [0, 0, 2], name="twist")
    structure = structure.with_pressure("lid", 3, fourier=[1, 0, 1])
    theirs = structure.join([Joint.between(structure.surface("OVER"), structure.surface("lid"))])
    assert ours.force is None and set(ours.forces) == {"base", "shaker", "shaker_sin", "twist", "pressure"}
    for name, load in theirs.forces.items():
        assert load.any()
        np.testing.assert_array_equal(ours.forces[name], load)
    np.testing.assert_array_equal(ours.preload, theirs.preload)
    assert 'pattern = "shaker_sin"\nfourier = [0, 0, 1]' in ours.notes[-1]


@pytest.mark.parametrize("old, new, message", [
    ("phase = 0.5", 'phase = "late"', r"\[\[force\]\] number 1: phase must be a finite number \[rad\], found 'late'"),
    ("value = 3", "value = [1]", r"\[\[pressure\]\] number 1: value must be a finite number, found \[1\]"),
    ("fourier = [1, 0, 1]", "fourier = 3", r"\[\[pressure\]\] number 1: fourier must be a list of finite numbers"),
    ('pattern = "twist"', "pattern = 3", r"\[\[moment\]\] number 1: pattern must be the name of a load pattern, found 3"),
    ("direction = [0, 0, 1]", "direction = [0, 1]", r"\[\[base\]\] number 1: direction must be three finite numbers"),
    ("phase", "phas", r"\[\[force\]\] number 1: unknown key 'phas'; did you mean 'phase'?"),
])
def test_wrong_loads_are_refused(tmp_path, old, new, message):
    path = written(tmp_path, LOADS.replace(old, new))
    with pytest.raises(ValueError, match=message):
        setup_file.apply(loose_cubes(), path)


def test_base_that_does_not_hold_alone(tmp_path):
    with pytest.raises(ValueError, match=r"\[\[base\]\] number 1: .*K r is 1 where"):
        setup_file.apply(two_cubes(), written(tmp_path, LOADS))


def test_ground_and_chosen_points(tmp_path):
    text = '[[joint]]\nground = "Foot"\nnormal_stiffness = 2.0\n'
    text += '[[joint]]\nbetween = ["OVER", "Under"]\nat = "corner"\nnormal_stiffness = 2.0\n'
    model = setup_file.apply(two_cubes(), written(tmp_path, text))
    assert model.contact_dofs.shape == (5, 3)
    np.testing.assert_allclose(model.contact["normal_stiffness"], [0.5] * 4 + [2.0])  # the last point carries the whole face
    assert model.units == "SI"


@pytest.mark.parametrize("old, new, message", [
    ("[[force]]", "[[forces]]", "joints.toml: unknown key 'forces'; did you mean 'force'?"),
    ("friction", "frction", r"joints.toml, \[\[joint\]\] number 1: unknown key 'frction'; did you mean 'friction'?"),
    ("directions", "direction", r"\[\[clamp\]\] number 2: unknown key 'direction'; did you mean 'directions'?"),
    ("[[joint]]", "[joint]", r"wanted \[\[joint\]\] in double brackets"),
    ('"FOOT"', '"FOOD"', r"joints.toml, \[\[clamp\]\] number 1: there is no set 'FOOD'; did you mean 'Foot'"),
    ('["over", "LID"]', '["over", "LAD"]', r"\[\[joint\]\] number 1: there is no set 'LAD'"),
    ('["over", "LID"]', '"over"', r"between must be two names, .*found 'over'"),
    ('between = ["over", "LID"]', "", "wanted either between .* or ground .*, found neither"),
    ('name = "middle"', 'ground = "over"', "wanted either between .* or ground .*, found between and ground"),
    ("[0, 0, 8]", "[0, 8]", r"\[\[force\]\] number 1: vector must be three finite numbers, found \[0, 8\]"),
    ("[0, 1, 2.5]", "[0, 1, nan]", r"\[\[preload\]\] number 1: vector must be three finite numbers"),
    ("[0, 0, 8]", "[0, 0, true]", r"\[\[force\]\] number 1: vector must be three finite numbers"),
    ('set = "FOOT"', "set = 3", r"\[\[clamp\]\] number 1: set must be the name of a set, found 3"),
    ('"xy"', "3", r"\[\[clamp\]\] number 2: directions must be text"),
    ('"xy"', '"xq"', r"\[\[clamp\]\] number 2: directions must be some of x, y, z"),
    ("friction = 0.3", "friction = -1", r"\[\[joint\]\] number 1: .*friction"),
    ("friction = 0.3", 'friction = "rough"', r"\[\[joint\]\] number 1: friction must be a number or a list of numbers, found 'rough'"),
    ("friction = 0.3", "friction = nan", r"\[\[joint\]\] number 1: friction must be a number or a list of numbers, found nan"),
    ('name = "middle"', "name = 3", r"\[\[joint\]\] number 1: name must be text, found 3"),
    ("units = \"mm, t, s\"", "units = 1", "units must be text"),
    ("gap = 1e-6", "gap = ", "joints.toml: .*line 18"),
])
def test_wrong_files_are_refused_by_entry_and_key(tmp_path, old, new, message):
    assert old in FULL
    path = written(tmp_path, FULL.replace(old, new))
    with pytest.raises(ValueError, match=message):
        setup_file.apply(two_cubes(), path)


@pytest.mark.parametrize("text", ["x = " + "[" * 5000 + "]" * 5000, ".".join("a" * 3000) + " = 1", "x = " + "[" * 40 + "]" * 40],
                         ids=["brackets", "dotted", "few"])
def test_files_deeper_than_the_stack_are_refused(tmp_path, text):
    with pytest.raises(ValueError, match="joints.toml: more than 32 brackets within brackets"):
        setup_file.apply(two_cubes(), written(tmp_path, text + "\n" + FULL))


def test_a_joint_with_the_ground_has_no_tolerance(tmp_path):
    with pytest.raises(ValueError, match=r"\[\[joint\]\] number 1: tolerance has no meaning"):
        setup_file.apply(two_cubes(), written(tmp_path, '[[joint]]\nground = "Foot"\ntolerance = 1e-6\n'))


def test_without_a_joint_there_is_no_model(tmp_path):
    with pytest.raises(ValueError, match=r"wanted at least one \[\[joint\]\], found clamp"):
        setup_file.apply(two_cubes(), written(tmp_path, '[[clamp]]\nset = "Foot"\n'))


def test_files_that_know_their_contact_points_take_no_written(tmp_path):
    with pytest.raises(ValueError, match="joints.toml: csv files hold their contact points themselves"):
        convert("csv", ["x.csv"], tmp_path / "m.h5", setup=tmp_path / "joints.toml")


def test_materials_of_the_set_up_file(tmp_path):
    """Of all cells, and of those of a set; the model has them."""
    ground = '[[joint]]\nground = "Foot"\n'
    model = setup_file.apply(two_cubes(), written(tmp_path, '[[material]]\nyoung = 2.1e5\npoisson = 0.3\n' + ground))
    assert model.mesh["materials"] == [Material(2.1e5, 0.3)] and model.mesh["material"]["hexahedron"].tolist() == [0, 0]
    for text, words in (("young = 1.0", "poisson must be a finite number, found None"),
                        ("young = 0.0\npoisson = 0.3", "must have a positive Young's modulus"),
                        ('young = 1.0\npoisson = 0.3\nset = "top"', "there is no cell with all of its nodes among those of 'top'")):
        with pytest.raises(ValueError, match=rf"\[\[material\]\] number 1: .*{words}"):
            setup_file.apply(two_cubes(), written(tmp_path, f"[[material]]\n{text}\n{ground}"))
