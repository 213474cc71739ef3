"""Build, check and write a full model: the input of `dovetail run`.

The model is equation (1) of docs/theory/equations.md,

    M u'' + xi K u' + K u + [0; g(x_c)] = F f(t) + P,

without xi and f(t), which belong to the case file; and the damping matrices C and K_structural, which the case file takes or leaves.
"""

import copy
from pathlib import Path

import h5py
import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from . import hdf5_parts, model_cyclic, model_mesh
from .damping_matrices import DampingMatrices
from .hdf5_parts import Part
from .hdf5_read import members, numbers, opened, whole, words
from .loads import excitation, need_name
from .parameters import CONTACT_WIDTH, contact_parameters
from .sparse_rows import even_range, fault, is_petsc, rows_of


class Model(DampingMatrices):
    """A structure with contact points, before any reduction.

    Parameters
    ----------
    K, M : scipy sparse, numpy or petsc4py Mat, (n, n)
        Stiffness [N/m] and mass [kg], symmetric, both triangles. SciPy matrices are whole on every rank, PETSc ones distributed.
    contact_dofs : (N_x, 3) int
        Zero-based indices of t1, t2, n of each contact point; positive n closes the gap. None for a cyclic model.
    force, preload : (n,) array or petsc4py Vec, optional
        F, the amplitude of the excitation, and P, the static load [N]. Default zero.
    C, K_structural : as K and M, optional
        Viscous damping [N s/m], which `damping.matrix = true` takes, and what the loss factor `damping.structural` is of, in place of
        K [N/m].
    forces : dict, optional
        Further load patterns by name, (n,) arrays or petsc4py Vecs [N], each with its own course in the case file. With these and
        without `force` there is no pattern "force".
    contact : dict, optional
        Any of `normal_stiffness`, `gap` (a number or one per point) and `tangential_stiffness`, `friction` (a number,
        [t1, t2], or one such pair per point). The case file can override them.
    mesh : dict, optional
        `nodes` (n_nodes, 3) [m]; `cells`, a dict of meshio cell type to (m, k) node rows in VTK order; `dof_node` (n,), the node of
        each dof, -1 for none; `dof_direction` (n,), 0 to 2 for displacements, 3 to 5 for rotations, -1 for others. Optional `sets`,
        a dict of name to node rows, and `changed`, the dofs that are no unknowns any more: `dof` (c,), `begin` (c+1,), `column`,
        `value`, with u[dof[i]] = sum of value[j] q[column[j]] for j from begin[i] to begin[i+1]. For stresses
        `materials`, a list of `material.Material`, `material`, a dict of cell type to (m,) rows of that list, -1 where there is none, and
        `integration`, likewise a number of `solids.INTEGRATION`. `Structure.with_material` gives them.
    joint : dict, optional
        `position` (N_x, 3) [m], `axes` (N_x, 3, 3) with rows t1, t2, n, `area` (N_x,) [m^2], `joint` (N_x,) number of the joint
        from 0, `names` of the joints. `Structure.join` gives it, as it gives `mesh`.
    cyclic : dict, optional
        That K and M are those of one of N equal sectors: `sectors`, `axis`, `origin`, `left`, `right`, `next_sector`, `nodes`, `faces` as
        the model file has them (docs/reference/files.md). `Structure.join` gives it.
    units : str
        Shown in messages and plots.
    comm : mpi4py communicator, optional
        Default: that of K when it is a PETSc matrix, else all ranks under mpirun, else this process.

    Raises
    ------
    ValueError
        On every rank, when anything above does not hold.
    """

    def __init__(self, K, M, contact_dofs, force=None, preload=None, contact=None, mesh=None, joint=None, units="SI",
                 comm=None, forces=None, C=None, K_structural=None, cyclic=None):
        if comm is None:
            comm = K.getComm().tompi4py() if is_petsc(K) else hdf5_parts.default_comm()
        self.K, self.M, self.units, self.comm = K, M, str(units), comm
        self._rows = {}
        self._take("K", K)
        self.n = self._rows["K"].n
        self._take("M", M)
        for name, matrix in (("C", C), ("K_structural", K_structural)):
            if matrix is not None:
                self._take(name, matrix)
        self.mesh = model_mesh.checked_mesh(mesh, self.n) if mesh else None
        self.cyclic = None if cyclic is None else model_cyclic.checked_cyclic(cyclic, self.n, self.mesh, joint)
        if cyclic is not None and contact_dofs is not None:
            raise ValueError("a cyclic model has no contact_dofs, its contact points are given by nodes; leave one of both out")
        self.contact_dofs = None if cyclic is not None else _contact_dofs(contact_dofs, self.n)
        self.forces = {name: self._load(load, name) for name, load in load_patterns(forces).items()}
        self.force = None if force is None and self.forces else self._load(force, "force")
        self.preload = self._load(preload, "preload")
        self.damping = {}  # keys of [damping] that an import has found
        self.courses = {}  # of patterns, [a0, a1, b1, ...]; Structure knows them
        self.contact = contact_parameters(contact or {}, self.contact_points)
        self.joint = model_mesh.checked_joint(joint, self.contact_points) if joint else None

    @property
    def contact_points(self):
        """N_x."""
        return len(self.contact_dofs) if self.cyclic is None else len(self.cyclic["nodes"])

    @classmethod
    def from_blocks(cls, Kee, Kec, Kcc, Mee, Mec, Mcc, Fe=None, Fc=None, Pe=None, Pc=None, **options):
        """A model from its elastic (e) and contact (c) blocks; contact dofs come last, ordered t1, t2, n per point.

        Parameters
        ----------
        Kee, Mee : (n_e, n_e);  Kec, Mec : (n_e, 3 N_x);  Kcc, Mcc : (3 N_x, 3 N_x)
            SciPy sparse or numpy.
        Fe, Pe : (n_e,), optional;  Fc, Pc : (3 N_x,), optional
            Parts of F and P [N], default zero.
        **options
            `contact`, `mesh`, `joint`, `units`, `comm`, `forces`, `C`, `K_structural` of Model.
        """
        n_e, n_c = np.shape(Kec)
        wanted = {"Kee": (Kee, (n_e, n_e)), "Kcc": (Kcc, (n_c, n_c)), "Mee": (Mee, (n_e, n_e)), "Mec": (Mec, (n_e, n_c)),
                  "Mcc": (Mcc, (n_c, n_c))}
        for name, (block, shape) in wanted.items():
            if np.shape(block) != shape:
                raise ValueError(f"{name} must have shape {shape} to go with Kec of shape {(n_e, n_c)}, "
                                 f"found {np.shape(block)}")
        if n_c == 0 or n_c % 3:
            raise ValueError(f"Kec must have 3 columns (t1, t2, n) per contact point, found {n_c}")
        Kec, Mec = sp.csr_matrix(Kec), sp.csr_matrix(Mec)
        K = sp.bmat([[Kee, Kec], [Kec.T, Kcc]], format="csr")
        M = sp.bmat([[Mee, Mec], [Mec.T, Mcc]], format="csr")
        contact_dofs = n_e + np.arange(n_c).reshape(-1, 3)
        return cls(K, M, contact_dofs, _stack(Fe, Fc, n_e, n_c, "F"), _stack(Pe, Pc, n_e, n_c, "P"), **options)

    def with_loads(self, force: ArrayLike | None = None, preload: ArrayLike | None = None, forces: dict | None = None) -> "Model":
        """The same model with another F or P or other patterns, where given; K and M are shared with this one."""
        result = copy.copy(self)
        if forces is not None:
            result.forces = {name: self._load(load, name) for name, load in load_patterns(forces).items()}
        result.force = self.force if force is None else self._load(force, "force")
        result.preload = self.preload if preload is None else self._load(preload, "preload")
        return result

    def with_stiffness(self, K) -> "Model":
        """The same model with another stiffness matrix K [N/m]."""
        return self._with_matrix("K", K)

    def with_contact(self, contact: dict) -> "Model":
        """The same model with other parameters of its contact points, as `contact` of the constructor."""
        result = copy.copy(self)
        result.contact = contact_parameters(contact, self.contact_points)
        return result

    def _with_matrix(self, name, matrix):
        result = copy.copy(self)
        result._rows = {other: rows for other, rows in self._rows.items() if other != name}
        setattr(result, name, None)
        if matrix is not None:
            result._take(name, matrix)
        return result

    def _take(self, name, matrix):
        rows, asymmetry = rows_of(matrix, name, self.comm)
        hdf5_parts.agree(self.comm, fault(rows, asymmetry, name))
        if self._rows and rows.n != self.n:
            raise ValueError(f"{'M' if name == 'K' else 'K'} and {name} must have the same size, found {self.n} and {rows.n}")
        self._rows[name] = rows
        setattr(self, name, matrix)

    def excitation(self) -> str:
        """The [[excitation.load]] entries of a case file in which every pattern has the course it was given, else a cosine."""
        names = [*([] if self.force is None else ["force"]), *self.forces]
        return excitation({name: self.courses.get(name, [0, 1]) for name in names})

    def write(self, path: str | Path) -> None:
        """Write the model file of docs/reference/files.md. Collective: every rank writes the rows it holds."""
        parts = []
        for name, rows in self._rows.items():
            parts += _sparse_parts(name, rows, self.comm)
        loads = {"force": self.force, "preload": self.preload} | {f"forces/{name}": load for name, load in self.forces.items()}
        for name, load in loads.items():
            if load is None:
                continue
            start, stop = load.getOwnershipRange() if is_petsc(load) else even_range(self.n, self.comm)
            values = load.getArray(readonly=True) if is_petsc(load) else load[start:stop]
            parts.append(Part(name, (self.n,), start, np.real(values).astype(np.float64)))
        points = {"contact/dofs": self.contact_dofs} if self.cyclic is None else model_cyclic.datasets(self.cyclic)
        parts += [self._share(name, values) for name, values in points.items()]
        parts += [self._share(f"contact/{name}", values) for name, values in self.contact.items()]
        attributes = {"": {"format": "dovetail-model", "version": 1, "units": self.units}}
        for name in self._rows:
            attributes[name] = {"MATLAB_sparse": np.uint64(self.n), "MATLAB_class": np.bytes_("double")}
        for name, values in model_mesh.datasets(self.mesh, self.joint).items():
            parts.append(self._share(name, values))
        attributes |= model_mesh.attributes(self.mesh, self.joint)
        if self.cyclic:
            attributes["cyclic"] = model_cyclic.attributes(self.cyclic)
        hdf5_parts.write(path, parts, attributes, self.comm)

    @classmethod
    def read(cls, path: str | Path) -> "Model":
        """The model in a file, as SciPy matrices in this process (serial)."""
        if not h5py.is_hdf5(path):
            raise ValueError(f"{path}: {'not an HDF5 file' if Path(path).is_file() else 'no such HDF5 file'}")
        with opened(path) as file:
            kind = words(file, "format", "unnamed")
            if kind != "dovetail-model":
                raise ValueError(f"{path}: format must be dovetail-model, found {kind}")
            contact = {name: numbers(file, f"contact/{name}") for name in CONTACT_WIDTH if f"contact/{name}" in file}
            mesh, joint = model_mesh.read_mesh(file), model_mesh.read_joint(file)
            loads = {name: numbers(file, name) for name in ("force", "preload") if name in file}
            loads["forces"] = {name: numbers(file, f"forces/{name}") for name in members(file, "forces")} if "forces" in file else None
            loads |= {name: read_sparse(file, name) for name in ("C", "K_structural") if name in file}
            cyclic = model_cyclic.read_cyclic(file)
            dofs = numbers(file, "contact/dofs", (None, 3), "i") if cyclic is None else None
            return cls(read_sparse(file, "K"), read_sparse(file, "M"), dofs, **loads, contact=contact, mesh=mesh, joint=joint,
                       cyclic=cyclic, units=words(file, "units", "SI"), comm=hdf5_parts.Alone())

    def _load(self, load, name):
        if load is None:
            return np.zeros(self.n)
        if not is_petsc(load):
            load = np.asarray(load, dtype=np.float64).reshape(-1)
        size = load.getSize() if is_petsc(load) else load.size
        if size != self.n:
            raise ValueError(f"{name} must have one entry per degree of freedom, {self.n}, found {size}")
        values = load.getArray(readonly=True) if is_petsc(load) else load
        hdf5_parts.agree(self.comm, None if np.all(np.isfinite(values)) else f"{name} has an entry that is not finite")
        return load

    def _share(self, name, values):
        """The part of an array known whole on every rank that this rank writes."""
        start, stop = even_range(len(values), self.comm)
        return Part(name, values.shape, start, values[start:stop])


def load_patterns(forces):
    """`forces` as a dict, its names checked: they are those of datasets."""
    forces = dict(forces or {})
    for name in forces:
        need_name(name)
        if name == "force":
            raise ValueError('"force" is the name of the pattern `force`; give it there, or take another name')
    return forces


def _sparse_parts(name, rows, comm):
    """MATLAB v7.3: column pointers `jc`, row numbers `ir` and `data`; rows stand for columns, the matrix being symmetric."""
    counts = comm.allgather(int(rows.data.size))
    offset, total = sum(counts[:comm.rank]), sum(counts)
    jc = rows.indptr[:-1].astype(np.uint64) + np.uint64(offset)
    if comm.rank == comm.size - 1:
        jc = np.append(jc, np.uint64(total))
    return [Part(f"{name}/data", (total,), offset, rows.data.astype(np.float64)),
            Part(f"{name}/ir", (total,), offset, rows.indices.astype(np.uint64)),
            Part(f"{name}/jc", (rows.n + 1,), rows.start, jc)]


def read_sparse(file, name):
    """The sparse matrix that MATLAB's v7.3 layout keeps under a name of an open file."""
    data, ir, jc = (numbers(file, f"{name}/{part}", (None,), kind) for part, kind in (("data", "f"), ("ir", "i"), ("jc", "i")))
    rows, columns = whole(file[name], "MATLAB_sparse"), jc.size - 1
    fits = rows == columns and jc[0] == 0 and jc[-1] == ir.size == data.size and np.all(np.diff(jc) >= 0)
    if not fits or ir.size and not 0 <= ir.min() <= ir.max() < rows:
        raise ValueError(f"/{name}: data, ir and jc do not fit together as a square sparse matrix of {rows} rows")
    return sp.csc_matrix((data, ir, jc), shape=(rows, columns)).tocsr()


def _stack(elastic, contact, n_e, n_c, name):
    parts = []
    for part, size, kind in ((elastic, n_e, "e"), (contact, n_c, "c")):
        part = np.zeros(size) if part is None else np.asarray(part, dtype=np.float64).reshape(-1)
        if part.size != size:
            raise ValueError(f"{name}{kind} must have {size} entries, found {part.size}")
        parts.append(part)
    return np.concatenate(parts)


def _contact_dofs(dofs, n):
    dofs = np.asarray(dofs)
    if dofs.shape[1:] != (3,) or not len(dofs) or not np.issubdtype(dofs.dtype, np.integer):
        raise ValueError("contact_dofs must be whole numbers of shape (N_x, 3), one row t1, t2, n per contact point, "
                         f"found {dofs.dtype} of shape {dofs.shape}")
    if dofs.min() < 0 or dofs.max() >= n:
        raise ValueError(f"contact_dofs must lie in 0 to {n - 1}, found {dofs.min()} to {dofs.max()}")
    values, counts = np.unique(dofs, return_counts=True)
    if counts.max() > 1:
        raise ValueError(f"contact_dofs must not repeat, found {values[counts.argmax()]} {counts.max()} times")
    return dofs.astype(np.int64)
