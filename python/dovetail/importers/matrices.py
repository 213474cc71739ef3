"""Bare matrices: Matrix Market, MATLAB (v4 to v7.3), PETSc binary, plain text for vectors.

`NAME=FILE` for each of K, M, contact_dofs and, if wanted, force, preload and contact parameters; or one MATLAB file that holds
variables of these names. `index_base=1` (or 0) says how contact_dofs counts and must be given: nothing else can tell.
"""

import difflib
from pathlib import Path

import h5py
import numpy as np
import scipy.io
import scipy.sparse as sp

from .. import hdf5_read
from ..model import CONTACT_WIDTH, Model
from ..petsc_begin import petsc
from .apart import apart
from .whole import whole

MATRICES = ("K", "M")
LOADS = ("force", "preload")
NAMES = MATRICES + ("contact_dofs", "index_base") + LOADS + tuple(CONTACT_WIDTH)
PETSC_MAT, PETSC_VEC = 1211216, 1211214  # the numbers that PETSc's binary files begin with


def convert(files, output):
    """Read the matrices in `files` and write a model file.

    Parameters
    ----------
    files : list of str
        "NAME=FILE" with a name in NAMES, "index_base=0" or "index_base=1", or MATLAB files with variables of these names.
    output : str
        Model file to write.

    Returns
    -------
    str
        What was written, in words.
    """
    given = collect(files)
    absent = [name for name in ("K", "M", "contact_dofs") if name not in given]
    if absent:
        raise ValueError(f"missing {', '.join(absent)}: give them as NAME=FILE or as variables of a .mat file; "
                         f"found {', '.join(given) or 'nothing'}")
    K, M = (whole(given[name][0], given[name][1], symmetric=given[name][2]) for name in MATRICES)
    if K.shape != M.shape:
        raise ValueError(f"{given['M'][1]}: wanted {K.shape[0]} rows as in {given['K'][1]}, found {M.shape[0]}")
    n = K.shape[0]
    dofs = _contact_dofs(given, n)
    loads = {name: _column(given[name], n) for name in LOADS if name in given}
    contact = {name: _parameter(given[name], len(dofs)) for name in CONTACT_WIDTH if name in given}
    Model(K, M, dofs, **loads, contact=contact).write(output)
    zero = [name for name in LOADS if name not in loads]
    return (f"full model: {n} degrees of freedom, {len(dofs)} contact points; nothing was removed"
            + (f"; not given, taken as zero: {', '.join(zero)}" if zero else ""))


def collect(files):
    """Every value given, by name: (value, where it stands, whether the file says that it is symmetric)."""
    given, whole_files = {}, []

    def add(name, value):
        if name in given:
            raise ValueError(f"{value[1]}: {name} is given twice, first in {given[name][1]}")
        given[name] = value

    for word in map(str, files):
        name, equals, rest = word.partition("=")
        if not equals:
            whole_files.append(word)
            for key, value in _variables(word).items():
                add(key, (value, f"{word}, variable {key}", False))
        elif name not in NAMES:
            close = difflib.get_close_matches(name, NAMES, n=1)
            raise ValueError(f"{word}: unknown name {name}; " + (f"did you mean {close[0]}?" if close else f"known: {', '.join(NAMES)}"))
        elif name == "index_base":
            add(name, (rest, word, False))
        else:
            add(name, read_file(rest, name))
    for path in whole_files:
        _refuse_misnamed(path, given)
    return given


def read_file(path, name):
    """One matrix or vector from a file of any known format: (value, where, whether the file says symmetric)."""
    with open(path, "rb") as stream:
        head = stream.read(16)
    where = f"{path}, {name}"
    if head.lower().startswith(b"%%matrixmarket"):
        value, symmetric = _matrix_market(path)
        return value, where, symmetric
    if int.from_bytes(head[:4], "big") in (PETSC_MAT, PETSC_VEC):
        return _petsc(path), where, False
    if Path(path).suffix.lower() == ".mat" or h5py.is_hdf5(path):
        variables = _variables(path)
        if name not in variables:
            raise ValueError(f"{path}: wanted a variable {name}, found {', '.join(variables) or 'none of ' + ', '.join(NAMES)}")
        return variables[name], f"{path}, variable {name}", False
    if name in MATRICES:
        raise ValueError(f"{where}: wanted a Matrix Market file (first line %%MatrixMarket ...), a MATLAB .mat file or a PETSc binary file")
    return _text(path), where, False


def _matrix_market(path):
    try:
        field, symmetry = scipy.io.mminfo(path)[4:]
        if field == "pattern" or symmetry == "skew-symmetric":
            raise ValueError(f"wanted numbers, symmetric or general, found {field}, {symmetry}")
        return scipy.io.mmread(path), symmetry == "symmetric"
    except (ValueError, IndexError, OverflowError, MemoryError, TypeError, AttributeError) as error:
        raise ValueError(f"{path}: not a readable Matrix Market file: {error}") from None


def _petsc(path):
    PETSc = petsc()
    with open(path, "rb") as stream:
        kind = int.from_bytes(stream.read(4), "big")
    viewer = PETSc.Viewer().createBinary(str(path), "r", comm=PETSc.COMM_SELF)
    try:
        if kind == PETSC_VEC:
            return PETSc.Vec().create(PETSc.COMM_SELF).load(viewer).getArray().copy()
        matrix = PETSc.Mat().create(PETSc.COMM_SELF)
        matrix.setType("aij")
        matrix.load(viewer)
        indptr, indices, data = matrix.getValuesCSR()
        return sp.csr_matrix((data, indices, indptr), shape=matrix.getSize())
    except PETSc.Error as error:
        raise ValueError(f"{path}: PETSc cannot read it (error {error.ierr}); is it cut off, or written with 64-bit indices or "
                         "complex numbers?") from None
    finally:
        viewer.destroy()


def _text(path):
    try:
        with open(path, encoding="utf-8-sig") as stream:
            rows = [(number, line.split("#")[0].replace(",", " ").split()) for number, line in enumerate(stream, start=1)]
    except UnicodeDecodeError:
        raise ValueError(f"{path}: neither text nor a Matrix Market, MATLAB .mat or PETSc binary file") from None
    rows = [(number, words) for number, words in rows if words]
    if not rows:
        raise ValueError(f"{path}: wanted numbers, found none")
    for number, words in rows:
        if len(words) != len(rows[0][1]):
            raise ValueError(f"{path}, line {number}: wanted {len(rows[0][1])} numbers as in the lines above, found {len(words)}")
        for word in words:
            try:
                float(word)
            except ValueError:
                raise ValueError(f"{path}, line {number}: wanted a number, found {word[:30]!r}") from None
    return np.array([words for _, words in rows], dtype=np.float64)


def _variables(path):
    """The variables of a MATLAB file that have a name in NAMES."""
    if h5py.is_hdf5(path):
        with hdf5_read.opened(path) as file:
            return {name: _v73(file, name, f"{path}, variable {name}") for name in NAMES if name in file}
    return apart(lambda: _loaded(path), path)


def _refuse_misnamed(path, given):
    """Loads under the names that the equations give them would be taken as zero."""
    if h5py.is_hdf5(path):
        with hdf5_read.opened(path) as file:
            names = list(file)
    else:
        names = apart(lambda: _names(path), path)
    for load, letter in zip(LOADS, "FP"):
        other = next((name for name in names if name.lower() in (load, letter.lower()) and name != load), None)
        if other and load not in given:
            raise ValueError(f"{path}: the variable {other} is not read; rename it {load} ({letter} of the equations), or, if it is "
                             "something else, leave it out")


def _names(path):
    try:
        return [name for name, _, _ in scipy.io.whosmat(path)]
    except Exception as error:  # as in _loaded
        if isinstance(error, OSError) and error.filename is not None:
            raise
        raise ValueError(f"{path}: not a readable MATLAB file: {error}") from None


def _loaded(path):
    try:
        found = scipy.io.loadmat(path, variable_names=NAMES)
    except Exception as error:  # loadmat raises many kinds for a file that is cut off or none at all
        if isinstance(error, OSError) and error.filename is not None:
            raise
        raise ValueError(f"{path}: not a readable MATLAB file: {error}") from None
    for name in NAMES:
        if sp.issparse(found.get(name)):
            _check_sparse(found[name], f"{path}, variable {name}")
    return {name: found[name] for name in NAMES if name in found}


def _v73(file, name, where):
    """A variable of a v7.3 file, which is HDF5 with columns first."""
    if isinstance(file[name], h5py.Group) and "MATLAB_sparse" in file[name].attrs:
        jc = hdf5_read.numbers(file, f"{name}/jc", (None,), "i")
        ir, data = np.zeros(0, np.int64), np.zeros(0)
        if f"{name}/ir" in file or f"{name}/data" in file:  # left out by MATLAB where there are no entries
            ir, data = hdf5_read.numbers(file, f"{name}/ir", (None,), "i"), hdf5_read.numbers(file, f"{name}/data", (None,))
        rows = hdf5_read.whole(file[name], "MATLAB_sparse")
        try:
            matrix = sp.csc_matrix((data, ir, jc), shape=(rows, jc.size - 1))
        except ValueError:
            raise ValueError(f"{where}: column pointers, row numbers and values do not fit together") from None
        _check_sparse(matrix, where)
        return matrix
    kind = hdf5_read.words(file[name], "MATLAB_class", "something else")
    if not isinstance(file[name], h5py.Dataset) or kind in ("char", "cell", "logical"):
        raise ValueError(f"{where}: wanted numbers, found {kind}")
    return hdf5_read.numbers(file, name).T


def _check_sparse(matrix, where):
    """SciPy itself trusts the indices of a matrix, and reads and writes wherever they point."""
    if not hasattr(matrix, "check_format"):  # COO, whose indices are checked when it is made
        return
    try:
        matrix.check_format(full_check=True)
    except ValueError as error:
        raise ValueError(f"{where}: column pointers, row numbers and values do not fit together: {error}") from None


def _numbers(given):
    value, where, _ = given
    value = value.toarray() if sp.issparse(value) else np.asarray(value)
    if value.dtype.kind not in "iuf":
        raise ValueError(f"{where}: wanted real numbers, found {value.dtype}")
    return value.astype(np.float64), where


def _column(given, n):
    values, where = _numbers(given)
    if values.size != n or max(values.shape) != n:
        raise ValueError(f"{where}: wanted one number per degree of freedom, {n}, found shape {values.shape}")
    return values.reshape(-1)


def _parameter(given, n_points):
    """A contact parameter as Model wants it: a number, (N_x,), (2,) or (N_x, 2)."""
    values, _ = _numbers(given)
    return values.reshape(-1) if 1 in values.shape and values.size in (n_points, 2) and n_points > 1 else np.squeeze(values)


def _contact_dofs(given, n):
    """Zero-based, (N_x, 3)."""
    if "index_base" not in given:
        raise ValueError("index_base is missing: say index_base=1 if contact_dofs counts the rows of K from 1 (as MATLAB and Fortran do), "
                         "index_base=0 if from 0 (in a .mat file: a variable index_base)")
    base, base_where, _ = given["index_base"]
    base = np.squeeze(base).tolist()
    if base not in (0, 1, "0", "1"):
        raise ValueError(f"{base_where}: index_base must be 0 or 1, found {base}")
    base = int(base)
    values, where = _numbers(given["contact_dofs"])
    if values.ndim != 2 or values.shape[1] != 3 or len(values) == 0:
        raise ValueError(f"{where}: wanted one row t1, t2, n per contact point, shape (N_x, 3), found shape {values.shape}")
    wrong = ~((values == np.round(values)) & (values >= base) & (values < n + base))
    if wrong.any():
        row, column = np.argwhere(wrong)[0]
        raise ValueError(f"{where}, row {row + 1}: wanted whole numbers from {base} to {n - 1 + base} (index_base={base}), "
                         f"found {values[row, column]:g}")
    return values.astype(np.int64) - base
