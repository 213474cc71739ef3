"""Numbers and words out of an HDF5 file that may be damaged, incomplete, or of another program."""

import os
import re
import time
from contextlib import contextmanager

import h5py
import numpy as np

DENSEST = 4096  # bytes of values per byte of file: deflate packs 1032 to 1 at best, and values never written take no place
READ_ATTEMPTS, READ_PAUSE = 10, 0.1  # a run may be in the middle of a write: number of tries, seconds between them
COMMANDS = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]|\r(?!\n)")  # to a terminal, in text of a file
KINDS = {"f": ("numbers", "iufb", np.float64), "i": ("whole numbers", "iu", np.int64)}


@contextmanager
def opened(path):
    """The open file. Whatever is wrong with it is a ValueError that names it."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            yield file
    except (OSError, KeyError, RuntimeError) as error:
        raise ValueError(f"{path}: cannot be read: {error.args[-1] if error.args else error}") from error
    except ValueError as error:
        if str(path) in str(error):
            raise
        raise ValueError(f"{path}: {error}") from error


def patiently(path, function, what="results file"):
    """function(open file) of a file that a run may be writing. It is closed at once, so that the run is never kept waiting.

    Whatever is wrong is a ValueError that names the file.
    """
    if os.path.isdir(path):
        raise ValueError(f"{path}: is a folder; a {what} is wanted")
    if not os.path.isfile(path):
        raise ValueError(f"{path}: no such file")
    for attempt in range(READ_ATTEMPTS):
        try:
            with h5py.File(path, "r", locking=False) as file:
                return function(file)
        except (OSError, KeyError, RuntimeError) as error:
            if attempt == READ_ATTEMPTS - 1:
                raise ValueError(f"{path}: not a readable {what}: {error.args[-1] if error.args else error}") from error
            time.sleep(READ_PAUSE)
        except ValueError as error:  # of the checks
            raise ValueError(f"{path}: {error}") from None


def dataset(group, name, shape=None, kind="f"):
    """A dataset below an open file or group, not read yet.

    Parameters
    ----------
    group : h5py.Group
    name : str
    shape : tuple of int, optional
        Size along each axis, None for any, ... at the end for any further axes; default any shape.
    kind : str
        "f": numbers; "i": whole numbers.

    Raises
    ------
    KeyError
        When there is none of that name.
    ValueError
        When it is no dataset, or of another type or shape, or promises more values than the file can hold.
    """
    place = f"{group.name.rstrip('/')}/{name}"
    try:
        item = group[name]
    except (KeyError, OSError, RuntimeError):  # the latter two for links that lead nowhere or round in circles
        raise KeyError(f"{place} is missing") from None
    what, kinds, _ = KINDS[kind]
    if not isinstance(item, h5py.Dataset) or item.shape is None or item.dtype.kind not in kinds:
        raise ValueError(f"{place}: wanted {what}, found {_in_words(item)}")
    if shape is not None and not _fits(item.shape, shape):
        said = ", ".join({None: "any", ...: "..."}.get(n, str(n)) for n in shape)
        raise ValueError(f"{place}: wanted shape ({said}), found {item.shape}")
    if item.is_virtual or item.external:  # files that were not named here would be read, and of any size
        raise ValueError(f"{place}: its values are in other files; write them into this one")
    if not _fits_its_file(item):
        raise ValueError(f"{place}: has shape {item.shape}, more than the file can hold: it is damaged, or this was never written")
    return item


def numbers(group, name, shape=None, kind="f"):
    """The values of `dataset`, as float64 or int64; those that int64 cannot hold are a ValueError too."""
    values = np.asarray(dataset(group, name, shape, kind)[()])
    if kind == "i" and values.dtype == np.uint64 and values.size and int(values.max()) > np.iinfo(np.int64).max:
        raise ValueError(f"{group.name.rstrip('/')}/{name}: {values.max()} is too large")
    return values.astype(KINDS[kind][2])


def members(file, name):
    """Names in a group, none if there is no such group."""
    if name not in file:
        return []
    if not isinstance(file[name], h5py.Group):
        raise ValueError(f"/{name}: wanted a group, found {_in_words(file[name])}")
    if strange := [member for member in file[name] if text(member) != member]:
        raise ValueError(f"/{name}: the name {strange[0]!r} holds what is no text")
    return list(file[name])


def attribute(item, name, otherwise=None):
    """An attribute as h5py gives it; `otherwise` where it is missing, empty or of a type that h5py does not know."""
    try:
        value = item.attrs.get(name, otherwise)
    except (OSError, RuntimeError, TypeError, ValueError):
        return otherwise
    return otherwise if isinstance(value, h5py.Empty) else value


def words(item, name, otherwise=""):
    """An attribute as text, however it was stored (fixed or variable length, h5py or C)."""
    value = attribute(item, name, otherwise)
    if isinstance(value, np.ndarray):
        value = value.reshape(-1)[0] if value.size else otherwise
    return text(value)


def text(value):
    """Bytes or a string of HDF5 as str; what is no UTF-8 in it, or a command to a terminal, is replaced, so that it can be printed."""
    value = value if isinstance(value, bytes) else str(value).encode("utf-8", "surrogateescape")
    return COMMANDS.sub("\ufffd", value.decode("utf-8", "replace"))


def whole(item, name):
    """An attribute that is one whole number, not negative."""
    value = np.asarray(attribute(item, name, "nothing"))
    if value.size != 1 or value.dtype.kind not in "iu" or value.min() < 0:
        raise ValueError(f"{item.name}: attribute {name} must be one whole number from 0 on, found {str(value)[:40]}")
    return int(value.item())


def _fits(found, wanted):
    if wanted and wanted[-1] is ...:
        found, wanted = found[:len(wanted) - 1], wanted[:-1]
    return len(found) == len(wanted) and all(n in (None, m) for n, m in zip(wanted, found))


def _fits_its_file(item):
    return item.size * item.dtype.itemsize <= DENSEST * os.path.getsize(item.file.filename)


def _in_words(item):
    if not isinstance(item, h5py.Dataset):
        return f"a {type(item).__name__.lower()}"
    return "nothing" if item.shape is None else f"values of type {item.dtype}"
