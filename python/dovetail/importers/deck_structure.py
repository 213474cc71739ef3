"""From a mesh and its matrices to a Structure: what fits, what was held, what is tied, what is loaded.

For every program: the deck may be an input file, an archive or bulk data.
"""

import numpy as np

from ..followers import from_equations
from ..loads import LATE, LATER
from ..material import UNKNOWN
from ..structure import Structure
from .deck_damping import notes_of
from .deck_loads import Unknowns, standing
from .deck_sector import need_plain
from .echo import ROUNDING
from .internal import INCOMPATIBLE, condensed
from .rigid import MOTIONS, mass, motions, resisted, unsatisfied, with_inner

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
    loads, late : list of inp_sets.Entry, inp_loads.Pressure and Weight
        To take, all of one step: real and imaginary parts of F, the excitation being Re(F exp(i omega t)).
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
        When mesh and matrices do not belong together, a translation has no stiffness or no mass, or a force acts on a node that is
        tied in a way that is not known.
    """
    placed = dof_node >= 0
    all_of_M, kept = M, np.ones(K.shape[0], dtype=bool)
    if any(map(INCOMPATIBLE.fullmatch, deck.types)):
        K, M, kept = condensed(K, M, ~placed)
        dof_node, dof_direction = dof_node[kept], dof_direction[kept]
        if not kept.all():
            notes.append(f"{(~kept).sum()} unknowns inside of C3D8I elements are condensed, element by element, with their mass")
    number = np.full((len(deck.nodes), 6), -1)
    known = dof_node >= 0
    number[dof_node[known], dof_direction[known]] = np.flatnonzero(known)
    used = np.zeros(len(deck.nodes), dtype=bool)
    for rows in deck.cells.values():
        used[rows] = True
    tied = used & ((number < 0) & ~held)[:, :3].any(axis=1)
    need_plain(deck, tied, sources[0])
    _check_diagonals(deck, K, M, dof_node, dof_direction, used, sources)

    counts = ", ".join(f"{len(rows)} {name}" for name, rows in deck.cells.items())
    notes.append(f"{deck.path}: {len(deck.nodes)} nodes, {counts} cells; {K.shape[0]} degrees of freedom from {sources[0]}")
    if held.any():
        notes.append(f"held by the boundary conditions and so no unknowns: {held[:, :3].sum()} displacements of "
                     f"{held[:, :3].any(axis=1).sum()} nodes")
    if not known.all():
        notes.append(f"{(~known).sum()} unknowns belong to nodes that the source program made itself; they are kept, without a "
                     "place in the mesh")
    if deck.shapeless:
        notes.append(f"elements {', '.join(deck.shapeless)} are in the matrices, but not in the mesh")
    followers = from_equations([equation.terms for equation in deck.equations], number, held)
    moved, judged = _rigid(deck, K, dof_node, dof_direction)
    spread = np.zeros((len(kept), 6))
    spread[kept] = moved  # in a translation nothing moves inside of an element
    _say_mass(mass(all_of_M, spread), notes)
    _need_fitting_mesh(deck, K, moved, dof_node, dof_direction, number, judged, sources[0])
    _say_rigid_motion(deck, K, moved, judged, dof_node, dof_direction, held, notes)
    node_sets, surfaces, tied_sets = _without_tied(deck, tied, followers, notes)
    moves = motions(deck.nodes, dof_node, dof_direction)[:, :3]
    unknowns = Unknowns(deck, number, held, followers, K.shape[0], lambda g: M @ (moves @ g))
    force = _force(unknowns, standing(loads, deck.matrix_step), notes, "as the amplitude F of the excitation")
    if deck.other_loads:
        notes.append(f"NOT taken: {', '.join(deck.other_loads)}; give such loads with [[force]] or [[preload]] in the set-up file")
    notes += notes_of(deck.damping, deck.damping_named)
    structure = Structure(K, M, deck.nodes, dof_node, dof_direction, labels=deck.labels, cells=deck.cells, node_sets=node_sets,
                          surfaces=surfaces, force=force, units=units)
    structure.followers, structure.tied_sets = followers, tied_sets
    structure.held_by_deck, structure.sector_of_deck = bool(held.any()), deck.sector
    structure.steps = _steps(deck, unknowns, notes)
    if late:
        imaginary = _force(unknowns, standing(late, deck.matrix_step), notes, "as imaginary part of F, in the load pattern \"force_sin\"")
        structure.forces["force" + LATER], structure.courses["force" + LATER] = -imaginary, LATE
    structure.damping = deck.damping
    structure.materials, structure.integration = deck.materials, deck.integration
    structure.material = _materials(deck, tied, notes)
    structure.notes = notes
    return structure


def _check_diagonals(deck, K, M, dof_node, dof_direction, used, sources):
    moving = (dof_node >= 0) & (dof_direction < 3)
    moving[moving] = used[dof_node[moving]]
    no_density = ", or a material has no density (*DENSITY, MP,DENS or RHO)"
    for name, matrix, path, reason in (("stiffness", K, sources[0], ""), ("mass", M, sources[1], no_density)):
        bad = np.flatnonzero(moving & (matrix.diagonal() <= 0))
        if bad.size:
            raise ValueError(f"{path}: the {name} of {place_of(deck, dof_node[bad[0]], dof_direction[bad[0]])} must be positive, "
                             f"found {matrix.diagonal()[bad[0]]:g} ({bad.size} such unknowns): the file is cut short{reason}")


def place_of(deck, node, direction):
    """A degree of freedom in words."""
    label = deck.labels[node] if node >= 0 else "of the source program's own"
    return f"node {label}, direction {direction + 1}"


def _rigid(deck, K, dof_node, dof_direction):
    """The six rigid motions (n, 6), and the rows (n,) bool of K that they can be judged by."""
    placed = dof_node >= 0
    plain = motions(deck.nodes, dof_node, dof_direction)
    moved = with_inner(K, plain, placed)
    if moved is not None:
        return moved, np.ones(K.shape[0], dtype=bool)
    return plain, abs(K[:, ~placed]).sum(axis=1).A1 == 0


def _say_mass(total, notes):
    alike = np.ptp(total) <= 1e-6 * total.max()
    notes.append(f"moving mass r^T M r: {f'{total[0]:.6g}' if alike else 'x {:.6g}, y {:.6g}, z {:.6g}'.format(*total)} "
                 "(kg if the files are in SI; t if they are in t, mm, s, N)")


def _say_rigid_motion(deck, K, moved, judged, dof_node, dof_direction, held, notes):
    """Energy of the six rigid motions over all of K, and what holds the mesh beside boundary conditions."""
    energy, scale, resists = resisted(K, moved)
    share = np.where(resists.any(axis=0), energy, 0.0) / scale.clip(min=np.finfo(float).tiny)
    notes.append("energy of rigid motions r^T K r, as a part of r^T |K| r: "
                 + ", ".join(f"{name} {value:.3g}" for name, value in zip(MOTIONS, share))
                 + (" (boundary conditions hold it)" if held.any() else "" if share.any() else ": nothing in the deck holds the mesh"))
    stuck = held.any(axis=1)
    for equation in deck.equations:
        if any(held[node, direction] for node, direction, _ in equation.terms):
            stuck[[node for node, _, _ in equation.terms]] = True
    rows = judged & (dof_node >= 0) & (dof_direction < 3)
    rows[rows] = ~_beside(deck, stuck)[dof_node[rows]]
    others = resists & rows[:, None]
    free = [equation for equation in deck.equations if not any(held[node, direction] for node, direction, _ in equation.terms)]
    for place, motion in unsatisfied([equation.terms for equation in free], deck.nodes):
        notes.append(f"CHECK: *EQUATION ({free[place].where}) is not true when the whole mesh moves rigidly, {motion}: it holds the "
                     "structure there")
    if others.any():
        first = int(np.argmax(np.where(rows, (np.abs(K @ moved) / scale.clip(min=np.finfo(float).tiny)).max(axis=1), -1)))
        count = len(np.unique(dof_node[others.any(axis=1)]))
        notes.append(f"CHECK: {count} node{'s' * (count != 1)} away from all boundary conditions resist{'s' * (count == 1)} rigid motion "
                     f"({', '.join(name for name, some in zip(MOTIONS, others.any(axis=0)) if some)}), most of all "
                     f"{place_of(deck, dof_node[first], dof_direction[first])}: a spring to the ground, an equation that is not true "
                     "for rigid motion, or prestress")


def _beside(deck, nodes):
    """Nodes (n_nodes,) bool that share a cell with some of these, or are among them."""
    near = nodes.copy()
    for rows in deck.cells.values():
        near[rows[nodes[rows].any(axis=1)]] = True
    return near


def _need_fitting_mesh(deck, K, moved, dof_node, dof_direction, number, judged, source):
    """Far from everything held or tied, rigid motion must give no force.

    A deck that was changed after the matrices were written, or in which nodes have other numbers, does not pass.
    """
    near = _beside(deck, (number[:, :3] < 0).any(axis=1))
    rows = judged & (dof_node >= 0) & (dof_direction < 3)
    rows[rows] = ~near[dof_node[rows]]
    if not rows.any():
        return
    own = K[rows]
    bad = (abs(own @ moved) > RIGID * (abs(own) @ abs(moved))).any(axis=1)
    if bad.mean() > 0.5:
        first = np.flatnonzero(rows)[np.argmax(bad)]
        raise ValueError(f"{deck.path} and {source} do not belong together: {bad.sum()} of {len(bad)} rows of the stiffness give a force "
                         f"when the whole mesh moves rigidly, the first for {place_of(deck, dof_node[first], dof_direction[first])}; was "
                         "the mesh changed after the matrices were written, or are its nodes numbered differently?")


def _without_tied(deck, tied, followers, notes):
    """Sets and surfaces without those that hold nodes whose motion an equation gives: a joint there would be wrong.

    The third, sets of such nodes whose equations are known: for loads.
    """
    kept_sets = {name: rows for name, rows in deck.node_sets.items() if not tied[rows].any()}
    kept_surfaces = {name: faces for name, faces in deck.surfaces.items() if not any(tied[rows].any() for rows in faces)}
    told = ~tied | (followers.table >= 0).any(axis=1)
    for_loads = {name: rows for name, rows in deck.node_sets.items() if name not in kept_sets and told[rows].all()}
    lost = [name for name in (*deck.node_sets, *deck.surfaces)
            if name not in kept_sets and name not in kept_surfaces and name not in for_loads]
    if tied.any():
        notes.append(f"the motion of {tied.sum()} nodes follows from others (equations, ties, couplings, rigid elements), first node "
                     f"{deck.labels[tied][0]}; the matrices hold that"
                     + (f"; sets with such nodes are taken for loads only, which go through the equations: {', '.join(for_loads)}"
                        if for_loads else "")
                     + (f"; NOT taken are the sets with nodes tied in another way: {', '.join(lost)}" if lost else ""))
    return kept_sets, kept_surfaces, for_loads


def _materials(deck, tied, notes):
    """`material` of the deck, without cells beside nodes whose motion is not in the model."""
    found, lost = {}, 0
    for kind, number in deck.material.items():
        beside = tied[deck.cells[kind]].any(axis=1)
        lost += np.count_nonzero(beside & (number != UNKNOWN))
        found[kind] = np.where(beside, UNKNOWN, number)
    if deck.materials:
        notes.append("materials for stresses: " + ", ".join(f"{one.name} (E {one.young:.6g}, nu {one.poisson:g})" for one in deck.materials)
                     + (f"; not of {lost} cells with nodes whose motion follows from others" if lost else ""))
    if deck.not_materials:
        notes.append(f"NOT taken, for stresses: {', '.join(deck.not_materials)}: wanted a linear isotropic material that is the same at "
                     "all temperatures")
    return found


def _force(unknowns, loads, notes, meaning, before=""):
    force, lost = unknowns.forces(loads, notes)
    if loads:
        total = np.array([force[unknowns.number[unknowns.number[:, axis] >= 0, axis]].sum() for axis in range(3)])
        total[abs(total) <= ROUNDING * abs(force).sum()] = 0.0
        notes.append(f"{before}{_words(loads)}, {meaning}: total ({', '.join(f'{value:.6g}' for value in total)})"
                     + (f"; {lost} forces on held directions are left out" if lost else ""))
    return force


def _words(loads):
    """The cards of loads, with the place of the first."""
    lines = {load.where: load.card for _, _, load in loads}
    return f"force from {len(lines)} lines of {', '.join(sorted(set(lines.values())))} ({next(iter(lines))})"


def _steps(deck, unknowns, notes):
    """Loads (n,) of every step that has some but does not write the matrices."""
    found = {}
    for step in sorted({load.step for load in deck.loads} - {deck.matrix_step}):
        loads = standing(deck.loads, step)
        try:
            found[step] = _force(unknowns, loads, notes, f"of step {step}, which [[preload]] step = {step} in the set-up file takes as "
                                 "the preload", "NOT taken: ")
        except ValueError as error:
            notes.append(f"NOT taken: the loads of step {step}: {error}")
    return found
