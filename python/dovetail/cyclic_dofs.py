"""Degrees of freedom on the two sides of a sector: both alike, kept by a turn, and free of the constraint itself."""

import numpy as np
import scipy.sparse as sp

from .importers.rigid import motions
from .sparse_rows import is_petsc

RIGID = 1e-3  # a row resists rigid motion when its force is above this share of the forces that should cancel
KEPT = 1e-9  # largest part of a direction that a turn may carry into another one, and still keep it
DIRECTIONS = "x", "y", "z", "rotation x", "rotation y", "rotation z"


def pairs_of(structure):
    """`left` and `right` of a model file, (q, 3) each: dofs of a displacement, or of a rotation, -1 where it is held.

    Raises ValueError when partners have other dofs, when a turn would not keep what is held, or when the matrices are not those of
    the sector alone. Collective for PETSc.
    """
    cyclic = structure.cyclic_sector
    table = np.full((len(structure.nodes), 6), -1)
    known = np.flatnonzero((structure.dof_node >= 0) & (structure.dof_direction >= 0))
    table[structure.dof_node[known], structure.dof_direction[known]] = known
    _need_held_axis(structure, table)
    for rows, name in ((cyclic.left, cyclic.left_name), (cyclic.right, cyclic.right_name)):
        following = rows[(structure.followers.table[rows] >= 0).any(axis=1)]
        if following.size:
            raise ValueError(f"node {structure.labels[following[0]]} of {name!r} follows others by an equation, a tie or the constraint "
                             f"between the sides ({len(following)} such nodes); matrices of the plain sector are wanted, in which both "
                             "sides are free")
    left, right = table[cyclic.left], table[cyclic.right]
    _need_alike(structure, left >= 0, right >= 0)
    _need_kept(structure, left >= 0)
    _need_plain(structure, table)
    if not (left >= 0).any():
        raise ValueError(f"every node of {cyclic.left_name!r} and {cyclic.right_name!r} is clamped, so the sector is not joined to its "
                         "neighbours; clamp less, or leave cyclic out")
    found = [[side[(side[:, part] >= 0).any(axis=1), part] for part in (slice(0, 3), slice(3, 6))] for side in (left, right)]
    return tuple(np.concatenate(parts) for parts in found)


def _need_held_axis(structure, table):
    rows = structure.cyclic_sector.on_axis
    free = rows[(table[rows] >= 0).any(axis=1)]
    if free.size:
        raise ValueError(f"node {structure.labels[free[0]]} lies on the axis and can move ({len(free)} such nodes of left and right); "
                         "clamp what lies on the axis, or cut the disk off at a radius")


def _need_alike(structure, left, right):
    cyclic, labels = structure.cyclic_sector, structure.labels
    worst = np.flatnonzero((left != right).any(axis=1))
    if not worst.size:
        return
    first = worst[0]
    sides = (cyclic.left, cyclic.left_name), (cyclic.right, cyclic.right_name)
    a, b = (f"node {labels[rows[first]]} of {name!r}" for rows, name in sides)
    advice = "clamp both alike"
    if (left[first, 3:] != right[first, 3:]).any() and (left[first, :3] == right[first, :3]).all():
        advice = "both sides need the same kind of elements"
    elif not (left[worst].any() and right[worst].any()) and len(worst) > len(left) / 2:
        advice = "clamp both alike, and bring matrices of the plain sector, without the constraint between its sides"
    raise ValueError(f"{a} can move along {_said(left[first])}, but its partner, {b}, along {_said(right[first])} "
                     f"({len(worst)} such pairs); {advice}")


def _need_kept(structure, free):
    """A turn must carry what is held onto what is held."""
    cyclic = structure.cyclic_sector
    R = np.abs(cyclic.rotation) > KEPT
    mixed = np.zeros(len(free), dtype=bool)
    for part in (free[:, :3], free[:, 3:]):
        mixed |= np.einsum("pi,ij,pj->p", part.astype(int), R.astype(int), (~part).astype(int)) > 0
    if mixed.any():
        first = np.argmax(mixed)
        raise ValueError(f"node {structure.labels[cyclic.left[first]]} of {cyclic.left_name!r} can move along {_said(free[first])} only "
                         f"({np.count_nonzero(mixed)} such nodes), and a turn by {360 / cyclic.sectors:.6g} degrees does not keep these "
                         "directions; clamp all three directions on left and right, or those along or across the axis")


def _need_plain(structure, table):
    """Rigid motion must need no forces at the sides, away from what is held: else the constraint is in the matrices already."""
    cyclic, K = structure.cyclic_sector, structure.K
    held, meshed = (table[:, :3] < 0).any(axis=1), np.zeros(len(table), dtype=bool)
    near = held.copy()
    for cells in structure.cells.values():
        near[cells[held[cells].any(axis=1)]] = True
        meshed[cells] = True
    judged_nodes = meshed & ~near  # those without cells may be neighbours of what is held
    begin, own_rows = _own_rows(K)
    moved, sizes = motions(structure.nodes, structure.dof_node, structure.dof_direction), abs(own_rows)
    bad = (np.abs(own_rows @ moved) > RIGID * (sizes @ np.abs(moved))).any(axis=1)
    placed = sizes @ (structure.dof_node < 0).astype(float) == 0  # rows without unknowns that have no place
    for rows, name in ((cyclic.left, cyclic.left_name), (cyclic.right, cyclic.right_name)):
        dofs = table[rows[judged_nodes[rows]], :3].ravel()
        own = dofs[(dofs >= begin) & (dofs < begin + len(bad))] - begin
        own = own[placed[own]]
        resisting, judged = own[bad[own]] + begin, len(own)
        if is_petsc(K):
            parts = K.getComm().tompi4py().allgather((resisting, judged))
            resisting, judged = np.concatenate([part for part, _ in parts]), sum(count for _, count in parts)
        if 2 * len(resisting) > judged:
            node = structure.labels[structure.dof_node[resisting.min()]]
            raise ValueError(f"a rigid motion needs forces at {len(resisting)} of {judged} unknowns of {name!r}, the first at node {node}: "
                             "the constraint between the sides is in the matrices already; write those of the plain sector, without it")


def _own_rows(K):
    """The first of the rows that this rank holds, and these rows as SciPy CSR."""
    if not is_petsc(K):
        return 0, sp.csr_matrix(K)
    begin, end = K.getOwnershipRange()
    indptr, indices, data = K.getValuesCSR()
    return begin, sp.csr_matrix((data, indices, indptr), shape=(end - begin, K.getSize()[1]))


def _said(free):
    return ", ".join(name for name, moves in zip(DIRECTIONS, free) if moves) or "nothing"
