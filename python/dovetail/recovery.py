"""Fields of the full model, put together from a branch and what its reduced file keeps of the modes. See `Results`."""

import numpy as np

from . import fourier
from .checked import whole_numbers
from .hdf5_read import dataset, opened, words
from .travelling_wave import amplitudes, series

OLD = "reduced.old.h5"  # where a run puts the reduced file of results that are there, when it makes another


def elastic(results, point, n, times, sector=None):
    """As `Results.elastic`."""
    if results.wave is not None or sector is not None:
        return _of_wave(results, point, n, times, sector)
    recovery = _stored(results, ("xe0", "Phi", "Psi"))
    motion = results.motion(point, n, times)
    contact = motion[:, results.modes:] + results.xp
    return _held(results, point) * recovery["xe0"] + motion[:, :results.modes] @ recovery["Phi"].T + contact @ recovery["Psi"].T


def unknowns(results, point, dofs, n, times, sector=None):
    """As `Results.unknowns`."""
    dofs = whole_numbers(dofs, "dofs", 0)
    row, column = _found(results, dofs)
    if results.wave is not None or sector is not None:
        return _of_wave(results, point, n, times, sector, row)
    motion = results.motion(point, n, times)
    contact_motion = motion[:, results.modes:] + results.xp
    values = np.empty((len(motion), dofs.size))
    values[:, column >= 0] = contact_motion[:, column[column >= 0]]
    row = row[row >= 0]
    if row.size:
        part = _stored(results, ("xe0", "Phi", "Psi"), slice(row.min(), row.max() + 1))
        xe0, Phi, Psi = (part[name][row - row.min()] for name in ("xe0", "Phi", "Psi"))
        values[:, column < 0] = _held(results, point) * xe0 + motion[:, :results.modes] @ Phi.T + contact_motion @ Psi.T
    return values


def rows(results, dofs, h=0):
    """Rows (k, N_a + 3 N_x): motion from the preload state of some unknowns of the full model, by those of `coefficients`.

    Of a sector of a cyclic structure those of a spatial index h, complex unless h = 0.
    """
    dofs = np.asarray(dofs, dtype=np.int64)
    row, column = _found(results, dofs)
    if h:
        return _of_index(results, h, row)
    values = np.zeros((dofs.size, results.modes + 3 * results.contact_points))
    values[np.flatnonzero(column >= 0), results.modes + column[column >= 0]] = 1.0
    row = row[column < 0]
    if row.size:
        part = _stored(results, ("Phi", "Psi"), slice(row.min(), row.max() + 1))
        values[column < 0] = np.hstack([part["Phi"], part["Psi"]])[row - row.min()]
    return values


def full(results, point, n, times, sector=None):
    """As `Results.full`."""
    recovery = _stored(results, ("elastic_dofs", "contact_dofs"))
    inner, contact = recovery["elastic_dofs"], recovery["contact_dofs"].reshape(-1)
    contact = contact[contact >= 0]  # -1 in a sector, whose unknowns are all displacements
    size = inner.size + contact.size
    if not np.array_equal(np.sort(np.concatenate([inner, contact])), np.arange(size)):
        raise ValueError(f"{results.reduced}: keeps {inner.size} elastic degrees of freedom only, not the full model; use elastic()")
    e = elastic(results, point, n, times, sector)
    field = np.empty((len(e), size))
    field[:, inner] = e
    if contact.size:
        field[:, contact] = results.motion(point, n, times)[:, results.modes:] + results.xp
    return field


def _held(results, point):
    """Factor on xe0, what the preload makes of the structure with the contact dofs held: that of a sweep over the preload."""
    return results.parameter[point] if results.parameter_name == "preload" else 1.0


def _of_wave(results, point, n, times, sector, row=None):
    """Total values (N, k) of rows of the recovery in a sector: each harmonic by the modes of its spatial index."""
    Z = amplitudes(results.coefficients_at(point, 0 if sector is None else sector))
    part = _stored(results, ("xe0", "Psi"), _span(row))
    rest = (_held(results, point) * part["xe0"] + part["Psi"] @ results.xp)[_within(row)]
    U = np.empty((len(rest), Z.shape[1]), complex)
    for h in np.unique(np.abs(results.wave.index)):
        values = _of_index(results, h, row)
        for of, harmonics in ((values, results.wave.index == h), (values.conj(), results.wave.index == -h)):
            if harmonics.any():
                U[:, harmonics] = of @ Z[:, harmonics]
    return rest + fourier.course(series(U), results.omega[point], n, times)


def _of_index(results, h, row=None):
    """Phi and Psi side by side (k, N_a + 3 N_x) of a spatial index, in some rows."""
    if h == 0:
        part = _stored(results, ("Phi", "Psi"), _span(row))
        return np.hstack([part["Phi"], part["Psi"]])[_within(row)]
    path, blocks = reduced_file(results), []
    with opened(path) as file:
        kept = len(dataset(file, "recovery/elastic_dofs", (None,), "i"))
        for kind, width in (("Phi", results.modes), ("Psi", 3 * results.contact_points)):
            name = f"cyclic/{abs(h)}/{kind}"
            if name not in file:
                raise ValueError(f"{path}: no recovery data ({name}); the run must start from a model file")
            parts = np.asarray(dataset(file, name, (kept, width, 2))[_span(row)], dtype=np.float64)
            blocks.append(parts[..., 0] + 1j * np.copysign(1, h) * parts[..., 1])
    return np.hstack(blocks)[_within(row)]


def _span(row):
    """The slice of a dataset that holds some rows, all for None; `_within` says where they are in it."""
    return slice(None) if row is None or not row.size else slice(row.min(), row.max() + 1)


def _within(row):
    return slice(None) if row is None else row - (row.min() if row.size else 0)


def reduced_file(results):
    """Path of the reduced file that results were computed with: the one they name, or where a later run has put it.

    Raises ValueError where it is not there, or another is.
    """
    others = []
    for path in (results.reduced, results.path.parent / OLD) if results.reduced else ():
        if not path.is_file():
            continue
        with opened(path) as file:
            found = words(file, "fingerprint")
        if not found or found == results.reduced_fingerprint or not results.reduced_fingerprint:
            return path
        others.append(path)
    if others:
        raise ValueError(f"{others[0]}: is not the one that {results.path} was computed with (another fingerprint); put that one back, or "
                         "run the case again")
    raise ValueError(f"{results.path}: the reduced file it was computed from is not there ({results.reduced})")


def _found(results, dofs):
    """For each of some dofs, its row among the elastic ones kept and its place among the contact dofs, -1 where it is not there."""
    recovery = _stored(results, ("elastic_dofs", "contact_dofs"))
    elastic = recovery["elastic_dofs"]
    row, column = _places(elastic, dofs), _places(recovery["contact_dofs"].reshape(-1), dofs)
    missing = dofs[(row < 0) & (column < 0)]
    if missing.size:
        raise ValueError(f"{results.reduced}: keeps {elastic.size} elastic degrees of freedom, and {missing.size} of the ones wanted "
                         f"are not among them, the first number {missing[0]}; output.motion says which are kept")
    return row, column


def _stored(results, names, rows=slice(None)):
    path = reduced_file(results)
    shapes = {"elastic_dofs": (None,), "contact_dofs": (results.contact_points, 3), "xe0": (None,), "Phi": (None, results.modes),
              "Psi": (None, 3 * results.contact_points)}
    with opened(path) as file:
        missing = [name for name in names if f"recovery/{name}" not in file]
        if missing:
            raise ValueError(f"{path}: no recovery data ({', '.join(missing)}); the run must start from a model file")
        found = {name: dataset(file, f"recovery/{name}", shapes[name], "i" if name.endswith("dofs") else "f") for name in names}
        lengths = {len(values) for name, values in found.items() if name != "contact_dofs"}
        if len(lengths) > 1:
            raise ValueError(f"{path}: recovery data of different lengths, {', '.join(map(str, sorted(lengths)))}")
        return {name: values[rows].astype(np.int64 if name.endswith("dofs") else np.float64) for name, values in found.items()}


def _places(known, wanted):
    """The row of each wanted number among the known ones (in any order), -1 where it is not there."""
    if not known.size:
        return np.full(wanted.shape, -1)
    order = np.argsort(known, kind="stable")
    place = order[np.searchsorted(known, wanted, sorter=order).clip(max=known.size - 1)]
    return np.where(known[place] == wanted, place, -1)
