"""A structure as one of N equal sectors."""

import copy

import numpy as np
from numpy.typing import ArrayLike

from .cyclic import matched
from .cyclic_contacts import contacts_of
from .cyclic_dofs import pairs_of
from .loaded import PRELOAD

ALONG = 1e-9  # of an acceleration: what may act across the axis


class CyclicStructure:
    """The part of `Structure` that makes it a sector."""

    cyclic_sector = None  # Cyclic, once `cyclic` is called
    sector_of_deck = None  # importers.deck_sector.DeckSector, where an imported deck has cyclic symmetry

    def cyclic(self, sectors: int, left: str | ArrayLike, right: str | ArrayLike, axis: ArrayLike, *, origin: ArrayLike = (0, 0, 0),
               tolerance: float | None = None) -> "CyclicStructure":
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
        self._need_inertia_along_axis()
        sector = self.cyclic_sector
        left, right = pairs_of(self)
        return {"sectors": sector.sectors, "axis": sector.axis, "origin": sector.origin, "left": left, "right": right,
                **contacts_of(joints, self)}

    def _need_inertia_along_axis(self):
        """In the turned axes of another sector, weight and base motion across the axis have other directions."""
        axis = self.cyclic_sector.axis
        for name, acceleration in self.inertia.items():
            if np.linalg.norm(acceleration - (acceleration @ axis) * axis) > ALONG * np.linalg.norm(acceleration):
                what = f"weight under {acceleration.tolist()}" if name is PRELOAD else f"base motion {name!r} along {acceleration.tolist()}"
                raise ValueError(f"the {what} is not the same on every sector; it must act along the axis, "
                                 f"({', '.join(f'{value + 0.0:.6g}' for value in axis)})")
