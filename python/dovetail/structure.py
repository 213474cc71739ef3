"""A finite-element structure with its mesh, before joints are marked.

    structure = Structure(K, M, nodes, dof_node, dof_direction, cells=..., node_sets=...)
    structure = structure.clamped("bottom").with_force("tip", [0, 1, 0])
    joint = Joint.between(structure.surface("upper"), structure.surface("lower"), normal_stiffness=..., ...)
    structure.join([joint]).write("model.h5")
"""

import copy
import difflib

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from . import cells as cell_kinds
from . import hdf5_parts
from .cyclic_structure import CyclicStructure
from .damping_matrices import DampingMatrices
from .followers import Followers
from .loaded import Loaded, is_zero, said_of
from .loads import real_vector
from .material import Material, of_cells
from .model import Model
from .parameters import CONTACT_WIDTH
from .relative import change_of
from .sparse_rows import is_petsc
from .surface import Surface


class Structure(Loaded, CyclicStructure, DampingMatrices):
    """K and M of a structure, the place and direction of every dof, and named parts of the mesh.

    Parameters
    ----------
    K, M : scipy sparse or petsc4py AIJ Mat, (n, n)
        Stiffness [N/m] and mass [kg], symmetric, both triangles. SciPy matrices are whole on every rank, PETSc ones distributed.
    nodes : (n_nodes, 3) array [m]
        This and all that follows, but for loads, is whole on every rank.
    dof_node : (n,) int
        Row in `nodes` of each dof, -1 if it belongs to none.
    dof_direction : (n,) int
        0, 1, 2 for displacements along x, y, z; 3, 4, 5 for rotations about them; -1 for others.
    labels : (n_nodes,) int, optional
        Node numbers of the program the mesh comes from, for messages; default rows.
    cells : dict, optional
        meshio cell type to (m, k) node rows, in VTK order.
    node_sets : dict, optional
        Name to (k,) node rows.
    surfaces : dict, optional
        Name to a list of (f, k) arrays of node rows: faces, k = 3, 4, 6, 8, corner nodes first, counter-clockwise seen from outside.
    force, preload : (n,) array or petsc4py Vec, optional
        F and P of eq (1) [N], default zero.
    units : str
    comm : mpi4py communicator, optional
        As in `Model`.
    """

    def __init__(self, K, M, nodes, dof_node, dof_direction, *, labels=None, cells=None, node_sets=None, surfaces=None, force=None,
                 preload=None, units="SI", comm=None):
        if comm is None:
            comm = K.getComm().tompi4py() if is_petsc(K) else hdf5_parts.default_comm()
        self.K, self.M, self.units, self.comm = _two_sided(K), _two_sided(M), str(units), comm
        self.n = int((K.getSize() if is_petsc(K) else np.shape(K))[0])
        self.nodes = np.asarray(nodes, dtype=np.float64)
        if self.nodes.ndim != 2 or self.nodes.shape[1] != 3:
            raise ValueError(f"nodes must have shape (n_nodes, 3), found {self.nodes.shape}")
        if (lost := np.flatnonzero(~np.isfinite(self.nodes).all(axis=1))).size:
            raise ValueError(f"nodes must have finite places, found {self.nodes[lost[0]]} in row {lost[0]}")
        count = len(self.nodes)
        self.dof_node, self.dof_direction = np.asarray(dof_node, dtype=np.int64), np.asarray(dof_direction, dtype=np.int64)
        for name, values, top in (("dof_node", self.dof_node, count), ("dof_direction", self.dof_direction, 6)):
            if values.shape != (self.n,) or (self.n and not -1 <= values.min() <= values.max() < top):
                raise ValueError(f"{name} must have one entry from -1 to {top - 1} per degree of freedom ({self.n}), found shape "
                                 f"{values.shape}" + (f", values {values.min()} to {values.max()}" if values.size else ""))
        self.labels = np.arange(count) if labels is None else np.asarray(labels)
        if self.labels.shape != (count,):
            raise ValueError(f"labels must have one entry per node ({count}), found shape {self.labels.shape}")
        self.cells = {cell_kinds.ALIASES.get(kind, kind): np.asarray(rows, dtype=np.int64) for kind, rows in (cells or {}).items()}
        self.node_sets = {str(name): np.asarray(rows, dtype=np.int64).reshape(-1) for name, rows in (node_sets or {}).items()}
        self.surfaces = {str(name): [np.asarray(rows, dtype=np.int64) for rows in faces] for name, faces in (surfaces or {}).items()}
        named = [(f"cells {kind!r}", rows) for kind, rows in self.cells.items()]
        named += [(f"node set {name!r}", rows) for name, rows in self.node_sets.items()]
        named += [(f"surface {name!r}", rows) for name, faces in self.surfaces.items() for rows in faces]
        for name, rows in named:
            if rows.size and not 0 <= rows.min() <= rows.max() < count:
                raise ValueError(f"{name} must name nodes 0 to {count - 1}, found {rows.min()} to {rows.max()}")
        self.materials, self.material, self.integration = [], {}, {}  # of cells, as `mesh` of Model has them
        self.damping = {}  # keys of [damping] that an import has found
        self.force, self.preload = self._load(force, "force"), self._load(preload, "preload")
        self.forces, self.courses = {}, {}  # further load patterns, and the series [a0, a1, b1, ...] of all that were added
        self.followers, self.tied_sets = Followers.none(count, self.n), {}  # importers know equations, and sets of nodes tied by them
        self.held_by_deck = False  # nodes that the matrices do not have, being held; nor the mass they share with their neighbours
        self.steps = {}  # loads of static steps of a deck, by number of the step

    def surface(self, name: str) -> Surface:
        """The surface of that name, or the outer cell faces all of whose nodes are in the node set of that name.

        A node set without any such face gives a Surface of its nodes, without faces.
        """
        if name in self.surfaces:
            faces = self.surfaces[name]
        else:
            rows = self._set(name, "surface or node set")
            inside = np.zeros(len(self.nodes), dtype=bool)
            inside[rows] = True
            faces = cell_kinds.outer_faces(self.nodes, self.cells, inside)
        if any(len(rows) for rows in faces):
            used = np.unique(np.concatenate([rows.ravel() for rows in faces]))
        else:
            used, faces = np.unique(self._set(name, "surface or node set")), []
        if used.size == 0:
            raise ValueError(f"surface {name!r} is empty")
        number = np.full(len(self.nodes), -1)
        number[used] = np.arange(used.size)
        return Surface(self.nodes[used], self.dofs_of(used), [number[rows] for rows in faces if len(rows)], name, self.labels[used],
                       self.cyclic_sector)

    def dofs_of(self, rows: ArrayLike) -> np.ndarray:
        """(k, 3) numbers of the x, y, z dofs of nodes, -1 where there is none."""
        table = np.full((len(self.nodes), 3), -1)
        known = np.flatnonzero((self.dof_node >= 0) & (self.dof_direction >= 0) & (self.dof_direction < 3))
        table[self.dof_node[known], self.dof_direction[known]] = known
        return table[rows]

    def clamped(self, where: str | ArrayLike, directions: str = "xyz") -> "Structure":
        """Without the dofs of some nodes.

        Parameters
        ----------
        where : name of a set, list of names, or (k,) array of node rows
        directions : str
            Any of x, y, z; with all three the rotations of the nodes go too.
        """
        wrong = set(directions) - set("xyz")
        if wrong or not directions:
            raise ValueError(f"directions must be some of x, y, z, found {directions!r}")
        held = ["xyz".index(d) for d in directions]
        if len(set(held)) == 3:
            held += [3, 4, 5]
        removed = np.isin(self.dof_node, self._nodes(where)) & np.isin(self.dof_direction, held) & (self.dof_node >= 0)
        if not removed.any():
            raise ValueError(f"nothing to clamp: the nodes of {said_of(where)} have no dofs in {directions} (any more)")
        kept = np.flatnonzero(~removed)
        result = copy.copy(self)
        result.n = len(kept)
        result.dof_node, result.dof_direction = self.dof_node[kept], self.dof_direction[kept]
        if is_petsc(self.K):
            from petsc4py import PETSc

            begin, end = self.K.getOwnershipRange()
            own = kept[(kept >= begin) & (kept < end)].astype(PETSc.IntType)
            index = PETSc.IS().createGeneral(own, comm=self.K.getComm())
            result._each_matrix(lambda matrix: matrix.createSubMatrix(index, index))
        else:
            result._each_matrix(lambda matrix: sp.csr_matrix(matrix)[kept][:, kept])
        result.force, result.preload = (self._kept(load, kept, result) for load in (self.force, self.preload))
        result.forces = {name: self._kept(load, kept, result) for name, load in self.forces.items()}
        result.steps = {step: self._kept(load, kept, result) for step, load in self.steps.items()}
        result.followers = self.followers.kept(kept)
        return result

    def with_springs(self, where: str | ArrayLike, stiffness: ArrayLike) -> "Structure":
        """With springs to the ground: `stiffness` (3,) [N/m] along x, y, z in all, in equal shares on the nodes of a set.

        As in `clamped`, `where` names nodes; a share on a direction without a dof is left out.
        """
        stiffness = real_vector(stiffness, "stiffness", "N/m")
        if np.any(stiffness < 0) or not np.any(stiffness):
            raise ValueError(f"stiffness must not be negative, nor all zero, found {stiffness.tolist()}")
        rows = np.unique(self._nodes(where))
        dofs = self.dofs_of(rows)
        free = (dofs >= 0) & (stiffness > 0)
        if not free.any():
            raise ValueError(f"no node of {said_of(where)} can take a spring: none has a free dof in its direction")
        diagonal = np.zeros(self.n)
        np.add.at(diagonal, dofs[free], np.tile(stiffness / len(rows), (len(rows), 1))[free])
        result = copy.copy(self)
        if is_petsc(self.K):
            result.K = self.K.copy()
            vector = result.K.getDiagonal()
            vector.setArray(vector.getArray() + diagonal[slice(*vector.getOwnershipRange())])
            result.K.setDiagonal(vector)
        else:
            result.K = sp.csr_matrix(self.K) + sp.diags(diagonal)
        return result

    def with_material(self, young: float, poisson: float, density: float = 0.0, *, name: str = "material",
                      where: str | ArrayLike | None = None) -> "Structure":
        """With the material of cells, for stresses; K and M stay as they are.

        Parameters
        ----------
        young, poisson, density : float
            Young's modulus [Pa], Poisson's ratio, density [kg/m^3].
        name : str
        where : as in `clamped`, optional
            The cells all of whose nodes are among these; default all.
        """
        inside = None
        if where is not None:
            inside = np.zeros(len(self.nodes), dtype=bool)
            inside[self._nodes(where)] = True
        result = copy.copy(self)
        result.materials = [*self.materials, Material(float(young), float(poisson), float(density), str(name))]
        result.material, count = of_cells(self.material, self.cells, len(self.materials), inside)
        if not count:
            raise ValueError("there are no cells that could have a material" if where is None else
                             f"there is no cell with all of its nodes among those of {said_of(where)}")
        return result

    def _with_matrix(self, name, matrix):
        size = self.n if matrix is None else (matrix.getSize() if is_petsc(matrix) else np.shape(matrix))[0]
        if size != self.n:
            raise ValueError(f"K and {name} must have the same size, found {self.n} and {size}")
        if matrix is not None and is_petsc(matrix) != is_petsc(self.K):
            raise ValueError(f"{name} must be of the same kind as K, {type(self.K).__name__}, found {type(matrix).__name__}")
        result = copy.copy(self)
        setattr(result, name, None if matrix is None else _two_sided(matrix))
        return result

    def _each_matrix(self, change):
        for name in ("K", "M", "C", "K_structural"):
            if (matrix := getattr(self, name)) is not None:
                setattr(self, name, change(matrix))

    def join(self, joints: list, *, motion_sets: bool = True) -> Model:
        """The model with the contact points of all joints, in their order: K' = T^T K T and so on, loads T^T f. Collective.

        Parameters
        ----------
        joints : list of Joint, or one Joint
        motion_sets : bool
            Pass the node sets on to the model file.
        """
        joints = list(joints) if isinstance(joints, (list, tuple)) else [joints]
        if not joints:
            raise ValueError("a model needs at least one joint, found none")
        for joint in joints:
            self._need_ours(joint)
        number = np.repeat(np.arange(len(joints)), [len(joint) for joint in joints])
        mesh = {"nodes": self.nodes, "cells": self.cells, "dof_node": self.dof_node, "dof_direction": self.dof_direction,
                "sets": self.node_sets if motion_sets else {}, "materials": self.materials, "material": self.material,
                "integration": self.integration}
        if self.cyclic_sector is None:
            change = change_of(joints, self.n)
            mesh["changed"] = {"dof": change.dof, "begin": change.rows.indptr, "column": change.rows.indices, "value": change.rows.data}
            matrix, load = change.apply, lambda values: change.apply_load(values, self.K)
            points = {"contact_dofs": np.concatenate([joint.contact_dofs for joint in joints])}
        else:
            matrix = load = _as_it_is
            points = {"contact_dofs": None, "cyclic": self._cyclic(joints)}
        stacked = {key: np.concatenate([getattr(joint, key) for joint in joints]) for key in ("position", "axes", "area")}
        force, forces = load(self.force), {name: load(values) for name, values in self.forces.items()}
        model = Model(matrix(self.K), matrix(self.M), force=None if forces and is_zero(self.force) else force, preload=load(self.preload),
                      contact=_contact(joints), mesh=mesh, units=self.units, comm=self.comm, forces=forces, **points,
                      joint={**stacked, "joint": number, "names": [joint.name for joint in joints]},
                      **{name: matrix(values) for name in ("C", "K_structural") if (values := getattr(self, name)) is not None})
        model.courses, model.damping = self.courses, self.damping
        return model

    def _need_ours(self, joint):
        """The dofs of a joint must be ours: it may have been made before clamping, which renumbers."""
        if joint.next_sector and self.cyclic_sector is None:
            raise ValueError(f"joint {joint.name!r} leads to the next sector, and this structure is not cyclic; say "
                             "structure.cyclic(...) before taking surfaces")
        own = joint.contact_dofs
        dofs = np.concatenate([own.ravel(), joint.other[joint.other >= 0].ravel()])
        fits = dofs.max(initial=-1) < self.n and np.array_equal(self.dof_direction[own], np.tile(np.arange(3), (len(own), 1)))
        if fits:
            held = joint.dofs[:, 0] < 0
            fits = np.allclose(self.nodes[self.dof_node[own[~held, 0]]], joint.position[~held], rtol=0, atol=1e-12 * _size(self.nodes))
        if not fits:
            raise ValueError(f"joint {joint.name!r} was not made from the surfaces of this structure; clamp first, then take surfaces and "
                             "make joints, for clamping renumbers the degrees of freedom")

    def _load(self, load, name):
        """As a Vec distributed like K when K is a PETSc matrix, else as an array (n,)."""
        if is_petsc(load):
            size = load.getSize()
        else:
            load = np.zeros(self.n) if load is None else np.array(load, dtype=np.float64).reshape(-1)
            size = load.size
        if size != self.n:
            raise ValueError(f"{name} must have one entry per degree of freedom, {self.n}, found {size}")
        if is_petsc(self.K) and not is_petsc(load):
            vector = self.K.createVecRight()
            vector.setArray(load[slice(*vector.getOwnershipRange())])
            return vector
        if is_petsc(load) and not is_petsc(self.K):
            raise ValueError(f"{name} is a PETSc vector, so K must be a PETSc matrix, found {type(self.K).__name__}")
        return load

    @staticmethod
    def _kept(load, kept, result):
        if not is_petsc(load):
            return load[kept]
        vector = result.K.createVecRight()
        begin, end = load.getOwnershipRange()
        vector.setArray(load.getArray()[kept[(kept >= begin) & (kept < end)] - begin])
        return vector

    def _nodes(self, where):
        if isinstance(where, str):
            if where in self.surfaces and where not in self.node_sets:
                return np.unique(np.concatenate([rows.ravel() for rows in self.surfaces[where]]))
            return self._set(where, "node set or surface")
        where = list(where)
        if where and all(isinstance(name, str) for name in where):
            return np.concatenate([self._nodes(name) for name in where])
        rows = np.asarray(where, dtype=None if where else np.int64)
        if not np.issubdtype(rows.dtype, np.integer) or (rows.size and not 0 <= rows.min() <= rows.max() < len(self.nodes)):
            raise ValueError(f"node rows must be whole numbers from 0 to {len(self.nodes) - 1}")
        return rows

    def _set(self, name, kind):
        if name not in self.node_sets:
            known = sorted({*self.node_sets, *self.surfaces})
            close = difflib.get_close_matches(str(name), known, 1)
            hint = f"; did you mean {close[0]!r}?" if close else f"; there are {', '.join(known) or 'none'}"
            raise ValueError(f"no {kind} {name!r}{hint}")
        return self.node_sets[name]


def _as_it_is(thing):
    """A sector keeps its own unknowns: those of its joints depend on the nodal diameter."""
    return thing


def _two_sided(matrix):
    """PETSc types that hold one triangle, or blocks, as AIJ; the rest as it is."""
    if is_petsc(matrix) and matrix.getType() not in ("seqaij", "mpiaij"):
        return matrix.convert("aij", type(matrix)())
    return matrix


def _contact(joints):
    """The parameters of all joints, one row per contact point; given for all joints or for none."""
    contact = {}
    for key in CONTACT_WIDTH:  # in the same order on every rank
        if not any(key in joint.contact for joint in joints):
            continue
        without = [joint.name for joint in joints if key not in joint.contact]
        if without:
            raise ValueError(f"joint {without[0]!r} has no {key}, other joints have; give it for all, or for none and in the case file")
        contact[key] = np.concatenate([joint.contact[key] for joint in joints])
    return contact


def _size(nodes):
    return float(np.linalg.norm(np.ptp(nodes, axis=0))) if len(nodes) else 0.0
