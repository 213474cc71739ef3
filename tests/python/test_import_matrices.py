"""Bare matrices in every format they come in, what is refused, and a model file that the program takes."""

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from petsc4py import PETSc

from dovetail import Model
from dovetail.importers import matrices
from launch import BINARY, words_of

N = 7
BESIDE = [-1.0 - i / 9 for i in range(N - 1)]
K = sp.diags([BESIDE, [4.0 + i / 7 for i in range(N)], BESIDE], [-1, 0, 1]).tocsr()
M = sp.diags([1.0 + i / 3 for i in range(N)]).tocsr()
FORCE, PRELOAD = np.arange(N) / 3, np.linspace(-1, 1, N)
ZERO_BASED = np.array([[1, 2, 3], [6, 5, 4]])
CASE = """model = "model.h5"
[reduction]
modes = 1
[damping]
stiffness = 0.01
[excitation]
fourier = [0, 1, 0]
[contact]
normal_stiffness = 1.0
tangential_stiffness = 1.0
friction = 0.3
gap = 0.0
[harmonic_balance]
harmonics = 3
[continuation]
omega = [0.5, 1.0]
step = 0.1
"""


def check(path, **extra):
    model = Model.read(path)
    np.testing.assert_allclose(model.K.toarray(), K.toarray(), rtol=1e-15)
    np.testing.assert_allclose(model.M.toarray(), M.toarray(), rtol=1e-15)
    np.testing.assert_array_equal(model.contact_dofs, ZERO_BASED)
    np.testing.assert_allclose(model.force, extra.get("force", np.zeros(N)), rtol=1e-15)
    np.testing.assert_allclose(model.preload, extra.get("preload", np.zeros(N)), rtol=1e-15)
    return model


def dofs_file(folder, text="2 3 4\n7 6 5\n"):
    (folder / "contact.txt").write_text(text)
    return f"contact_dofs={folder / 'contact.txt'}"


def market(folder, symmetry="symmetric"):
    for name, matrix in (("K", K), ("M", M)):
        scipy.io.mmwrite(str(folder / f"{name}.mtx"), matrix, symmetry=symmetry, precision=17)
    return [f"{name}={folder / name}.mtx" for name in "KM"]


@pytest.mark.parametrize("symmetry", ["symmetric", "general"])
def test_matrix_market(tmp_path, symmetry):
    said = matrices.convert([*market(tmp_path, symmetry), dofs_file(tmp_path), "index_base=1"], tmp_path / "m.h5")
    assert said == ("full model: 7 degrees of freedom, 2 contact points; nothing was removed; not given, taken as zero: force, preload")
    check(tmp_path / "m.h5")


def test_zero_based_dofs_and_loads_from_text(tmp_path):
    (tmp_path / "f.txt").write_text("# amplitude\n" + "\n".join(repr(float(value)) for value in FORCE))
    (tmp_path / "p.txt").write_text(", ".join(repr(float(value)) for value in PRELOAD))
    words = [*market(tmp_path), dofs_file(tmp_path, "1 2 3\n6 5 4\n"), "index_base=0", f"force={tmp_path / 'f.txt'}",
             f"preload={tmp_path / 'p.txt'}"]
    matrices.convert(words, tmp_path / "m.h5")
    check(tmp_path / "m.h5", force=FORCE, preload=PRELOAD)


def variables():
    return {"K": K, "M": M, "contact_dofs": ZERO_BASED + 1.0, "index_base": 1.0, "force": FORCE[:, None], "preload": PRELOAD[:, None],
            "friction": np.array([[0.3, 0.4], [0.5, 0.6]]), "gap": np.array([[1e-3], [2e-3]]), "normal_stiffness": 5.0}


def check_contact(model):
    np.testing.assert_array_equal(model.contact["friction"], [[0.3, 0.4], [0.5, 0.6]])
    np.testing.assert_array_equal(model.contact["gap"], [1e-3, 2e-3])
    np.testing.assert_array_equal(model.contact["normal_stiffness"], [5, 5])


@pytest.mark.parametrize("version", ["5", "4"])
def test_matlab_up_to_version_7(tmp_path, version):
    scipy.io.savemat(tmp_path / "model.mat", variables() | {"unrelated": 3.0}, format=version)
    matrices.convert([tmp_path / "model.mat"], tmp_path / "m.h5")
    check_contact(check(tmp_path / "m.h5", force=FORCE, preload=PRELOAD))


def write_v73(path, values):
    """As MATLAB lays its v7.3 files out: HDF5 behind a text of 512 bytes, columns first, sparse matrices as data, ir, jc."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in values.items():
            if sp.issparse(value):
                value = value.tocsc()
                group = file.create_group(name)
                group.attrs["MATLAB_class"], group.attrs["MATLAB_sparse"] = np.bytes_("double"), np.uint64(value.shape[0])
                group["data"], group["ir"], group["jc"] = value.data, value.indices.astype(np.uint64), value.indptr.astype(np.uint64)
            else:
                file[name] = np.atleast_2d(value).T
                file[name].attrs["MATLAB_class"] = np.bytes_("double")
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def test_matlab_version_7_3(tmp_path):
    write_v73(tmp_path / "model.mat", variables())
    matrices.convert([tmp_path / "model.mat"], tmp_path / "m.h5")
    check_contact(check(tmp_path / "m.h5", force=FORCE, preload=PRELOAD))


@pytest.mark.parametrize("write", [scipy.io.savemat, write_v73])
@pytest.mark.parametrize("load, other", [("force", "F"), ("preload", "P"), ("force", "Force")])
def test_loads_under_other_names_are_not_taken_as_zero(tmp_path, write, load, other):
    values = variables()
    values[other] = values.pop(load)
    write(tmp_path / "model.mat", values)
    with pytest.raises(ValueError, match=f"model.mat: the variable {other} is not read; rename it {load}"):
        matrices.convert([tmp_path / "model.mat"], tmp_path / "m.h5")
    (tmp_path / "given.txt").write_text("\n".join(map(repr, values[other].ravel().tolist())))
    matrices.convert([tmp_path / "model.mat", f"{load}={tmp_path / 'given.txt'}"], tmp_path / "m.h5")
    check(tmp_path / "m.h5", force=FORCE, preload=PRELOAD)


def test_matlab_dense_and_mixed_with_others(tmp_path):
    write_v73(tmp_path / "K.mat", {"K": K.toarray()})
    scipy.io.savemat(tmp_path / "rest.mat", {"contact_dofs": ZERO_BASED + 1, "index_base": 1})
    matrices.convert([f"K={tmp_path / 'K.mat'}", market(tmp_path)[1], tmp_path / "rest.mat"], tmp_path / "m.h5")
    check(tmp_path / "m.h5")


def petsc_file(path, thing):
    viewer = PETSc.Viewer().createBinary(str(path), "w", comm=PETSc.COMM_SELF)
    thing.view(viewer)
    viewer.destroy()
    return path


def petsc_matrix(matrix, kind="aij"):
    size = matrix.shape[0]
    made = PETSc.Mat().create(PETSc.COMM_SELF)
    made.setSizes((size, size))
    made.setType(kind)
    made.setUp()
    matrix = matrix.tocoo()
    for i, j, value in zip(matrix.row, matrix.col, matrix.data):
        if kind != "sbaij" or i <= j:
            made.setValue(i, j, value)
    made.assemble()
    return made


def test_petsc_binary(tmp_path):
    words = [f"{name}={petsc_file(tmp_path / name, petsc_matrix(matrix))}" for name, matrix in (("K", K), ("M", M))]
    words.append(f"force={petsc_file(tmp_path / 'f', PETSc.Vec().createWithArray(FORCE, comm=PETSc.COMM_SELF))}")
    matrices.convert([*words, dofs_file(tmp_path), "index_base=1"], tmp_path / "m.h5")
    check(tmp_path / "m.h5", force=FORCE)


def one_entry(row, column, value, matrix=K):
    changed = matrix.tolil()
    changed[row, column] = value
    return changed.tocsr()


@pytest.mark.parametrize("name, matrix, words", [
    ("K", sp.tril(K), ["K.mtx, K", "only the lower triangle", "declare the matrix symmetric"]),
    ("M", sp.triu(K), ["M.mtx, M", "only the upper triangle"]),
    ("K", one_entry(2, 3, 9.0), ["K.mtx, K", "symmetric", "row 3, column 4"]),
    ("K", K[:, :6], ["K.mtx, K", "7 x 6"]),
    ("K", K * 1j, ["K.mtx, K", "complex"]),
    ("M", M[:5, :5], ["M.mtx, M", "wanted 7 rows", "found 5"]),
    ("K", one_entry(4, 4, np.nan), ["K.mtx, K", "row 5, column 5", "not finite"]),
])
def test_wrong_matrices_are_refused(tmp_path, name, matrix, words):
    files = market(tmp_path)
    scipy.io.mmwrite(str(tmp_path / f"{name}.mtx"), matrix, symmetry="general")
    refused([*files, dofs_file(tmp_path), "index_base=1"], tmp_path, words)


def refused(files, folder, words):
    with pytest.raises(ValueError) as caught:
        matrices.convert(files, folder / "m.h5")
    for word in words:
        assert word in str(caught.value), str(caught.value)
    assert not (folder / "m.h5").exists()


@pytest.mark.parametrize("text, base, words", [
    ("2 3 4\n7 6 5\n", None, ["index_base is missing", "index_base=1", "MATLAB"]),
    ("2 3 4\n7 6 5\n", "2", ["index_base must be 0 or 1", "2"]),
    ("0 1 2\n", "1", ["contact.txt", "row 1", "from 1 to 7", "found 0"]),
    ("1 2 3\n4 5 7\n", "0", ["contact.txt", "row 2", "from 0 to 6", "found 7"]),
    ("1 2 2.5\n", "1", ["contact.txt", "whole numbers", "2.5"]),
    ("1 2\n", "1", ["contact.txt", "shape (N_x, 3)"]),
    ("1 2 3\n4 5\n", "1", ["contact.txt, line 2", "wanted 3 numbers"]),
    ("1 2 x3\n", "1", ["contact.txt, line 1", "'x3'"]),
    ("1 2 3\n3 4 5\n", "1", ["contact_dofs must not repeat"]),
    ("", "1", ["contact.txt", "wanted numbers"]),
])
def test_wrong_contact_dofs_are_refused(tmp_path, text, base, words):
    files = [*market(tmp_path), dofs_file(tmp_path, text)] + ([f"index_base={base}"] if base else [])
    refused(files, tmp_path, words)


def test_unreadable_files_are_refused(tmp_path):
    files = [*market(tmp_path), dofs_file(tmp_path), "index_base=1"]
    whole = (tmp_path / "K.mtx").read_text()
    (tmp_path / "K.mtx").write_text(whole[:len(whole) // 2])
    refused(files, tmp_path, ["K.mtx", "Matrix Market"])
    (tmp_path / "K.mtx").write_text(whole.replace("symmetric", "skew-symmetric"))
    refused(files, tmp_path, ["K.mtx", "skew-symmetric"])
    (tmp_path / "K.mtx").write_text("1 2 3\n")
    refused(files, tmp_path, ["K.mtx, K", "%%MatrixMarket"])
    petsc_file(tmp_path / "cut", petsc_matrix(K))
    (tmp_path / "cut").write_bytes((tmp_path / "cut").read_bytes()[:200])
    refused([f"K={tmp_path / 'cut'}", *files[1:]], tmp_path, ["cut", "PETSc"])
    (tmp_path / "bad.mat").write_bytes(b"MATLAB 5.0 MAT-file".ljust(200, b"\1"))
    refused([tmp_path / "bad.mat", *files], tmp_path, ["bad.mat", "MATLAB"])
    scipy.io.savemat(tmp_path / "other.mat", {"stiffness": K})
    refused([f"K={tmp_path / 'other.mat'}", *files[1:]], tmp_path, ["other.mat", "variable K"])
    with pytest.raises(OSError, match="gone.mtx"):
        matrices.convert([f"K={tmp_path / 'gone.mtx'}", *files[1:]], tmp_path / "m.h5")


def test_one_triangle_from_petsc_is_refused(tmp_path):
    files = [*market(tmp_path), dofs_file(tmp_path), "index_base=1"]
    path = petsc_file(tmp_path / "half", petsc_matrix(K, "sbaij"))
    refused([f"K={path}", *files[1:]], tmp_path, ["half, K", "only the upper triangle"])


def test_wrong_names_and_sizes_are_refused(tmp_path):
    files = [*market(tmp_path), dofs_file(tmp_path), "index_base=1"]
    refused(files[1:], tmp_path, ["missing K"])
    refused([*files, "forces=f.txt"], tmp_path, ["forces", "did you mean force"])
    refused([*files, files[0]], tmp_path, ["K is given twice"])
    (tmp_path / "f.txt").write_text("1\n2\n3\n")
    refused([*files, f"force={tmp_path / 'f.txt'}"], tmp_path, ["f.txt, force", "7", "(3, 1)"])
    scipy.io.savemat(tmp_path / "text.mat", {"force": "a text"})
    refused([*files, tmp_path / "text.mat"], tmp_path, ["text.mat, variable force", "real numbers"])
    write_v73(tmp_path / "v73.mat", {"M": M})
    with h5py.File(tmp_path / "v73.mat", "r+") as file:
        file["M/jc"][-1] = 99
    refused([files[0], *files[2:], tmp_path / "v73.mat"], tmp_path, ["v73.mat, variable M", "do not fit together"])


def test_the_program_takes_the_model(tmp_path):
    write_v73(tmp_path / "model.mat", variables())
    matrices.convert([tmp_path / "model.mat"], tmp_path / "model.h5")
    (tmp_path / "case.toml").write_text(CASE)
    out, _ = words_of([str(BINARY), "run", str(tmp_path / "case.toml"), "--dry-run"])
    assert "7" in out and "2 contact points" in out
