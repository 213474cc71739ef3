"""Bodies and the rigid motions that nothing holds, springs to the ground, and what the import says about them."""

import brick
import numpy as np
import pytest
import scipy.sparse as sp

from dovetail import Structure
from dovetail.importers import setup_file
from dovetail.importers.bodies import bodies


def counts(structure):
    return [body.free.shape[1] for body in bodies(structure)]


@pytest.mark.parametrize("mapping", [lambda points: points, brick.turned((1, 2, 3), 0.7, (0.3, -2, 5))], ids=["straight", "turned"])
def test_two_bodies_have_six_rigid_motions_each_and_clamps_take_theirs(mapping):
    structure = brick.pair(over=(3, 2, 2), poisson=0.3, mapping=mapping)
    assert counts(structure) == [6, 6]
    found = bodies(structure.clamped("bottom"))
    assert [body.free.shape[1] for body in found] == [6, 0] and set(found[0].rows) == set(structure.node_sets["over"])
    corner = int(structure.node_sets["bottom"][0])
    assert counts(structure.clamped([corner])) == [6, 3]
    np.testing.assert_allclose(structure.K[found[0].dofs][:, found[0].dofs] @ found[0].free, 0, atol=1e-12)


def test_a_line_of_nodes_and_a_single_node():
    """Without rotation about the line, and without any."""
    nodes = np.array([(0.0, 0, 0), (1, 0, 0), (5, 5, 5)])
    K = np.zeros((9, 9))
    K[:6, :6] = np.kron([[1, -1], [-1, 1]], np.diag([1.0, 0, 0]))
    structure = Structure(sp.csr_matrix(K), sp.identity(9, format="csr"), nodes, np.repeat(np.arange(3), 3), np.tile(np.arange(3), 3))
    assert counts(structure) == [5, 3]


def test_soft_springs_hold_a_body():
    """However soft: 1e-9 of what an element resists."""
    structure = brick.pair(poisson=0.3)
    held = structure.with_springs("top", [0, 0, 1e-9])
    assert sorted(counts(held)) == [3, 6]
    assert counts(structure.with_springs("top", [1e-9, 1e-9, 1e-9]).with_springs("bottom", [0, 1e-9, 0])) in ([0, 4], [4, 0])
    assert abs((held.K - structure.K).sum() - 1e-9) < 1e-15


def test_springs_are_those_of_the_ground():
    """A body on springs of k in all comes down by P / k."""
    structure = brick.pair(poisson=0.3).with_springs("top", [1.0, 1.0, 4.0]).with_springs("bottom", [1.0, 1.0, 1.0])
    load = structure.with_preload("top", [0, 0, -2.0]).preload
    u = sp.linalg.spsolve(structure.K.tocsc(), load)
    z = structure.dofs_of(structure.node_sets["over"])[:, 2]
    np.testing.assert_allclose(u[structure.dofs_of(structure.node_sets["top"])[:, 2]].mean(), -0.5, rtol=1e-9)
    np.testing.assert_allclose(u[z], -0.5, rtol=1e-9)


def test_springs_on_distributed_matrices():
    pytest.importorskip("petsc4py")
    from petsc4py import PETSc

    plain = brick.pair(poisson=0.3)
    K, M = (PETSc.Mat().createAIJ(matrix.shape, csr=(matrix.indptr, matrix.indices, matrix.data), comm=PETSc.COMM_SELF)
            for matrix in (plain.K, plain.M))
    ours = Structure(K, M, plain.nodes, plain.dof_node, plain.dof_direction, node_sets=plain.node_sets).with_springs("top", [1, 2, 0])
    theirs = plain.with_springs("top", [1, 2, 0])
    indptr, indices, data = ours.K.getValuesCSR()
    assert abs(sp.csr_matrix((data, indices, indptr), shape=theirs.K.shape) - theirs.K).max() < 1e-15
    indptr, indices, data = K.getValuesCSR()
    assert abs(sp.csr_matrix((data, indices, indptr), shape=theirs.K.shape) - plain.K).max() == 0  # a copy was changed


SETUP = """[[clamp]]
set = "bottom"
[[spring]]
set = "top"
stiffness = [0, 2.0, 0]
[[preload]]
set = "top"
vector = [0, 0, -3]
[[joint]]
between = ["upper", "lower"]
"""


def applied(folder, text):
    path = folder / "joints.toml"
    path.write_text(text)
    return "\n".join(setup_file.apply(brick.pair(poisson=0.3), path).notes)


def test_import_says_what_joints_have_to_hold_and_how_the_preload_pulls(tmp_path):
    said = applied(tmp_path, SETUP)
    assert "2 bodies; rigid motions that only joints can hold: 4" in said
    assert "4 of the body of node 0 (27 nodes); preload on it (0, 0, -3), moment about its middle (0, 0, 0)" in said
    said = applied(tmp_path, SETUP.replace("[0, 2.0, 0]", "[2.0, 2.0, 2.0]"))
    assert "2 bodies, all held: no rigid motion is left to the joints" in said
    assert "the preload does not move it" in applied(tmp_path, SETUP.replace("[0, 0, -3]", "[0, 2, 0]"))  # the springs take it
    said = applied(tmp_path, SETUP.replace("[0, 0, -3]", "[1, 0, 0]"))
    assert "preload on it (1, 0, 0), moment about its middle (0, 0.5, 0)" in said
    loose = SETUP.replace('[[preload]]\nset = "top"', '[[preload]]\nset = "bottom"').replace('[[clamp]]\nset = "bottom"\n', "")
    said = applied(tmp_path, loose)
    assert "the preload does not move it" in said


@pytest.mark.parametrize("old, new, message", [
    ("[0, 2.0, 0]", "[0, 0, 0]", r"\[\[spring\]\] number 1: stiffness must not be negative, nor all zero"),
    ("[0, 2.0, 0]", "[0, -1, 0]", r"\[\[spring\]\] number 1: stiffness must not be negative"),
    ("[0, 2.0, 0]", "2.0", r"\[\[spring\]\] number 1: stiffness must be three finite numbers"),
    ("stiffness", "stifness", "did you mean 'stiffness'")])
def test_wrong_springs_are_refused(tmp_path, old, new, message):
    with pytest.raises(ValueError, match=message):
        applied(tmp_path, SETUP.replace(old, new))
