r"""One Jenkins element: a mass on a spring, with one slider beside it. Writes model.h5 beside this file.

    wall |---/\/\/\ K---+------+
         |              | MASS | --> t1, F(t)
         |--slider--k_t-+------+            NORMAL presses the slider against the wall

The mass itself is the contact point. It moves along t1 alone; t2 and n are there because every point has them.
"""

from pathlib import Path

import numpy as np

from dovetail import Model

MASS, K = 1.0, 1e6  # [kg], [N/m]
NORMAL = 20.0  # [N]
empty, across = np.zeros((0, 0)), np.zeros((0, 3))

model = Model.from_blocks(empty, across, np.diag([K, K, 0.0]), empty, across, MASS * np.eye(3), Fc=[1.0, 0.0, 0.0], Pc=[0.0, 0.0, NORMAL])
model.write(Path(__file__).with_name("model.h5"))
print(f"model.h5: {model.n} degrees of freedom, {len(model.contact_dofs)} contact point")
