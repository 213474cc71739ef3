"""Rigid motions of a mesh in its matrices: what resists them, and the mass that moves."""

import warnings

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla

MOTIONS = ("x", "y", "z", "about x", "about y", "about z")
ROTATION = 1e-6  # a row resists rotation above this share of the forces that should cancel: coordinates are rounded, too
LEAST = 1e-13  # the same for translation, of matrices in full precision


def motions(nodes, dof_node, dof_direction):
    """(n, 6) displacements of the unknowns in six rigid motions, rotations about the middle of the nodes [m]; 0 without a place."""
    moved = np.zeros((len(dof_node), 6))
    known = dof_node >= 0
    X = nodes - nodes.mean(axis=0)
    moves = known & (dof_direction >= 0) & (dof_direction < 3)
    for axis in range(3):
        turn = np.cross(np.eye(3)[axis], X)
        moved[known & (dof_direction == axis), axis] = 1
        moved[known & (dof_direction == 3 + axis), 3 + axis] = 1
        moved[moves, 3 + axis] = turn[dof_node[moves], dof_direction[moves]]
    return moved


def with_inner(K, moved, placed):
    """The motions with unknowns that have no place (not `placed`, (n,) bool) following as they like; None where they cannot."""
    if placed.all():
        return moved
    inside = np.flatnonzero(~placed)
    with warnings.catch_warnings():
        warnings.simplefilter("error", sla.MatrixRankWarning)
        try:
            followed = sla.spsolve(sp.csc_matrix(K[inside][:, inside]), -(K[inside][:, placed] @ moved[placed]))
        except (sla.MatrixRankWarning, RuntimeError):
            return None
    result = moved.copy()
    result[inside] = followed.reshape(len(inside), -1)
    return result if np.isfinite(result).all() else None


def mass(M, moved):
    """r^T M r of the three translations."""
    return np.einsum("ik,ik->k", moved[:, :3], M @ moved[:, :3])


def digits_of(matrix):
    """Rounding of the numbers of a matrix: half a unit of their last decimal, relative, from the largest hundred."""
    largest = np.partition(np.abs(matrix.data), -min(100, matrix.nnz))[-100:]
    for digits in range(4, 15):
        if all(float(f"{value:.{digits}e}") == value for value in largest.tolist()):
            return 0.5 * 10.0**-digits
    return LEAST


def resisted(K, moved):
    """Energies r^T K r (6,), their scale r^T |K| r (6,), and by row and motion (n, 6) whether the force is more than rounding."""
    force, size = K @ moved, abs(K) @ abs(moved)
    allowed = 20 * max(digits_of(K), LEAST)
    limits = np.r_[np.full(3, allowed), np.full(3, max(allowed, ROTATION))]
    energy, scale = np.einsum("ik,ik->k", moved, force), np.einsum("ik,ik->k", abs(moved), size)
    return energy, scale, abs(force) > limits * size.max(axis=0).clip(min=np.finfo(float).tiny)


def unsatisfied(equations, nodes):
    """[(number of the equation, name of the motion)] of equations that a rigid motion of the nodes does not satisfy."""
    X = nodes - nodes.mean(axis=0)
    turns = np.stack([np.cross(axis, X) for axis in np.eye(3)])  # (3, n_nodes, 3)
    found = []
    for number, terms in enumerate(equations):
        left, size = np.zeros(6), np.zeros(6)
        for node, direction, coefficient in terms:
            r = np.zeros(6)
            if direction < 3:
                r[direction], r[3:] = 1.0, turns[:, node, direction]
            else:
                r[direction] = 1.0
            left += coefficient * r
            size += abs(coefficient * r)
        lever = np.linalg.norm(X, axis=1).max() * sum(abs(coefficient) for _, _, coefficient in terms)
        bad = np.abs(left) > ROTATION * np.r_[size[:3], np.maximum(size[3:], 1e-3 * lever)]
        if bad.any():
            found.append((number, MOTIONS[int(np.argmax(bad))]))
    return found
