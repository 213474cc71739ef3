"""One of 36 sectors of a bladed disk: blade in its slot, disk, shrouds that touch those of the neighbours -> model.h5.

    python3 inputs/blisk/model.py                               # or under mpirun -n R: the same model
    python3 inputs/blisk/model.py --dofs 150000 --flank 3x9 --shroud 2x5
    python3 inputs/blisk/model.py --no-shroud
    python3 inputs/blisk/model.py --interference 0.1            # of the shrouds [mm]

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
from dovetail.cells import outer_faces
from dovetail.meshes import bladed_disk, elastic_solid
from dovetail.meshes.blade_root import flank_joints
from dovetail.meshes.divisions import pair

MATERIAL = elastic_solid.TITANIUM
CONTACT = {"normal_stiffness": 1e12, "tangential_stiffness": 5e11, "friction": 0.3}  # stiffness per area [N/m^3]
SHROUD = bladed_disk.Shroud(slope=np.radians(-10))  # so that whole faces are pressed, not edges alone
INTERFERENCE = 0.05  # of the shrouds [mm]
PRESSURE = 1000.0  # amplitude on the pressure side [Pa]
SPEED = 1500.0  # of the centrifugal load [1/min]


def structure(dofs=20_000, flank=(1, 3), shroud=(1, 3), side=(3, 3), speed=SPEED, comm=MPI.COMM_WORLD):
    """A sector under centrifugal load and pressure, clamped at the bore; blade and disk apart from each other. Collective.

    dofs: about as many unknowns; flank, shroud: pairs of triangles down and along their contact faces, shroud None for none; side: on the
    sides of the disk; speed [1/min].
    """
    disk = bladed_disk.BladedDisk(shroud=SHROUD if shroud else None)
    mesh = elastic_solid.on_first_rank(comm, lambda: bladed_disk.mesh_sector(dofs, flank, shroud or (1, 1), disk, side))
    mesh.node_sets["surface"] = np.unique(np.concatenate([faces.ravel() for faces in outer_faces(mesh.nodes, {"tetra10": mesh.cells})]))
    free = elastic_solid.structure(mesh, MATERIAL, comm, elastic_solid.centrifugal(MATERIAL, speed))
    loaded = elastic_solid.with_pressure(free, "airfoil", PRESSURE).clamped("bore")
    return loaded.cyclic(disk.blades, "left", "right", axis=bladed_disk.AXIS)


def joints(solid, interference=INTERFERENCE):
    """Both flanks of the root, and the shroud with that of the next sector, if there is one; interference [mm]."""
    made = flank_joints(solid, **CONTACT)
    if "shroud_right" in solid.node_sets:
        made.append(Joint.between(solid.surface("shroud_right"), solid.surface("shroud_left"), next_sector=True, t1=(1, 0, 0),
                                  gap=-1e-3 * interference, name="shroud", **CONTACT))
    return made


def build(dofs=20_000, flank=(1, 3), shroud=(1, 3), side=(3, 3), speed=SPEED, interference=INTERFERENCE, comm=MPI.COMM_WORLD):
    """dovetail.Model of the sector; arguments as above. Collective."""
    solid = structure(dofs, flank, shroud, side, speed, comm)
    return solid.join(joints(solid, interference))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--dofs", type=int, default=20_000, help="about as many unknowns; default %(default)s")
    parser.add_argument("--flank", type=pair, default=(1, 3), metavar="NxM",
                        help="pairs of triangles down a flank and along the axis: (2N+1) x (2M+1) contact points on each; default 1x3")
    parser.add_argument("--shroud", type=pair, default=(1, 3), metavar="NxM", help="likewise across a shroud and along it; default 1x3")
    parser.add_argument("--side", type=pair, default=(3, 3), metavar="NxM", help="likewise on the sides of the disk, whose nodes cost most "
                        "in the reduction; default 3x3")
    parser.add_argument("--no-shroud", action="store_true", help="blades that touch the disk alone")
    parser.add_argument("--interference", type=float, default=INTERFERENCE, help="of the shrouds [mm]; default %(default)s")
    parser.add_argument("--speed", type=float, default=SPEED, help="of the centrifugal load [1/min]; default %(default)s")
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_name("model.h5"))
    options = parser.parse_args()
    logging.disable(logging.INFO)  # the form compiler's, on first use
    comm = MPI.COMM_WORLD
    start = time.perf_counter()
    solid = structure(options.dofs, options.flank, None if options.no_shroud else options.shroud, options.side, options.speed, comm)
    made = joints(solid, options.interference)
    if comm.rank == 0:
        print("\n".join([solid.cyclic_sector.report(), *(joint.report() for joint in made)]))
    model = solid.join(made)
    model.write(options.output)
    if comm.rank == 0:
        print(f"{options.output}: {model.n} dofs, {model.contact_points} contact points, {time.perf_counter() - start:.1f} s "
              f"on {comm.size} rank{'s' * (comm.size > 1)}")


if __name__ == "__main__":
    sys.exit(main())
