"""Displacements that equations give from others: forces on them act on those others."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp


@dataclass(frozen=True)
class Followers:
    """Directions of nodes that are no unknowns, because equations tie them to unknowns.

    table : (n_nodes, 3) int, row in `motion`, -1 for directions that follow no equation
    motion : (t, n) SciPy CSR, displacement of each by the unknowns
    """

    table: np.ndarray
    motion: sp.csr_matrix

    @classmethod
    def none(cls, nodes, n):
        return cls(np.full((nodes, 3), -1), sp.csr_matrix((0, n)))

    def kept(self, dofs):
        """Where only some of the unknowns are left, the others being held."""
        return replace(self, motion=self.motion[:, dofs])

    def force(self, nodes, axes, values):
        """(n,) of forces (k,) on directions (k,) of nodes (k,); those that follow no equation are left out."""
        rows = self.table[nodes, axes]
        known = rows >= 0
        on = np.zeros(self.motion.shape[0], dtype=np.asarray(values).dtype)
        np.add.at(on, rows[known], np.asarray(values)[known])
        return self.motion.T @ on


def from_equations(equations, number, held):
    """Followers by equations sum c u = 0, the first term of each being the one that follows.

    Parameters
    ----------
    equations : list of lists of (node row, direction from 0, coefficient)
    number : (n_nodes, 6) int, unknown of each direction, -1 for none
    held : (n_nodes, 6) bool

    An equation is passed over when one of its terms is neither an unknown, nor held, nor the first of another equation.
    """
    n = int(number.max(initial=-1)) + 1
    first = {terms[0][:2]: row for row, terms in enumerate(equations) if number[terms[0][:2]] < 0 and not held[terms[0][:2]]}
    usable = dict(first)
    while True:
        bad = [place for place, row in usable.items()
               if any(number[term[:2]] < 0 and not held[term[:2]] and term[:2] not in usable for term in equations[row][1:])]
        if not bad:
            break
        for place in bad:
            del usable[place]
    place_of = {place: i for i, place in enumerate(usable)}
    direct, among = ([], [], []), ([], [], [])
    for i, row in enumerate(usable.values()):
        (_, _, leading), *others = equations[row]
        for node, direction, coefficient in others:
            target, column = (direct, number[node, direction]) if number[node, direction] >= 0 else (among, place_of.get((node, direction)))
            if column is not None:
                for part, value in zip(target, (-coefficient / leading, i, column)):
                    part.append(value)
    t = len(usable)
    term = total = sp.csr_matrix((direct[0], (direct[1], direct[2])), shape=(t, n))
    chain = sp.csr_matrix((among[0], (among[1], among[2])), shape=(t, t))
    for _ in range(t):
        term = chain @ term
        if term.nnz == 0:
            break
        total = total + term
    table = np.full((len(number), 3), -1)
    for (node, direction), i in place_of.items():
        if direction < 3:
            table[node, direction] = i
    return Followers(table, sp.csr_matrix(total))
