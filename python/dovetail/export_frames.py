"""Instants of a period as files of VTK, written by meshio, and the collection that ParaView plays.

Numbers have single precision, as pictures need no more; lengths, forces and energies are in units of the model.
"""

from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import numpy as np

from .contact_period import ContactPeriod
from .cyclic import about
from .fatigue import von_mises
from .life import Life
from .moving_mesh import MovingMesh
from .strains import PAIRS

ENERGY = "friction_energy"  # per period
MILLION = 1e6  # periods, of wear


@dataclass
class MeshFrames:
    """The mesh of some sectors: total displacement, what of it vibrates, its amplitude, which nodes are in which set, and stresses."""

    mesh: MovingMesh
    sectors: list
    life: Life | None = None

    def __post_init__(self):
        mesh, count = self.mesh, len(self.sectors)
        self.points = np.concatenate([mesh.places(sector) for sector in self.sectors])
        first = len(mesh.nodes) * np.arange(count)[:, None, None]
        self.cells = {kind: (first + rows).reshape(-1, rows.shape[1]) for kind, rows in mesh.cells.items() if len(rows)}
        if not self.cells:
            self.cells = {"vertex": np.arange(len(self.points))[:, None]}
        self.still = {"amplitude": np.tile(mesh.amplitude(), count), "node": np.tile(mesh.rows, count)}
        for name, rows in mesh.sets.items():
            inside = np.zeros(len(mesh.nodes), dtype=np.uint8)
            inside[rows] = 1
            self.still[f"set {name}"] = np.tile(inside, count)
        if mesh.wave is not None:
            self.still["sector"] = np.repeat(self.sectors, len(mesh.nodes))
        if self.life is not None:
            self.pair = self.life.of_nodes(mesh.rows)
            lasting = {"stress_mean": self.life.mean, "stress_amplitude": self.life.amplitude, "utilisation": self.life.utilisation}
            self.still |= {name: np.tile(self._at_nodes(values), count) for name, values in lasting.items() if values is not None}

    def fields(self, share):
        """Of an instant, at a share of the period."""
        theta = 2 * np.pi * share
        moving = {name: np.concatenate([self.mesh.displacement(theta, sector, mean) for sector in self.sectors])
                  for name, mean in (("displacement", True), ("vibration", False))}
        if self.life is not None:
            moving["stress"] = np.concatenate([self._stress(theta, sector) for sector in self.sectors])
            moving["von_mises"] = von_mises(moving["stress"])
        return moving | self.still

    def _stress(self, theta, sector):
        """(k, 6) of the nodes of a sector, along the axes of the model."""
        stress = self._at_nodes(self.life.stress.at(theta - self.mesh.lag(sector)))
        return turned(stress, self.mesh.rotation(sector)) if sector else stress

    def _at_nodes(self, values):
        """Values (P, ...) of pairs of node and material at the nodes, nan where there are none."""
        known = self.pair >= 0
        return np.where(known.reshape(-1, *[1] * (values.ndim - 1)), values[self.pair], np.nan)

    def in_words(self):
        kinds = ", ".join(f"{len(rows)} {kind}" for kind, rows in self.cells.items())
        return f"{_of(self.sectors, self.mesh.wave)}{len(self.points)} nodes; {kinds}"


@dataclass
class ContactFrames:
    """The contact points of some sectors, at their places at rest, and what they do; vectors along the axes of the model.

    position, normal : (N_x, 3); axes : (N_x, 3, 3) rows t1, t2, n; joint : (N_x,) number of the joint; area : (N_x,), 0 if not known
    frequency : periods per second [Hz]; wear : volume that a unit of friction work takes away, None if not asked for
    """

    position: np.ndarray
    axes: np.ndarray
    joint: np.ndarray
    area: np.ndarray
    period: ContactPeriod
    mesh: MovingMesh | None
    sectors: list
    frequency: float
    wear: float | None = None

    @classmethod
    def of(cls, joint, period, *others):
        """joint : as in `Model`."""
        return cls(joint["position"], joint["axes"], joint["joint"], joint["area"], period, *others)

    def __post_init__(self):
        count, number = len(self.sectors), np.arange(len(self.position))
        self.points = np.concatenate([about(self.position, self.mesh.origin, self.mesh.rotation(sector)) if sector else self.position
                                      for sector in self.sectors])
        self.cells = {"vertex": np.arange(len(self.points))[:, None]}
        period, per_area = self.period, bool(np.all(self.area > 0))
        still = {"contact": number + 1, "joint": self.joint, "slip_path": period.slip_path, ENERGY: period.energy,
                 "slip_share": period.slip, "open_share": period.open}
        if per_area:
            per = period.energy / self.area
            still |= {"area": self.area, f"{ENERGY}_per_area": per, "friction_power_per_area": per * self.frequency}
            if self.wear is not None:
                still["wear_depth_per_million_periods"] = MILLION * self.wear * per
        self.still = {name: np.tile(values, count) for name, values in still.items()}
        if self.mesh is not None and self.mesh.wave is not None:
            self.still["sector"] = np.repeat(self.sectors, len(number))
        self.still["normal"] = np.concatenate([self._turned(self.axes[:, 2], sector) for sector in self.sectors])

    def fields(self, share):
        """Of an instant, at a share of the period."""
        parts = [self._of_sector(share, sector) for sector in self.sectors]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]} | self.still

    def _of_sector(self, share, sector):
        period = self.period
        lag = self.mesh.lag(sector) / (2 * np.pi) if sector else 0.0
        i = period.at(share - lag)
        force, relative = period.force[:, i], period.relative[:, i]
        fields = {"state": period.state[:, i], "gap": period.gap[:, i], "normal_force": force[:, 2],
                  "friction_force": self._turned(np.einsum("pd,pdx->px", force[:, :2], self.axes[:, :2]), sector),
                  "relative_displacement": self._turned(np.einsum("pd,pdx->px", relative, self.axes), sector)}
        if np.all(self.area > 0):
            fields["pressure"] = force[:, 2] / self.area
            fields["shear"] = np.linalg.norm(force[:, :2], axis=1) / self.area
        if self.mesh is not None and self.mesh.contact is not None:
            for name, mean in (("displacement", True), ("vibration", False)):
                moved = self.mesh.displacement(2 * np.pi * share, sector, mean)[self.mesh.contact]
                fields[name] = np.where(self.mesh.contact[:, None] >= 0, moved, 0.0)
        return fields

    def _turned(self, vectors, sector):
        return vectors @ self.mesh.rotation(sector).T if sector else vectors

    def in_words(self):
        wave = None if self.mesh is None else self.mesh.wave
        return f"{_of(self.sectors, wave)}{len(self.points)} contact points"


def turned(tensors, R):
    """Tensors (..., 6) turned by R (3, 3)."""
    full = np.empty((*tensors.shape[:-1], 3, 3))
    for component, (i, j) in enumerate(PAIRS):
        full[..., i, j] = full[..., j, i] = tensors[..., component]
    full = R @ full @ R.T
    return np.stack([full[..., i, j] for i, j in PAIRS], axis=-1)


def _of(sectors, wave):
    if wave is None:
        return ""
    return f"all {wave.sectors} sectors, " if len(sectors) > 1 else f"sector {sectors[0]}, "


def write_instant(path, part, share, same=None):
    """A file of the instant at a share of the period; `same`: fields by name that have one value everywhere."""
    everywhere = {name: np.full(len(part.points), value) for name, value in (same or {}).items()}
    data = {name: _single(values) for name, values in (part.fields(share) | everywhere).items()}
    cells = [(kind, rows) for kind, rows in part.cells.items()]
    needed().Mesh(_single(part.points), cells, point_data=data).write(path, compression="zlib")


def write_list(folder, name, times, files):
    """NAME.pvd, by which ParaView plays files at their times."""
    sets = "\n".join(f'    <DataSet timestep="{time:.9g}" group="" part="0" file={quoteattr(file)}/>' for time, file in zip(times, files))
    (folder / f"{name}.pvd").write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
                                        f"{sets}\n  </Collection>\n</VTKFile>\n")


def needed():
    """The module meshio, or a ValueError that says how to get it."""
    try:
        import meshio
    except ImportError:
        raise ValueError("files for ParaView are written by meshio, which is not installed: apt install python3-meshio, or pip install "
                         "meshio") from None
    return meshio


def _single(values):
    """Floating point numbers in single precision, whole ones in 32 bits."""
    values = np.asarray(values)
    return values.astype({"f": np.float32, "i": np.int32}.get(values.dtype.kind, values.dtype))
