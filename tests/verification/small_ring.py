"""A ring of few sectors that touch their neighbours, twice: as one sector, and as a structure that knows no cyclic symmetry.

A sector has a disk and two faces of a shroud, three directions each. The right face touches the left one of the next sector.
"""

import h5py
import numpy as np

import cases
import cyclic_sector
from whole_rotor import later

DISK, LEFT, RIGHT = (slice(3 * i, 3 * i + 3) for i in range(3))
DAMPING = 0.004  # times stiffness [s]
CONTACT = {"normal_stiffness": 2.0, "tangential_stiffness": [1.0, 1.0], "friction": [0.3, 0.3], "gap": 0.0}
PRESS = 1.0  # of the faces on one another, if nothing else held them
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


def write(folder, N, engine_order, harmonics, force, omega, more="", **contact):
    """The two cases, of the sector and of the whole ring, over frequencies `omega`: a first one, a last one and others between."""
    K, M, T = matrices(N)
    press = np.zeros(9)
    press[RIGHT.stop - 1], press[LEFT.stop - 1] = PRESS, -PRESS
    P = T.T @ np.tile(press, N)
    F = T.T @ np.kron(np.eye(N), FORCE[:, None])
    of_sector = [np.r_[6 * j:6 * j + 6, 6 * N + 3 * j:6 * N + 3 * j + 3] for j in range(N)]

    def of_index(matrix, h, columns):
        blocks = (matrix[np.ix_(of_sector[0], columns[j])] * np.exp(-2j * np.pi * h * j / N) for j in range(N))
        return sum(blocks) if h else sum(blocks).real

    models = [cyclic_sector.reduced(of_index(K, h, of_sector), of_index(M, h, of_sector), of_index(F, h, [[j] for j in range(N)]),
                                    P[of_sector[0]], 6, 6) for h in range(N // 2 + 1)]
    whole = cyclic_sector.reduced(K, M, F, P, 6 * N, 6 * N)
    values = CONTACT | contact
    made = []
    for name, patterns in (("sector", ["tip"]), ("ring", [f"tip_{j}" for j in range(N)])):
        with h5py.File(folder / f"{name}.h5", "w") as file:
            file.attrs["format"], file.attrs["version"], file.attrs["force_names"] = "dovetail-reduced", 1, patterns
            first = models[0] if name == "sector" else whole
            for key in ("Kaa", "Kxx", "Mxx", "Fa", "Fx", "R"):
                file[key] = first[key]
            file["Max"] = first["Mxa"].T
            if name == "sector":
                file.create_group("cyclic").attrs["sectors"] = N
                for h, model in enumerate(models[1:], 1):
                    file[f"cyclic/{h}/Kaa"] = model["Kaa"]
                    file[f"cyclic/{h}/Max"] = cyclic_sector.parts(model["Mxa"].conj().T)
                    for key in ("Mxx", "Kxx", "Fa", "Fx"):
                        file[f"cyclic/{h}/{key}"] = cyclic_sector.parts(model[key])
        series = [later([0.0, force, 0.0], j * 2 * np.pi * engine_order / N).tolist() for j in range(len(patterns))]
        loads = "".join(f'[[excitation.load]]\npattern = "{pattern}"\nfourier = {course}\n' for pattern, course in zip(patterns, series))
        path = folder / f"{name}.toml"
        path.write_text(
            f'reduced = "{name}.h5"\ndamping.stiffness = {DAMPING}\n'
            + (f"excitation.engine_order = {engine_order}\n" if name == "sector" else "")
            + f'harmonic_balance = {{ harmonics = {harmonics}, samples = "exact" }}\n'
            "newton = { step_tolerance = 1e-9, residual_tolerance = 1e-9 }\nstability.enabled = true\naccuracy.estimates = false\n"
            + "".join(f"contact.{key} = {[value] * (1 if name == 'sector' else N)}\n" for key, value in values.items())
            + f"continuation = {{ omega = {[omega[0], omega[-1]]}, at = {list(omega[1:-1])}, adaptive = true, step = 0.05 }}\n"
            f'output.directory = "{name}"\n' + more + loads)
        made.append(cases.Case(path, None, None, {}))
    return made


def write_start(folder, N, engine_order, omega, coefficients, force):
    """start.h5 of the ring: the wave of a sector's `coefficients` (dofs, 2H+1), which begins with 6 elastic ones."""
    X = np.concatenate([later_rows(coefficients[6:], j * 2 * np.pi * engine_order / N) for j in range(N)])
    with h5py.File(folder / "ring.h5") as file:
        squares, coupling, F = file["Kaa"][()], file["Max"][()], file["Fa"][()]
    a = np.zeros((len(squares), X.shape[1]))
    course = np.array([later([0.0, force, 0.0], j * 2 * np.pi * engine_order / N) for j in range(N)])
    for k in range(1, (X.shape[1] + 1) // 2):
        motion, w = X[:, 2 * k - 1] - 1j * X[:, 2 * k], k * omega
        load = F.T @ (course[:, 1] - 1j * course[:, 2]) if k == 1 else 0
        modal = (load + w**2 * coupling @ motion) / (squares * (1 + 1j * w * DAMPING) - w**2)
        a[:, 2 * k - 1], a[:, 2 * k] = modal.real, -modal.imag
    with h5py.File(folder / "start.h5", "w") as file:
        file.attrs["format"], file.attrs["version"] = "dovetail-results", 1
        file["points/omega"], file["points/coefficients"] = [omega], np.vstack([a, X])[None]


def later_rows(rows, phase):
    return np.array([later(row, phase) for row in rows])
