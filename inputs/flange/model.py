r"""Two tubes whose flanges are pressed together by six bolts. Writes model.h5 beside this file.

            |  |    |  |  <- shaken
            |  |    |  |                 z
        ____|  |    |  |____             |
       |_______|    |_______|  bolts     +-- x
       |____    |  |    ____|
            |  |    |  |
            |__|    |__|  clamped

Eight-node bricks in rings around z. Each bolt pulls at one node of either flange, with a force that stays.
"""

from pathlib import Path

import numpy as np
import scipy.sparse as sp

from dovetail import Joint, Structure
from dovetail.solids import rule, shapes

E, NU, RHO = 210e9, 0.3, 7800.0  # steel [N/m^2], [-], [kg/m^3]
RADII = np.array([0.020, 0.024, 0.030, 0.036])  # of tube, inside and outside, bolts, rim [m]
AROUND, BOLTS = 18, 6  # bricks round a ring; bolts, evenly
UPPER = np.array([0.0, 0.008, 0.030, 0.052, 0.074, 0.096])  # levels of the upper part: joint, top of the flange, tube [m]
LOWER = np.array([0.0, -0.008, -0.024, -0.040])
BOLT_FORCE = 3000.0  # [N]
BRICK = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])  # corners, in VTK order


def part(levels):
    """Nodes (n, 3) [m] and cells (m, 8): a flange between the first two levels, a tube beyond."""
    levels, count = np.sort(levels), len(levels)
    flange = 0 if levels[0] == 0 else count - 2  # which layer it is
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    r, angle, z = np.meshgrid(RADII, turn, levels, indexing="ij")
    nodes = np.column_stack([(r * np.cos(angle)).ravel(), (r * np.sin(angle)).ravel(), z.ravel()])
    row = np.arange(len(nodes)).reshape(r.shape)
    cells = np.array([[row[i + a, (j + b) % AROUND, k + c] for a, b, c in BRICK]
                      for k in range(count - 1) for i in range(len(RADII) - 1 if k == flange else 1) for j in range(AROUND)])
    used, cells = np.unique(cells, return_inverse=True)
    return nodes[used], cells.reshape(-1, 8)


def matrices(nodes, cells):
    """K and M (3n, 3n) of the bricks, two Gauss points per direction."""
    lame, shear = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
    gauss = rule("hexahedron")
    values = shapes("hexahedron", gauss.points)[0]
    K, M = np.zeros((2, len(cells), 8, 3, 8, 3))
    for value, local, weight in zip(values, gauss.slopes, gauss.weights):
        jacobian = np.einsum("wa,cwx->cax", local, nodes[cells])
        slope = np.linalg.solve(jacobian, np.broadcast_to(local.T, (len(cells), 3, 8)))  # (m, 3, 8)
        volume = weight * np.linalg.det(jacobian)
        parts = np.einsum("c,cxi,cyj->cixjy", volume, slope, slope)
        K += lame * parts + shear * parts.transpose(0, 1, 4, 3, 2)
        K += shear * np.einsum("cixjx,kl->cikjl", parts, np.eye(3))
        M += RHO * np.einsum("c,i,j,kl->cikjl", volume, value, value, np.eye(3))
    dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 24)
    rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, 24).ravel()
    return [sp.csr_matrix((block.ravel(), (rows, columns)), shape=(3 * len(nodes),) * 2) for block in (K, M)]


(upper, cells_up), (lower, cells_low) = part(UPPER), part(LOWER)
nodes, cells = np.vstack([upper, lower]), np.vstack([cells_up, cells_low + len(upper)])
K, M = matrices(nodes, cells)
z, above = nodes[:, 2], np.arange(len(nodes)) < len(upper)
sets = {"upper face": above & (z == 0), "lower face": ~above & (z == 0), "clamped": z == LOWER[-1], "top": z == UPPER[-1]}
for i in range(BOLTS):
    turn = 2 * np.pi * i / BOLTS
    on_axis = np.linalg.norm(nodes[:, :2] - RADII[2] * np.array([np.cos(turn), np.sin(turn)]), axis=1) < 1e-9
    sets |= {f"head {i}": on_axis & (z == UPPER[1]), f"nut {i}": on_axis & (z == LOWER[1])}
structure = Structure(K, M, nodes, np.repeat(np.arange(len(nodes)), 3), np.tile([0, 1, 2], len(nodes)), cells={"hexahedron": cells},
                      node_sets={name: np.flatnonzero(inside) for name, inside in sets.items()})
structure = structure.with_material(E, NU, RHO, name="steel").clamped("clamped").with_force("top", [1.0, 0.0, 0.0])
for i in range(BOLTS):
    structure = structure.with_preload(f"head {i}", [0, 0, -BOLT_FORCE]).with_preload(f"nut {i}", [0, 0, BOLT_FORCE])
flange = Joint.between(structure.surface("upper face"), structure.surface("lower face"), t1=[1, 0, 0], name="flange",
                       normal_stiffness=1e13, tangential_stiffness=8e12, friction=0.15)
model = structure.join([flange])
model.write(Path(__file__).with_name("model.h5"))
print(f"model.h5: {model.n} degrees of freedom, {len(flange)} contact points")
