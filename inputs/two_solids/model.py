"""Two steel posts that touch with their platforms: mesh, finite elements, relative contact dofs, preload -> model.h5.

    python3 inputs/two_solids/model.py                     # or under mpirun -n R: the same model
    python3 inputs/two_solids/model.py --frequencies       # the table of README.md

Rank 0 meshes; everything after that is distributed and stays so.
"""

import argparse
import logging
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import petsc4py

petsc4py.init([])
import scipy.sparse as sp
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc
from slepc4py import SLEPc

from dovetail import Model
from dovetail.meshes import two_solids

YOUNG, POISSON, DENSITY = 210e9, 0.3, 7800.0  # steel [Pa], [-], [kg/m^3]
SIGNS = np.array([1.0, -1.0, -1.0])  # t1 = x, t2 = -y, n = -z: post 1 lies above post 2, so positive n closes
NORMAL_STIFFNESS, TANGENTIAL_STIFFNESS = 4e9, 4e6  # of the whole patch, shared by its points [N/m]
FRICTION = 0.1


@dataclass
class Posts:
    """Both posts on the free dofs, contact dofs relative. Distributed; node numbers are global, 3 dofs each."""

    K: PETSc.Mat  # (n, n) [N/m]
    M: PETSc.Mat  # (n, n) [kg]
    T: PETSc.Mat  # (n, n): displacements of all free dofs = T q
    force: PETSc.Vec  # (n,) 1 N in x at each loaded point, in terms of q
    pairs: np.ndarray  # (N_x, 2) free node numbers on post 1 and post 2, known to all ranks
    coordinates: np.ndarray  # (own free nodes, 3) [m]
    picture: dict = field(repr=False)  # the `mesh` of dovetail.Model

    @property
    def contact_dofs(self):
        """(N_x, 3) dofs of t1, t2, n: the sum of a pair lives at the place of post 1's node, the difference at post 2's."""
        return 3 * self.pairs[:, 1:] + np.arange(3)


def build(size=0.0125, divisions=(4, 4), points=(3, 3), comm=MPI.COMM_WORLD):
    """Mesh, assemble, and pass to relative contact dofs. Collective.

    size: largest edge [m]; divisions: elements along x and y of the patch; points: contact points along x and y.
    """
    space = _displacement_space(size, divisions, comm)
    matrices = _assemble(space)
    own = space.dofmap.index_map.size_local
    coordinates = space.tabulate_dof_coordinates()[:own]
    free = coordinates[:, 1] > 1e-9
    first = comm.exscan(int(free.sum())) or 0
    number = np.where(free, first + np.cumsum(free) - 1, -1)  # of each own node among the free ones

    pairs = _pairs(coordinates, number, _belongs_to_post_1(space)[:own], points, comm)
    own_dofs = 3 * (space.dofmap.index_map.local_range[0] + np.flatnonzero(free))[:, None] + np.arange(3)
    rows = PETSc.IS().createGeneral(own_dofs.astype(PETSc.IntType).ravel(), comm=comm)
    K, M = (matrix.createSubMatrix(rows, rows) for matrix in matrices)
    T = _relative(K, pairs)
    return Posts(K.ptap(T), M.ptap(T), T, _force(T, coordinates, number), pairs, coordinates[free],
                 _picture(space, number, pairs, comm))


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


def _belongs_to_post_1(space):
    """For nodes on the patch: (own and ghost nodes,) bool. Near the patch, post 1 is what lies above its plane."""
    cells = space.dofmap.list.array.reshape(-1, 10)
    z = space.tabulate_dof_coordinates()[:, 2]
    above = np.zeros(len(z), dtype=bool)
    above[cells[z[cells].mean(axis=1) > two_solids.PLANE_Z]] = True
    return above


def _pairs(coordinates, number, on_post_1, points, comm):
    """Numbers (N_x, 2) of the nodes on post 1 and post 2 at each contact point, x running fastest. Only the patch is shared."""
    x, y = (np.linspace(*ends, n) for ends, n in zip((two_solids.PATCH_X, two_solids.PATCH_Y), points))
    targets = np.array([(a, b, two_solids.PLANE_Z) for b in y for a in x])
    patch = np.flatnonzero(two_solids.on_patch(coordinates))
    found = comm.allgather((coordinates[patch], number[patch], on_post_1[patch]))
    where, numbers, above = (np.concatenate(parts) for parts in zip(*found))
    pairs = np.full((len(targets), 2), -1)
    for side, chosen in enumerate((above, ~above)):
        at = np.linalg.norm(where[chosen][:, None] - targets, axis=2) < 1e-9  # (nodes, N_x)
        if np.any(at.sum(axis=0) != 1):
            raise ValueError(f"{points[0]} x {points[1]} contact points do not fall on nodes of the patch: along each edge, "
                             "points - 1 must divide twice the number of its divisions")
        pairs[:, side] = numbers[chosen][at.argmax(axis=0)]
    return pairs


def _relative(K, pairs):
    """T of u = T q, distributed like K: (u1, u2) = 1/2 [I I; I -I] (s, r) at every pair, r = SIGNS * (t1, t2, n)."""
    begin, end = K.getOwnershipRange()
    diagonal = np.ones(end - begin)
    one, two = (3 * side[:, None] + np.arange(3) for side in pairs.T)  # (N_x, 3) dofs
    half = np.full(one.shape, 0.5)
    rows = np.stack([one, one, two, two]).ravel()
    columns = np.stack([one, two, one, two]).ravel()
    values = np.stack([half, half * SIGNS, half, -half * SIGNS]).ravel()
    mine = (rows >= begin) & (rows < end)
    diagonal[np.unique(rows[mine]) - begin] = 0.0
    plain = np.flatnonzero(diagonal)
    local = sp.csr_matrix((np.append(values[mine], diagonal[plain]),
                           (np.append(rows[mine] - begin, plain), np.append(columns[mine], begin + plain))),
                          shape=(end - begin, K.getSize()[0]))
    csr = local.indptr.astype(PETSc.IntType), local.indices.astype(PETSc.IntType), local.data
    return PETSc.Mat().createAIJ(K.getSizes(), csr=csr, comm=K.getComm())


def _force(T, coordinates, number):
    """1 N in x at each loaded point, in terms of q: T^T F."""
    plain, force = T.createVecRight(), T.createVecRight()
    for point in two_solids.LOADED_POINTS:
        at = np.flatnonzero(np.linalg.norm(coordinates - point, axis=1) < 1e-9)
        plain.setValues(3 * number[at].astype(PETSc.IntType), np.ones(len(at)), addv=PETSc.InsertMode.ADD_VALUES)
    plain.assemble()
    T.multTranspose(plain, force)
    return force


def _picture(space, number, pairs, comm):
    """Nodes, corner tetrahedra, and the node of every dof, whole on all ranks; no direction where a dof is a sum or difference."""
    nodes = space.dofmap.index_map
    own_cells = space.mesh.topology.index_map(3).size_local
    corners = space.dofmap.list.array.reshape(-1, 10)[:own_cells, :4]
    parts = comm.allgather((space.tabulate_dof_coordinates()[:nodes.size_local],
                            nodes.local_to_global(corners.ravel()).reshape(-1, 4),
                            nodes.local_range[0] + np.flatnonzero(number >= 0)))
    coordinates, cells, free = (np.concatenate(part) for part in zip(*parts))
    direction = np.tile(np.arange(3), (len(free), 1))
    direction[pairs.ravel()] = -1
    return {"nodes": coordinates, "cells": cells, "cell_type": "tetra", "dof_node": np.repeat(free, 3),
            "dof_direction": direction.ravel()}


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


def characteristic_frequencies(posts):
    """Eigenfrequencies [Hz] with the contact dofs fixed (5), open (4) and sticking (1)."""
    begin, end = posts.K.getOwnershipRange()
    own = posts.contact_dofs[(posts.contact_dofs >= begin) & (posts.contact_dofs < end)]
    rest = PETSc.IS().createGeneral(np.setdiff1d(np.arange(begin, end), own).astype(PETSc.IntType), comm=posts.K.getComm())
    fixed = frequencies(posts.K.createSubMatrix(rest, rest), posts.M.createSubMatrix(rest, rest), 5)
    diagonal = posts.K.getDiagonal()
    share = np.array([TANGENTIAL_STIFFNESS, TANGENTIAL_STIFFNESS, NORMAL_STIFFNESS]) / len(posts.pairs)
    for dofs, stiffness in zip(posts.contact_dofs.T, share):
        mine = dofs[(dofs >= begin) & (dofs < end)]
        diagonal.setValues(mine.astype(PETSc.IntType), np.full(len(mine), stiffness), addv=PETSc.InsertMode.ADD_VALUES)
    diagonal.assemble()
    sticking = posts.K.copy()
    sticking.setDiagonal(diagonal)
    return {"fixed": fixed, "open": frequencies(posts.K, posts.M, 4), "sticking": frequencies(sticking, posts.M, 1)}


def print_frequencies(comm):
    """The table of README.md: more contact points, finer meshes, finer patches."""
    rows = ((0.0125, (4, 4), (2, 2)), (0.0125, (4, 4), (3, 3)), (0.0125, (4, 4), (5, 5)), (0.0075, (4, 4), (2, 2)),
            (0.005, (4, 4), (2, 2)), (0.0125, (10, 10), (2, 2)), (0.0125, (10, 10), (6, 6)), (0.005, (10, 10), (6, 6)))
    for size, divisions, points in rows:
        posts = build(size, divisions, points, comm)
        found = characteristic_frequencies(posts)
        if comm.rank == 0:
            columns = " | ".join(" ".join(f"{f:.1f}" for f in found[kind]) for kind in ("fixed", "open", "sticking"))
            print(f"| {1e3 * size:g} mm | {divisions[0]} x {divisions[1]} | {len(posts.pairs)} | {posts.K.getSize()[0]} "
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
    preload = closing_preload(posts.K, posts.contact_dofs, options.closing)
    contact = {"normal_stiffness": NORMAL_STIFFNESS / len(posts.pairs), "friction": FRICTION, "gap": 0.0,
               "tangential_stiffness": TANGENTIAL_STIFFNESS / len(posts.pairs)}
    Model(posts.K, posts.M, posts.contact_dofs, posts.force, preload, contact, posts.picture).write(options.output)
    pressing = preload.sum()
    if comm.rank == 0:
        print(f"{options.output}: {posts.K.getSize()[0]} dofs, {len(posts.pairs)} contact points, preload {pressing:.0f} N, "
              f"{time.perf_counter() - start:.1f} s on {comm.size} rank{'s' * (comm.size > 1)}")


if __name__ == "__main__":
    sys.exit(main())
