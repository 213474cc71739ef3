"""Stiffness, mass and body forces of an elastic solid of ten-node tetrahedra, assembled by dolfinx on all ranks.

The mesh is known whole to every rank; matrices are distributed from the start and stay so.
"""

import copy

import numpy as np

from .. import faces
from ..material import Material
from ..petsc_begin import petsc
from ..structure import Structure

PETSc = petsc()
import ufl  # noqa: E402
from dolfinx import fem, mesh as dolfinx_mesh  # noqa: E402
from dolfinx.fem import petsc as fem_petsc  # noqa: E402

VTK_TO_DOLFINX = [0, 1, 2, 3, 9, 8, 5, 7, 6, 4]  # dolfinx counts mid-side nodes from the edge 2-3 backwards
LOAD_QUADRATURE = np.array([(1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3)])  # each with weight 1/6: exact for flat six-node triangles

STEEL = Material(210e9, 0.3, 7800.0, "steel")
TITANIUM = Material(114e9, 0.33, 4430.0, "Ti-6Al-4V")


def on_first_rank(comm, make):
    """What make() returns on rank 0, on every rank; what it raises there is raised everywhere. Collective."""
    made = error = None
    if comm.rank == 0:
        try:
            made = make()
        except Exception as exception:  # gmsh raises nothing more special; the other ranks must not wait for ever
            error = exception
    made, error = comm.bcast((made, error))
    if error is not None:
        raise error
    return made


def structure(tetrahedra, material, comm, body_force=None):
    """The solid, free in space. Collective.

    Parameters
    ----------
    tetrahedra : dovetail.meshes.tetrahedra.Tetrahedra
        The same on every rank.
    material : Material
    comm : mpi4py communicator
    body_force : callable, optional
        From the coordinates (an indexable UFL expression, [m]) to a list of three components [N/m^3]; becomes the preload.

    Returns
    -------
    dovetail.Structure
        Three dofs per node, x, y, z. Nodes are numbered as the ranks hold them; `labels` are the rows of `tetrahedra`.
    """
    space = _displacement_space(tetrahedra, comm)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    shear = material.young / (2 * (1 + material.poisson))
    lame = 2 * shear * material.poisson / (1 - 2 * material.poisson)
    stress = 2 * shear * ufl.sym(ufl.grad(u)) + lame * ufl.div(u) * ufl.Identity(3)
    K = _assembled(ufl.inner(stress, ufl.sym(ufl.grad(v))) * ufl.dx(metadata={"quadrature_degree": 2}), comm)
    M = _assembled(material.density * ufl.inner(u, v) * ufl.dx(metadata={"quadrature_degree": 4}), comm, with_zeros=False)
    preload = None
    if body_force:
        work = ufl.inner(ufl.as_vector(body_force(ufl.SpatialCoordinate(space.mesh))), v)
        assembled = fem_petsc.assemble_vector(fem.form(work * ufl.dx(metadata={"quadrature_degree": 4})))
        assembled.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        preload = K.createVecRight()
        preload.setArray(assembled.getArray())

    labels = np.concatenate(comm.allgather(_own_rows(space)))
    row = np.empty(len(labels), dtype=np.int64)
    row[labels] = np.arange(len(labels))
    sets = {name: row[nodes] for name, nodes in tetrahedra.node_sets.items()}
    solid = Structure(K, M, tetrahedra.nodes[labels], np.repeat(np.arange(len(labels)), 3), np.tile(np.arange(3), len(labels)),
                     labels=labels, cells={"tetra10": row[tetrahedra.cells]}, node_sets=sets, preload=preload, comm=comm)
    return solid.with_material(material.young, material.poisson, material.density, name=material.name)


def _displacement_space(tetrahedra, comm):
    """Quadratic displacements on the curved elements; rank 0 hands the cells out."""
    cells = tetrahedra.cells[:, VTK_TO_DOLFINX] if comm.rank == 0 else np.empty((0, 10))
    nodes = tetrahedra.nodes if comm.rank == 0 else np.empty((0, 3))
    if hasattr(fem, "functionspace"):
        from basix.ufl import element

        curved = ufl.Mesh(element("Lagrange", "tetrahedron", 2, shape=(3,)))
        return fem.functionspace(dolfinx_mesh.create_mesh(comm, cells.astype(np.int64), nodes, curved), ("Lagrange", 2, (3,)))
    curved = ufl.Mesh(ufl.VectorElement("Lagrange", "tetrahedron", 2))  # dolfinx before 0.7
    return fem.VectorFunctionSpace(dolfinx_mesh.create_mesh(comm, cells.astype(np.int64), nodes, curved), ("Lagrange", 2))


def _own_rows(space):
    """Row in `tetrahedra.nodes` of each node whose displacements this rank owns. Space and geometry have the same nodes."""
    row = np.empty(space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts, dtype=np.int64)
    geometry = space.mesh.geometry
    row[_flat(space.dofmap.list)] = np.asarray(geometry.input_global_indices)[_flat(geometry.dofmap)]
    return row[:space.dofmap.index_map.size_local]


def _flat(table):
    """Cell after cell; dolfinx before 0.7 has a list of lists instead of an array (cells, nodes)."""
    return np.asarray(getattr(table, "array", table)).reshape(-1)


def _assembled(form, comm, with_zeros=True):
    """On the communicator given: dolfinx's own goes with its mesh, and a matrix that is still in use there crashes (dolfinx 0.9).

    Exact zeros are two thirds of a mass matrix, which couples no two directions.
    """
    matrix = fem_petsc.assemble_matrix(fem.form(form))
    matrix.assemble()
    sizes, (indptr, indices, data) = matrix.getSizes(), matrix.getValuesCSR()
    matrix.destroy()
    if not with_zeros:
        kept = data != 0
        ends = np.concatenate([[0], np.cumsum(kept)])[indptr]
        indptr, indices, data = ends.astype(PETSc.IntType), indices[kept], data[kept]
    return PETSc.Mat().createAIJ(sizes, csr=(indptr, indices, data), comm=comm)


def centrifugal(material, speed):
    """Body force rho omega^2 r [N/m^3] as a function of the coordinates; the machine turns about x, speed in 1/min."""
    strength = material.density * (2 * np.pi * speed / 60) ** 2
    return lambda x: [0.0, strength * x[1], strength * x[2]]


def pressure_force(surface, pressure):
    """Nodal forces (m, 3) [N] of a pressure [Pa] that acts on a surface of six-node triangles, against its outward normal.

    surface : dovetail Surface with m points
    """
    shapes, slopes = faces.shape(6, LOAD_QUADRATURE)
    forces = np.zeros((len(surface.points), 3))
    for rows in surface.faces:
        if rows.shape[1] != 6:
            raise ValueError(f"pressure acts on six-node triangles, found faces with {rows.shape[1]} nodes on {surface.name!r}")
        along = np.einsum("psa,fsi->fpai", slopes, surface.points[rows])
        normal = np.cross(along[:, :, 0], along[:, :, 1])  # twice the area of the face, at each place
        np.add.at(forces, rows, -pressure / 6 * np.einsum("ps,fpi->fsi", shapes, normal))
    return forces


def with_pressure(structure, name, pressure):
    """The structure with an excitation F [N]: a pressure [Pa] on the surface of that name."""
    surface = structure.surface(name)
    force = structure.force.copy()
    begin, end = force.getOwnershipRange()
    own = (surface.dofs >= begin) & (surface.dofs < end)
    force.setValues(surface.dofs[own].astype(PETSc.IntType), pressure_force(surface, pressure)[own], addv=PETSc.InsertMode.ADD_VALUES)
    force.assemble()
    result = copy.copy(structure)
    result.force = force
    return result
