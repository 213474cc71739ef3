"""From the loads of a deck to forces on unknowns, and which of them stand in a step."""

import numpy as np

from .. import faces as face_kinds
from .inp_loads import Pressure, Weight

GAUSS = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)]), np.array([5.0, 8.0, 5.0]) / 9
TRIANGLE = ((1 / 3, 1 / 3, 9 / 80),) + tuple(
    (x, y, w) for a, w in (((6 - np.sqrt(15)) / 21, (155 - np.sqrt(15)) / 2400), ((6 + np.sqrt(15)) / 21, (155 + np.sqrt(15)) / 2400))
    for x, y in ((a, a), (1 - 2 * a, a), (a, 1 - 2 * a)))  # degree 5


def pressure_forces(X):
    """Forces (m, k, 3) at the nodes of faces X (m, k, 3) by a unit pressure onto them: -integral of N n dA."""
    k = X.shape[1]
    if face_kinds.CORNERS[k] == 3:
        places, weights = np.array([rule[:2] for rule in TRIANGLE]), [rule[2] for rule in TRIANGLE]
    else:
        places = np.stack(np.meshgrid(GAUSS[0], GAUSS[0]), axis=-1).reshape(-1, 2)
        weights = np.outer(GAUSS[1], GAUSS[1]).ravel()
    forces = np.zeros(X.shape)
    for place, weight in zip(places, weights):
        values, slopes = face_kinds.shape(k, place[None])
        slope = np.einsum("ka,mki->mia", slopes[0], X)
        forces -= weight * values[0][:, None] * np.cross(slope[:, :, 0], slope[:, :, 1])[:, None]
    return forces


def standing(loads, step):
    """The loads that act in a step: those of earlier ones too, unless replaced at the same place or ended by OP=NEW."""
    kept = {}  # kind, place -> (step, value, load)
    ended = set()
    for load in sorted((load for load in loads if load.step <= step), key=lambda load: load.step):
        kind = "CLOAD" if hasattr(load, "first") else "DLOAD"
        if load.anew and (kind, load.step) not in ended:
            ended.add((kind, load.step))
            kept = {key: entry for key, entry in kept.items() if key[0] != kind or entry[0] == load.step}
        for place, value in _places(load):
            before = kept.get((kind, place))
            if before is not None and before[0] == load.step:
                value = value + before[1]
            kept[kind, place] = (load.step, value, load)
    return [(place, value, load) for (_, place), (_, value, load) in kept.items()]


def _places(load):
    if isinstance(load, Pressure):
        return [(key, load.value) for key in load.faces]
    if isinstance(load, Weight):
        return [(tuple(load.elements.tolist()), load.vector)]
    return [((row, load.first), load.value) for row in load.rows.tolist()]


class Unknowns:
    """Where forces on nodes go.

    number (n_nodes, 6) int, unknown of each direction, -1 for none; held (n_nodes, 6) bool; followers: Followers; weigh(g) gives the
    forces (n,) by an acceleration (3,), elements the count of all of them.
    """

    def __init__(self, deck, number, held, followers, n, weigh):
        self.deck, self.number, self.held, self.followers, self.n, self.weigh = deck, number, held, followers, n, weigh
        self.elements = sum(map(len, deck.cells.values()))

    def forces(self, loads, notes):
        """(n,) forces of [(place, value, load)], and how many act on held directions and are left out."""
        force, lost = np.zeros(self.n), 0
        groups = {}
        for place, value, load in loads:
            if isinstance(load, Weight):
                if len(np.unique(load.elements)) != self.elements:
                    notes.append(f"NOT taken: the weight of a part ({load.where}); [[gravity]] in the set-up file is that of the whole")
                    continue
                if self.held.any():
                    notes.append(f"NOT taken: the weight ({load.where}), because the matrices do not have all mass beside nodes that the "
                                 "deck holds; hold them with [[clamp]] in the set-up file instead")
                    continue
                force += self.weigh(value)
            elif isinstance(load, Pressure):
                groups.setdefault((load.where, len(load.faces[place])), []).append((load.faces[place], value))
            else:
                if not 1 <= load.first <= 6:
                    raise ValueError(f"{load.where}: wanted a direction from 1 to 6, found {load.first}")
                lost += self._put(force, np.array([place[0]]), np.array([load.first - 1]), np.array([value]), load.where)
        for (where, k), faces in groups.items():
            rows = np.array([nodes for nodes, _ in faces])
            shares = np.array([value for _, value in faces])[:, None, None] * pressure_forces(self.deck.nodes[rows])
            for axis in range(3):
                lost += self._put(force, rows.ravel(), np.full(rows.size, axis), shares[:, :, axis].ravel(), where)
        return force, lost

    def _put(self, force, nodes, axes, values, where):
        dofs = self.number[nodes, axes]
        there, turns = dofs >= 0, axes < 3
        tied = np.zeros(len(nodes), dtype=bool)
        tied[turns] = self.followers.table[nodes[turns], axes[turns]] >= 0
        stuck = ~there & ~tied & ~self.held[nodes, axes] & (values != 0)
        if stuck.any():
            first = np.argmax(stuck)
            raise ValueError(f"{where}: the force acts on node {self.deck.labels[nodes[first]]}, direction {axes[first] + 1}, which is no "
                             "unknown of the matrices (tied in a way that no *EQUATION tells, or without that direction); load other nodes")
        np.add.at(force, dofs[there], values[there])
        if tied.any():
            force += self.followers.force(nodes[tied], axes[tied], values[tied])
        return int((~there & ~tied & (values != 0)).sum())
