"""Stress at the nodes of a mesh over a period: from the cells around a node, of each material by itself."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from . import fourier, solids
from .material import UNKNOWN, Material
from .motion import find_model, nodal_displacement, read_model_parts
from .strains import cell_stress

BLOCK = 1 << 22  # numbers of displacement gradients in memory at a time
GIVEN = "given"  # name of a material that the model file does not have


@dataclass(frozen=True)
class NodalStress:
    """Stress of the P pairs of a node and a material of the cells around it: where materials meet, a node has several.

    node : (P,) rows of the nodes of the model; material : (P,) rows of `materials`, a list of Material
    series : (2H+1, P, 6) Fourier coefficients in time, mean a0/2; components as in `strains`, along the axes of the model
    left_out : dict of what has no stress, in words, to the number of cells
    """

    node: np.ndarray
    material: np.ndarray
    materials: list
    series: np.ndarray
    left_out: dict

    def without(self, nodes):
        """The same without some rows of nodes."""
        kept = ~np.isin(self.node, nodes)
        return replace(self, node=self.node[kept], material=self.material[kept], series=self.series[:, kept])

    def at(self, theta, mean=True):
        """(P, 6) at a phase [rad]; without the mean: what of it vibrates."""
        basis = fourier.basis(len(self.series) // 2, theta)
        basis[0] *= mean
        return np.tensordot(basis, self.series, 1)


def nodal_stress(results, point, model=None, material=None):
    """The NodalStress of a point of the branch, of sector 0 of a cyclic structure.

    Parameters
    ----------
    results : Results
    point : int
    model : path-like, optional
        Default: `motion.find_model`.
    material : Material, optional
        Of cells for which the model has none.

    Raises
    ------
    ValueError
        Where the motion of all nodes or the materials are not known.
    """
    mesh, U = stressed_mesh(results, point, model, material)
    return of_displacements(mesh, U)


def stressed_mesh(results, point, model=None, material=None):
    """The `mesh` of the model, with a material for all of its cells, and Fourier coefficients (2H+1, n_nodes, 3) of displacements."""
    path = find_model(results, model)
    mesh, _ = read_model_parts(path)
    if mesh is None:
        raise ValueError(f"{path}: has no mesh, so there are no stresses")
    mesh = mesh if material is None else _with(mesh, material)
    if not any((numbers != UNKNOWN).any() for numbers in mesh["material"].values()):
        raise ValueError(f"{path}: its cells have no material; say --material E NU here, or give the model one: with_material(E, nu) of "
                         "dovetail.Structure, or [[material]] in the set-up file of an import")
    samples = 2 * results.harmonics + 1  # as many as there are coefficients: they follow from them exactly
    try:
        u = nodal_displacement(results, point, n=samples, model=path)
    except ValueError as error:
        raise ValueError(f'{error}; stresses want the motion of all nodes: output.motion = "all" in the case file, and another '
                         "run") from None
    basis = fourier.basis(results.harmonics, fourier.phases(samples))
    basis[:, 0] = 1.0  # a0 is twice the mean
    return mesh, 2 / samples * np.tensordot(basis, u, (0, 0))


def of_displacements(mesh, U):
    """The NodalStress of displacements of nodes.

    Parameters
    ----------
    mesh : dict
        As in `Model`, checked.
    U : (c, n_nodes, 3)
        c fields, such as Fourier coefficients.
    """
    materials, left_out = mesh["materials"], {}
    count = max(len(materials), 1)
    parts, keys = [], []
    for kind, rows in mesh["cells"].items():
        number = mesh["material"][kind]
        if kind not in solids.SHAPE:
            _leave(left_out, kind, len(rows))
            continue
        _leave(left_out, f"{kind} without material", np.count_nonzero(number == UNKNOWN))
        for how in np.unique(mesh["integration"][kind]):
            mine = np.flatnonzero((number != UNKNOWN) & (mesh["integration"][kind] == how))
            if (kind, how) not in solids.POINTS:
                _leave(left_out, f"{kind} with integration {solids.INTEGRATION[how]}", len(mine))
            elif mine.size:
                parts.append((kind, how, rows[mine], number[mine]))
                keys.append((rows[mine] * count + number[mine][:, None]).ravel())
    if not parts:
        raise ValueError("there are no solid cells with a material, so there are no stresses; without are "
                         + ", ".join(f"{number} {what}" for what, number in left_out.items()))
    pairs = np.unique(np.concatenate(keys))
    total, cells = np.zeros((len(U), len(pairs), 6)), np.zeros(len(pairs))
    for (kind, how, rows, number), key in zip(parts, keys):
        young, poisson = (np.array([getattr(one, name) for one in materials])[number] for name in ("young", "poisson"))
        place = np.searchsorted(pairs, key).reshape(rows.shape)
        cells += np.bincount(place.ravel(), minlength=len(pairs))
        step = max(1, BLOCK // (9 * len(U) * len(solids.POINTS[kind, how])))
        for begin in range(0, len(rows), step):
            some = slice(begin, begin + step)
            values = cell_stress(kind, how, mesh["nodes"][rows[some]], U[:, rows[some]], young[some], poisson[some])
            gather = sp.csr_matrix((np.ones(place[some].size), (place[some].ravel(), np.arange(place[some].size))),
                                   shape=(len(pairs), place[some].size))
            total += np.stack([gather @ field.reshape(-1, 6) for field in values])
    return NodalStress(pairs // count, pairs % count, materials, total / cells[:, None], left_out)


def _leave(left_out, what, number):
    if number:
        left_out[what] = left_out.get(what, 0) + int(number)


def _with(mesh, material):
    """The mesh with a material for cells that have none."""
    number = len(mesh["materials"])
    return {**mesh, "materials": [*mesh["materials"], material],
            "material": {kind: np.where(numbers == UNKNOWN, number, numbers) for kind, numbers in mesh["material"].items()}}


def given_material(words):
    """The Material of two numbers of a command line, E and nu; None for None."""
    return None if words is None else Material(*words, name=GIVEN)
