"""A piece of the outer surface of a structure: nodes, their dofs, and the faces between them."""

from dataclasses import dataclass, field, replace

import numpy as np

from . import faces as face_kinds


@dataclass(frozen=True)
class Surface:
    """One side of a joint.

    Parameters
    ----------
    points : (m, 3) array [m]
    dofs : (m, 3) int array
        Numbers of the x, y, z dof of each node, -1 where it was removed (clamped).
    faces : list of (f, k) int arrays
        Rows of `points`, k = 3, 4, 6 or 8: corner nodes first, counter-clockwise seen from outside, then mid-side nodes.
    name : str
    labels : (m,) int array, optional
        What the nodes are called in messages; default their rows.
    cyclic : dovetail.cyclic.Cyclic, optional
        The sector it belongs to; `Structure.surface` gives it.
    """

    points: np.ndarray
    dofs: np.ndarray
    faces: list = field(default_factory=list)
    name: str = "surface"
    labels: np.ndarray = None
    cyclic: object = None

    def __post_init__(self):
        def keep(name, value):
            object.__setattr__(self, name, value)

        keep("points", np.asarray(self.points, dtype=np.float64))
        keep("dofs", np.asarray(self.dofs, dtype=np.int64))
        keep("faces", [np.asarray(rows, dtype=np.int64) for rows in self.faces])
        keep("labels", np.arange(len(self.points)) if self.labels is None else np.asarray(self.labels))
        m = len(self.points)
        if m == 0 or self.points.shape != (m, 3) or self.dofs.shape != (m, 3) or self.labels.shape != (m,):
            raise ValueError(f"surface {self.name!r} must have points (m, 3), dofs (m, 3) and labels (m,) with m > 0, found shapes "
                             f"{self.points.shape}, {self.dofs.shape} and {self.labels.shape}")
        for rows in self.faces:
            if rows.ndim != 2 or rows.shape[1] not in face_kinds.NODES:
                raise ValueError(f"surface {self.name!r} must have faces (f, k) with k = 3, 4, 6 or 8, found shape {rows.shape}")
            if rows.size and not 0 <= rows.min() <= rows.max() < m:
                raise ValueError(f"surface {self.name!r} must have faces of points 0 to {m - 1}, found {rows.min()} to {rows.max()}")

    def in_next_sector(self) -> "Surface":
        """The same surface of the next sector; dofs stay those of this one."""
        if self.cyclic is None:
            raise ValueError(f"surface {self.name!r} is that of a structure that is not cyclic, so there is no next sector; say "
                             "structure.cyclic(...) before taking surfaces, or [cyclic] in the set-up file")
        return replace(self, points=self.cyclic.to_next(self.points), name=f"{self.name} of the next sector")

    @property
    def size(self) -> float:
        """Diagonal of the box around the surface [m]."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    def areas(self) -> np.ndarray:
        """Tributary area (m,) [m^2] of each node, positive; together they are the area of the surface."""
        self._need_faces("an area")
        areas = np.zeros(len(self.points))
        for rows in self.faces:
            np.add.at(areas, rows, face_kinds.node_areas(self.points[rows]))
        return areas

    def area_vectors(self) -> np.ndarray:
        """Tributary areas (m, 3) [m^2] along the outward normals of the faces around each node."""
        self._need_faces("a normal")
        total = np.zeros((len(self.points), 3))
        for rows in self.faces:
            X, k = self.points[rows], rows.shape[1]
            areas = face_kinds.node_areas(X)
            for i, xi in enumerate(face_kinds.NODES[k]):
                np.add.at(total, rows[:, i], areas[:, [i]] * face_kinds.normals(X, np.tile(xi, (len(X), 1))))
        return total

    def normals(self) -> np.ndarray:
        """Outward unit normals (m, 3) at the nodes: those of the faces around, weighted by area."""
        total = self.area_vectors()
        length = np.linalg.norm(total, axis=1)
        bad = np.flatnonzero(length <= 0)
        if bad.size:
            raise ValueError(f"surface {self.name!r}: no normal at node {self.labels[bad[0]]}, which has no face or faces that "
                             "look in opposite directions")
        return total / length[:, None]

    def _need_faces(self, what):
        if not any(len(rows) for rows in self.faces):
            raise ValueError(f"surface {self.name!r} has no faces, so its nodes have no {what.split()[-1]}; give faces, or cells "
                             "of which the set holds whole outer faces")
