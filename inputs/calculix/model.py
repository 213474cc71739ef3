r"""A beam whose foot is pressed onto a block: decks for CalculiX, for the matrices and for its own contact through time, and model.h5.

       |=========================  beam, 40 x 10 x 5 mm, held at the left
       |                    [___]  block under its end, 10 x 10 x 2.5 mm, held from below: presses and rubs

CalculiX must be on the path. Writes all files into out, beside this file.
"""

import argparse
import subprocess
from pathlib import Path

import numpy as np

from dovetail import Joint
from dovetail.importers import calculix

PRESSED, LIMIT = 100.0, 0.3  # onto the foot [N], friction
NORMAL, TANGENTIAL = 1000.0, 50.0  # contact stiffness per area [N/mm^3]
DAMPING, FORCE = 4000.0, 20.0  # of the mass [1/s], amplitude of the load on the end [N]
PERIODS, GROWS, STEPS = 20, 3, 64  # in all, while the load grows, time steps of each
CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
SIMPSON = {0.0: 1 / 6, 5.0: 4 / 6, 10.0: 1 / 6}  # shares of the three nodes along an edge of the foot [mm]


def block(name, first, origin, cells, edges=(5.0, 5.0, 2.5)):
    """Nodes and elements as text, and places by node."""
    shape = np.array(cells) + 1
    places = dict(enumerate(np.array(origin) + np.array(list(np.ndindex(*shape))) * edges, first))
    text = "*NODE\n" + "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in places.items()) + f"*ELEMENT, TYPE=C3D8, ELSET={name}\n"
    for number, cell in enumerate(np.ndindex(*cells), first):
        text += ", ".join(map(str, [number, *(first + np.ravel_multi_index((np.array(cell) + CORNERS).T, shape))])) + "\n"
    return text, places


def node_set(name, places, where):
    return f"*NSET, NSET={name}\n" + "".join(f"{node},\n" for node, place in places.items() if where(*place))


def material(name, body, density, damping=""):
    """In CalculiX 2.20 a second *DAMPING card, with zeros, switched off the first: so the deck has one."""
    return f"*MATERIAL, NAME={name}\n*ELASTIC\n210000, 0.3\n*DENSITY\n{density}\n{damping}*SOLID SECTION, ELSET={body}, MATERIAL={name}\n"


def mesh():
    beam, nodes = block("BEAM", 1, (0, 0, 0), (8, 2, 2))
    base, others = block("BASE", 1001, (30, 0, -2.5), (2, 2, 1))
    text = beam + base + node_set("HELD", nodes | others, lambda x, y, z: x == 0 or z == -2.5)
    text += node_set("END", nodes, lambda x, y, z: x == 40) + node_set("TIP", nodes, lambda x, y, z: (x, y, z) == (40, 5, 5))
    text += node_set("ABOVE", nodes, lambda x, y, z: x >= 30 and z == 5)
    text += node_set("UNDER", nodes, lambda x, y, z: x >= 30 and z == 0) + node_set("OVER", others, lambda x, y, z: z == 0)
    text += "*ELSET, ELSET=BOTH\nBEAM, BASE\n*BOUNDARY\nHELD, 1, 3\n"
    return text + material("STEEL", "BOTH", 7.8e-9, f"*DAMPING, ALPHA={DAMPING}, BETA=0\n")


def through_time(hertz):
    """The deck with CalculiX's own contact. BALLAST is no part of the problem: see the page."""
    ballast, far = block("BALLAST", 2001, (0, 0, 5000), (1, 1, 1), (1000.0, 1000.0, 1000.0))
    ballast += node_set("BELOW", far, lambda x, y, z: z == 5000) + node_set("TOP", far, lambda x, y, z: z > 5000)
    ballast += "*BOUNDARY\nBELOW, 1, 3\n" + material("LIGHT", "BALLAST", 1e-15)
    times = np.arange(PERIODS * STEPS + 1) / STEPS
    shake = "".join(f"{t / hertz:.10e}, {np.sin(2 * np.pi * t) * min(1, t / GROWS):.10e}\n" for t in times)
    foot = "".join(f"{number}, S1\n" for number in (25, 27, 29, 31))
    return mesh() + ballast + f"""*SURFACE, NAME=FOOT
{foot}*SURFACE, NAME=BLOCK
BASE, S2
*SURFACE INTERACTION, NAME=RUBS
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
{NORMAL}
*FRICTION
{LIMIT}, {TANGENTIAL}
*CONTACT PAIR, INTERACTION=RUBS, TYPE=SURFACE TO SURFACE
FOOT, BLOCK
*AMPLITUDE, NAME=SHAKE
{shake}*AMPLITUDE, NAME=PUSH
0, 0, {1 / hertz}, 1, 1, 1
*STEP, INC=100000
*STATIC
*CLOAD
ABOVE, 3, {-PRESSED / 9}
*EL FILE, FREQUENCY=100000
ENER
*END STEP
*STEP, INC=100000
*CONTROLS, PARAMETERS=FIELD
1e-9, 1e-3
*DYNAMIC, DIRECT, ALPHA=0
{1 / hertz / STEPS:.10e}, {PERIODS / hertz:.10e}
*CLOAD, AMPLITUDE=SHAKE
END, 2, {FORCE / 9}
*CLOAD, AMPLITUDE=PUSH
TOP, 3, -2.5e6
*NODE PRINT, NSET=TIP, FREQUENCY=1
U
*END STEP
"""


def through_calculix(path, text):
    path.write_text(text)
    done = subprocess.run(["ccx", path.stem], cwd=path.parent, capture_output=True, text=True, check=True)
    if "*ERROR" in done.stdout:
        raise RuntimeError(done.stdout[-2000:])


def main():
    parser = argparse.ArgumentParser(description="Writes model.h5, and through.inp at each frequency; runs CalculiX on both.")
    parser.add_argument("hertz", type=int, nargs="*", help="frequencies at which CalculiX goes through time [Hz]")
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).parent / "out", help="folder")
    options = parser.parse_args()
    options.output.mkdir(exist_ok=True)
    deck = options.output / "matrices.inp"
    through_calculix(deck, mesh() + "*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n*END STEP\n")
    structure = calculix.read([deck]).with_force("END", [0, 1, 0]).with_preload("ABOVE", [0, 0, -PRESSED])
    model = structure.join([Joint.between(structure.surface("UNDER"), structure.surface("OVER"), normal_stiffness=NORMAL,
                                          tangential_stiffness=TANGENTIAL, friction=LIMIT)])
    model.write(options.output / "model.h5")
    x, y, _ = (model.joint["position"] - [30, 0, 0]).T
    share = np.array([SIMPSON[a] * SIMPSON[b] for a, b in zip(x.round(6), y.round(6))]) * 100  # [mm^2]
    model.contact |= {"normal_stiffness": NORMAL * share, "tangential_stiffness": TANGENTIAL * np.stack([share, share], axis=1)}
    model.write(options.output / "simpson.h5")
    print(f"{model.n} degrees of freedom, {len(share)} contact points")
    for hertz in options.hertz:
        through_calculix(options.output / f"through{hertz}.inp", through_time(hertz))
        print(f"through{hertz}.dat: {PERIODS * STEPS} steps")


if __name__ == "__main__":
    main()
