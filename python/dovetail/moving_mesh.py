"""The mesh in motion, at any phase of the period, of one sector or of all sectors of a wheel."""

from dataclasses import dataclass

import numpy as np

from . import fourier
from .cells import outer_faces
from .cyclic import about, turn
from .hdf5_read import numbers, opened
from .model_cyclic import read_cyclic
from .motion import find_model, nodal_displacement, read_model_parts
from .travelling_wave import TravellingWave

FACE = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}  # by the number of nodes
PHASES = 64  # at which the largest motion is looked for


@dataclass(frozen=True)
class MovingMesh:
    """Nodes, cells and motion of sector 0, or of a structure that is no sector.

    nodes : (k, 3); cells : dict of cell type to (m, width) rows of `nodes`; sets : dict of name to rows of `nodes`
    rows : (k,) which nodes of the model these are
    series : (2H+1, k, 3) Fourier coefficients of the total displacement, mean a0/2
    contact : (N_x,) rows of `nodes`, those of side a of the contact points, -1 where it is held; None where they are not known
    wave : TravellingWave or None; axis, origin : (3,) of the turn from sector to sector
    """

    nodes: np.ndarray
    cells: dict
    sets: dict
    rows: np.ndarray
    series: np.ndarray
    contact: np.ndarray | None = None
    wave: TravellingWave | None = None
    axis: np.ndarray | None = None
    origin: np.ndarray | None = None

    def places(self, sector=0):
        """(k, 3) nodes of a sector at rest, without load."""
        return about(self.nodes, self.origin, self.rotation(sector)) if sector else self.nodes

    def displacement(self, theta, sector=0, mean=True):
        """(k, 3) total displacement at a phase [rad], along the axes of the model; without its mean: how it vibrates."""
        basis = fourier.basis(len(self.series) // 2, theta - self.lag(sector))
        basis[0] *= mean
        u = np.tensordot(basis, self.series, 1)
        return u @ self.rotation(sector).T if sector else u

    def lag(self, sector):
        """By how much later [rad] a sector does what sector 0 does."""
        return 2 * np.pi * (sector * self.wave.engine_order % self.wave.sectors) / self.wave.sectors if sector else 0.0

    def amplitude(self):
        """(k,) largest distance of each node from its mean place within the period."""
        largest = np.zeros(len(self.nodes))
        for theta in fourier.phases(PHASES):
            largest = np.maximum(largest, np.linalg.norm(self.displacement(theta, mean=False), axis=1))
        return largest

    def rotation(self, sector):
        """(3, 3) turn from sector 0 to another."""
        return turn(self.axis, 2 * np.pi * sector / self.wave.sectors)


def moving_mesh(results, point, model=None, surface=False):
    """The MovingMesh of a point of the branch; with `surface` only of the outer faces. ValueError where its motion is not known."""
    path = find_model(results, model)
    mesh, _ = read_model_parts(path)
    if mesh is None:
        raise ValueError(f"{path}: has no mesh, so there is no motion to show")
    cells, rows = mesh["cells"], np.arange(len(mesh["nodes"]))
    if surface:
        faces = outer_faces(mesh["nodes"], cells)
        if not faces:
            raise ValueError(f"{path}: the mesh has no cells with faces, only {', '.join(sorted(cells)) or 'none'}")
        rows = np.unique(np.concatenate([face.ravel() for face in faces]))
        cells = {FACE[face.shape[1]]: np.searchsorted(rows, face) for face in faces}
    sets = {name: np.searchsorted(rows, np.intersect1d(nodes, rows)) for name, nodes in mesh["sets"].items()}
    samples = 2 * results.harmonics + 1  # as many as there are coefficients: they follow from them exactly
    u = nodal_displacement(results, point, rows, samples, model=path)
    basis = fourier.basis(results.harmonics, fourier.phases(samples))
    basis[:, 0] = 1.0  # a0 is twice the mean
    series = 2 / samples * np.tensordot(basis, u, (0, 0))
    with opened(path) as file:
        cyclic = read_cyclic(file)
        contact = _contact_rows(file, mesh, cyclic, rows)
    turned = {}
    if results.wave is not None:
        if cyclic is None or cyclic["sectors"] != results.wave.sectors:
            found = "no sector of a cyclic structure" if cyclic is None else f"one of {cyclic['sectors']} sectors"
            raise ValueError(f"{path}: is {found}, the results are of one of {results.wave.sectors}; name the model of this run")
        turned = {"wave": results.wave, "axis": cyclic["axis"], "origin": cyclic["origin"]}
    return MovingMesh(mesh["nodes"][rows], cells, sets, rows, series, contact, **turned)


def largest_at(mesh):
    """Phase [rad] at which the node that moves most of all is farthest from its mean place."""
    node = int(np.argmax(mesh.amplitude()))
    course = fourier.basis(len(mesh.series) // 2, fourier.phases(PHASES))
    course[:, 0] = 0.0
    return fourier.phases(PHASES)[np.argmax(np.linalg.norm(course @ mesh.series[:, node], axis=1))]


def _contact_rows(file, mesh, cyclic, rows):
    """`contact` of MovingMesh, from an open model file; a pair of nodes has one place, so only the model knows whose side a node is."""
    if cyclic is not None:
        nodes = cyclic["nodes"][:, 0]
        moves = nodes >= 0
    elif "contact/dofs" in file:
        nodes = mesh["dof_node"][numbers(file, "contact/dofs", (None, 3), "i")[:, 0]]
        moves = np.ones(len(nodes), bool)
    else:
        return None
    found = np.minimum(np.searchsorted(rows, nodes), len(rows) - 1)
    return np.where(moves, found, -1) if np.array_equal(rows[found[moves]], nodes[moves]) else None
