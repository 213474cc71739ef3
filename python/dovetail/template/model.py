"""Two clamped steel beams bolted together in a lap joint: builds the matrices and writes model.h5.

         clamped |==============A======|                     z
                           |======B==============| clamped   |__ x    (y into the page)
                           <-overlap->

Replace the two beams by your own K and M; what Dovetail needs is in the call of Model at the end. Units: N, m, kg, s.
"""

import itertools
from pathlib import Path

import numpy as np
import scipy.sparse as sp

try:
    from dovetail import Model
except ImportError as error:
    raise SystemExit(f"{error}\nTell Python where Dovetail is, and start again:\n"
                     "    export PYTHONPATH=FOLDER_OF_DOVETAIL/python") from None

E, NU, RHO = 210e9, 0.3, 7800.0  # steel [N/m^2], [-], [kg/m^3]
LENGTH, WIDTH, HEIGHT = 0.12, 0.02, 0.01  # one beam [m]
CELLS = (12, 2, 2)  # 8-node bricks along x, y, z
OVERLAP = 3  # length of the joint in cells
CLAMPING = 900.0  # force that presses the beams together, as the bolts do [N]


def brick(size):
    """Stiffness and mass (24, 24) of an 8-node brick with edges `size` [m], two Gauss points per direction."""
    lame, shear = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
    elasticity = np.diag([2 * shear] * 3 + [shear] * 3)
    elasticity[:3, :3] += lame
    corners = np.array(list(itertools.product((-1, 1), repeat=3)))
    stiffness, mass = np.zeros((24, 24)), np.zeros((24, 24))
    for point in itertools.product((-1 / np.sqrt(3), 1 / np.sqrt(3)), repeat=3):
        factors = 1 + corners * point
        shape = factors.prod(axis=1) / 8
        slope = np.column_stack([corners[:, i] * np.delete(factors, i, axis=1).prod(axis=1) / 8 * 2 / size[i] for i in range(3)])
        strain = np.zeros((6, 8, 3))
        for i, j, row in ((0, 1, 3), (1, 2, 4), (0, 2, 5)):
            strain[row, :, i], strain[row, :, j] = slope[:, j], slope[:, i]
        for i in range(3):
            strain[i, :, i] = slope[:, i]
        strain, volume = strain.reshape(6, 24), np.prod(size) / 8
        stiffness += strain.T @ elasticity @ strain * volume
        mass += RHO * volume * np.kron(np.outer(shape, shape), np.eye(3))
    return stiffness, mass


def beam(origin):
    """Nodes (n, 3) [m], cells (m, 8), K and M (3n, 3n) of one beam whose lower corner is at `origin`."""
    counts = np.array(CELLS) + 1
    size = np.array([LENGTH, WIDTH, HEIGHT]) / CELLS
    grid = np.array(list(itertools.product(*map(range, counts))))
    strides = np.array([counts[1] * counts[2], counts[2], 1])
    cells = np.array([(np.array(cell) + list(itertools.product((0, 1), repeat=3))) @ strides
                      for cell in itertools.product(*map(range, CELLS))])
    dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 24)
    rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, 24).ravel()
    K, M = (sp.csr_matrix((np.tile(block.ravel(), len(cells)), (rows, columns))) for block in brick(size))
    return origin + grid * size, cells, K, M


overlap = OVERLAP * LENGTH / CELLS[0]
nodes_a, cells_a, K_a, M_a = beam(np.array([0.0, 0.0, HEIGHT]))
nodes_b, cells_b, K_b, M_b = beam(np.array([LENGTH - overlap, 0.0, 0.0]))
nodes = np.vstack([nodes_a, nodes_b])
K, M = sp.block_diag([K_a, K_b], format="csr"), sp.block_diag([M_a, M_b], format="csr")

# Pairs of nodes that touch: the lower face of A on the upper face of B.
on_face = np.flatnonzero((np.abs(nodes[:, 2] - HEIGHT) < 1e-9) & (nodes[:, 0] > LENGTH - overlap - 1e-9)
                         & (nodes[:, 0] < LENGTH + 1e-9))
upper, lower = on_face[on_face < len(nodes_a)], on_face[on_face >= len(nodes_a)]  # in the same order: x, then y

# Contact works on relative displacements. A's touching dofs are replaced by r, with u_A = u_B + r, that is u = T [r or u].
T = sp.lil_matrix(sp.identity(3 * len(nodes)))
for a, b in zip(upper, lower):
    for direction in range(3):
        T[3 * a + direction, 3 * b + direction] = 1.0
# A lies above B, so that the joint closes for negative z: n = -z, t1 = x, t2 = -y.
for a in upper:
    T[:, 3 * a + 1] *= -1.0
    T[:, 3 * a + 2] *= -1.0
T = T.tocsr()

force, preload = np.zeros(3 * len(nodes)), np.zeros(3 * len(nodes))
tip = np.argmin(np.linalg.norm(nodes - [LENGTH - overlap / 2, 0.0, 2 * HEIGHT], axis=1))
force[3 * tip + 1] = 1.0  # F: f(t) of the case file times 1 N in y, on top of the joint
area = upper.size
preload[3 * upper + 2] = -CLAMPING / area
preload[3 * lower + 2] = CLAMPING / area

free = np.ones(3 * len(nodes), dtype=bool)
clamped = np.flatnonzero((nodes[:, 0] < 1e-9) | (nodes[:, 0] > 2 * LENGTH - overlap - 1e-9))
free[(3 * clamped[:, None] + np.arange(3)).ravel()] = False
number = np.cumsum(free) - 1  # of a dof after the clamped ones are gone
T = T[:, free]

model = Model(
    K=T.T @ K @ T,
    M=T.T @ M @ T,
    contact_dofs=number[3 * upper[:, None] + [0, 1, 2]],  # t1, t2, n of each contact point
    force=T.T @ force,
    preload=T.T @ preload,
    mesh={"nodes": nodes, "cells": np.vstack([cells_a, cells_b + len(nodes_a)]), "cell_type": "hexahedron",
          "dof_node": np.flatnonzero(free) // 3, "dof_direction": np.flatnonzero(free) % 3},
)
model.write(Path(__file__).with_name("model.h5"))
print(f"model.h5: {model.n} degrees of freedom, {len(upper)} contact points")
