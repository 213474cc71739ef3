"""Writes a results file from given arrays, as the compiled core would."""

import h5py
import numpy as np

from dovetail import reference

SAMPLES = 256  # per period


def write(path, omega, coefficients, modes, contact, xp=None, w=None, reduced="", title="synthetic", samples=SAMPLES, events=None,
          units="SI", watch="", **points):
    """contact: dict of (N_x,) or (N_x, 2) arrays; events: list of (kind, point, omega, amplitude, unknown); points: extra (n,) datasets;
    returns path."""
    coefficients = np.asarray(coefficients, dtype=float)
    n, rows, size = coefficients.shape
    n_points = (rows - modes) // 3
    xp = np.zeros(3 * n_points) if xp is None else xp
    w = np.zeros((n_points, 2)) if w is None else w
    defaults = {"arclength": np.arange(n), "newton_iterations": 3 * np.ones(n), "linear_iterations": np.ones(n),
                "residual": np.zeros(n), "seconds": 0.1 * np.ones(n), "stick": np.ones(n), "slip": np.zeros(n), "open": np.zeros(n)}
    with h5py.File(path, "w") as file:
        file.attrs.update({"format": "dovetail-results", "version": 1, "harmonics": (size - 1) // 2, "samples": samples, "modes": modes,
                           "contact_points": n_points, "case": "title = 'x'", "title": title, "reduced": str(reduced),
                           "units": units, "watch": watch})
        file["points/omega"] = np.asarray(omega, dtype=float)
        file["points/coefficients"] = coefficients
        for name, values in {**defaults, **points}.items():
            file[f"points/{name}"] = values
        X = coefficients[:, modes:].reshape(n, n_points, 3, size)
        for name, values in activity(X, contact, xp.reshape(-1, 3), w).items():
            file[f"points/contact/{name}"] = values
        for name, values in {"law": np.zeros(n_points, int), **contact}.items():
            file[f"contact/{name}"] = values
        if events is not None:
            kinds = sorted({event[0] for event in events})
            columns = list(zip(*events)) or [()] * 5
            file["events/kind"] = np.array([kinds.index(kind) for kind in columns[0]], int)
            file["events/kind"].attrs["names"] = " ".join(kinds)
            for name, values, kind in zip(("point", "omega", "amplitude", "unknown"), columns[1:], (int, float, float, int)):
                file[f"events/{name}"] = np.array(values, kind)
        file["preload/xp"] = xp
        file["preload/g"] = np.zeros(3 * n_points)
        file["preload/w"] = w
    return path


def activity(X, contact, xp, w):
    """What the points do, from the samples of their motion X (n, N_x, 3, 2H+1): datasets of /points/contact, (n, N_x) each."""
    x = np.swapaxes(reference.synthesis(X, SAMPLES), -1, -2)
    force, state = reference.law(x, xp, w, contact["normal_stiffness"], contact["tangential_stiffness"], contact["friction"],
                                 contact["gap"], contact.get("law", 0))
    is_open, slips = state[..., 0] == reference.OPEN, np.abs(state) == 1
    changes = [np.sum(what != np.roll(what, 1, axis=2), axis=2) for what in (is_open, slips[..., 0], slips[..., 1])]
    shares = {"open": is_open.mean(axis=2), "slip": slips.any(axis=3).mean(axis=2)}
    work = np.sum((force + np.roll(force, -1, axis=2)) / 2 * (np.roll(x, -1, axis=2) - x), axis=(2, 3))
    return {**shares, "stick": 1 - shares["open"] - shares["slip"], "events": sum(changes), "dissipation": work}
