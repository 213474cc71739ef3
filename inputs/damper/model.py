r"""Half of a wedge under the platforms of two blades that move against each other. Writes model.h5 beside this file.

       | blade
       |         :              z, outwards
    ---+--___    : mirror       |
            ---__:              +-- x, around the wheel; y, along the axis
      wedge  --__:
               --:

The blade is a mass on springs. Nothing holds the wedge but the face and the mirror plane, where its other half is: it is free to
move outwards, where the centrifugal force presses it against the platform.
"""

from pathlib import Path

import numpy as np
import scipy.sparse as sp

from dovetail import Joint, Structure

BLADE, WEDGE = 0.5, 0.01  # [kg]
BLADE_STIFFNESS = (2e6, 2e7, 2e8)  # along x, y, z [N/m]: it bends around the wheel, at 318 Hz
MIRROR = 1e9  # [N/m]
ANGLE = np.radians(70)  # between the face and the radius
CENTRIFUGAL = 200.0  # on this half of the wedge [N]

structure = Structure(
    K=sp.diags([*BLADE_STIFFNESS, MIRROR, 0.0, 0.0], format="csr"),
    M=sp.diags([BLADE] * 3 + [WEDGE] * 3, format="csr"),
    nodes=np.zeros((2, 3)),
    dof_node=np.repeat([0, 1], 3),
    dof_direction=np.tile([0, 1, 2], 2),
    node_sets={"blade": [0], "wedge": [1]},
)
structure = structure.with_force("blade", [1.0, 0.0, 0.0]).with_preload("wedge", [0.0, 0.0, CENTRIFUGAL])
c, s = np.cos(ANGLE), np.sin(ANGLE)
face = Joint.between(structure.surface("blade"), structure.surface("wedge"), normal=[c, 0.0, -s], t1=[s, 0.0, c], name="face")
model = structure.join([face])
model.write(Path(__file__).with_name("model.h5"))
print(f"model.h5: {model.n} degrees of freedom, {len(face)} contact point")
