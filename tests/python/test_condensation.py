"""Statics by the contact dofs alone: against the whole structure, of SciPy and of PETSc matrices."""

import numpy as np
import pytest
import scipy.sparse as sp

from dovetail import Model
from dovetail.bolts import static_state
from dovetail.condensation import Condensed

SIZE, KEPT = 200, np.array([150, 7, 30, 31, 32, 199])  # more inner dofs than are solved at once


def stiffness(seed=1):
    """A chain with random branches, held softly."""
    random = np.random.default_rng(seed)
    ends = np.array([(i, i + 1) for i in range(SIZE - 1)] + [random.choice(SIZE, 2, replace=False) for _ in range(SIZE)])
    pull = sp.csr_matrix((np.tile([1.0, -1.0], len(ends)), (np.repeat(np.arange(len(ends)), 2), ends.ravel())), shape=(len(ends), SIZE))
    return sp.csr_matrix(pull.T @ sp.diags(random.uniform(0.5, 2, len(ends))) @ pull + 1e-3 * sp.identity(SIZE))


def in_petsc(matrix):
    PETSc = pytest.importorskip("petsc4py.PETSc", reason="needs petsc4py")
    csr = matrix.indptr.astype(PETSc.IntType), matrix.indices.astype(PETSc.IntType), matrix.data
    return PETSc.Mat().createAIJ(matrix.shape, csr=csr, comm=PETSc.COMM_SELF)


@pytest.fixture(params=["SciPy", "large", "PETSc"])
def of_kind(request, monkeypatch):
    """What makes a matrix of this kind."""
    if request.param == "large":
        monkeypatch.setattr("dovetail.condensation.LARGE", 0)
    return in_petsc if request.param == "PETSc" else sp.csr_matrix


@pytest.mark.parametrize("kept", [KEPT, np.random.default_rng(2).permutation(SIZE)[:130], np.arange(SIZE)], ids=["few", "many", "all"])
def test_dofs_kept_move_as_in_the_whole_structure(of_kind, kept):
    K, load = stiffness(), np.random.default_rng(3).normal(size=SIZE)
    condensed = Condensed(of_kind(K), kept)
    wanted = np.linalg.solve(K.toarray(), load)
    x = np.linalg.solve(condensed.stiffness, condensed.load(load))
    np.testing.assert_allclose(x, wanted[kept], rtol=1e-9, atol=1e-9 * abs(wanted).max())
    np.testing.assert_allclose(condensed.displacements(x, load), wanted, rtol=1e-9, atol=1e-9 * abs(wanted).max())
    np.testing.assert_allclose(condensed.stiffness, np.linalg.inv(np.linalg.inv(K.toarray())[np.ix_(kept, kept)]), atol=1e-8)


def test_a_part_that_nothing_holds_is_told(of_kind):
    K = stiffness().tolil()
    K[:10, 10:] = K[10:, :10] = 0.0
    K[:10, :10] = np.eye(10) - 0.1  # slides as a whole
    condensed = Condensed(of_kind(sp.csr_matrix(K)), np.array([50, 51, 52]))
    with pytest.raises(ValueError, match="a part moves freely even with all contact points held"):
        condensed.load(np.eye(SIZE)[3])


@pytest.mark.parametrize("friction", [True, False])
def test_static_state_of_petsc_matrices_is_that_of_scipy_ones(friction):
    K, load = stiffness(), np.zeros(SIZE)
    load[[32, 199]] = 0.2, 0.1
    load[[7, 31, 100]] = 0.05, 0.3, 0.02
    contact = {"normal_stiffness": 3.0, "tangential_stiffness": 2.0, "friction": 0.3}
    M, dofs = sp.identity(SIZE, format="csr"), KEPT.reshape(2, 3)
    models = [Model(given(K), given(M), dofs, contact=contact) for given in (sp.csr_matrix, in_petsc)]
    (u, g), (petsc_u, petsc_g) = (static_state(model, load, friction) for model in models)
    springs = np.zeros(SIZE)
    springs[KEPT] = g.ravel()
    np.testing.assert_allclose(K @ u + springs, load, atol=1e-9)
    assert (g[:, 2] > 0).any()
    np.testing.assert_allclose(petsc_u, u, rtol=1e-8, atol=1e-8 * abs(u).max())
    np.testing.assert_allclose(petsc_g, g, atol=1e-8 * abs(g).max())
