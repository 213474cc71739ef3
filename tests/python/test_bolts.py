"""Bolts: the static state while tightening, the same after locking, with and without friction; the textbook's bolt diagram."""

import re
from types import SimpleNamespace

import brick
import h5py
import numpy as np
import pytest
import scipy.sparse as sp

from dovetail import Joint, Model
from dovetail.bolts import Bolt, static_state, tightened
from dovetail.importers import setup_file
from launch import run

SETUP = """[[clamp]]
set = "bottom"
[[force]]
set = "top"
vector = [0, 1e-5, 0]
[[preload]]
set = "top"
vector = [2e-4, 0, 0]
[[spring]]
set = "top"
stiffness = [0.05, 0.05, 0]
[[bolt]]
between = ["head", "bottom half"]
force = 4e-3
name = "M1"
{rest}
[[joint]]
between = ["upper", "lower"]
normal_stiffness = 3.0
tangential_stiffness = [2.0, 1.0]
friction = 0.1
"""
CASE = """model = "model.h5"
reduction.modes = 3
damping.stiffness = 0.02
excitation.fourier = [0, 1]
harmonic_balance.harmonics = 1
continuation.omega = [0.2, 0.2]
"""


def structure():
    found = brick.pair(over=(4, 2, 2), under=(4, 2, 2), poisson=0.3)
    nodes, top = found.nodes, found.node_sets["top"]
    found.node_sets["head"] = top[nodes[top, 0] < 0.6]
    found.node_sets["bottom half"] = np.flatnonzero((abs(nodes[:, 2] + 0.5) < 1e-9) & (nodes[:, 0] < 0.6))
    return found


def applied(folder, rest):
    folder.mkdir(exist_ok=True)
    (folder / "joints.toml").write_text(SETUP.format(rest=rest))
    return setup_file.apply(structure(), folder / "joints.toml")


def preload_state(folder, model):
    """x_p (N_x, 3) and g (N_x, 3) of a run of the program."""
    model.write(folder / "model.h5")
    (folder / "case.toml").write_text(CASE)
    done = run(SimpleNamespace(path=folder / "case.toml"), out="out")
    with h5py.File(done.folder / "results.h5") as file:
        return file["preload/xp"][()].reshape(-1, 3), file["preload/g"][()].reshape(-1, 3)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """The model with the force kept, and its preload state."""
    folder = tmp_path_factory.mktemp("kept")
    model = applied(folder, "")
    return model, *preload_state(folder, model)


def test_a_force_that_stays_is_a_pair_of_preloads(kept):
    model, _, g = kept
    plain = structure().clamped("bottom").with_preload("top", [2e-4, 0, 0]).with_springs("top", [0.05, 0.05, 0])
    axis = plain.nodes[plain.node_sets["bottom half"]].mean(axis=0) - plain.nodes[plain.node_sets["head"]].mean(axis=0)
    axis *= 4e-3 / np.linalg.norm(axis)
    plain = plain.with_preload("head", axis).with_preload("bottom half", -axis)
    joint = Joint.between(plain.surface("upper"), plain.surface("lower"))
    np.testing.assert_allclose(model.preload, plain.join([joint]).preload, atol=1e-18)
    assert not model.forces and any(note == "bolt M1: force 0.004 N, which stays" for note in model.notes)
    assert not any("unit pull" in note for note in model.notes)
    assert (g[:, 2] > 0).any() and (g[:, 2] == 0).any()  # it presses here, and lifts there


def test_the_state_is_that_of_the_program(kept):
    """Points stick, slip and are open."""
    model, xp, g = kept
    u, ours = static_state(model, model.preload)
    slips = np.isclose(abs(g[:, :2]), 0.1 * g[:, 2:]) & (g[:, 2:] > 0)
    assert slips.any() and not slips[g[:, 2] > 0].all()
    np.testing.assert_allclose(ours, g, atol=1e-8 * abs(g).max())
    np.testing.assert_allclose(u[model.contact_dofs], xp, atol=1e-8 * abs(xp).max())


@pytest.mark.parametrize("stiffness", ["", "stiffness = 0.7"])
def test_locking_keeps_the_static_state_and_stiffens_what_follows(tmp_path, kept, stiffness):
    plain, xp, g = kept
    model = applied(tmp_path / "locked", f'then = "lock"\n{stiffness}')
    locked_xp, locked_g = preload_state(tmp_path / "locked", model)
    np.testing.assert_allclose(locked_g, g, atol=1e-7 * abs(g).max())
    np.testing.assert_allclose(locked_xp, xp, atol=1e-7 * abs(xp).max())
    change = (model.K - plain.K).toarray()
    values = np.linalg.eigvalsh(change)
    assert values[-1] > 0 and abs(values[:-1]).max() < 1e-12 * values[-1]  # along the pull, and nowhere else
    assert any(re.fullmatch(r"bolt \w+: tightened to 0.004 N, its ends approach by \S+ m; then locked by a stiffness of \S+ N/m", note)
               for note in model.notes), model.notes


def test_without_friction_the_sliders_begin_without_force(tmp_path, kept):
    """The normal forces are those of a joint without friction; then friction is there, and nothing has slipped."""
    plain, _, _ = kept
    bare = Model(plain.K, plain.M, plain.contact_dofs, plain.force, plain.preload, {**plain.contact, "friction": 0.0}, comm=plain.comm)
    (tmp_path / "bare").mkdir()
    bare_xp, bare_g = preload_state(tmp_path / "bare", bare)
    for rest in ("tighten_with_friction = false", 'tighten_with_friction = false\nthen = "lock"'):
        model = applied(tmp_path / "free", rest)
        xp, g = preload_state(tmp_path / "free", model)
        np.testing.assert_allclose(g[:, 2], bare_g[:, 2], atol=1e-7 * bare_g.max())
        assert abs(g[:, :2]).max() < 1e-9 * g.max() and abs(xp).max() < 1e-7 * abs(bare_xp).max()
        np.testing.assert_allclose(model.contact["friction"], 0.1)
        assert any("tightened without friction" in note for note in model.notes)


@pytest.mark.parametrize("rest", ['then = "lock"', "tighten_with_friction = false"])
def test_tightening_keeps_the_damping_of_the_structure(tmp_path, rest):
    (tmp_path / "joints.toml").write_text(SETUP.format(rest=rest))
    damped = structure()
    damped = damped.with_damping_matrix(0.1 * damped.M).with_structural_matrix(0.2 * damped.K)
    damped.damping = {"mass": 3.0}
    model = setup_file.apply(damped, tmp_path / "joints.toml")
    assert abs(model.C - 0.1 * model.M).max() < 1e-15 and model.K_structural is not None and model.damping == {"mass": 3.0}


def test_bolt_diagram_of_the_textbook():
    """Plates of stiffness k_c, a bolt of k_b tightened to F: of a pull S the bolt takes k_b / (k_b + k_c)."""
    k_c, k_b, force, pull = 5.0, 2.0, 10.0, 3.0
    K, M = sp.identity(3, format="csr") * 1e-12, sp.identity(3, format="csr")
    contact = {"normal_stiffness": k_c, "tangential_stiffness": 1.0, "friction": 0.3}
    model = Model(K, M, [[0, 1, 2]], preload=np.zeros(3), contact=contact)
    closing = np.array([0, 0, 1.0])
    locked, _ = tightened(model, [Bolt("one", closing, force, lock=True, stiffness=k_b)])
    _, at_rest = static_state(locked, locked.preload)
    np.testing.assert_allclose(at_rest[0, 2], force, rtol=1e-9)
    _, pulled = static_state(locked, locked.preload - pull * closing)
    np.testing.assert_allclose(pulled[0, 2], force - pull * k_c / (k_b + k_c), rtol=1e-9)
    kept, _ = tightened(model, [Bolt("one", closing, force)])
    np.testing.assert_allclose(static_state(kept, kept.preload - pull * closing)[1][0, 2], force - pull, rtol=1e-9)


@pytest.mark.parametrize("rest, message", [
    ('then = "hold"', r'\[\[bolt\]\] number 1: then must be "keep", which .* or "lock"'),
    ("stiffness = 3", r'\[\[bolt\]\] number 1: stiffness is that of a bolt with then = "lock"'),
    ('then = "lock"\nstiffness = -3', r"\[\[bolt\]\] number 1: stiffness must be a positive number, found -3"),
    ("axis = [0, 0, 0]", r"\[\[bolt\]\] number 1: axis must be three finite numbers, not all zero"),
    ("tighten_with_friction = 1", "tighten_with_friction must be true or false, found 1"),
    ("forc = 1", "did you mean 'force'")])
def test_wrong_bolts_are_refused(tmp_path, rest, message):
    with pytest.raises(ValueError, match=message):
        applied(tmp_path, rest)


def test_what_tightening_needs_is_said(tmp_path):
    text = SETUP.format(rest='then = "lock"').replace("friction = 0.1\n", "")
    (tmp_path / "joints.toml").write_text(text)
    with pytest.raises(ValueError, match=r"\[\[bolt\]\]: a bolt that is locked, .* needs friction of the joints here"):
        setup_file.apply(structure(), tmp_path / "joints.toml")
    model = structure()
    with pytest.raises(ValueError, match="same middle; give axis"):
        (tmp_path / "other.toml").write_text(SETUP.format(rest="").replace('["head", "bottom half"]', '["head", "head"]'))
        setup_file.apply(model, tmp_path / "other.toml")
    loose = SETUP.format(rest="tighten_with_friction = false").replace("[0.05, 0.05, 0]", "[0, 0, 1e-9]")
    (tmp_path / "joints.toml").write_text(loose)
    with pytest.raises(ValueError, match="cannot be tightened without friction: the loads push a part along the joint"):
        setup_file.apply(model, tmp_path / "joints.toml")
    (tmp_path / "joints.toml").write_text(loose.replace("[2e-4, 0, 0]", "[0, 0, 0]").replace('name = "M1"', "axis = [0, 0, -1]"))
    assert setup_file.apply(model, tmp_path / "joints.toml").preload.any()  # nothing pushes along
