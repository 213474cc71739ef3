"""Small valid files of each kind Dovetail reads, and what can be wrong with one: every edit on every dataset and attribute of it.

A file with random bytes mostly tests the HDF5 library; these are whole HDF5 files with something in them that does not belong.
"""

import sys

import h5py
import numpy as np
import scipy.sparse as sp

K = np.array([[10, -10, 0, 0, 0], [-10, 20, -10, 0, 0], [0, -10, 20, -10, 0], [0, 0, -10, 20, -10], [0, 0, 0, -10, 20]], dtype=float)
HUGE = (2**31, 2**40, 2**62)
OTHER_TYPES = {"int8": "i1", "uint64": "u8", "big_endian": ">f8", "big_int": ">i4", "half": "f2", "long_double": "g", "complex": "c16",
               "bool": "?", "text": "S3", "words": h5py.string_dtype(), "compound": [("a", "i4"), ("b", "f8")], "opaque": "V8",
               "reference": h5py.ref_dtype, "lists": h5py.vlen_dtype("f8")}
NUMBERS = {"nan": np.nan, "inf": np.inf, "minus_inf": -np.inf, "minus_one": -1, "zero": 0, "huge": 1e308, "tiny": 1e-310, "int_max": 2**31,
           "long_max": 2**63 - 1, "long_min": -2**63}


def model(file):
    """Five dofs, one contact point, a mesh with a set and a changed dof."""
    file.attrs["format"], file.attrs["version"], file.attrs["units"] = "dovetail-model", 1, "SI"
    for name, matrix in (("K", K), ("M", np.eye(5))):
        columns = sp.csc_matrix(matrix)
        file.create_group(name).attrs["MATLAB_sparse"] = np.uint64(5)
        parts = {"data": columns.data, "ir": columns.indices.astype(np.uint64), "jc": columns.indptr.astype(np.uint64)}
        for key, values in parts.items():
            file[name][key] = values
    file["force"], file["preload"] = [1.0, 1, 0, 0, 0], [1.0, 0.1, 0.1, 0.1, 0.1]
    file["forces/lift"] = [0.0, 1, 0, 0, 1]
    file["contact/dofs"] = np.array([[2, 3, 4]])
    file["contact/normal_stiffness"], file["contact/gap"] = [1.0], [-3.5]
    file["contact/tangential_stiffness"], file["contact/friction"] = [[1.0, 2.0]], [[0.5, 0.5]]
    file["contact/position"], file["contact/axes"] = np.zeros((1, 3)), np.eye(3)[None]
    file["contact/area"], file["contact/joint"] = [1.0], [0]
    file["contact"].attrs["joints"] = np.array([b"joint"])
    file["mesh/nodes"] = np.eye(4)[:, :3]
    file["mesh/dof_node"], file["mesh/dof_direction"] = [0, 0, 1, 1, 1], [0, 1, 0, 1, 2]
    file["mesh/cells/tetra"], file["mesh/sets/tip"] = [[0, 1, 2, 3]], [1, 3]
    file["mesh/changed/dof"], file["mesh/changed/begin"] = [1], [0, 2]
    file["mesh/changed/column"], file["mesh/changed/value"] = [1, 2], [1.0, -1.0]


def reduced(file):
    """Two modes, one contact point, recovery of the two elastic dofs."""
    file.attrs["format"], file.attrs["version"], file.attrs["source"] = "dovetail-reduced", 1, "0123 with 2 modes"
    file.attrs["units"], file.attrs["model"], file.attrs["modes_counted"] = "SI", "model.h5", 1
    file.attrs["force_names"] = ["force"]
    file["Kaa"], file["Fa"], file["Max"] = [1.0, 4.0], [1.0, 0.5], np.full((2, 3), 0.1)
    file["Kxx"], file["Mxx"], file["Fx"], file["R"] = K[2:, 2:], np.eye(3), np.ones(3), np.ones(3)
    file["recovery/contact_dofs"], file["recovery/elastic_dofs"] = [[2, 3, 4]], [0, 1]
    file["recovery/xe0"], file["recovery/Phi"], file["recovery/Psi"] = np.zeros(2), np.eye(2), np.ones((2, 3))


def results(file):
    """Three points of two modes, one contact point and one harmonic."""
    file.attrs["format"], file.attrs["version"], file.attrs["reduced"] = "dovetail-results", 1, "reduced.h5"
    for name, value in {"harmonics": 1, "samples": 16, "modes": 2, "contact_points": 1, "ranks": 1}.items():
        file.attrs[name] = value
    for name in ("title", "case", "units", "program"):
        file.attrs[name] = "text"
    points = file.create_group("points")
    coefficients = np.sin(np.arange(45.0)).reshape(3, 5, 3)
    points.create_dataset("coefficients", data=coefficients, maxshape=(None, 5, 3), chunks=(4, 5, 3))
    for name in ("omega", "arclength", "residual", "seconds", "stick", "slip", "open", "multiplier"):
        points.create_dataset(name, data=[0.9, 1.0, 1.1], maxshape=(None,), chunks=(4,))
    for name in ("newton_iterations", "linear_iterations", "stable", "instability", "harmonics"):
        points.create_dataset(name, data=np.array([1, 0, 1], dtype="i4"), maxshape=(None,), chunks=(4,))
    for name in ("stick", "slip", "open", "dissipation", "events"):
        points.create_dataset(f"contact/{name}", data=np.ones((3, 1), dtype="i4" if name == "events" else "f8"), maxshape=(None, 1))
    file["events/kind"], file["events/point"] = np.array([1, 0], dtype="i4"), np.array([1, 1], dtype="i4")
    file["events/omega"], file["events/amplitude"] = [1.0, 1.05], [0.5, 0.4]
    file["events/kind"].attrs["names"] = "fold peak branch stability"
    file["contact/law"], file["contact/normal_stiffness"], file["contact/gap"] = [0], [1.0], [0.0]
    file["contact/tangential_stiffness"], file["contact/friction"] = [[1.0, 1.0]], [[0.3, 0.3]]
    file["preload/xp"], file["preload/g"], file["preload/w"] = np.ones(3), np.ones(3), np.zeros((1, 2))


KINDS = {"model": model, "reduced": reduced, "results": results}


def _values(shape, dtype):
    """Something of a shape and type, or None where there is nothing to write."""
    try:
        return np.ones(shape).astype(dtype)
    except (TypeError, ValueError):
        return None


def _replaced(make):
    """An edit that puts another dataset in the place of one."""
    def edit(file, name):
        old = file[name][()] if isinstance(file.get(name), h5py.Dataset) else np.ones(1)
        if name in file:
            del file[name]
        make(file, name, np.asarray(old))
    return edit


def _typed(dtype):
    def make(file, name, old):
        set_ = file.create_dataset(name, old.shape, dtype)
        values = _values(old.shape, set_.dtype)
        if values is not None and set_.dtype.kind in "iufcSb":
            set_[...] = values
    return _replaced(make)


def _valued(change):
    def make(file, name, old):
        with np.errstate(all="ignore"):
            file[name] = change(old.copy())
    return _replaced(make)


def _with(number, everywhere):
    def change(old):
        fits = old.dtype.kind == "f" or isinstance(number, int) and np.iinfo(old.dtype).min <= number <= np.iinfo(old.dtype).max
        values = old if fits else old.astype(float)
        values[(Ellipsis if everywhere else -1) if values.ndim else ()] = number
        return values
    return _valued(change)


def _linked(link):
    def make(file, name, old):
        file[name] = link
    return _replaced(make)


def _made(**options):
    def make(file, name, old):
        file.create_dataset(name, data=np.atleast_1d(old), **options)
    return _replaced(make)


def _promised(shape_of, **options):
    """A dataset of some shape in which nothing was ever written."""
    return _replaced(lambda file, name, old: file.create_dataset(name, shape_of(old.shape), old.dtype, **options))


def _virtual(file, name, old):
    layout = h5py.VirtualLayout(old.shape or (1,), old.dtype)
    layout[...] = h5py.VirtualSource("absent.h5", "x", old.shape or (1,))
    file.create_virtual_dataset(name, layout)


def _group(file, name, old):
    file.create_group(name)


def _empty(file, name, old):
    file[name] = h5py.Empty(old.dtype)


def _committed(file, name, old):
    file[name] = old.dtype


DATASET_EDITS = {
    "deleted": _replaced(lambda file, name, old: None), "group": _replaced(_group), "empty": _replaced(_empty),
    "committed_type": _replaced(_committed), "virtual": _replaced(_virtual),
    "dangling_link": _linked(h5py.SoftLink("/nowhere")), "group_link": _linked(h5py.SoftLink("/")),
    "external_link": _linked(h5py.ExternalLink("absent.h5", "/x")),
    "own_link": _replaced(lambda file, name, old: file.__setitem__(name, h5py.SoftLink("/" + name))),
    "gzip": _made(compression="gzip"), "lzf": _made(compression="lzf"), "checksum": _made(fletcher32=True, shuffle=True),
    "raw_file": _promised(lambda shape: shape or (1,), external=[("absent.bin", 0, h5py.h5f.UNLIMITED)]),
    "unwritten": _promised(lambda shape: shape), "chunks_unwritten": _promised(lambda shape: shape or (1,), chunks=True),
    "scalar": _valued(lambda old: old.reshape(-1)[0]), "nothing": _valued(lambda old: old[:0] if old.ndim else old.reshape(1)[:0]),
    "column": _valued(lambda old: old.reshape(-1, 1)), "row": _valued(lambda old: old.reshape(1, -1)),
    "flat": _valued(lambda old: old.reshape(-1)), "transposed": _valued(lambda old: old.T), "deeper": _valued(lambda old: old[None]),
    "longer": _valued(lambda old: np.concatenate([np.atleast_1d(old)] * 2)), "shorter": _valued(lambda old: np.atleast_1d(old)[:-1]),
    "wider": _valued(lambda old: np.stack([old, old], axis=-1)), "no_columns": _valued(lambda old: np.zeros((*old.shape, 0))),
    "reversed": _valued(lambda old: old.reshape(-1)[::-1].reshape(old.shape)), "raised": _valued(lambda old: old + 1),
    "as_float": _valued(lambda old: old + 0.5), "as_int": _valued(lambda old: old.astype(int)),
}
DATASET_EDITS |= {f"as_{name}": _typed(dtype) for name, dtype in OTHER_TYPES.items()}
DATASET_EDITS |= {f"{name}_{'all' if all_ else 'last'}": _with(value, all_) for name, value in NUMBERS.items() for all_ in (True, False)}
DATASET_EDITS |= {f"promises_{n}": _promised(lambda shape, n=n: (n, *shape[1:]), chunks=True) for n in HUGE}
DATASET_EDITS |= {f"promises_{n}_wide": _promised(lambda shape, n=n: (*shape, n), chunks=True) for n in HUGE[:2]}

ATTRIBUTES = {
    "empty": h5py.Empty("f8"), "no_entry": np.zeros(0), "list": np.array([1, 2, 3]), "matrix": np.ones((20, 20)), "text": "1",
    "bytes": b"\xff\xfe", "fixed_text": np.bytes_("x" * 300), "texts": np.array([b"a" * 50, b"b"] * 40), "long_text": "x" * 60000,
    "words": np.array(["a", "b"], dtype=h5py.string_dtype()), "compound": np.zeros(1, dtype=OTHER_TYPES["compound"]), "true": True,
    "float": 1.5, "nan": np.nan, "complex": 1j, "minus_one": -1, "zero": 0, "int_max": 2**31, "long_max": np.uint64(2**64 - 1),
}


def _attribute(value):
    def edit(file, place):
        name, _, key = place.rpartition("@")
        if name in file:
            if key in file[name].attrs:
                del file[name].attrs[key]
            if value is not None:
                file[name].attrs[key] = value
    return edit


ATTRIBUTE_EDITS = {"without": _attribute(None)} | {name: _attribute(value) for name, value in ATTRIBUTES.items()}


def places(file):
    """Names of the datasets and groups of an open file, and "group@attribute" of its attributes."""
    items, attributes = [], [f"/@{key}" for key in file.attrs]

    def visit(name, item):
        items.append(name)
        attributes.extend(f"{name}@{key}" for key in item.attrs)

    file.visititems(visit)
    return items, attributes


def all_edits(kind):
    """Every ("place edit", function of the file) of a kind."""
    with h5py.File("places", "w", driver="core", backing_store=False) as file:
        KINDS[kind](file)
        return list(edits_of(file))


def edits_of(file):
    """Every ("place edit", function of the file) for what is in an open file."""
    items, attributes = places(file)
    for names, edits in ((items, DATASET_EDITS), (attributes, ATTRIBUTE_EDITS)):
        for name in names:
            for label, edit in edits.items():
                yield f"{name} {label}", lambda file, edit=edit, name=name: edit(file, name)


def write(path, kind, edits):
    """A file of a kind with edits done to it; those that cannot follow each other (a dataset in a deleted group) are left out."""
    latest = len(edits) % 2 == 0  # both formats of file in which HDF5 writes
    with h5py.File(path, "w", libver="latest" if latest else "earliest") as file:
        KINDS[kind](file)
        apply(file, edits)


def apply(file, edits):
    for edit in edits:
        try:
            edit(file)
        except (KeyError, OSError, TypeError, ValueError, RuntimeError, AttributeError, OverflowError, IndexError):
            pass


if __name__ == "__main__":  # good files of every kind, in both formats, in the folder named
    for kind in KINDS:
        write(f"{sys.argv[1]}/{kind}.h5", kind, [])
        write(f"{sys.argv[1]}/{kind}_old.h5", kind, [lambda file: None])
