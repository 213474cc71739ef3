"""A ring of few sectors that touch their neighbours, twice: as one sector, and as a structure that knows no cyclic symmetry.

A sector has a disk and two faces of a shroud, three directions each. The right face touches the left one of the next sector.
"""

import re

import h5py
import numpy as np

import cases
import cyclic_sector
from whole_rotor import later

DISK, LEFT, RIGHT = (slice(3 * i, 3 * i + 3) for i in range(3))
DAMPING = 0.004  # times stiffness [s]
CONTACT = {"normal_stiffness": 2.0, "tangential_stiffness": [1.0, 1.0], "friction": [0.4, 0.4], "gap": 0.0}
PRESS = 3.0  # on the faces, towards one another
FORCE = np.array([0, 0, 0, 0.6, 1.0, 0.3, 0.5, 1.0, 0.4])


def matrices(N):
    """K, M (9 N, 9 N) of the elastic dofs of all sectors, 6 each, and then the 3 of the contacts; T, which makes displacements of them."""
    K, M = np.zeros((9 * N, 9 * N)), np.eye(9 * N)
    stiff = np.array([0.7, 1.0, 0.9])

    def spring(a, b, k):
        for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            K[i, j] += sign * np.diag(k)

    def at(j, dofs):
        return slice(9 * (j % N) + dofs.start, 9 * (j % N) + dofs.stop)

    for j in range(N):
        K[at(j, DISK), at(j, DISK)] += np.diag([3.0, 4.0, 5.0])
        M[at(j, DISK), at(j, DISK)] *= 2
        spring(at(j, DISK), at(j + 1, DISK), 0.5 * stiff)
        spring(at(j, DISK), at(j, LEFT), stiff)
        spring(at(j, DISK), at(j, RIGHT), 0.9 * stiff)
        spring(at(j, LEFT), at(j, RIGHT), np.array([2.0, 3.0, 8.0]))
        skew = 0.15 * np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]])  # directions are coupled in the blade
        K[at(j, LEFT), at(j, LEFT)] += skew
        K[at(j, RIGHT), at(j, RIGHT)] += skew
    T = np.zeros((9 * N, 9 * N))
    for j in range(N):
        apart = slice(6 * N + 3 * j, 6 * N + 3 * j + 3)
        T[at(j, DISK), 6 * j:6 * j + 3] = np.eye(3)
        for face, sign in ((at(j, RIGHT), 1), (at(j + 1, LEFT), -1)):
            T[face, 6 * j + 3:6 * j + 6], T[face, apart] = np.eye(3), sign * np.eye(3) / 2
    return T.T @ K @ T, T.T @ M @ T, T


def write(folder, N, engine_order, harmonics, force, omega, points):
    """The cases of the sector and of the whole ring. The sector's goes from omega[0] towards omega[1] over so many points, the ring's
    is of one point, which `write_start` gives it."""
    K, M, T = matrices(N)
    press = np.zeros(9)
    press[RIGHT.stop - 1], press[LEFT.stop - 1] = PRESS, -PRESS
    P = T.T @ np.tile(press, N)
    F = T.T @ np.kron(np.eye(N), FORCE[:, None])
    of_sector = [np.r_[6 * j:6 * j + 6, 6 * N + 3 * j:6 * N + 3 * j + 3] for j in range(N)]

    def of_index(matrix, h, columns):
        blocks = sum(matrix[np.ix_(of_sector[0], columns[j])] * np.exp(-2j * np.pi * h * j / N) for j in range(N))
        return blocks if h else blocks.real

    models = [cyclic_sector.reduced(of_index(K, h, of_sector), of_index(M, h, of_sector), of_index(F, h, [[j] for j in range(N)]),
                                    P[of_sector[0]], 6, 6) for h in range(N // 2 + 1)]
    with h5py.File(folder / "sector.h5", "w") as file:
        put(file, models[0], ["tip"])
        file.create_group("cyclic").attrs["sectors"] = N
        for h, model in enumerate(models[1:], 1):
            file[f"cyclic/{h}/Kaa"] = model["Kaa"]
            file[f"cyclic/{h}/Max"] = cyclic_sector.parts(model["Mxa"].conj().T)
            for key in ("Mxx", "Kxx", "Fa", "Fx"):
                file[f"cyclic/{h}/{key}"] = cyclic_sector.parts(model[key])
    with h5py.File(folder / "ring.h5", "w") as file:
        put(file, cyclic_sector.reduced(K, M, F, P, 6 * N, 6 * N), [f"tip_{j}" for j in range(N)])
    sector = case(folder, "sector", 1, harmonics, [("tip", [0.0, force, 0.0])],
                  f"excitation.engine_order = {engine_order}\n"
                  f"continuation = {{ omega = {list(omega)}, adaptive = true, step = 0.05, max_points = {points} }}\n")
    loads = [(f"tip_{j}", course.tolist()) for j, course in enumerate(courses(N, engine_order, force))]
    return sector, case(folder, "ring", N, harmonics, loads, 'continuation = { omega = [1, 1], start = "start.h5" }\n')


def put(file, model, patterns):
    file.attrs["format"], file.attrs["version"], file.attrs["force_names"] = "dovetail-reduced", 1, patterns
    for key in ("Kaa", "Kxx", "Mxx", "Fa", "Fx", "R"):
        file[key] = model[key]
    file["Max"] = model["Mxa"].T


def case(folder, name, points, harmonics, loads, more):
    path = folder / name / "case.toml"
    path.parent.mkdir()
    path.write_text(
        f'reduced = "../{name}.h5"\ndamping.stiffness = {DAMPING}\n'
        f'harmonic_balance = {{ harmonics = {harmonics}, samples = "exact" }}\n'
        "newton = { step_tolerance = 1e-9, residual_tolerance = 1e-9 }\nstability.enabled = true\naccuracy.estimates = false\n"
        + "".join(f"contact.{key} = {[value] * points}\n" for key, value in CONTACT.items()) + more
        + "".join(f'[[excitation.load]]\npattern = "{pattern}"\nfourier = {course}\n' for pattern, course in loads))
    return cases.Case(path, None, None, {})


def courses(N, engine_order, force):
    """Fourier coefficients (N, 3) of the load of every sector."""
    return np.array([later([0.0, force, 0.0], j * 2 * np.pi * engine_order / N) for j in range(N)])


def all_sectors(rows, N, engine_order):
    """Motions (N n, 2H+1) of all sectors, from (n, 2H+1) of the first."""
    return np.array([later(row, j * 2 * np.pi * engine_order / N) for j in range(N) for row in rows])


def write_start(ring, N, engine_order, force, omega, coefficients):
    """Let `ring` begin with the wave of a sector's coefficients (6 + 3, 2H+1) at omega; motions of its contacts then."""
    X = all_sectors(coefficients[6:], N, engine_order)
    folder = ring.path.parent
    with h5py.File(folder.parent / "ring.h5") as file:
        squares, coupling, F = file["Kaa"][()], file["Max"][()], file["Fa"][()]
    course = courses(N, engine_order, force)
    a = np.zeros((len(squares), X.shape[1]))
    for k in range(1, (X.shape[1] + 1) // 2):
        motion, w = X[:, 2 * k - 1] - 1j * X[:, 2 * k], k * omega
        load = F.T @ (course[:, 1] - 1j * course[:, 2]) if k == 1 else 0
        modal = (load + w**2 * coupling @ motion) / (squares * (1 + 1j * w * DAMPING) - w**2)
        a[:, 2 * k - 1], a[:, 2 * k] = modal.real, -modal.imag
    with h5py.File(folder / "start.h5", "w") as file:
        file.attrs["format"], file.attrs["version"] = "dovetail-results", 1
        file["points/omega"], file["points/coefficients"] = [omega], np.vstack([a, X])[None]
    text = ring.path.read_text()
    ring.path.write_text(re.sub(r"omega = \[.*?\]", f"omega = [{omega!r}, {omega!r}]", text))
    return X
