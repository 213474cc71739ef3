"""Writes a results file from given arrays, as the compiled core would."""

import h5py
import numpy as np


def write(path, omega, coefficients, modes, contact, xp=None, w=None, reduced="", title="synthetic", **points):
    """contact: dict of (N_x,) or (N_x, 2) arrays; points: extra (n,) datasets; returns path."""
    coefficients = np.asarray(coefficients, dtype=float)
    n, rows, size = coefficients.shape
    n_points = (rows - modes) // 3
    defaults = {"arclength": np.arange(n), "newton_iterations": 3 * np.ones(n), "linear_iterations": np.ones(n),
                "residual": np.zeros(n), "seconds": 0.1 * np.ones(n), "stick": np.ones(n), "slip": np.zeros(n), "open": np.zeros(n)}
    with h5py.File(path, "w") as file:
        file.attrs.update({"format": "dovetail-results", "version": 1, "harmonics": (size - 1) // 2, "samples": 256, "modes": modes,
                           "contact_points": n_points, "case": "title = 'x'", "title": title, "reduced": str(reduced)})
        file["points/omega"] = np.asarray(omega, dtype=float)
        file["points/coefficients"] = coefficients
        for name, values in {**defaults, **points}.items():
            file[f"points/{name}"] = values
        for name, values in contact.items():
            file[f"contact/{name}"] = values
        file["preload/xp"] = np.zeros(3 * n_points) if xp is None else xp
        file["preload/g"] = np.zeros(3 * n_points)
        file["preload/w"] = np.zeros((n_points, 2)) if w is None else w
    return path
