"""Joints: rigid motion, patch tests, energy, parameters, gaps, refusals; distributed matrices against SciPy ones."""

import re
import subprocess
import sys

import brick
import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import splu, spsolve

from dovetail import Joint, Surface
from launch import SECONDS, SURROUNDINGS

TURNED = brick.turned((1, 2, 3), 0.7, (0.3, -2, 5))


def joined(structure, **options):
    joint = Joint.between(structure.surface("upper"), structure.surface("lower"), **options)
    return joint, structure.join(joint)


def transformation(model):
    """T of u = T q, (n, n), from what the model file says of the changed dofs."""
    changed = model.mesh["changed"]
    T = sp.identity(model.n, format="lil")
    for i, dof in enumerate(changed["dof"]):
        entries = slice(changed["begin"][i], changed["begin"][i + 1])
        T[dof, dof] = 0.0
        T[dof, changed["column"][entries]] = changed["value"][entries]
    return T.tocsc()


def unknowns(model, displacement):
    """q of displacements u (..., n)."""
    return splu(transformation(model)).solve(np.ascontiguousarray(displacement.T)).T


def bent(points):
    """A block as a piece of a tube about the y axis; contact on the radius 3."""
    x, y, z = points.T
    return np.stack([(3 + z) * np.sin(x / 3), y, (3 + z) * np.cos(x / 3)], axis=1)


@pytest.mark.parametrize("over", [(2, 2, 2), (3, 4, 1)], ids=["matching", "not matching"])
@pytest.mark.parametrize("mapping", [lambda points: points, TURNED], ids=["straight", "turned"])
def test_rigid_motion_makes_no_relative_displacement(over, mapping):
    structure = brick.pair(over=over, mapping=mapping, poisson=0.3)
    joint, model = joined(structure)
    assert joint.kind == ("pairs" if over == (2, 2, 2) else "faces")
    for motion in brick.rigid_motions(structure.nodes):
        q = unknowns(model, motion.ravel())
        np.testing.assert_allclose(q[model.contact_dofs], 0, atol=1e-13 * np.abs(motion).max())
        np.testing.assert_allclose(model.K @ q, 0, atol=1e-12 * np.abs(motion).max())  # no force in the structure either


def test_rigid_motion_of_a_bent_matching_pair():
    structure = brick.pair(mapping=bent)
    joint, model = joined(structure)
    assert joint.kind == "pairs"
    motions = brick.rigid_motions(structure.nodes).reshape(6, -1)
    np.testing.assert_allclose(unknowns(model, motions)[:, model.contact_dofs], 0, atol=1e-12)


@pytest.mark.parametrize("over", [(2, 2, 2), (3, 4, 1)], ids=["matching", "not matching"])
def test_energies_and_relative_displacements(over):
    structure = brick.pair(over=over, mapping=TURNED, poisson=0.3).with_force("top", [1.0, 2, 3]).with_preload("over", [0, 1, 0])
    joint, model = joined(structure)
    rng = np.random.default_rng(1)
    T = transformation(model)
    for q in rng.standard_normal((3, model.n)):
        u = T @ q
        for changed, plain in ((model.K, structure.K), (model.M, structure.M)):
            assert q @ (changed @ q) == pytest.approx(u @ (plain @ u), rel=1e-12)
        assert q @ model.force == pytest.approx(u @ structure.force, rel=1e-12)
        assert q @ model.preload == pytest.approx(u @ structure.preload, rel=1e-12)
        on_b = np.zeros((len(joint), 3))
        np.add.at(on_b, joint.point, joint.weight[:, None] * u[joint.other])
        t1, t2, n = ((u[joint.dofs] - on_b)[:, None] @ joint.axes.transpose(0, 2, 1))[:, 0].T
        np.testing.assert_allclose(q[model.contact_dofs], np.stack([t1, t2, n], axis=1), atol=1e-13)
    if joint.kind == "pairs":
        q = unknowns(model, u)
        np.testing.assert_allclose(q[joint.other], u[joint.dofs] + u[joint.other], atol=1e-13)  # s, at the place of b
        assert not np.isin(joint.other, model.contact_dofs).any()


def squeezed(over, under, pressure=3.0, per_area=7.0, young=20.0, poisson=0.3):
    """Both blocks under uniform pressure, the joint as linear springs: stress-free sides, the bottom held without hindrance."""
    structure = brick.pair(over=over, under=under, young=young, poisson=poisson)
    corner = np.flatnonzero(np.linalg.norm(structure.nodes - [0, 0, -1], axis=1) < 1e-9)
    edge = np.flatnonzero(np.linalg.norm(structure.nodes - [2, 0, -1], axis=1) < 1e-9)
    structure = structure.clamped("bottom", "z").clamped(corner, "xy").clamped(edge, "y")
    joint, model = joined(structure, normal_stiffness=per_area, tangential_stiffness=2 * per_area, friction=0.1)
    load = np.zeros(structure.n)
    top = structure.surface("top")
    load[top.dofs[:, 2]] = -pressure * top.areas()
    T = transformation(model)
    springs = np.zeros(model.n)
    springs[model.contact_dofs[:, :2]] = model.contact["tangential_stiffness"]
    springs[model.contact_dofs[:, 2]] = model.contact["normal_stiffness"]
    q = spsolve((model.K + sp.diags(springs)).tocsc(), T.T @ load)
    exact = pressure * (2 / young + 1 / per_area)  # both blocks and the joint in series
    return q[model.contact_dofs], -(T @ q)[top.dofs[:, 2]], exact, pressure / per_area, joint


def test_patch_test_of_matching_blocks():
    contact, sinking, exact, closing, joint = squeezed((3, 2, 2), (3, 2, 1))
    assert joint.kind == "pairs"
    np.testing.assert_allclose(contact, np.tile([0, 0, closing], (len(contact), 1)), atol=1e-12)
    np.testing.assert_allclose(sinking, exact, rtol=1e-12)


def test_patch_test_of_nested_blocks():
    """A finer side a: its equal pressure is passed on exactly, because the shape functions of b are bilinear on its faces."""
    contact, sinking, exact, closing, joint = squeezed((4, 4, 2), (2, 2, 1))
    assert joint.kind == "faces"
    np.testing.assert_allclose(contact, np.tile([0, 0, closing], (len(contact), 1)), atol=1e-12)
    np.testing.assert_allclose(sinking, exact, rtol=1e-12)


def test_patch_test_of_blocks_that_do_not_match():
    """Point forces on faces are not quite a uniform pressure. Mean sinking and total force stay close, single points less so,
    and refinement helps; the total force is exact, being equilibrium."""
    errors = []
    for factor in (1, 2):
        contact, sinking, exact, closing, joint = squeezed((5 * factor, 3 * factor, 2), (3 * factor, 2 * factor, 2))
        assert joint.kind == "faces"
        np.testing.assert_allclose(joint.contact["normal_stiffness"] @ contact[:, 2], 3.0 * 2, rtol=1e-12)
        errors.append((abs(sinking.mean() / exact - 1), np.abs(contact[:, 2] / closing - 1).max()))
    assert errors[0][0] < 3e-3 and errors[0][1] < 0.05, errors
    assert errors[1][0] < errors[0][0] / 2, errors


def test_stiffness_is_shared_by_area():
    structure = brick.pair(over=(3, 2, 1), under=(3, 2, 1))
    joint, model = joined(structure, normal_stiffness=10.0, tangential_stiffness=[4.0, 6.0], friction=[0.1, 0.2], gap=1e-3)
    assert joint.area.sum() == pytest.approx(2, rel=1e-14)
    assert model.contact["normal_stiffness"].sum() == pytest.approx(20, rel=1e-14)
    np.testing.assert_allclose(model.contact["tangential_stiffness"].sum(axis=0), [8, 12], rtol=1e-14)
    np.testing.assert_array_equal(model.contact["friction"], np.tile([0.1, 0.2], (12, 1)))
    np.testing.assert_array_equal(model.contact["gap"], 1e-3)
    corner = np.flatnonzero(np.all(joint.position == 0, axis=1))
    assert joint.area[corner] == pytest.approx(2 / 6 / 4, rel=1e-14)
    np.testing.assert_array_equal(model.joint["position"], joint.position)
    changed = joint.with_parameters(normal_stiffness=np.arange(1.0, 13.0), friction=0.5)
    np.testing.assert_array_equal(changed.contact["normal_stiffness"], np.arange(1, 13))
    np.testing.assert_array_equal(changed.contact["friction"], np.full((12, 2), 0.5))
    np.testing.assert_array_equal(changed.contact["gap"], 1e-3)


def test_chosen_points_take_the_area_of_the_rest():
    places = [(0, 0, 0.01), (2, 0, 0), (0, 1, 0), (2, 1, 0)]
    joint, _ = joined(brick.pair(over=(4, 2, 1), under=(4, 2, 1)), normal_stiffness=1.0, at=places)
    np.testing.assert_allclose(joint.position, np.array(places) * [1, 1, 0])
    np.testing.assert_allclose(joint.area, 0.5, rtol=1e-14)  # nodes halfway between are shared
    np.testing.assert_allclose(joint.contact["normal_stiffness"], 0.5, rtol=1e-14)
    one, _ = joined(brick.pair(), at=[(0.4, 0, 0)])
    np.testing.assert_allclose(one.area, 2, rtol=1e-14)


def test_axes_of_a_bent_surface():
    """On a tube about y: normals inwards or outwards along the radius, t1 along the axis, t2 around."""
    structure = brick.pair(over=(8, 2, 1), under=(8, 2, 1), mapping=bent)
    joint, _ = joined(structure, t1=[0, 1, 0])
    radial = joint.position * [1, 0, 1] / 3
    inner = np.abs(np.arctan2(joint.position[:, 0], joint.position[:, 2]) - 1 / 3) < 0.3  # at the ends a flat face has no neighbour
    np.testing.assert_allclose(joint.axes[inner, 2], -radial[inner], atol=1e-12)
    np.testing.assert_allclose(joint.axes[inner, 0], np.tile([0, 1, 0], (inner.sum(), 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(joint.axes), 1, rtol=1e-12)
    np.testing.assert_allclose(joint.axes[:, 1], np.cross(joint.axes[:, 2], joint.axes[:, 0]), atol=1e-12)
    default, _ = joined(structure)
    np.testing.assert_allclose(default.axes[inner], joint.axes[inner], atol=1e-12)  # y is the axis least aligned


def test_gap_of_a_pair_within_the_tolerance():
    joint, _ = joined(brick.pair(gap=0.01), gap="geometry", tolerance=0.02)
    assert joint.kind == "pairs" and joint.contact["gap"] == pytest.approx(0.01, rel=1e-12)
    assert "at most 0.01 m between partners" in joint.report()


def test_ground():
    structure = brick.pair()
    joint = Joint.ground(structure.surface("bottom"), normal_stiffness=2.0, t1=[1, 1, 0])
    model = structure.join([joint])
    np.testing.assert_allclose(joint.axes[0], [[0.5**0.5, 0.5**0.5, 0], [0.5**0.5, -0.5**0.5, 0], [0, 0, -1]], atol=1e-15)
    u = np.random.default_rng(0).standard_normal(structure.n)
    q = unknowns(model, u)
    np.testing.assert_allclose(q[model.contact_dofs], np.einsum("mij,mj->mi", joint.axes, u[joint.dofs]), atol=1e-14)


@pytest.mark.parametrize("fixed, sign", [("under", 1), ("over", -1)])
def test_a_clamped_side_is_the_ground(fixed, sign):
    structure = brick.pair().clamped(fixed)
    joint, model = joined(structure)
    u = np.random.default_rng(0).standard_normal(structure.n)
    moving = structure.surface("upper" if fixed == "under" else "lower")
    wanted = sign * np.einsum("mij,mj->mi", joint.axes, u[moving.dofs])  # u_a - u_b
    np.testing.assert_allclose(unknowns(model, u)[model.contact_dofs], wanted, atol=1e-14)


def test_several_joints_are_stacked():
    structure = brick.pair()
    first = Joint.between(structure.surface("upper"), structure.surface("lower"), friction=0.1, name="middle")
    second = Joint.ground(structure.surface("bottom"), friction=0.2)
    model = structure.join([first, second])
    np.testing.assert_array_equal(model.contact_dofs, np.vstack([first.contact_dofs, second.contact_dofs]))
    np.testing.assert_array_equal(model.joint["joint"], np.repeat([0, 1], 9))
    assert model.joint["names"] == ["middle", "bottom - ground"]
    np.testing.assert_array_equal(model.contact["friction"][:, 0], np.repeat([0.1, 0.2], 9))
    motions = brick.rigid_motions(structure.nodes).reshape(6, -1)
    np.testing.assert_allclose(unknowns(model, motions)[:, first.contact_dofs], 0, atol=1e-13)


def test_a_joint_may_stand_on_the_points_of_another():
    """Three storeys of surfaces: points of the first on faces whose nodes are contact points of the second."""
    structure = brick.pair(over=(3, 4, 1))
    first = Joint.between(structure.surface("upper"), structure.surface("lower"))
    second = Joint.ground(structure.surface("lower"))
    model = structure.join([first, second])
    u = np.random.default_rng(2).standard_normal(structure.n)
    q = unknowns(model, u)
    np.testing.assert_allclose(q[second.contact_dofs], np.einsum("mij,mj->mi", second.axes, u[second.dofs]), atol=1e-13)
    on_b = np.zeros((len(first), 3))
    np.add.at(on_b, first.point, first.weight[:, None] * u[first.other])
    np.testing.assert_allclose(q[first.contact_dofs], np.einsum("mij,mj->mi", first.axes, u[first.dofs] - on_b), atol=1e-13)


def test_report():
    joint, _ = joined(brick.pair(), normal_stiffness=8.0, friction=0.3)
    text = joint.report()
    assert "joint upper - lower: 9 contact points, pairs of matching nodes" in text
    assert "area       2 m^2" in text and "k_n        1 to 4 N/m per point" in text and "within 0 degrees of (0, 0, -1)" in text
    other = joint.report("t, mm, s, N")
    assert "area       2 mm^2\n" in other and "k_n        1 to 4 N/mm per point" in other and "distance   0 mm along the normal" in other
    plain = joint.report("none")
    assert "area       2\n" in plain and "k_n        1 to 4 per point" in plain and "distance   0 along the normal" in plain


def surfaces(**changes):
    structure = brick.pair(**changes)
    return structure.surface("upper"), structure.surface("lower")


@pytest.mark.parametrize("make, message", [
    (lambda: Joint.between(*surfaces(), normal_stiffness=-1), "normal_stiffness must be positive, found -1"),
    (lambda: Joint.between(*surfaces(), normal_stiffness=[1, 2]), "normal_stiffness must be a number, found"),
    (lambda: Joint.between(*surfaces(), tangential_stiffness=[1, 2, 3]), r"must be a number or \[t1, t2\]"),
    (lambda: Joint.between(*surfaces(), friction=-0.1), "friction must not be negative, found -0.1"),
    (lambda: Joint.between(*surfaces(), gap="none"), "gap must be a number, one per point, or \"geometry\", found 'none'"),
    (lambda: Joint.between(*surfaces(), gap=[1, 2]), r"one per contact point \(9\), found shape \(2,\)"),
    (lambda: Joint.between(*surfaces(), t1=[0, 0, 1]), "t1 is parallel to the normal at"),
    (lambda: Joint.between(*surfaces(), t1=[0, 0]), "t1 must be a vector of three numbers"),
    (lambda: Joint.between(*surfaces(), normal=[0, 0, 1]), "normal given does not point out of 'upper'"),
    (lambda: Joint.between(*surfaces(), at=[[0, 0, 0], [0, 0.1, 0]]), "2 places of `at` are nearest to the same node"),
    (lambda: Joint.between(*surfaces(), at=[0, 0, 0]), r"`at` must be places of shape \(k, 3\)"),
    (lambda: Joint.between(*surfaces(), tolerance=-1), "tolerance must not be negative"),
    (lambda: Joint.between(*surfaces(over=(4, 2, 1)), tolerance=0.6), "is the partner of 2 contact points; make the tolerance"),
    (lambda: Joint.ground(surfaces()[0], gap="geometry"), "the ground has no geometry"),
    (lambda: Joint.between(surfaces()[0], surfaces()[0]), "do not face each other at node .* 0 degrees"),
    (lambda: Joint.between(surfaces()[0], brick.pair(mapping=brick.turned((0, 0, 1), 0, (0.2, 0, 0))).surface("lower")),
     r"node 0 of 'upper' at \(0, 0, 0\) lies 0.2 beyond the faces of 'lower'"),
    (lambda: Joint.between(Surface([[0, 0, 0]], [[0, 1, 2]]), surfaces()[1]), "has no faces, so its nodes have no normal"),
    (lambda: Joint.ground(Surface([[0, 0, 0]], [[0, 1, 2]]), normal=[0, 0, 1], normal_stiffness=1), "per area, and 1 of 1 contact points"),
    (lambda: Joint.between(surfaces(over=(3, 3, 1))[0], Surface([[0, 0, 0]], [[0, 1, 2]], name="dot")),
     "not every contact point has a partner among the nodes of 'dot', which has no faces"),
    (lambda: Surface([[0, 0, 0]], [[0, 1, 2]], [[[0, 0, 1]]]), "faces of points 0 to 0, found 0 to 1"),
    (lambda: Surface([[0, 0, 0]], [[0, 1, 2]], [np.zeros((1, 5), int)]), "k = 3, 4, 6 or 8"),
])
def test_wrong_input_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_points_clamped_in_part_are_refused():
    structure = brick.pair().clamped("upper", "x")
    with pytest.raises(ValueError, match=r"node 0 is clamped in 1 of 3 directions \(9 such nodes\)"):
        joined(structure)
    with pytest.raises(ValueError, match="cannot move, nor can its partner"):
        joined(structure.clamped(["upper", "lower"]))


def test_joints_that_do_not_go_together_are_refused():
    structure = brick.pair()
    upper, lower = structure.surface("upper"), structure.surface("lower")
    joint = Joint.between(upper, lower)
    with pytest.raises(ValueError, match="joints 'upper - lower' and 'lower - ground' both take a node"):
        structure.join([joint, Joint.ground(lower)])
    with pytest.raises(ValueError, match="joint 'lower - ground' has no friction, other joints have"):
        brick.pair(over=(3, 3, 1)).join([Joint.between(*surfaces(over=(3, 3, 1)), friction=0.1),
                                         Joint.ground(surfaces(over=(3, 3, 1))[1])])
    with pytest.raises(ValueError, match="at least one joint"):
        structure.join([])
    with pytest.raises(ValueError, match="was not made from the surfaces of this structure; clamp first"):
        structure.clamped("top").join(joint)
    finer = brick.pair(over=(3, 3, 1))
    there = Joint.between(finer.surface("upper"), finer.surface("lower"))
    back = Joint.between(finer.surface("lower"), finer.surface("upper"))
    with pytest.raises(ValueError, match="stand on each other's contact points in a circle"):
        finer.join([there, back])


DISTRIBUTED = """
import sys
import numpy as np
from petsc4py import PETSc
import brick
from dovetail import Joint, Structure
comm = PETSc.COMM_WORLD
over = tuple(map(int, sys.argv[2].split(",")))
plain = brick.pair(over=over, mapping=brick.turned((1, 2, 3), 0.7), poisson=0.3)
if sys.argv[3] == "petsc":
    def distributed(whole):
        mine = PETSc.Mat().createAIJ(whole.shape, nnz=100, comm=comm)
        begin, end = mine.getOwnershipRange()
        part = whole[begin:end]
        return PETSc.Mat().createAIJ(whole.shape, csr=(part.indptr, part.indices, part.data), comm=comm)
    plain = Structure(distributed(plain.K), distributed(plain.M), plain.nodes, plain.dof_node, plain.dof_direction, cells=plain.cells,
                      node_sets=plain.node_sets)
structure = plain.with_base_acceleration([1, 0, 0]).with_gravity([0, 0, -1])
structure = structure.clamped("bottom").with_force("top", [1, 2, 3]).with_preload("over", [0, -1, 5])
structure = structure.with_force("over", [0, 1, 2], name="late", phase=1.0)
joint = Joint.between(structure.surface("upper"), structure.surface("lower"), normal_stiffness=1.0, friction=0.1)
structure.join(joint).write(sys.argv[1])
"""


@pytest.mark.parametrize("over", ["2,2,2", "3,4,1"], ids=["matching", "not matching"])
@pytest.mark.slow
def test_distributed_matrices_give_the_same_model(tmp_path, over):
    from dovetail import Model

    (tmp_path / "write.py").write_text(DISTRIBUTED)
    models = []
    for ranks, kind in ((1, "scipy"), (1, "petsc"), (2, "petsc")):
        path = tmp_path / f"{kind}{ranks}.h5"
        command = ["mpirun", "-n", str(ranks), sys.executable, str(tmp_path / "write.py"), str(path), over, kind]
        search = SURROUNDINGS | {"PYTHONPATH": SURROUNDINGS["PYTHONPATH"] + ":" + str(re.sub("[^/]*$", "", __file__))}
        done = subprocess.run(command, env=search, capture_output=True, text=True, timeout=SECONDS)
        assert done.returncode == 0, done.stderr
        models.append(Model.read(path))
    for model in models[1:]:
        for name in ("K", "M"):
            difference = abs(getattr(model, name) - getattr(models[0], name)).max()
            assert difference < 1e-14 * abs(getattr(models[0], name)).max()
        for name in ("force", "preload"):
            np.testing.assert_allclose(getattr(model, name), getattr(models[0], name), atol=1e-14)
        assert list(model.forces) == list(models[0].forces) == ["base", "late", "late_sin"]
        for name, load in models[0].forces.items():
            np.testing.assert_allclose(model.forces[name], load, atol=1e-14)
        np.testing.assert_array_equal(model.contact_dofs, models[0].contact_dofs)
        for key in ("dof", "begin", "column", "value"):
            np.testing.assert_array_equal(model.mesh["changed"][key], models[0].mesh["changed"][key])
        np.testing.assert_array_equal(model.joint["axes"], models[0].joint["axes"])
