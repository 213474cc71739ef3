"""A bladed disk of six sectors as a whole rotor: no cyclic symmetry, one load pattern for each sector.

rotor.npz holds one sector, loads, and answers of an independent program for all sectors.
"""

from pathlib import Path

import h5py
import numpy as np
import scipy.sparse as sp

from dovetail import Model

DATA = np.load(Path(__file__).with_name("data") / "rotor.npz")
N, NODES = int(DATA["sector/N"]), len(DATA["sector/nodes"])
CASES = sorted({name.split("/")[0] for name in DATA.files} - {"sector"})


def coordinates(pairs):
    """T (6 sectors' displacements, unknowns), the number of elastic unknowns.

    Every sector counts in axes of its own. Right faces move as the left ones of the next sector. Contact pairs (a, b, axes, to the
    next sector) move by their sum and their relative displacement; the latter of all sectors come last.
    """
    sector = {name: DATA[f"sector/{name}"].tolist() for name in ("clamped", "left", "right")}
    turn = 2 * np.pi / N
    R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    right_of = dict(zip(sector["left"], sector["right"]))
    touching = {node for a, b, *_ in pairs for node in (a, b)}
    plain = sorted(set(range(NODES)) - set(sector["clamped"]) - set(sector["right"]) - touching)
    elastic = 3 * N * (len(plain) + len(pairs))
    rows, columns, values = [], [], []

    def put(of, node, column, block):
        rows.extend(3 * (NODES * (of % N) + node) + np.repeat(range(3), 3))
        columns.extend(column + np.tile(range(3), 3))
        values.extend(block.ravel())

    for j in range(N):
        first = 3 * j * (len(plain) + len(pairs))
        for k, node in enumerate(plain):
            put(j, node, first + 3 * k, np.eye(3))
            if node in right_of:
                put(j - 1, right_of[node], first + 3 * k, R)
        for k, (a, b, axes, beyond) in enumerate(pairs):
            back = R.T if beyond else np.eye(3)
            both, apart = first + 3 * (len(plain) + k), elastic + 3 * (len(pairs) * j + k)
            put(j, a, both, np.eye(3) / 2), put(j + beyond, b, both, back / 2)
            put(j, a, apart, axes.T / 2), put(j + beyond, b, apart, -back @ axes.T / 2)
    shape = 3 * NODES * N, elastic + 3 * N * len(pairs)
    return sp.csr_matrix((values, (rows, columns)), shape=shape), elastic


def later(series, phase):
    """Fourier coefficients [a0, a1, b1, ...] of a series whose harmonic k comes k phases later."""
    out = np.array(series)
    for k in range(1, (len(out) + 1) // 2):
        c, s = series[2 * k - 1:2 * k + 1]
        out[2 * k - 1:2 * k + 1] = c * np.cos(k * phase) - s * np.sin(k * phase), c * np.sin(k * phase) + s * np.cos(k * phase)
    return out


def write(folder, name, omega, samples):
    """model.h5 and case.toml of a case at one frequency; path of the case."""
    given = {key.split("/")[1]: DATA[key] for key in DATA.files if key.startswith(f"{name}/")}
    sector = {key.split("/")[1]: DATA[key] for key in DATA.files if key.startswith("sector/")}
    pairs = [(a, b, axes, 0) for a, b, axes in zip(sector["root_a"], sector["root_b"], sector["root_axes"])]
    if len(given["gap"]) > len(pairs):
        pairs += [(a, b, axes, 1) for a, b, axes in zip(sector["shroud_a"], sector["shroud_b"], sector["shroud_axes"])]
    T, elastic = coordinates(pairs)

    def of_sector(matrix):
        return sp.csr_matrix(tuple(sector[f"{matrix}_{part}"] for part in ("data", "indices", "indptr")))

    K, M = (T.T @ sp.block_diag([of_sector(X)] * N) @ T for X in "KM")
    forces, loads = {}, []
    for pattern, series in zip(given["patterns"], given["fourier"]):
        for j in range(N):
            force = np.zeros((N, 3 * NODES))
            force[j] = sector[f"pattern_{pattern}"]
            forces[f"{pattern}_{j}"] = T.T @ force.ravel()
            course = later(series, j * 2 * np.pi * int(given["engine_order"]) / N).tolist()
            loads.append(f'[[excitation.load]]\npattern = "{pattern}_{j}"\nfourier = {course}\n')
    contact = {"normal_stiffness": np.tile(given["kn"], N), "tangential_stiffness": np.tile(given["kt"], (N, 1)),
               "friction": np.tile(given["mu"], (N, 1)), "gap": np.tile(given["gap"], N)}
    dofs = elastic + np.arange(3 * N * len(pairs)).reshape(-1, 3)
    Model(K.tocsr(), M.tocsr(), dofs, None, T.T @ np.tile(sector["preload"], N), contact, forces=forces).write(folder / "model.h5")
    (folder / "case.toml").write_text(
        f'model = "model.h5"\nreduction.modes = {elastic}\ndamping.stiffness = {float(sector["xi"])!r}\n'
        f"harmonic_balance = {{ harmonics = {int(given['H'])}, samples = {samples} }}\n"
        "newton = { step_tolerance = 1e-6, residual_tolerance = 1e-6 }\n"
        f"continuation.omega = [{omega!r}, {omega!r}]\nstability.enabled = false\n" + "".join(loads))
    return folder / "case.toml"


def write_start(folder, name, omega, X):
    """start.h5, from which the case then begins: contact motions X (3 N_x, 2H+1), and what the modes do then."""
    with h5py.File(folder / "reduced.h5") as file:
        squares, coupling, F = file["Kaa"][()], file["Max"][()], file["Fa"][()]
    courses = np.array([later(series, j * 2 * np.pi * int(DATA[f"{name}/engine_order"]) / N)
                        for series in DATA[f"{name}/fourier"] for j in range(N)])
    a = np.zeros((len(squares), X.shape[1]))
    a[:, 0] = F.T @ courses[:, 0] / squares
    for k in range(1, (X.shape[1] + 1) // 2):
        force, motion = ((values[..., 2 * k - 1] - 1j * values[..., 2 * k]) for values in (F.T @ courses, X))
        w = k * omega
        modal = (force + w**2 * coupling @ motion) / (squares * (1 + 1j * w * float(DATA["sector/xi"])) - w**2)
        a[:, 2 * k - 1], a[:, 2 * k] = modal.real, -modal.imag
    case = folder / "case.toml"
    case.write_text(case.read_text().replace("stability", 'continuation.start = "start.h5"\nstability', 1))
    with h5py.File(folder / "start.h5", "w") as file:
        file.attrs["format"], file.attrs["version"] = "dovetail-results", 1
        file["points/omega"], file["points/coefficients"] = [omega], np.vstack([a, X])[None]
