"""A bladed disk of six sectors by one of them: the reduced matrices of every spatial index, written without Dovetail's reduction.

The sector and its loads are those of whole_rotor.py; cyclic.npz holds what an independent program says of few modes.
"""

from functools import lru_cache
from pathlib import Path

import h5py
import numpy as np
import scipy.linalg

from sector_model import FREE, SECTOR, contacts, matrix, transform
from whole_rotor import CASES, DATA, N

__all__ = ["CASES", "FEW", "given", "write", "write_start"]

FEW = np.load(Path(__file__).with_name("data") / "cyclic.npz")


def given(name):
    """Arrays of a case, by their names."""
    return {key.split("/")[1]: DATA[key] for key in DATA.files if key.startswith(f"{name}/")}


def index(k, engine_order):
    """h of harmonic k in -N/2 < h <= N/2."""
    h = k * engine_order % N
    return h - N if 2 * h > N else h


def reduced(K, M, F, P, elastic, modes):
    """The Craig-Bampton model of Hermitian K, M and loads F (n, patterns); R by P, and the basis (n, unknowns)."""
    e, c = slice(None, elastic), slice(elastic, None)
    squares, phi = scipy.linalg.eigh(K[e, e], M[e, e], subset_by_index=(0, modes - 1))
    psi = np.linalg.solve(K[e, e], -K[e, c])
    whole = np.vstack([psi, np.eye(psi.shape[1])])
    moving = np.vstack([phi, np.zeros((psi.shape[1], modes))])
    return {"Kaa": squares, "Kxx": K[c, c] + K[c, e] @ psi, "Mxx": whole.conj().T @ M @ whole, "Mxa": whole.conj().T @ M @ moving,
            "Fa": (moving.conj().T @ F).T, "Fx": (whole.conj().T @ F).T, "R": -(whole.conj().T @ P),
            "basis": np.hstack([moving, whole])}


def of_every_index(name, modes=None):
    """Reduced models of h = 0 .. N/2 of a case, the first one real; "basis": displacements of the sector's free dofs."""
    return [dict(model) for model in _of_every_index(name, modes)]


@lru_cache
def _of_every_index(name, modes):
    case = given(name)
    points = contacts()[:len(case["gap"])]
    free = np.repeat(3 * FREE, 3) + np.tile(range(3), len(FREE))
    K, M = matrix("K"), matrix("M")
    F = np.array([SECTOR[f"pattern_{pattern}"][free] for pattern in case["patterns"]]).T
    models = []
    for h in range(N // 2 + 1):
        T = transform(h, points)
        T = T.real if h == 0 else T
        H, elastic = T.conj().T, T.shape[1] - 3 * len(points)
        models.append(reduced(H @ (K @ T), H @ (M @ T), H @ F, H @ SECTOR["preload"][free], elastic, modes or elastic))
        models[-1]["basis"] = T @ models[-1]["basis"]
    return models


def parts(values):
    """Real and imaginary ones along a last axis."""
    return np.stack([values.real, values.imag], axis=-1)


def write(folder, name, omega, samples=3072, modes=None, further=""):
    """reduced.h5 and case.toml of a case at one frequency; path of the case, and its reduced models by index."""
    case, models = given(name), of_every_index(name, modes)
    points = len(case["gap"])
    with h5py.File(folder / "sector.h5", "w") as file:
        file.attrs["format"], file.attrs["version"], file.attrs["force_names"] = "dovetail-reduced", 1, case["patterns"].tolist()
        first = models[0]
        for key in ("Kaa", "Kxx", "Mxx", "Fa", "Fx", "R"):
            file[key] = first[key]
        file["Max"] = first["Mxa"].T
        file.create_group("cyclic").attrs["sectors"] = N
        for h, model in enumerate(models[1:], 1):
            file[f"cyclic/{h}/Kaa"] = model["Kaa"]
            file[f"cyclic/{h}/Max"] = parts(model["Mxa"].conj().T)
            for key in ("Mxx", "Kxx", "Fa", "Fx"):
                file[f"cyclic/{h}/{key}"] = parts(model[key])
    loads = "".join(f'[[excitation.load]]\npattern = "{pattern}"\nfourier = {series.tolist()}\n'
                    for pattern, series in zip(case["patterns"], case["fourier"]))
    contact = {"normal_stiffness": case["kn"], "tangential_stiffness": case["kt"], "friction": case["mu"], "gap": case["gap"]}
    (folder / "case.toml").write_text(
        f'reduced = "sector.h5"\ndamping.stiffness = {float(DATA["sector/xi"])!r}\n'
        f"excitation.engine_order = {int(case['engine_order'])}\n"
        f"harmonic_balance = {{ harmonics = {int(case['H'])}, samples = {samples} }}\n"
        "newton = { step_tolerance = 1e-6, residual_tolerance = 1e-6 }\n"
        + "".join(f"contact.{key} = {values.tolist()}\n" for key, values in contact.items())
        + f"continuation.omega = [{omega!r}, {omega!r}]\n" + further + loads)
    assert points == len(models[0]["R"]) // 3
    return folder / "case.toml", models


def write_start(folder, name, omega, models, X):
    """start.h5, from which the case then begins: contact motions X (3 N_x, 2H+1), and what the modes do then."""
    case = given(name)
    a = np.zeros((len(models[0]["Kaa"]), X.shape[1]))
    a[:, 0] = case["fourier"][:, 0] @ models[0]["Fa"] / models[0]["Kaa"]
    for k in range(1, (X.shape[1] + 1) // 2):
        h = index(k, int(case["engine_order"]))
        model = models[abs(h)]
        turned = np.conj if h < 0 else np.asarray
        force, motion = ((values[..., 2 * k - 1] - 1j * values[..., 2 * k]) for values in (case["fourier"], X))
        w = k * omega
        modal = (force @ turned(model["Fa"]) + w**2 * turned(model["Mxa"]).conj().T @ motion) / (
            model["Kaa"] * (1 + 1j * w * float(DATA["sector/xi"])) - w**2)
        a[:, 2 * k - 1], a[:, 2 * k] = modal.real, -modal.imag
    path = folder / "case.toml"
    path.write_text(path.read_text().replace("continuation.omega", 'continuation.start = "start.h5"\ncontinuation.omega', 1))
    with h5py.File(folder / "start.h5", "w") as file:
        file.attrs["format"], file.attrs["version"] = "dovetail-results", 1
        file.attrs["sectors"], file.attrs["engine_order"] = N, case["engine_order"]
        file["points/omega"], file["points/coefficients"] = [omega], np.vstack([a, X])[None]
