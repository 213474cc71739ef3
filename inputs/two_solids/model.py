"""Two steel posts that touch with their platforms: mesh, finite elements, relative contact dofs, preload -> model.h5.

    python3 inputs/two_solids/model.py                     # or under mpirun -n R: the same model
    python3 inputs/two_solids/model.py --frequencies       # the table of README.md

Rank 0 meshes; the matrices are distributed from the start and stay so. Axes of the joint: post 1 lies above post 2, so n = -z;
t1 = x, t2 = n x t1 = -y.
"""

import argparse
import logging
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import petsc4py

petsc4py.init([])
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc
from slepc4py import SLEPc

from dovetail import Joint, Model, Structure
from dovetail.meshes import two_solids

YOUNG, POISSON, DENSITY = 210e9, 0.3, 7800.0  # steel [Pa], [-], [kg/m^3]
NORMAL_STIFFNESS, TANGENTIAL_STIFFNESS = 4e9, 4e6  # of the whole patch, shared by its points [N/m]
FRICTION = 0.1


@dataclass
class Posts:
    """Both posts, clamped at the bottom and loaded; the joint; and the model that comes of them. Matrices are distributed."""

    structure: Structure
    joint: Joint
    model: Model  # without preload


def build(size=0.0125, divisions=(4, 4), points=(3, 3), comm=MPI.COMM_WORLD):
    """Mesh, assemble, and pass to relative contact dofs. Collective.

    size: largest edge [m]; divisions: elements along x and y of the patch; points: contact points along x and y.
    """
    space = _displacement_space(size, divisions, comm)
    K, M = _assemble(space)
    nodes, cells = _mesh(space, comm)
    patch = two_solids.on_patch(nodes)
    on_post_1 = np.zeros(len(nodes), dtype=bool)
    on_post_1[cells[nodes[cells[:, :4]].mean(axis=1)[:, 2] > two_solids.PLANE_Z]] = True  # near the patch, it lies above its plane
    sets = {"bottom": nodes[:, 1] < 1e-9, "patch of post 1": patch & on_post_1, "patch of post 2": patch & ~on_post_1,
            "loaded": np.any(np.linalg.norm(nodes[:, None] - two_solids.LOADED_POINTS, axis=2) < 1e-9, axis=1)}
    structure = Structure(K, M, nodes, np.repeat(np.arange(len(nodes)), 3), np.tile(np.arange(3), len(nodes)), cells={"tetra10": cells},
                          node_sets={name: np.flatnonzero(inside) for name, inside in sets.items()})
    structure = structure.clamped("bottom").with_force("loaded", [len(two_solids.LOADED_POINTS), 0, 0])
    joint = _joint(structure, points)
    return Posts(structure, joint, structure.join(joint))


def _displacement_space(size, divisions, comm):
    """Quadratic displacements on the mesh of rank 0, distributed."""
    vertices, cells = np.empty((0, 3)), np.empty((0, 4), dtype=np.int64)
    if comm.rank == 0:
        vertices, cells = two_solids.mesh_pair(size, divisions)
    straight = ufl.Mesh(ufl.VectorElement("Lagrange", "tetrahedron", 1))
    return fem.VectorFunctionSpace(mesh.create_mesh(comm, cells.astype(np.int64), vertices, straight), ("Lagrange", 2))


def _assemble(space):
    """Stiffness [N/m] and mass [kg] of all dofs, clamped ones included."""
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    shear = YOUNG / (2 * (1 + POISSON))
    lame = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    stress = 2 * shear * ufl.sym(ufl.grad(u)) + lame * ufl.div(u) * ufl.Identity(3)
    stiffness = ufl.inner(stress, ufl.sym(ufl.grad(v))) * ufl.dx(metadata={"quadrature_degree": 2})
    mass = DENSITY * ufl.inner(u, v) * ufl.dx(metadata={"quadrature_degree": 4})
    matrices = [fem.petsc.assemble_matrix(fem.form(form)) for form in (stiffness, mass)]
    for matrix in matrices:
        matrix.assemble()
    return matrices


def _mesh(space, comm):
    """Nodes (n_nodes, 3) [m] and 10-node tetrahedra in VTK order, whole on all ranks."""
    index = space.dofmap.index_map
    own_cells = space.mesh.topology.index_map(3).size_local
    cells = space.dofmap.list.array.reshape(-1, 10)[:own_cells, [0, 1, 2, 3, 9, 6, 8, 7, 5, 4]]
    parts = comm.allgather((space.tabulate_dof_coordinates()[:index.size_local],
                            index.local_to_global(cells.ravel()).reshape(-1, 10)))
    return tuple(np.concatenate(part) for part in zip(*parts))


def _joint(structure, points):
    """The joint of both patches, x running fastest; the posts' stiffness is shared equally by the points."""
    x, y = (np.linspace(*ends, n) for ends, n in zip((two_solids.PATCH_X, two_solids.PATCH_Y), points))
    targets = np.array([(a, b, two_solids.PLANE_Z) for b in y for a in x])
    upper, lower = (structure.surface(f"patch of post {i}") for i in (1, 2))
    distance = np.linalg.norm(upper.points[:, None] - targets, axis=2).min(axis=0)
    if distance.max() > 1e-9:
        raise ValueError(f"{points[0]} x {points[1]} contact points do not fall on nodes of the patch: along each edge, "
                         "points - 1 must divide twice the number of its divisions")
    return Joint.between(upper, lower, at=targets, friction=FRICTION).with_parameters(
        normal_stiffness=NORMAL_STIFFNESS / len(targets), tangential_stiffness=TANGENTIAL_STIFFNESS / len(targets))


def closing_preload(K, contact_dofs, closing):
    """P (n,) [N] that closes every point by `closing` [m] if nothing resists: P_e = 0, P_c = K_xx (0, 0, closing).

    One static solve with the contact dofs prescribed, whose reactions are P_c; then R = -P_c (eq 2).
    """
    held, right = K.copy(), K.createVecRight()
    prescribed, preload = right.duplicate(), right.duplicate()
    begin, end = K.getOwnershipRange()
    normal = contact_dofs[:, 2]
    own_normal = normal[(normal >= begin) & (normal < end)]
    prescribed.setValues(own_normal.astype(PETSc.IntType), np.full(len(own_normal), closing))
    prescribed.assemble()
    contact = contact_dofs.ravel()
    own = contact[(contact >= begin) & (contact < end)]
    held.zeroRowsColumns(own.astype(PETSc.IntType), diag=1.0, x=prescribed, b=right)
    solver = _direct_solver(held)
    displacement = prescribed.copy()
    solver.solve(right, displacement)
    K.mult(displacement, preload)
    values = preload.getArray()
    elastic = np.ones(len(values), dtype=bool)
    elastic[own - begin] = False
    values[elastic] = 0.0  # round-off of the equilibrium
    return preload


def _direct_solver(K):
    K.setOption(PETSc.Mat.Option.SPD, True)
    solver = PETSc.KSP().create(comm=K.getComm())
    solver.setOperators(K)
    solver.setType("preonly")
    solver.getPC().setType("cholesky")
    solver.getPC().setFactorSolverType("mumps")
    solver.setErrorIfNotConverged(True)
    return solver


def frequencies(K, M, count):
    """The lowest `count` eigenfrequencies [Hz] of K v = omega^2 M v, by shift-invert at zero."""
    problem = SLEPc.EPS().create(comm=K.getComm())
    problem.setOperators(K, M)
    problem.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    problem.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    problem.setTarget(0.0)
    problem.setDimensions(count)
    problem.setTolerances(tol=1e-12)
    transform = problem.getST()
    transform.setType("sinvert")
    transform.setShift(0.0)
    transform.setKSP(_direct_solver(K))
    problem.solve()
    if problem.getConverged() < count:
        raise RuntimeError(f"only {problem.getConverged()} of {count} eigenfrequencies converged")
    return np.sqrt([problem.getEigenvalue(i).real for i in range(count)]) / (2 * np.pi)


def characteristic_frequencies(model):
    """Eigenfrequencies [Hz] with the contact dofs fixed (5), open (4) and sticking (1)."""
    begin, end = model.K.getOwnershipRange()
    own = model.contact_dofs[(model.contact_dofs >= begin) & (model.contact_dofs < end)]
    rest = PETSc.IS().createGeneral(np.setdiff1d(np.arange(begin, end), own).astype(PETSc.IntType), comm=model.K.getComm())
    fixed = frequencies(model.K.createSubMatrix(rest, rest), model.M.createSubMatrix(rest, rest), 5)
    diagonal = model.K.getDiagonal()
    stiffness = np.column_stack([model.contact["tangential_stiffness"], model.contact["normal_stiffness"]])
    mine = (model.contact_dofs >= begin) & (model.contact_dofs < end)
    diagonal.setValues(model.contact_dofs[mine].astype(PETSc.IntType), stiffness[mine], addv=PETSc.InsertMode.ADD_VALUES)
    diagonal.assemble()
    sticking = model.K.copy()
    sticking.setDiagonal(diagonal)
    return {"fixed": fixed, "open": frequencies(model.K, model.M, 4), "sticking": frequencies(sticking, model.M, 1)}


def print_frequencies(comm):
    """The table of README.md: more contact points, finer meshes, finer patches."""
    rows = ((0.0125, (4, 4), (2, 2)), (0.0125, (4, 4), (3, 3)), (0.0125, (4, 4), (5, 5)), (0.0075, (4, 4), (2, 2)),
            (0.005, (4, 4), (2, 2)), (0.0125, (10, 10), (2, 2)), (0.0125, (10, 10), (6, 6)), (0.005, (10, 10), (6, 6)))
    for size, divisions, points in rows:
        model = build(size, divisions, points, comm).model
        found = characteristic_frequencies(model)
        if comm.rank == 0:
            columns = " | ".join(" ".join(f"{f:.1f}" for f in found[kind]) for kind in ("fixed", "open", "sticking"))
            print(f"| {1e3 * size:g} mm | {divisions[0]} x {divisions[1]} | {len(model.contact_dofs)} | {model.n} "
                  f"| {columns} |", flush=True)


def main():
    def pair(text):
        return tuple(int(part) for part in text.split("x"))

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=float, default=0.0125, help="largest edge [m]; default %(default)s")
    parser.add_argument("--patch", type=pair, default=(4, 4), metavar="NXxNY", help="elements along the patch; default 4x4")
    parser.add_argument("--points", type=pair, default=(3, 3), metavar="NXxNY", help="contact points; default 3x3")
    parser.add_argument("--closing", type=float, default=1e-3, help="preload: closing if nothing resists [m]; default %(default)s")
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_name("model.h5"))
    parser.add_argument("--frequencies", action="store_true", help="print eigenfrequencies of a series of meshes, write nothing")
    options = parser.parse_args()
    logging.disable(logging.INFO)  # the form compiler's, on first use
    comm = MPI.COMM_WORLD
    if options.frequencies:
        return print_frequencies(comm)

    start = time.perf_counter()
    posts = build(options.size, options.patch, options.points, comm)
    preload = closing_preload(posts.model.K, posts.model.contact_dofs, options.closing)
    posts.model.with_loads(preload=preload).write(options.output)
    pressing = preload.sum()
    if comm.rank == 0:
        print(posts.joint.report())
        print(f"{options.output}: {posts.model.n} dofs, {len(posts.joint)} contact points, preload {pressing:.0f} N, "
          f"{time.perf_counter() - start:.1f} s on {comm.size} rank{'s' * (comm.size > 1)}")


if __name__ == "__main__":
    sys.exit(main())
