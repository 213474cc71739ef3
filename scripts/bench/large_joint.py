"""A joint of thousands of contact points from preload to response: how long, how much memory, and what is known of it in closed form.

The structure is an elastic layer, as a torus of SIDE x SIDE points, so that waves along it are its motions: a wave of the wave number q
has E* |q| of stiffness for an area, as a half-space has, and the mass that moves with it, rho / (2 |q| + 1 / depth). In the order of the
points K and M are full. Three interior modes lean on the even motion. With that the frequencies of the stuck structure are known: those
of 3 x 3 matrices, one for each wave.

The pressure on the joint is not even, so that under the load a part of the points slips.
"""

import argparse
import os

import h5py
import numpy as np
import scipy.linalg
from measure import BINARY, OUTPUT, keep, summary_of, weigh

SPACING, MODULUS, DENSITY, DEPTH = 1e-3, 2.2e11, 7800.0, 0.05  # of points [m]; E* [Pa]; [kg/m^3]; of the layer [m]
GROUND = 5e12  # stiffness of the even motion [Pa/m]
COUPLED = np.array([[1, 0.2, 0.1], [0.2, 1, 0.1], [0.1, 0.1, 1]])  # of the directions t1, t2, n
NORMAL, TANGENTIAL, PRESSED, FRICTION = 2e7, 1e7, 100.0, 0.3  # springs [N/m], force [N] and coefficient of a point
INTERIOR = np.array([1.2e4, 2.6e4, 4.1e4])  # [rad/s]
LEANS = 0.5  # of the mass of the even motion
FORCE = 50.0  # on the first interior mode, by SIDE: some 40 % of the points slip [N kg^-1/2]
CASE = """reduced = "reduced.h5"
contact = {{ law = "coulomb", friction = {friction}, normal_stiffness = {normal}, tangential_stiffness = {tangential} }}
damping = {{ stiffness = 1e-6 }}
excitation = {{ fourier = [0, 0, 1] }}
harmonic_balance = {{ harmonics = {harmonics}, solver = "modal" }}
continuation = {{ omega = [{omega}, {end}], max_points = {points} }}
stability = {{ enabled = false }}
accuracy = {{ estimates = false }}
"""


def waves(side):
    """|q| of each wave [1/m], (side, side)."""
    numbers = 2 * np.pi * np.fft.fftfreq(side, SPACING)
    return np.hypot(numbers[:, None], numbers[None, :])


def per_wave(side):
    """Stiffness and mass of a point in each wave, (side, side): times COUPLED, and for each direction."""
    q = waves(side)
    stiffness = MODULUS * q
    stiffness[0, 0] = GROUND
    return SPACING**2 * stiffness, SPACING**2 * DENSITY / (2 * q + 1 / DEPTH)


def rows_of(kernel, directions, first, count):
    """Rows of `count` points of a matrix (3 points, 3 points): kernel (side, side) of the way from point to point."""
    side = len(kernel)
    rows = np.empty((count, 3, side * side, 3))
    for row, point in zip(rows, range(first, first + count), strict=True):
        away = np.roll(kernel, (point // side, point % side), (0, 1)).reshape(-1)
        np.multiply(directions[:, None, :], away[None, :, None], out=row)
    return rows.reshape(3 * count, -1)


def write(path, side, force, at_once=50):
    """The reduced file, a few points at a time."""
    points, (stiffness, mass) = side * side, per_wave(side)
    even = LEANS * np.sqrt(mass[0, 0] / points)
    with h5py.File(path, "w") as file:
        file.attrs.update(format="dovetail-reduced", version=1, units="SI")
        file["Kaa"], file["Fa"] = INTERIOR**2, np.array([force, 0.0, 0.0])
        file["Max"] = np.tile(even * np.eye(3), points)
        file["Fx"] = np.zeros(3 * points)
        pressure = np.zeros((side, side, 3))
        pressure[:, :, 2] = -PRESSED * (1 + 0.8 * np.cos(2 * np.pi * np.arange(side) / side))[:, None]
        file["R"] = pressure.reshape(-1)
        for name, of, directions in (("Kxx", stiffness, COUPLED), ("Mxx", mass, np.eye(3))):
            kernel = np.fft.ifft2(of).real
            data = file.create_dataset(name, (3 * points, 3 * points), "f8")
            for first in range(0, points, at_once):
                count = min(at_once, points - first)
                data[3 * first:3 * (first + count)] = rows_of(kernel, directions, first, count)


def stuck_frequencies(side, count):
    """The lowest of the structure with its joint stuck [rad/s], in closed form."""
    springs = np.diag([TANGENTIAL, TANGENTIAL, NORMAL])
    found = []
    for stiffness, mass in zip(*(of.reshape(-1) for of in per_wave(side)), strict=True):
        K, M = stiffness * COUPLED + springs, mass * np.eye(3)
        if not found:  # the even wave, as a unit vector, and the interior modes
            beside = LEANS * np.sqrt(mass) * np.eye(3)
            K, M = scipy.linalg.block_diag(np.diag(INTERIOR**2), K), np.block([[np.eye(3), beside], [beside, M]])
        found.extend(scipy.linalg.eigh(K, M, eigvals_only=True))
    return np.sqrt(np.sort(found)[:count])


def run(folder, ranks, arguments):
    command = [BINARY, "run", folder / "case.toml", "-hb_modal_many", arguments.many]
    if ranks > 1:
        os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        command = ["mpirun", "--oversubscribe", "-n", ranks, *command]
    return weigh(command)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--side", type=int, default=32, help="points on a side; 100 are 30 000 contact dofs; default %(default)s")
    parser.add_argument("--ranks", type=int, default=2, help="default %(default)s")
    parser.add_argument("--harmonics", type=int, default=3, help="default %(default)s")
    parser.add_argument("--points", type=int, default=4, help="of the curve; default %(default)s")
    parser.add_argument("--many", type=int, default=12000, help="dofs from which on few modes are found; default %(default)s")
    arguments = parser.parse_args()
    folder = OUTPUT / f"large_joint/{arguments.side}"
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "reduced.h5").exists():
        write(folder / "reduced.partial.h5", arguments.side, arguments.side * FORCE)
        (folder / "reduced.partial.h5").rename(folder / "reduced.h5")
    exact = stuck_frequencies(arguments.side, 10)
    (folder / "case.toml").write_text(
        CASE.format(friction=FRICTION, normal=NORMAL, tangential=TANGENTIAL, harmonics=arguments.harmonics, points=arguments.points,
                    omega=0.995 * exact[0], end=1.005 * exact[0]))
    text, cost = run(folder, arguments.ranks, arguments)
    summary, stages = summary_of(folder)
    print(text)
    found = np.array(summary["resonances"]["stuck"][:10])
    print(f"stuck frequencies against closed form: {np.max(abs(found / exact - 1)):.1e}")
    print(f"{3 * arguments.side**2} contact dofs, {arguments.ranks} ranks: {cost.wall:.0f} s, {cost.cpu:.0f} s of the processor")
    keep(f"large_joint_{arguments.side}", {"stages": stages, "wall": cost.wall, "cpu": cost.cpu})


if __name__ == "__main__":
    main()
