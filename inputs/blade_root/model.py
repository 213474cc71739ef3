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

from mpi4py import MPI

from dovetail.meshes import elastic_solid
from dovetail.meshes.blade_root import flank_joints, mesh_sector
from dovetail.meshes.divisions import pair

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
    free = elastic_solid.structure(sector, MATERIAL, comm, elastic_solid.centrifugal(MATERIAL, speed))
    return elastic_solid.with_pressure(free, "airfoil", PRESSURE).clamped("clamped")


def joints(solid, points=None):
    """Both flanks; see `blade_root.flank_joints`."""
    return flank_joints(solid, points, normal_stiffness=NORMAL_STIFFNESS, tangential_stiffness=TANGENTIAL_STIFFNESS, friction=FRICTION)


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
