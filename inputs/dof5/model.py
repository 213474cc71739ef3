"""Five degrees of freedom, one contact point: two elastic masses, then t1, t2, n. Writes model.h5 beside this file."""

from pathlib import Path

import numpy as np

from dovetail import Model

Kee = np.array([[10.0, -10.0], [-10.0, 20.0]])  # [N/m]
Kec = np.array([[0.0, 0.0, 0.0], [-10.0, 0.0, 0.0]])
Kcc = np.array([[20.0, -10.0, 0.0], [-10.0, 20.0, -10.0], [0.0, -10.0, 20.0]])
Mee, Mec, Mcc = np.eye(2), np.zeros((2, 3)), np.eye(3)  # [kg]
Fe = [1.0, 1.0]  # [N]
Pe, Pc = [1.0, 0.1], [0.1, 0.1, 0.1]  # [N]

model = Model.from_blocks(Kee, Kec, Kcc, Mee, Mec, Mcc, Fe=Fe, Pe=Pe, Pc=Pc)
model.write(Path(__file__).with_name("model.h5"))
print(f"model.h5: {model.n} degrees of freedom, {len(model.contact_dofs)} contact point")
