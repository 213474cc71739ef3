"""Two free steel beams, bolted together in a lap joint and hung on soft springs: a joint with many points whose modes lie far apart."""

import sys
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from dovetail import Joint, Structure

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
import brick

LENGTH, WIDTH, HEIGHT, OVERLAP = 0.36, 0.025, 0.0125, 0.12  # of a beam; of the joint [m]
CELLS = (36, 4, 2)  # bricks of a beam: 13 x 5 pairs of nodes in the joint
BOLTS, CLAMPING, REACH = (0.2, 0.5, 0.8), 4000.0, 0.012  # along the joint; force [N] on nodes within [m] of each
SUSPENSION = 3.0  # frequency of the beams as a rigid body on their springs [Hz]
CASE = """title = "two free beams, lap joint"
model = "model.h5"
reduction = {{ modes = 20 }}
damping = {{ stiffness = 2e-6 }}
excitation = {{ fourier = [0, {force!r}] }}
contact = {{ normal_stiffness = {kn!r}, tangential_stiffness = {kt!r}, friction = 0.3 }}
harmonic_balance = {{ harmonics = 3, solver = "modal" }}
continuation = {{ omega = {omega}, at = {at} }}
stability = {{ enabled = false }}
"""


def structure():
    """The beams and their springs, clamped together at the bolts, shaken across at one end."""
    corners = [(0, 0, HEIGHT), (LENGTH - OVERLAP, 0, 0)]
    grids = [brick.grid(corner, (LENGTH, WIDTH, HEIGHT), CELLS) for corner in corners]
    (upper, cells), (lower, cells_below) = grids
    nodes, cells = np.vstack([upper, lower]), np.vstack([cells, cells_below + len(upper)])
    K, M = brick.matrices(nodes, cells, young=2e11, poisson=0.3, density=7800.0)
    x, y, z = nodes.T
    above = np.arange(len(nodes)) < len(upper)
    joint = (abs(z - HEIGHT) < 1e-9) & (x > LENGTH - OVERLAP - 1e-9) & (x < LENGTH + 1e-9)
    ends = (x < 1e-9) | (x > 2 * LENGTH - OVERLAP - 1e-9)
    mass = M.sum() / 3
    K = K + sp.diags(np.repeat(ends * mass * (2 * np.pi * SUSPENSION) ** 2 / ends.sum(), 3))
    sets = {"upper face": joint & ~above, "lower face": joint & above, "end": x < 1e-9}
    near = [(abs(x - (LENGTH - OVERLAP * (1 - place))) < REACH) & (abs(y - WIDTH / 2) < REACH) & joint for place in BOLTS]
    for i, bolt in enumerate(near):
        sets |= {f"bolt {i} above": bolt & above, f"bolt {i} below": bolt & ~above}
    made = Structure(K.tocsr(), M, nodes, np.repeat(np.arange(len(nodes)), 3), np.tile([0, 1, 2], len(nodes)),
                     cells={"hexahedron": cells}, node_sets={name: np.flatnonzero(inside) for name, inside in sets.items()})
    made = made.with_force("end", [0, 0, 1.0])
    for i in range(len(near)):
        made = made.with_preload(f"bolt {i} above", [0, 0, -CLAMPING]).with_preload(f"bolt {i} below", [0, 0, CLAMPING])
    return made


def write(folder, force=1.0, omega=(1200.0, 900.0), at=(), kn=1e8, kt=1e8):
    """model.h5 and case.toml in a folder; path of the case."""
    folder.mkdir(parents=True, exist_ok=True)
    made = structure()
    joint = Joint.between(made.surface("lower face"), made.surface("upper face"))
    made.join([joint]).write(folder / "model.h5")
    path = folder / "case.toml"
    path.write_text(CASE.format(force=force, omega=list(omega), at=list(at), kn=kn, kt=kt))
    return path
