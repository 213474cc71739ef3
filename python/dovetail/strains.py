"""Strain and stress at the nodes of solid cells from the displacements of their nodes.

Tensors have six components, xx, yy, zz, xy, yz, zx, as VTK and ParaView have them; shear strains are half the engineering ones.
See docs/theory/stress.md.
"""

import numpy as np

from . import solids

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
TWICE = np.array([1, 1, 1, 2, 2, 2])  # how often a component stands in a symmetric tensor


def cell_stress(kind, integration, X, U, young, poisson):
    """Stress at the nodes of cells of one kind, each by itself.

    Parameters
    ----------
    kind : str
        One of solids.SHAPE.
    integration : int
        solids.USUAL, ...
    X : (m, w, 3) places of the nodes
    U : (c, m, w, 3) c fields of displacements
    young, poisson : (m,)

    Returns
    -------
    (c, m, w, 6)
    """
    rule = solids.rule(kind, integration)
    return np.einsum("wp,cmps->cmws", rule.to_nodes, _at_points(rule, integration, X, U, young, poisson))


def cell_forces(kind, integration, X, U, young, poisson):
    """(c, m, w, 3) forces that the nodes exert on cells so deformed, the integral of B^T sigma [N]; arguments as of `cell_stress`."""
    rule = solids.rule(kind, integration)
    stress = _at_points(rule, integration, X, U, young, poisson) * (rule.weights * np.abs(np.linalg.det(_jacobian(rule, X))))[..., None]
    slopes, forces = _slopes(rule, X), np.zeros(U.shape)
    for component, (i, j) in enumerate(PAIRS):
        forces[..., i] += np.einsum("cmp,mpw->cmw", stress[..., component], slopes[..., j])
        if i != j:
            forces[..., j] += np.einsum("cmp,mpw->cmw", stress[..., component], slopes[..., i])
    return forces


def _at_points(rule, integration, X, U, young, poisson):
    """Stress (c, m, p, 6) at the integration points."""
    gradient = np.einsum("cmwi,mpwj->cmpij", U, _slopes(rule, X), optimize=True)
    if integration == solids.INCOMPATIBLE:
        gradient += _incompatible(rule, X, gradient, young, poisson)
    return hooke(strain(gradient), young[:, None], poisson[:, None])


def _slopes(rule, X):
    """(m, p, w, 3) of the shape functions along x, y, z at the integration points."""
    return rule.slopes[None] @ np.linalg.inv(_jacobian(rule, X))


def strain(gradient):
    """(..., 6) of displacement gradients (..., 3, 3)."""
    return np.stack([(gradient[..., i, j] + gradient[..., j, i]) / 2 for i, j in PAIRS], axis=-1)


def hooke(strain, young, poisson):
    """Stress (..., 6) of an isotropic material; young, poisson: anything that fits (...)."""
    shear = young / (2 * (1 + poisson))
    lame = 2 * shear * poisson / (1 - 2 * poisson)
    stress = 2 * shear[..., None] * strain
    stress[..., :3] += (lame * strain[..., :3].sum(axis=-1))[..., None]
    return stress


def _jacobian(rule, X):
    """(m, p, 3, 3) dx_i / dxi_a at the integration points."""
    return np.einsum("pwa,mwi->mpia", rule.slopes, X)


def _incompatible(rule, X, gradient, young, poisson):
    """(c, m, p, 3, 3) what the incompatible modes of C3D8I add: the displacements (1 - xi_a^2) alpha_a that make the energy least.

    Their slopes are taken with the Jacobian of the centre, as CalculiX does, whose stiffness this goes with.
    """
    centre = np.einsum("wa,mwi->mia", solids.shapes("hexahedron", np.zeros((1, 3)))[1][0], X)
    volume = rule.weights * np.abs(np.linalg.det(_jacobian(rule, X)))
    slopes = -2 * rule.points[:, :, None] * np.linalg.inv(centre)[:, None]  # (m, p, a, 3)
    modes = np.einsum("mpaj,ik->aimpkj", slopes, np.eye(3)).reshape(9, *slopes.shape[:2], 3, 3)
    stress = hooke(strain(modes), young[:, None], poisson[:, None]) * TWICE
    own = np.einsum("ampk,bmpk,mp->mab", stress, strain(modes), volume, optimize=True)
    right = np.einsum("ampk,cmpk,mp->mac", stress, strain(gradient), volume, optimize=True)
    return np.einsum("mac,ampij->cmpij", -np.linalg.solve(own, right), modes, optimize=True)
