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
from mpi4py import MPI
from petsc4py import PETSc

from dovetail import Joint, Model, Structure
from dovetail.eigenfrequencies import characteristic
from dovetail.meshes import elastic_solid, two_solids
from dovetail.meshes.divisions import pair
from dovetail.meshes.tetrahedra import Tetrahedra

NORMAL_STIFFNESS, TANGENTIAL_STIFFNESS = 4e9, 4e6  # of the whole patch, shared by its points [N/m]
FRICTION = 0.1
COUNTS = (5, 1, 4)  # eigenfrequencies with the contact points held, stuck, open


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
    mesh = elastic_solid.on_first_rank(comm, lambda: _mesh(size, divisions))
    structure = elastic_solid.structure(mesh, elastic_solid.STEEL, comm)
    structure = structure.clamped("bottom").with_force("loaded", [len(two_solids.LOADED_POINTS), 0, 0])
    joint = _joint(structure, points)
    return Posts(structure, joint, structure.join(joint))


def _mesh(size, divisions):
    """Ten-node tetrahedra of both posts with the sets of nodes that matter."""
    mesh = Tetrahedra.straight(*two_solids.mesh_pair(size, divisions))
    nodes, cells = mesh.nodes, mesh.cells
    patch = two_solids.on_patch(nodes)
    on_post_1 = np.zeros(len(nodes), dtype=bool)
    on_post_1[cells[nodes[cells[:, :4]].mean(axis=1)[:, 2] > two_solids.PLANE_Z]] = True  # near the patch, it lies above its plane
    sets = {"bottom": nodes[:, 1] < 1e-9, "patch of post 1": patch & on_post_1, "patch of post 2": patch & ~on_post_1,
            "loaded": np.any(np.linalg.norm(nodes[:, None] - two_solids.LOADED_POINTS, axis=2) < 1e-9, axis=1)}
    return Tetrahedra(nodes, cells, {name: np.flatnonzero(inside) for name, inside in sets.items()})


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
    held.setOption(PETSc.Mat.Option.SPD, True)
    solver = PETSc.KSP().create(comm=held.getComm())
    solver.setOperators(held)
    solver.setType("preonly")
    solver.getPC().setType("cholesky")
    solver.getPC().setFactorSolverType("mumps")
    solver.setErrorIfNotConverged(True)
    displacement = prescribed.copy()
    solver.solve(right, displacement)
    K.mult(displacement, preload)
    values = preload.getArray()
    elastic = np.ones(len(values), dtype=bool)
    elastic[own - begin] = False
    values[elastic] = 0.0  # round-off of the equilibrium
    return preload


def print_frequencies(comm):
    """The table of README.md: more contact points, finer meshes, finer patches."""
    rows = ((0.0125, (4, 4), (2, 2)), (0.0125, (4, 4), (3, 3)), (0.0125, (4, 4), (5, 5)), (0.0075, (4, 4), (2, 2)),
            (0.005, (4, 4), (2, 2)), (0.0125, (10, 10), (2, 2)), (0.0125, (10, 10), (6, 6)), (0.005, (10, 10), (6, 6)))
    for size, divisions, points in rows:
        model = build(size, divisions, points, comm).model
        found = characteristic(model, COUNTS)
        if comm.rank == 0:
            columns = " | ".join(" ".join(f"{f:.1f}" for f in values) for values in found.values())
            print(f"| {1e3 * size:g} mm | {divisions[0]} x {divisions[1]} | {len(model.contact_dofs)} | {model.n} "
                  f"| {columns} |", flush=True)


def main():
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
