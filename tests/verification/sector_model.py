"""The sector of rotor.npz as a model file with /cyclic, and what its reduced file says of every nodal diameter."""

import h5py
import numpy as np
import scipy.linalg
import scipy.sparse as sp

import whole_rotor

N, NODES = whole_rotor.N, whole_rotor.NODES
SECTOR = {name.split("/")[1]: whole_rotor.DATA[name] for name in whole_rotor.DATA.files if name.startswith("sector/")}
STIFFNESS = np.repeat([[5e7, 5e7, 1e8], [1e7, 1e7, 2e7]], [6, 2], axis=0)  # of the cases with shrouds: t1, t2, n
FREE = np.setdiff1d(np.arange(NODES), SECTOR["clamped"])
DOF = np.full((NODES, 3), -1)
DOF[FREE] = np.arange(3 * len(FREE)).reshape(-1, 3)
INNER = 3 * (len(FREE) - 6 - 2 * 2 - 2 * len(SECTOR["left"]))  # dofs off faces, root points and nodes of shrouds
ALL = INNER + 3 * 2 + 3 * len(SECTOR["left"])  # modes of a nodal diameter with the contact points held


def matrix(name):
    rows = np.ravel([3 * FREE + d for d in range(3)], order="F")
    whole = sp.csr_matrix(tuple(SECTOR[f"{name}_{part}"] for part in ("data", "indices", "indptr")))
    return whole[rows][:, rows].tocsc()


def put(file, name, A):
    A = sp.csc_matrix(A)
    A.sort_indices()
    group = file.create_group(name)
    group["data"], group["ir"], group["jc"] = A.data, A.indices, A.indptr
    group.attrs["MATLAB_sparse"] = A.shape[0]


def write_model(path, patterns=("lift",), points=8):
    """A model with the 6 contact points of the roots and, to the next sector, 2 of the shrouds or none."""
    rows = np.ravel([3 * FREE + d for d in range(3)], order="F")
    pairs = [np.column_stack([SECTOR[f"{part}_a"], SECTOR[f"{part}_b"]]) for part in ("root", "shroud")]
    with h5py.File(path, "w") as file:
        file.attrs["format"], file.attrs["version"] = "dovetail-model", 1
        for name in "KM":
            put(file, name, matrix(name))
        file["preload"] = SECTOR["preload"][rows]
        for pattern in patterns:
            file[f"forces/{pattern}"] = SECTOR[f"pattern_{pattern}"][rows]
        file["mesh/nodes"] = SECTOR["nodes"]
        file["mesh/dof_node"], file["mesh/dof_direction"] = np.repeat(FREE, 3), np.tile(np.arange(3), len(FREE))
        file["contact/nodes"] = np.concatenate(pairs)[:points]
        file["contact/axes"] = np.concatenate([SECTOR["root_axes"], SECTOR["shroud_axes"]])[:points]
        file["contact/normal_stiffness"], file["contact/tangential_stiffness"] = STIFFNESS[:points, 2], STIFFNESS[:points, :2]
        file["contact/friction"] = np.full((points, 2), 0.3)
        file["contact/gap"] = np.full(points, -3e-4)
        cyclic = file.create_group("cyclic")
        cyclic.attrs["sectors"], cyclic.attrs["axis"], cyclic.attrs["origin"] = N, [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]
        cyclic["left"], cyclic["right"] = DOF[SECTOR["left"]], DOF[SECTOR["right"]]
        cyclic["next_sector"] = np.repeat([0, 1], [6, 2])[:points]


def write_case(path, modes, interior_modes=None, exact=False):
    interior = "" if interior_modes is None else f"reduction.interior_modes = {interior_modes}\n"
    interior += "reduction.exact_modes = true\n" if exact else ""
    path.write_text(f'model = "model.h5"\nreduction.modes = {modes}\n{interior}harmonic_balance.harmonics = 3\n'
                    f'[excitation]\nengine_order = 1\n[[excitation.load]]\npattern = "lift"\nfourier = [0, 1]\n'
                    f'[continuation]\nomega = [1500.0, 3000.0]\n[stability]\nenabled = false\n')
    return path


def index(file, h):
    """K and M (n, n) of nodal diameter h, modes first, F (patterns, n), and the rows of the recovery (dofs, n)."""
    def values(name):
        if h == 0:
            return file[name][()]
        parts = file[f"cyclic/{h}/{name.split('/')[-1]}"][()]
        return parts[..., 0] + 1j * parts[..., 1]

    kaa, kxx, mxx, max_ = (values(name) if name != "Kaa" or h == 0 else file[f"cyclic/{h}/Kaa"][()]
                           for name in ("Kaa", "Kxx", "Mxx", "Max"))
    K = scipy.linalg.block_diag(np.diag(kaa), kxx)
    M = np.block([[np.eye(len(kaa)), max_], [max_.conj().T, mxx]])
    F = np.hstack([np.atleast_2d(values("Fa")), np.atleast_2d(values("Fx"))])
    order = np.argsort(file["recovery/elastic_dofs"][()])
    return K, M, F, np.hstack([values("recovery/Phi"), values("recovery/Psi")])[order]


def frequencies(K, M):
    """All, by the inverse problem, which is the accurate one where the spectrum is wide; K positive definite."""
    return 1 / np.sqrt(scipy.linalg.eigh(M, K, eigvals_only=True)[::-1])


def springs(modes):
    return np.diag(np.concatenate([np.zeros(modes), STIFFNESS.ravel()]))


def contacts():
    """Node a, node b, face as (node, weight), axes, and whether b is in the next sector, of each contact point."""
    return [(a, b, (), axes, beyond) for part, beyond in (("root", 0), ("shroud", 1))
            for a, b, axes in zip(SECTOR[f"{part}_a"], SECTOR[f"{part}_b"], SECTOR[f"{part}_axes"])]


def transform(h, points=None):
    """T_h (dofs, [plain nodes, sums, relative displacements]), written from the specification, sign by sign."""
    points = points or contacts()
    turn, phase = 2 * np.pi / N, np.exp(2j * np.pi * h / N)
    R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    touching = [node for a, b, *_ in points for node in (a, b)]
    plain = np.setdiff1d(FREE, np.concatenate([SECTOR["right"], touching]))
    pairs = [min(a, b) >= 0 for a, b, *_ in points]
    first = 3 * (len(plain) + sum(pairs))
    T = np.zeros((3 * len(FREE), first + 3 * len(points)), complex)
    right_of, column = dict(zip(SECTOR["left"], SECTOR["right"])), {node: 3 * k + np.arange(3) for k, node in enumerate(plain)}
    for node in plain:
        T[DOF[node], column[node]] = 1
        if node in right_of:
            T[np.ix_(DOF[right_of[node]], column[node])] = R / phase
    for k, (a, b, face, axes, beyond) in enumerate(points):
        both, apart = 3 * (len(plain) + sum(pairs[:k])) + np.arange(3), first + 3 * k + np.arange(3)
        seen = R / phase if beyond else np.eye(3)
        back, half = seen.conj().T, 0.5 if pairs[k] else 1.0
        if a >= 0:
            T[np.ix_(DOF[a], apart)] = half * axes.T
        if b >= 0:
            T[np.ix_(DOF[b], apart)] = -half * back @ axes.T
        if pairs[k]:
            T[np.ix_(DOF[a], both)], T[np.ix_(DOF[b], both)] = np.eye(3) / 2, back / 2
        for node, weight in face:
            T[np.ix_(DOF[a], column[node])] += weight * seen
    return T
