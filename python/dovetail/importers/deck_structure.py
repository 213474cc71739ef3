"""From a mesh and its matrices to a Structure: what fits, what was held, what is tied, what is loaded.

For every program: the deck may be an input file, an archive or bulk data.
"""

import numpy as np

from ..loads import LATE, LATER
from ..structure import Structure
from .deck_damping import notes_of

RIGID = 1e-3  # a stiffness row resists rigid motion when its force is above this share of the forces that should cancel


def build(deck, K, M, dof_node, dof_direction, held, loads, *, sources, units, notes, late=()):
    """Check mesh against matrices and say what was taken.

    Parameters
    ----------
    deck : inp.Deck
    K, M : scipy CSR, (n, n)
        Of the unknowns that are left.
    dof_node, dof_direction : (n,) int
        As in dovetail.Structure; -1 for unknowns of nodes that are not in the deck.
    held : (n_nodes, 6) bool
        Directions that boundary conditions took out of the matrices.
    loads, late : list of inp_sets.Entry
        Forces to take: real and imaginary parts of F, the excitation being Re(F exp(i omega t)).
    sources : (str, str)
        Names of the files of stiffness and mass, for messages.
    units : str
    notes : list of str
        What was taken and what was not, one sentence each; goes on here and becomes `notes` of the structure.

    Returns
    -------
    dovetail.Structure

    Raises
    ------
    ValueError
        When mesh and matrices do not belong together, a translation has no stiffness or no mass, or a force acts on a tied node.
    """
    number = np.full((len(deck.nodes), 6), -1)
    known = dof_node >= 0
    number[dof_node[known], dof_direction[known]] = np.flatnonzero(known)
    used = np.zeros(len(deck.nodes), dtype=bool)
    for rows in deck.cells.values():
        used[rows] = True
    tied = used & ((number < 0) & ~held)[:, :3].any(axis=1)
    _check_diagonals(deck, K, M, dof_node, dof_direction, used, sources)
    _check_rigid_motion(deck, K, dof_node, dof_direction, number, sources[0], notes)

    counts = ", ".join(f"{len(rows)} {name}" for name, rows in deck.cells.items())
    notes.append(f"{deck.path}: {len(deck.nodes)} nodes, {counts} cells; {K.shape[0]} degrees of freedom from {sources[0]}")
    x = dof_direction == 0
    notes.append(f"moving mass, the sum of M in x: {M[x][:, x].sum():.6g} (kg if the files are in SI; t if they are in t, mm, s, N)")
    if held.any():
        notes.append(f"held by the boundary conditions and so no unknowns: {held[:, :3].sum()} displacements of "
                     f"{held[:, :3].any(axis=1).sum()} nodes")
    if not known.all():
        notes.append(f"{(~known).sum()} unknowns belong to nodes that the source program made itself; they are kept, without a "
                     "place in the mesh")
    if deck.shapeless:
        notes.append(f"elements {', '.join(deck.shapeless)} are in the matrices, but not in the mesh")
    node_sets, surfaces = _without_tied(deck, tied, notes)
    force = _force(deck, loads, number, held, K.shape[0], notes, "the amplitude F of the excitation")
    if deck.other_loads:
        notes.append(f"NOT taken: {', '.join(deck.other_loads)}; give such loads with [[force]] or [[preload]] in the set-up file")
    notes += notes_of(deck.damping, deck.damping_named)
    structure = Structure(K, M, deck.nodes, dof_node, dof_direction, labels=deck.labels, cells=deck.cells, node_sets=node_sets,
                          surfaces=surfaces, force=force, units=units)
    if late:
        imaginary = _force(deck, late, number, held, K.shape[0], notes, "imaginary part of F, in the load pattern \"force_sin\"")
        structure.forces["force" + LATER], structure.courses["force" + LATER] = -imaginary, LATE
    structure.damping = deck.damping
    structure.notes = notes
    return structure


def _check_diagonals(deck, K, M, dof_node, dof_direction, used, sources):
    moving = (dof_node >= 0) & (dof_direction < 3)
    moving[moving] = used[dof_node[moving]]
    no_density = ", or a material has no density (*DENSITY, MP,DENS or RHO)"
    for name, matrix, path, reason in (("stiffness", K, sources[0], ""), ("mass", M, sources[1], no_density)):
        bad = np.flatnonzero(moving & (matrix.diagonal() <= 0))
        if bad.size:
            raise ValueError(f"{path}: the {name} of {place(deck, dof_node[bad[0]], dof_direction[bad[0]])} must be positive, "
                             f"found {matrix.diagonal()[bad[0]]:g} ({bad.size} such unknowns): the file is cut short{reason}")


def place(deck, node, direction):
    """A degree of freedom in words."""
    label = deck.labels[node] if node >= 0 else "of the source program's own"
    return f"node {label}, direction {direction + 1}"


def _check_rigid_motion(deck, K, dof_node, dof_direction, number, source, notes):
    """Stiffness rows far from everything held or tied must give no force when the whole body moves rigidly.

    A deck that was changed after the matrices were written, or in which nodes have other numbers, does not pass.
    """
    partial = (number[:, :3] < 0).any(axis=1)
    near = partial.copy()
    for rows in deck.cells.values():
        near[rows[partial[rows].any(axis=1)]] = True
    known = dof_node >= 0
    rows = known & (dof_direction < 3)
    rows[rows] = ~near[dof_node[rows]]
    if not known.all():
        rows &= abs(K[:, ~known]).sum(axis=1).A1 == 0
    if not rows.any():
        return
    motion = np.zeros((len(known), 6))
    X = deck.nodes - deck.nodes.mean(axis=0)
    for axis in range(3):
        turn = np.cross(np.eye(3)[axis], X)  # (n_nodes, 3)
        motion[known & (dof_direction == axis), axis] = 1
        motion[known & (dof_direction == 3 + axis), 3 + axis] = 1
        moves = known & (dof_direction < 3)
        motion[moves, 3 + axis] = turn[dof_node[moves], dof_direction[moves]]
    K = K[rows]
    left, all_of_it = abs(K @ motion), abs(K) @ abs(motion)
    bad = (left > RIGID * all_of_it).any(axis=1)
    if bad.mean() > 0.5:
        first = np.flatnonzero(rows)[np.argmax(bad)]
        raise ValueError(f"{deck.path} and {source} do not belong together: {bad.sum()} of {len(bad)} rows of the stiffness give a force "
                         f"when the whole mesh moves rigidly, the first for {place(deck, dof_node[first], dof_direction[first])}; was "
                         "the mesh changed after the matrices were written, or are its nodes numbered differently?")
    if bad.any():
        notes.append(f"{bad.sum()} rows of the stiffness resist rigid motion of the whole (springs to ground, equations or prestress)")


def _without_tied(deck, tied, notes):
    """Sets and surfaces without those that hold nodes whose motion an equation gives: a joint there would be wrong."""
    kept_sets = {name: rows for name, rows in deck.node_sets.items() if not tied[rows].any()}
    kept_surfaces = {name: faces for name, faces in deck.surfaces.items() if not any(tied[rows].any() for rows in faces)}
    lost = [name for name in (*deck.node_sets, *deck.surfaces) if name not in kept_sets and name not in kept_surfaces]
    if tied.any():
        notes.append(f"the motion of {tied.sum()} nodes follows from others (equations, ties, couplings, rigid elements), first node "
                     f"{deck.labels[tied][0]}; the matrices hold that"
                     + (f", but the sets with such nodes are NOT taken: {', '.join(lost)}" if lost else ""))
    return kept_sets, kept_surfaces


def _force(deck, loads, number, held, n, notes, meaning):
    force, lost = np.zeros(n), 0
    for load in loads:
        if not 1 <= load.first <= 6:
            raise ValueError(f"{load.where}: wanted a direction from 1 to 6, found {load.first}")
        dofs = number[load.rows, load.first - 1]
        stuck = (dofs < 0) & ~held[load.rows, load.first - 1]
        if stuck.any():
            raise ValueError(f"{load.where}: the force acts on node {deck.labels[load.rows[stuck][0]]}, direction {load.first}, which is "
                             "no unknown of the matrices (tied by an equation, or without that direction); load other nodes")
        np.add.at(force, dofs[dofs >= 0], load.value)
        lost += int((dofs < 0).sum())
    if loads:
        total = [sum(load.value * (number[load.rows, axis] >= 0).sum() for load in loads if load.first == axis + 1) for axis in range(3)]
        notes.append(f"force from {len(loads)} lines of *CLOAD, as {meaning}: total "
                     f"({', '.join(f'{value:.6g}' for value in total)})"
                     + (f"; {lost} forces on held directions are left out" if lost else ""))
    return force
