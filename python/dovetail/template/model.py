"""Two clamped steel beams bolted together in a lap joint: builds the matrices and writes model.h5.

         clamped |==============A======|                     z
                           |======B==============| clamped   |__ x    (y into the page)
                           <-overlap->

Replace the two beams by your own K, M and mesh; what Dovetail needs begins at Structure. Units: N, m, kg, s.
"""

import itertools
from pathlib import Path

import numpy as np
import scipy.sparse as sp

try:
    from dovetail import Joint, Structure
except ImportError as error:
    raise SystemExit(f"{error}\nTell Python where Dovetail is, and start again:\n"
                     "    export PYTHONPATH=FOLDER_OF_DOVETAIL/python") from None

E, NU, RHO = 210e9, 0.3, 7800.0  # steel [N/m^2], [-], [kg/m^3]
LENGTH, WIDTH, HEIGHT = 0.12, 0.02, 0.01  # one beam [m]
CELLS = (12, 2, 2)  # 8-node bricks along x, y, z
OVERLAP = 3  # length of the joint in cells
BRICK = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])  # its corners, in VTK order
CLAMPING = 900.0  # force that presses the beams together, as the bolts do [N]


def brick(size):
    """Stiffness and mass (24, 24) of an 8-node brick with edges `size` [m], two Gauss points per direction."""
    lame, shear = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
    elasticity = np.diag([2 * shear] * 3 + [shear] * 3)
    elasticity[:3, :3] += lame
    corners = 2 * BRICK - 1
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
    cells = np.array([(np.array(cell) + BRICK) @ strides
                      for cell in itertools.product(*map(range, CELLS))])
    dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 24)
    rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, 24).ravel()
    K, M = (sp.csr_matrix((np.tile(block.ravel(), len(cells)), (rows, columns))) for block in brick(size))
    return origin + grid * size, cells, K, M


overlap = OVERLAP * LENGTH / CELLS[0]
nodes_a, cells_a, K_a, M_a = beam(np.array([0.0, 0.0, HEIGHT]))
nodes_b, cells_b, K_b, M_b = beam(np.array([LENGTH - overlap, 0.0, 0.0]))
nodes = np.vstack([nodes_a, nodes_b])

x, z, of_a = nodes[:, 0], nodes[:, 2], np.arange(len(nodes)) < len(nodes_a)
touching = (np.abs(z - HEIGHT) < 1e-9) & (x > LENGTH - overlap - 1e-9) & (x < LENGTH + 1e-9)
sets = {
    "ends": (x < 1e-9) | (x > 2 * LENGTH - overlap - 1e-9),
    "lower face of A": touching & of_a,
    "upper face of B": touching & ~of_a,
    "shaken": np.arange(len(nodes)) == np.argmin(np.linalg.norm(nodes - [LENGTH - overlap / 2, 0.0, 2 * HEIGHT], axis=1)),
}
structure = Structure(
    K=sp.block_diag([K_a, K_b], format="csr"),
    M=sp.block_diag([M_a, M_b], format="csr"),
    nodes=nodes,
    dof_node=np.repeat(np.arange(len(nodes)), 3),
    dof_direction=np.tile([0, 1, 2], len(nodes)),
    cells={"hexahedron": np.vstack([cells_a, cells_b + len(nodes_a)])},
    node_sets={name: np.flatnonzero(inside) for name, inside in sets.items()},
)
structure = (
    structure.with_material(E, NU, RHO, name="steel")  # for stresses
    .clamped("ends")
    .with_force("shaken", [0.0, 1.0, 0.0])  # F: f(t) of the case file times 1 N in y, on top of the joint
    .with_preload("lower face of A", [0.0, 0.0, -CLAMPING])
    .with_preload("upper face of B", [0.0, 0.0, CLAMPING])
)
# Stiffness and friction of the joint are in case.toml; Joint.between takes them as well, stiffness per area.
joint = Joint.between(structure.surface("lower face of A"), structure.surface("upper face of B"))
model = structure.join([joint])
model.units = "SI"  # a label for what is printed and drawn; numbers stay as they are
model.write(Path(__file__).with_name("model.h5"))
print(joint.report(model.units))
print(f"model.h5: {model.n} degrees of freedom, {len(joint)} contact points")
