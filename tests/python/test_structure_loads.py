"""Loads that Structure puts on its nodes: totals, phases, moments, pressure, base motion and weight."""

import re
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import scipy.sparse as sp

import brick
from dovetail import Joint, Model, Structure, loads, reference
from launch import run


def totals(structure, load):
    """Sum of the forces (3,) and of their moments about the origin (3,)."""
    moves = structure.dof_direction < 3
    forces = np.zeros((len(structure.nodes), 3))
    forces[structure.dof_node[moves], structure.dof_direction[moves]] = load[moves]
    return forces.sum(axis=0), np.cross(structure.nodes, forces).sum(axis=0)


def test_a_pattern_for_each_name():
    structure = brick.pair().with_force("top", [1, 2, 3]).with_force("bottom", [1, 0, 0], name="foot")
    structure = structure.with_force("top", [0, 1, 0], name="foot")
    np.testing.assert_allclose(totals(structure, structure.force)[0], [1, 2, 3])
    np.testing.assert_allclose(totals(structure, structure.forces["foot"])[0], [1, 1, 0], atol=1e-15)
    assert not brick.pair().forces and structure.clamped("bottom").forces["foot"].size < structure.n


def test_a_phase_makes_two_patterns():
    """cos(omega t - phase): the cosine of the phase with [0, 1], the sine with [0, 0, 1]."""
    structure = brick.pair().with_force("top", [0, 2, 0], name="shaker", phase=0.3)
    for name, part in (("shaker", np.cos(0.3)), ("shaker_sin", np.sin(0.3))):
        np.testing.assert_allclose(totals(structure, structure.forces[name])[0], [0, 2 * part, 0], atol=1e-15)
    assert structure.courses == {"shaker": [0, 1], "shaker_sin": [0, 0, 1]}
    by_hand = brick.pair().with_force("top", np.array([0, 2, 0]) * np.exp(-0.3j), name="shaker")
    for name in structure.forces:
        np.testing.assert_allclose(by_hand.forces[name], structure.forces[name], atol=1e-15)
    wave, nodes = brick.pair(), brick.pair().node_sets["top"][:2]
    for node, phase in zip(nodes, (0.3, 1.1)):  # nodes with phases of their own: two patterns in all
        wave = wave.with_force([node], [0, 2, 0], phase=phase)
    dofs = [np.flatnonzero((wave.dof_node == node) & (wave.dof_direction == 1))[0] for node in nodes]
    assert list(wave.courses) == ["force", "force_sin"]
    np.testing.assert_allclose(wave.force[dofs] - 1j * wave.forces["force_sin"][dofs], 2 * np.exp([-0.3j, -1.1j]), rtol=1e-14)
    turning = brick.pair().with_force("top", [1, -1j, 0])  # Re((1, -i) exp(i omega t)) = (cos, sin): it goes round
    np.testing.assert_allclose(totals(turning, turning.force)[0], [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(totals(turning, turning.forces["force_sin"])[0], [0, 1, 0], atol=1e-15)


def test_moments_are_totals_without_a_force():
    for moment in ([1.0, 0, 0], [0.2, -3, 0.7]):
        structure = brick.pair().with_moment("over", moment, name="turn")
        force, found = totals(structure, structure.forces["turn"])
        np.testing.assert_allclose(force, 0, atol=1e-14)
        np.testing.assert_allclose(found, moment, atol=1e-13)
    late = brick.pair().with_moment("over", [0, 0, 2], phase=np.pi / 2)
    np.testing.assert_allclose(totals(late, late.forces["force_sin"])[1], [0, 0, 2], atol=1e-13)
    line = np.flatnonzero((brick.pair().nodes[:, 1:] == 0).all(axis=1))
    with pytest.raises(ValueError, match="cannot make the moment.*lie on a line"):
        brick.pair().with_moment(line, [1, 0, 0])
    np.testing.assert_allclose(totals(*[(s := brick.pair().with_moment(line, [0, 0, 1])), s.force])[1], [0, 0, 1], atol=1e-14)


def test_pressure_pushes_against_the_outward_normal():
    structure = brick.pair().with_pressure("top", 3.0)
    force, moment = totals(structure, structure.forces["pressure"])
    np.testing.assert_allclose(force, [0, 0, -6], atol=1e-14)  # 3 Pa on 2 m^2
    np.testing.assert_allclose(moment, [-3, 6, 0], atol=1e-13)  # in the middle of 2 x 1
    assert structure.courses["pressure"] == [0, 1]
    series = brick.pair().with_pressure("top", 2.0, fourier=[1.0, 0, 0.5], name="p")
    np.testing.assert_allclose(totals(series, series.forces["p"])[0], [0, 0, -4], atol=1e-14)
    np.testing.assert_allclose(totals(series, series.preload)[0], [0, 0, -2], atol=1e-14)  # half the first coefficient
    assert series.courses["p"] == [0, 0, 0.5]


def test_pressure_with_a_series_at_each_node():
    """A wave over the surface: with its constant part, and patterns for the coefficients that are there."""
    x = brick.pair().surface("top").points[:, 0]
    each = np.column_stack([2 + 0 * x, np.cos(x), np.sin(x), 0 * x, 0.1 * x])
    structure = brick.pair().with_pressure("top", each, name="wave")
    assert structure.courses == {"wave_a1": [0, 1], "wave_b1": [0, 0, 1], "wave_b2": [0, 0, 0, 0, 1]}
    np.testing.assert_allclose(totals(structure, structure.preload)[0], [0, 0, -2], atol=1e-14)
    complex_wave = brick.pair().with_pressure("top", np.exp(-1j * x), name="wave")  # cos(omega t - x)
    for ours, theirs in (("wave", "wave_a1"), ("wave_sin", "wave_b1")):
        np.testing.assert_allclose(complex_wave.forces[ours], structure.forces[theirs], atol=1e-15)


def test_weight_and_base_motion_are_those_of_the_mass():
    structure = brick.pair(density=1.5).with_gravity([0, 0, -10]).with_base_acceleration([2, 0, 0])
    np.testing.assert_allclose(totals(structure, structure.preload)[0], [0, 0, -10 * 1.5 * 4], atol=1e-12)  # 4 m^3
    np.testing.assert_allclose(totals(structure, structure.forces["base"])[0], [-1.5 * 4, 0, 0], atol=1e-12)


def test_what_is_refused():
    held, K = brick.pair().clamped("bottom"), brick.pair().K.tolil()
    K[0, 0] += 1
    free = brick.pair()
    spring = Structure(K.tocsr(), free.M, free.nodes, free.dof_node, free.dof_direction)
    for make, words in (
            (lambda: held.with_base_acceleration([1, 0, 0]), "K r is .*call it before `clamped`"),
            (lambda: spring.with_base_acceleration([1, 0, 0]), "K r is .*springs to the ground"),
            (lambda: free.with_base_acceleration([0, 0, 0]), "direction must not be zero"),
            (lambda: free.with_base_acceleration([1j, 0, 0]), "direction must be real"),
            (lambda: free.with_force("top", [1, 2, np.nan]), "force must be a vector of three finite numbers"),
            (lambda: free.with_force("top", [1, 2, 3], phase=np.inf), "phase must be a finite number"),
            (lambda: free.with_force("top", [1, 2, 3], phase="late"), "phase must be a finite number .* found 'late'"),
            (lambda: free.with_force("top", [1, 2, 3], phase=[0, 1]), "phase must be a finite number .* a call each"),
            (lambda: free.with_pressure("top", 1.0, fourier=[]), "fourier must have a coefficient"),
            (lambda: free.with_force("top", [1, 2, 3], name="a/b"), "without a slash, found 'a/b'"),
            (lambda: free.with_preload("top", [1, 2j, 3]), "preload must be real"),
            (lambda: free.with_moment("top", [1, 2]), "moment must be a vector of three finite numbers"),
            (lambda: free.with_pressure("top", [1.0, 2]), "pressure must be finite numbers of shape"),
            (lambda: free.with_pressure("top", 1j, fourier=[0, 1]), "complex pressure"),
            (lambda: free.with_pressure("top", 1.0, name="p").with_force("top", [1, 0, 0], name="p", phase=1).with_pressure(
                "top", 1.0, fourier=[0, 0, 1], name="p"), "'p' has the course"),
            (lambda: Model(K, free.M, [[0, 1, 2]], forces={"force": np.ones(free.n)}), '"force" is the name of the pattern'),
            (lambda: Model(K, free.M, [[0, 1, 2]], forces={"lift": np.ones(3)}), "lift must have one entry")):
        with pytest.raises(ValueError, match=words):
            make()


def test_patterns_reach_the_model_file_and_come_back(tmp_path):
    structure = brick.pair().clamped("bottom").with_force("top", [0, 1, 0], name="shaker", phase=0.5).with_preload("top", [0, 0, -1])
    joint = Joint.between(structure.surface("upper"), structure.surface("lower"))
    model = structure.join(joint)
    model.write(tmp_path / "model.h5")
    with h5py.File(tmp_path / "model.h5") as file:
        assert set(file["forces"]) == {"shaker", "shaker_sin"} and "force" not in file
    again = Model.read(tmp_path / "model.h5")
    for name, load in model.forces.items():
        np.testing.assert_array_equal(again.forces[name], load)
    assert again.force is None
    text = model.excitation()
    assert re.findall(r'pattern = "(\w+)"\nfourier = \[([\d, ]+)\]', text) == [("shaker", "0, 1"), ("shaker_sin", "0, 0, 1")]
    both = structure.with_force("top", [1, 0, 0]).join(joint)
    assert both.force.any() and 'pattern = "force"' in both.excitation()


# A chain along x on a base that shakes: two masses, the first of which slides on the base.
K, XI = sp.csr_matrix([[7.0, -4, -3], [-4, 6, -2], [-3, -2, 5]]), 0.02
MASSES, KT, MU, PRESS, KN = np.array([1.0, 1.3, 0.7]), 6.0, 0.4, 2.0, 5.0
COURSE = [0, 1.5, 0.7, 0, 0.4]


def shaken_chain():
    """Nodes base, slider, tip with x, y, z each; y and z are held by springs between neighbours, too. The slider's z is pressed down."""
    k, m = sp.kron(K, sp.identity(3)), sp.kron(sp.diags(MASSES), sp.identity(3))
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    structure = Structure(k.tocsr(), m.tocsr(), nodes, np.repeat(np.arange(3), 3), np.tile([0, 1, 2], 3), node_sets={"base": [0]})
    return structure.with_base_acceleration([1, 0, 0]).clamped("base").with_preload([1], [0, 0, PRESS])


def test_relative_and_absolute_base_motion_are_one():
    """Solved relative to the base, and with the base's displacement u_b = -a / (k Omega)^2 in the equations of absolute ones.

    The slider's contact coordinates are relative to the base in both. It slips.
    """
    structure, omega, H = shaken_chain(), 1.1, 5
    dofs = np.array([[0, 1, 2]])  # t1 = x, t2 = y, n = z of the slider
    contact = reference.Contact.uniform(1, KN, KT, MU, 0.0)
    reduced = reference.craig_bampton(structure.K, structure.M, dofs, structure.forces["base"], structure.preload, 3)
    system = reference.HarmonicBalance(reduced, contact, reference.contact_preload(reduced, contact), XI, COURSE, H, 256)
    relative = system.solve(omega)
    x = reference.synthesis(system.contact_part(relative), 256)[0].T
    T = reference.law(x, system.preload.xp[0], system.preload.w[0], contact.kn[0], contact.kt[0], contact.mu[0], contact.gap[0])[1]
    assert 0.2 < np.mean(np.abs(T[:, 0]) == 1) < 0.95, "it slips for a part of the period"

    squares, phi, psi = reference.bases(structure.K, structure.M, dofs, 3)
    basis = np.block([[np.zeros((3, 3)), np.eye(3)], [phi, psi]])  # slider x y z, then tip x y z
    k, m = np.kron(K.toarray(), np.eye(3)), np.kron(np.diag(MASSES), np.eye(3))
    base = np.zeros((3, 2 * H + 1))  # displacement of the base along x
    for place, a in enumerate(COURSE):
        if place > 0:
            base[0, place] = -a / ((place + 1) // 2 * omega) ** 2
    with_base = np.vstack([base, base, 0 * base])  # the slider's coordinate is relative: u = x + u_b
    system.excitation = -basis.T @ dynamic_forces(k[3:], m[3:], with_base, omega)
    absolute = system.solve(omega)
    within = 1e-12 * np.abs(relative).max()
    np.testing.assert_allclose((basis @ absolute)[3:] - base, (basis @ relative)[3:], rtol=0, atol=within)  # the tip
    np.testing.assert_allclose(absolute[3:], relative[3:], rtol=0, atol=within)  # the slider


def dynamic_forces(k, m, motion, omega):
    """Forces (rows, 2H+1) of K u + xi K u' + M u''."""
    out = np.empty((len(k), motion.shape[1]))
    out[:, 0] = k @ motion[:, 0]
    for h in range(1, motion.shape[1] // 2 + 1):
        c, s, w = motion[:, 2 * h - 1], motion[:, 2 * h], h * omega
        out[:, 2 * h - 1] = k @ c - w * w * (m @ c) + w * XI * (k @ s)
        out[:, 2 * h] = k @ s - w * w * (m @ s) - w * XI * (k @ c)
    return out


CHAIN = f"""model = "{{name}}.h5"
reduction.modes = 3
damping.stiffness = {XI}
newton = {{{{ step_tolerance = 1e-13, residual_tolerance = 1e-13 }}}}
continuation.omega = [{{omega}}, {{omega}}]
harmonic_balance = {{{{ harmonics = 5, solver = "{{solver}}" }}}}
contact = {{{{ normal_stiffness = {KN}, tangential_stiffness = {KT}, friction = {MU}, gap = 0.0 }}}}
"""


@pytest.mark.parametrize("solver", ["modal", "assembled"])
def test_the_program_finds_relative_and_absolute_base_motion_alike(tmp_path, solver):
    """Absolute motion by a pattern for each coefficient of what the moving base does at this frequency."""
    structure, omega = shaken_chain(), 1.1
    k, m, base = np.kron(K.toarray(), np.eye(3)), np.kron(np.diag(MASSES), np.eye(3)), np.zeros((3, len(COURSE)))
    base[0, 1:] = -np.array(COURSE[1:]) / (np.array([1, 1, 2, 2])[:len(COURSE) - 1] * omega) ** 2
    absolute = -dynamic_forces(k[3:], m[3:], np.vstack([base, base, 0 * base]), omega)  # the slider's coordinate is relative
    patterns = {f"c{place}": absolute[:, place] for place in range(1, len(COURSE))}
    found = {}
    for name, forces, courses in (("relative", {"base": structure.forces["base"]}, {"base": COURSE}),
                                  ("absolute", patterns, {name: [0] * int(name[1:]) + [1] for name in patterns})):
        Model(structure.K, structure.M, [[0, 1, 2]], preload=structure.preload, forces=forces).write(tmp_path / f"{name}.h5")
        path = tmp_path / f"{name}.toml"
        path.write_text(CHAIN.format(name=name, solver=solver, omega=omega) + loads.excitation(courses))
        found[name] = run(SimpleNamespace(path=path), out=name).points
    slider = [found[name]["coefficients"][0][-3:] for name in ("relative", "absolute")]
    assert 0.2 < found["relative"]["slip"][0] == found["absolute"]["slip"][0]
    np.testing.assert_allclose(*slider, rtol=0, atol=1e-12 * np.abs(slider[0]).max())
