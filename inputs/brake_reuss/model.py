"""The Brake-Reuss beam: mesh, finite elements, bolts tightened without friction, contact on the lap -> model.h5.

    python3 inputs/brake_reuss/model.py                    # the model of case.toml
    python3 inputs/brake_reuss/model.py --size 0.006       # finer everywhere, with more contact points
    python3 inputs/brake_reuss/model.py --frequencies      # the table of README.md

The preload of the model is the normal forces of the contact points, and displacements count from the tightened state.
"""

import argparse
import logging
import sys
import time
from pathlib import Path

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

import beam
from dovetail import Joint
from dovetail.bolts import static_state
from dovetail.eigenfrequencies import eigenfrequencies
from dovetail.material import Material
from dovetail.meshes import elastic_solid

STEEL = Material(192.31e9, 0.3, 7784.3, "steel")  # of the beams that were measured and computed by others
NORMAL_STIFFNESS, TANGENTIAL_STIFFNESS = 1e13, 8.2e12  # per area [N/m^3]; their ratio is Mindlin's, 2 (1 - nu) / (2 - nu)
FRICTION = 0.03
BOLT_FORCE = 12249.0  # [N]
SUSPENSION = 1.0  # frequency of the beam as a rigid body on its springs [Hz]


def structure(size, tied=False, material=STEEL):
    """The beam with its bolts, hung on soft springs at both ends; a unit force along z at its tip."""
    mesh = beam.mesh(size, tied)
    free = elastic_solid.structure(mesh, material, MPI.COMM_SELF)
    mass = material.density * mesh.jacobians().mean(axis=1).sum() / 6
    return free.with_springs("ends", np.full(3, mass * (2 * np.pi * SUSPENSION) ** 2)).with_force("tip", [0.0, 0.0, 1.0])


def lap(solid, stiffness=1.0, friction=FRICTION):
    """The joint; t1 along the beam, n along the bolts. `stiffness`: a factor on both of its stiffnesses."""
    return Joint.between(solid.surface("lap A"), solid.surface("lap B"), t1=(1, 0, 0), name="lap", friction=friction,
                         normal_stiffness=stiffness * NORMAL_STIFFNESS, tangential_stiffness=stiffness * TANGENTIAL_STIFFNESS)


def tightened(solid, joint):
    """The model of the tightened beam, and the state of its contact points: displacements and forces (m, 3).

    The shanks are whole: pulled at both ends they shorten, and bear less than the pull. With gaps that are all zero, and without
    friction, forces are proportional to it; it is such that the joint bears three times BOLT_FORCE.
    """
    for i in (1, 2, 3):
        solid = solid.with_preload(f"head {i}", [0.0, 0.0, -BOLT_FORCE]).with_preload(f"nut {i}", [0.0, 0.0, BOLT_FORCE])
    model = solid.join([joint])
    u, g = static_state(model, model.preload.getArray(), friction=False)
    factor = len(beam.BOLTS) * BOLT_FORCE / g[:, 2].sum()
    x, g = factor * u[model.contact_dofs], factor * g
    preload = model.K.createVecRight()
    preload.setValues(model.contact_dofs[:, 2].astype(PETSc.IntType), g[:, 2])
    preload.assemble()
    return model.with_loads(preload=preload).with_contact({**model.contact, "gap": -x[:, 2]}), x, g


def at_preload(model, g, count, sticks=True):
    """Lowest eigenfrequencies [Hz] of the tightened beam: what presses sticks, or slides freely; the rest is open."""
    K, closed = model.K.copy(), g[:, 2] > 0
    springs = np.column_stack([model.contact["tangential_stiffness"], model.contact["normal_stiffness"]])[closed]
    springs[:, :2] *= sticks
    diagonal = K.getDiagonal()
    diagonal.setValues(model.contact_dofs[closed].astype(PETSc.IntType), springs, addv=PETSc.InsertMode.ADD_VALUES)
    diagonal.assemble()
    K.setDiagonal(diagonal)
    return elastic(K, model.M, count)


def elastic(K, M, count):
    """Lowest eigenfrequencies [Hz] beyond the six rigid motions on the springs."""
    return eigenfrequencies(K, M, count + 6)[6:]


def print_frequencies():
    """The tables of README.md: finer meshes, and other contact stiffnesses."""
    for size in (0.016, 0.012, 0.008, 0.006):
        tied, solid = structure(size, tied=True), structure(size)
        joint = lap(solid)
        model, _, g = tightened(solid, joint)
        row = elastic(tied.K, tied.M, 1).tolist() + at_preload(model, g, 5)[[0, 2, 4]].tolist()
        print(f"| {1e3 * size:g} mm | {model.n} | {len(joint)} |", " | ".join(f"{f:.1f}" for f in row), "|", flush=True)
    solid = structure(0.012)
    for factor in (0.1, 1, 10):
        joint = lap(solid, factor)
        model, _, g = tightened(solid, joint)
        closed = joint.area[g[:, 2] > 0].sum() / joint.area.sum()
        row = at_preload(model, g, 5)[[0, 2, 4]]
        print(f"| {factor * NORMAL_STIFFNESS:g} |", " | ".join(f"{f:.1f}" for f in row), f"| {closed:.0%} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=float, default=0.012, help="edges on the lap [m]; default %(default)s")
    parser.add_argument("--friction", type=float, default=FRICTION, help="default %(default)s")
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_name("model.h5"))
    parser.add_argument("--frequencies", action="store_true", help="print eigenfrequencies of a series of meshes, write nothing")
    options = parser.parse_args()
    logging.disable(logging.INFO)  # the form compiler's, on first use
    if options.frequencies:
        return print_frequencies()

    start = time.perf_counter()
    solid = structure(options.size)
    joint = lap(solid, friction=options.friction)
    model, _, g = tightened(solid, joint)
    model.write(options.output)
    print(joint.report())
    print(f"the joint bears {g[:, 2].sum():.0f} N on {np.count_nonzero(g[:, 2])} of {len(joint)} points")
    print(f"{options.output}: {model.n} dofs, {time.perf_counter() - start:.1f} s")


if __name__ == "__main__":
    sys.exit(main())
