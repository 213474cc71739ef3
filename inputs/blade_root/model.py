"""A blade in the slot of its disk: mesh, finite elements, two dovetail flanks in contact, centrifugal load and pressure -> model.h5.

    python3 inputs/blade_root/model.py                          # or under mpirun -n R: the same model
    python3 inputs/blade_root/model.py --dofs 400000            # as fine as memory allows
    python3 inputs/blade_root/model.py --frequencies            # the table of README.md
    python3 inputs/blade_root/model.py --picture blade_root.png

Rank 0 meshes; everything after that is distributed and stays so.
"""

import argparse
import logging
import sys
import time
from pathlib import Path

import numpy as np
from mpi4py import MPI

from dovetail import Joint
from dovetail.meshes import elastic_solid
from dovetail.meshes.blade_root import Sector, mesh_sector

MATERIAL = elastic_solid.TITANIUM
NORMAL_STIFFNESS, TANGENTIAL_STIFFNESS = 1e12, 5e11  # per area [N/m^3]
FRICTION = 0.3
PRESSURE = 200.0  # amplitude on the pressure side [Pa]
SPEED = 1500.0  # of the machine [1/min]


def structure(dofs=150_000, divisions=(3, 9), speed=SPEED, comm=MPI.COMM_WORLD):
    """Blade and disk, clamped where the disk goes on, under centrifugal load and pressure; apart from each other. Collective.

    dofs: about as many unknowns; divisions: pairs of triangles down a flank and along the axis; speed: [1/min].
    """
    sector = elastic_solid.on_first_rank(comm, lambda: mesh_sector(dofs, divisions))
    free = elastic_solid.structure(sector, MATERIAL, comm, centrifugal(speed))
    return elastic_solid.with_pressure(free, "airfoil", PRESSURE).clamped("clamped")


def centrifugal(speed):
    """Body force rho omega^2 r [N/m^3] as a function of the coordinates; the machine turns about x."""
    strength = MATERIAL.density * (2 * np.pi * speed / 60) ** 2
    return lambda x: [0.0, strength * x[1], strength * x[2]]


def joints(solid, points=None):
    """Both flanks. t1 points down the flank, t2 along the axis.

    points: contact points down a flank and along the axis, evenly spread; None for all nodes.
    """
    sector = Sector()
    (y0, z1), (y1, z0) = sector.flank_ends
    made = []
    for name, side in (("left", -1), ("right", 1)):
        at = None
        if points:
            down, along = (np.linspace(0, 1, n) if n > 1 else np.array([0.5]) for n in points)
            at = np.array([(sector.length * (a - 0.5), side * (y0 + d * (y1 - y0)), z1 + d * (z0 - z1)) for a in along for d in down])
        made.append(Joint.between(
            solid.surface(f"flank_{name}"), solid.surface(f"slot_{name}"), normal_stiffness=NORMAL_STIFFNESS,
            tangential_stiffness=TANGENTIAL_STIFFNESS, friction=FRICTION, t1=(0, side * (y1 - y0), z0 - z1), at=at, name=name))
    return made


def build(dofs=150_000, divisions=(3, 9), points=None, speed=SPEED, comm=MPI.COMM_WORLD):
    """dovetail.Model of the sector; arguments as above. Collective."""
    solid = structure(dofs, divisions, speed, comm)
    return solid.join(joints(solid, points))


def print_frequencies(divisions, points, comm):
    """The table of README.md: finer meshes."""
    from dovetail.eigenfrequencies import characteristic

    for dofs in (20_000, 60_000, 150_000):
        model = build(dofs, divisions, points, comm=comm)
        found = characteristic(model, counts=(3, 3, 8), below=10.0)
        if comm.rank == 0:
            columns = " | ".join(" ".join(f"{f:.1f}" for f in values if f > 0) for values in found.values())
            print(f"| {model.n} | {len(model.contact_dofs)} | {columns} |", flush=True)


def main():
    def pair(text):
        return tuple(int(part) for part in text.split("x"))

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--dofs", type=int, default=150_000, help="about as many unknowns; default %(default)s")
    parser.add_argument("--flank", type=pair, default=(3, 9), metavar="NxM",
                        help="pairs of triangles down a flank and along the axis; default 3x9")
    parser.add_argument("--points", type=pair, metavar="NxM",
                        help="contact points on each flank; default all its nodes, (2N+1) x (2M+1) of them")
    parser.add_argument("--speed", type=float, default=SPEED, help="of the machine [1/min]; default %(default)s")
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_name("model.h5"))
    parser.add_argument("--frequencies", action="store_true", help="print eigenfrequencies of a series of meshes, write nothing")
    parser.add_argument("--picture", type=Path, metavar="PNG", help="draw the sector, write no model")
    options = parser.parse_args()
    logging.disable(logging.INFO)  # the form compiler's, on first use
    comm = MPI.COMM_WORLD
    if options.frequencies:
        return print_frequencies(options.flank, options.points, comm)

    start = time.perf_counter()
    solid = structure(options.dofs, options.flank, options.speed, comm)
    made = joints(solid, options.points)
    if comm.rank == 0:
        print("\n".join(joint.report() for joint in made))
    if options.picture:
        import picture

        return picture.draw(solid, made, options.picture) if comm.rank == 0 else None
    model = solid.join(made)
    model.write(options.output)
    if comm.rank == 0:
        print(f"{options.output}: {model.n} dofs, {len(model.contact_dofs)} contact points, {time.perf_counter() - start:.1f} s "
              f"on {comm.size} rank{'s' * (comm.size > 1)}")


if __name__ == "__main__":
    sys.exit(main())
