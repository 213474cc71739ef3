"""A structure as one of N equal sectors."""

import copy

from .cyclic import matched
from .cyclic_contacts import contacts_of
from .cyclic_dofs import pairs_of


class CyclicStructure:
    """The part of `Structure` that makes it a sector."""

    cyclic_sector = None  # Cyclic, once `cyclic` is called
    sector_of_deck = None  # importers.deck_sector.DeckSector, where an imported deck has cyclic symmetry

    def cyclic(self, sectors, left, right, axis, *, origin=(0, 0, 0), tolerance=None):
        """As one of N equal sectors of a disk, K and M being those of its own elements only. Before surfaces are taken for joints.

        Parameters
        ----------
        sectors : int
            N, so many make the disk.
        left, right : name of a set, list of names, or (k,) array of node rows
            The nodes where the sector meets its neighbours: right is left turned by +2 pi / N about the axis.
        axis, origin : (3,) array
            Direction of the axis, and a point on it [m]. The turn follows the right-hand rule.
        tolerance : float, optional
            How far apart partners may lie [m], default 1e-6 of the size of the structure.

        Raises
        ------
        ValueError
            When a node has no partner. What is clamped at the sides is checked by `join`.
        """
        result = copy.copy(self)
        result.cyclic_sector = matched(self, sectors, left, right, axis, origin, tolerance)
        return result

    def _cyclic(self, joints):
        """The `cyclic` of Model. Collective for PETSc."""
        sector = self.cyclic_sector
        left, right = pairs_of(self)
        return {"sectors": sector.sectors, "axis": sector.axis, "origin": sector.origin, "left": left, "right": right,
                **contacts_of(joints, self)}
