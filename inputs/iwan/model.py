r"""The Iwan element: a mass on a spring, with many sliders beside it that slip one after the other. Writes model.h5 beside this file.

    wall |---/\/\/\ K-----------+------+
         |--slider 1--k_t / N---| MASS | --> t1, F(t)
         |--    ...         ----|      |
         |--slider N--k_t / N---+------+

Unknowns belong to one contact point each. So the mass is cut into N points, and LINK holds each of them to the middle of all, whose
motion it leaves alone. The sliders differ in what presses them: evenly from nothing to twice the mean.
"""

import argparse
from pathlib import Path

import numpy as np

from dovetail import Model

MASS, K, TANGENTIAL = 1.0, 1e6, 5e5  # [kg], [N/m] and k_t [N/m] of all points together
NORMAL = 40.0  # [N], likewise
LINK = 1e9  # [N/m]: points part by a hundred thousandth of their motion

parser = argparse.ArgumentParser(description="Writes the Iwan element.")
parser.add_argument("--points", type=int, default=32, help="N, sliders (default 32)")
parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_name("model.h5"), help="model file to write")
options = parser.parse_args()
N = options.points

empty, across = np.zeros((0, 0)), np.zeros((0, 3 * N))
stiffness = np.kron(np.eye(N) / N, np.diag([K, 4 * K, 0.0])) + np.kron(np.eye(N) - 1 / N, np.diag([LINK, 0.0, 0.0]))
pressed = NORMAL / N * (2 * np.arange(N) + 1) / N
model = Model.from_blocks(empty, across, stiffness, empty, across, MASS / N * np.eye(3 * N), Fc=np.tile([1.0, 0.0, 0.0], N) / N,
                          Pc=np.kron(pressed, [0.0, 0.0, 1.0]), contact={"tangential_stiffness": TANGENTIAL / N})
model.write(options.output)
print(f"{options.output.name}: {model.n} degrees of freedom, {N} contact points")
