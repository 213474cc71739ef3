"""Writing and reading model files, serial and distributed; refusal of wrong input."""

import subprocess
import sys

import h5py
import numpy as np
import pytest
import scipy.sparse as sp

from dovetail import Model, hdf5_parts
from dovetail.model_cyclic import checked_cyclic
from launch import SECONDS, SURROUNDINGS


DISTRIBUTED = """
import os, sys
if sys.argv[2] == "turns":  # makes Debian load the h5py without MPI
    os.environ.pop("OMPI_COMM_WORLD_SIZE", None)
import h5py
import numpy as np
from petsc4py import PETSc
from dovetail import Model
comm = PETSc.COMM_WORLD
assert comm.size == int(sys.argv[3])
assert comm.size == 1 or h5py.get_config().mpi == (sys.argv[2] != "turns")
n = 23
K, M = (PETSc.Mat().createAIJ((n, n), nnz=(3, 3)) for _ in range(2))
first, last = K.getOwnershipRange()
for i in range(first, last):
    K[i, i], M[i, i] = 3.0 + i, 1.0
    for j in (i - 1, i + 1):
        if 0 <= j < n:
            K[i, j], M[i, j] = -1.0 / (1 + min(i, j)), 0.1
if sys.argv[2] == "unsymmetric" and last == n:
    K[n - 1, 0] = 5.0
K.assemble(), M.assemble()
force = K.createVecLeft()
force.setArray(np.arange(first, last) ** 2.0)
try:
    Model(K, M, np.array([[3, 4, 5], [12, 20, 13]]), force=force, preload=np.arange(n) / 7,
          contact={"friction": 0.3, "gap": [1.0, 2.0]}).write(sys.argv[1])
except ValueError as error:
    print(f"refused on rank {comm.rank}: {error}")
"""


MESH = {"nodes": np.zeros((1, 3)), "cells": {}, "dof_node": np.zeros(9, int), "dof_direction": np.zeros(9, int)}
JOINT = {"position": np.zeros((1, 3)), "axes": np.eye(3)[None], "area": [1.0], "joint": [0], "names": ["a"]}


def small(n=9, **changes):
    K = sp.diags([-1.0, 2.5, -1.0], [-1, 0, 1], shape=(n, n), format="csr")
    arguments = {"K": K, "M": sp.identity(n, format="csr") * 2, "contact_dofs": [[3, 1, 8]], "force": np.arange(n)}
    return Model(**{**arguments, **changes})


def contents(path):
    found = {}
    with h5py.File(path, "r") as file:
        def visit(name, thing):
            found.update({f"{name}@{key}": value for key, value in thing.attrs.items()})
            if isinstance(thing, h5py.Dataset):
                found[name] = thing[()]
        visit("", file)
        file.visititems(visit)
    return found


def test_file_has_the_documented_layout(tmp_path):
    K = sp.csr_matrix(np.array([[4.0, 0, -1, 0], [0, 5, 0, -2], [-1, 0, 6, 0], [0, -2, 0, 7]]))
    Model(K, sp.identity(4), [[1, 2, 3]], preload=[1, 2, 3, 4], contact={"friction": [0.1, 0.2]}).write(tmp_path / "m.h5")
    found = contents(tmp_path / "m.h5")
    assert found["@format"] == "dovetail-model" and found["@version"] == 1 and found["@units"] == "SI"
    assert found["K@MATLAB_sparse"] == 4 and found["K@MATLAB_sparse"].dtype == np.uint64
    assert found["K/jc"].dtype == found["K/ir"].dtype == np.uint64
    np.testing.assert_array_equal(found["K/data"], [4, -1, 5, -2, -1, 6, -2, 7])
    np.testing.assert_array_equal(found["K/ir"], [0, 2, 1, 3, 0, 2, 1, 3])
    np.testing.assert_array_equal(found["K/jc"], [0, 2, 4, 6, 8])
    np.testing.assert_array_equal(found["contact/dofs"], [[1, 2, 3]])
    np.testing.assert_array_equal(found["contact/friction"], [[0.1, 0.2]])
    np.testing.assert_array_equal(found["preload"], [1, 2, 3, 4])
    np.testing.assert_array_equal(found["force"], np.zeros(4))


def test_round_trip(tmp_path):
    mesh = {"nodes": np.random.rand(3, 3), "cells": {"line": [[0, 1], [1, 2]], "vertex": [[2]]}, "dof_node": np.r_[np.arange(8) // 3, -1],
            "dof_direction": np.r_[np.arange(8) % 3, -1], "sets": {"tip": [2], "side/left": [0, 1], "none": []},
            "materials": [(2e11, 0.3, 7850.0, "steel"), (7e10, 0.33, 2700.0, "aluminium")],
            "material": {"line": [1, 0], "vertex": [-1]},
            "integration": {"line": [0, 0], "vertex": [0]},
            "changed": {"dof": [3, 4], "begin": [0, 2, 3], "column": [3, 1, 8], "value": [0.5, -0.5, 1.0]}}
    joint = {"position": [[1.0, 2.0, 3.0]], "axes": np.eye(3)[None], "area": [0.25], "joint": [1], "names": ["left", "à droite"]}
    written = small(contact={"normal_stiffness": [5.0], "tangential_stiffness": 7.0, "gap": -1}, mesh=mesh, joint=joint, units="mm-N-s")
    written.write(tmp_path / "m.h5")
    read = Model.read(tmp_path / "m.h5")
    assert abs(read.K - written.K).max() == 0 and abs(read.M - written.M).max() == 0
    assert read.units == "mm-N-s" and read.joint["names"] == ["left", "à droite"]
    np.testing.assert_array_equal(read.force, written.force)
    np.testing.assert_array_equal(read.contact_dofs, [[3, 1, 8]])
    np.testing.assert_array_equal(read.contact["tangential_stiffness"], [[7.0, 7.0]])
    for key in ("nodes", "dof_node", "dof_direction"):
        np.testing.assert_array_equal(read.mesh[key], mesh[key])
    assert read.mesh["materials"] == written.mesh["materials"] and read.mesh["materials"][1].name == "aluminium"
    for group in ("cells", "sets", "material", "integration", "changed"):
        assert read.mesh[group].keys() == mesh[group].keys()
        for key, values in mesh[group].items():
            np.testing.assert_array_equal(read.mesh[group][key], values)
    for key in ("position", "axes", "area", "joint"):
        np.testing.assert_array_equal(read.joint[key], joint[key])


def test_exact_zeros_are_not_written(tmp_path):
    K = sp.csr_matrix(([3.0, 0.0, 0.0, 4.0, 5.0], ([0, 0, 1, 1, 2], [0, 1, 0, 1, 2])))
    Model(K, sp.identity(3), [[0, 1, 2]]).write(tmp_path / "m.h5")
    np.testing.assert_array_equal(contents(tmp_path / "m.h5")["K/data"], [3, 4, 5])


def test_blocks_are_put_in_place():
    rng = np.random.default_rng(1)
    A, B = (m + m.T for m in rng.random((2, 8, 8)))
    e, c = slice(0, 2), slice(2, 8)
    model = Model.from_blocks(A[e, e], A[e, c], A[c, c], B[e, e], B[e, c], B[c, c], Fe=[1, 2], Pc=np.arange(6))
    np.testing.assert_array_equal(model.K.toarray(), A)
    np.testing.assert_array_equal(model.M.toarray(), B)
    np.testing.assert_array_equal(model.contact_dofs, [[2, 3, 4], [5, 6, 7]])
    np.testing.assert_array_equal(model.force, [1, 2, 0, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(model.preload, [0, 0, 0, 1, 2, 3, 4, 5])
    equal = Model.from_blocks(*3 * [np.eye(3)], *3 * [np.eye(3)])  # numpy blocks of one shape
    np.testing.assert_array_equal(equal.K.toarray(), np.tile(np.eye(3), (2, 2)))


def test_other_loads_leave_the_rest_and_the_first_model():
    first = small(forces={"a": np.ones(9)})
    other = first.with_loads(preload=np.full(9, 3.0), forces={"b": np.full(9, 2.0)})
    np.testing.assert_array_equal(other.forces["b"], np.full(9, 2.0))
    np.testing.assert_array_equal(other.force, np.arange(9))
    np.testing.assert_array_equal(other.preload, np.full(9, 3.0))
    assert list(other.forces) == ["b"] and list(first.forces) == ["a"] and not first.preload.any()
    np.testing.assert_array_equal(first.with_loads(force=np.ones(9)).force, np.ones(9))


def test_another_stiffness_is_written_and_the_first_stays(tmp_path):
    first = small()
    first.with_stiffness(3 * first.K).write(tmp_path / "other.h5")
    first.write(tmp_path / "first.h5")
    np.testing.assert_array_equal(contents(tmp_path / "other.h5")["K/data"], 3 * contents(tmp_path / "first.h5")["K/data"])
    assert contents(tmp_path / "first.h5")["K/data"][0] == 2.5
    with pytest.raises(ValueError, match="K must be symmetric"):
        first.with_stiffness(sp.diags([1.0, 2.5], [-1, 0], shape=(9, 9)))


def test_patterns_without_a_course_are_cosines():
    assert small(forces={"a": np.ones(9)}).excitation() == (
        '[[excitation.load]]\npattern = "force"\nfourier = [0, 1]\n\n[[excitation.load]]\npattern = "a"\nfourier = [0, 1]\n')


@pytest.mark.parametrize("changes, message", [
    ({"K": sp.random(9, 8)}, r"K must be square, found shape \(9, 8\)"),
    ({"M": sp.identity(8)}, "same size, found 9 and 8"),
    ({"K": sp.diags([1.0, 2.5], [-1, 0], shape=(9, 9))}, r"K must be symmetric.* row 0"),
    ({"K": sp.diags([np.r_[1.0, np.nan, np.ones(7)]], [0])}, "K has an entry that is not finite in row 1"),
    ({"force": np.ones(5)}, "force must have one entry per degree of freedom, 9, found 5"),
    ({"preload": np.full(9, np.inf)}, "preload has an entry that is not finite"),
    ({"contact_dofs": [[0, 1, 9]]}, "contact_dofs must lie in 0 to 8, found 0 to 9"),
    ({"contact_dofs": [[0, 1, -1]]}, "contact_dofs must lie in 0 to 8, found -1 to 1"),
    ({"contact_dofs": [[0, 1, 2], [3, 1, 5]]}, "must not repeat, found 1 2 times"),
    ({"contact_dofs": [0, 1, 2]}, r"shape \(N_x, 3\).* found int64 of shape \(3,\)"),
    ({"contact_dofs": [[0.0, 1.0, 2.0]]}, "whole numbers.* found float64"),
    ({"contact_dofs": np.empty((0, 3), int)}, r"one row t1, t2, n per contact point, found int64 of shape \(0, 3\)"),
    ({"forces": {"force": np.ones(9)}}, '"force" is the name of the pattern'),
    ({"forces": {"a/b": np.ones(9)}}, "name of a load pattern must be a text without a slash"),
    ({"contact": {"normal_stiffness": 0.0}}, "normal_stiffness must be positive, found 0"),
    ({"contact": {"tangential_stiffness": [1.0, -2.0]}}, "tangential_stiffness must be positive, found -2"),
    ({"contact": {"friction": -0.1}}, "friction must not be negative, found -0.1"),
    ({"contact": {"friction": [1, 2, 3]}}, r"a number, \[t1, t2\] or one such pair per point"),
    ({"contact": {"gap": np.nan}}, "gap must be finite"),
    ({"contact": {"stiffness": 1.0}}, "unknown .'stiffness'.; known are"),
    ({"mesh": {"nodes": np.zeros((1, 3))}}, "mesh must have nodes, cells, dof_node, dof_direction and may .* found nodes"),
    ({"mesh": {**MESH, "nodes": np.zeros((1, 2))}}, r"mesh nodes must have shape \(n_nodes, 3\), found \(1, 2\)"),
    ({"mesh": {**MESH, "cells": {"line": [[0, 1]]}}}, "cells 'line' must be .* numbers of nodes, 0 to 0"),
    ({"mesh": {**MESH, "cells": [[0, 0]]}}, "cells must be a dict"),
    ({"mesh": {**MESH, "sets": {"tip": [-1]}}}, "set 'tip' must hold numbers of nodes, 0 to 0"),
    ({"mesh": {**MESH, "sets": {"tip": [0, 1]}}}, "set 'tip' must hold numbers of nodes, 0 to 0"),
    ({"mesh": {**MESH, "dof_direction": np.full(9, 6)}}, "dof_direction must have shape .9,. and values from -1 to 5"),
    ({"mesh": {**MESH, "changed": {"dof": [1], "begin": [0, 1], "column": [9], "value": [1.0]}}}, "columns 0 to 8"),
    ({"mesh": {**MESH, "changed": {"dof": [1], "begin": [0, 2], "column": [2], "value": [1.0]}}}, "values between begin"),
    ({"joint": {"position": [[0, 0, 0]]}}, "joint must have position, axes, area, joint, names, found position"),
    ({"joint": {**JOINT, "area": [1, 2]}}, r"joint area must have shape \(1,\), found \(2,\)"),
    ({"joint": {**JOINT, "joint": [1]}}, "joint numbers must lie in 0 to 0"),
])
def test_wrong_input_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        small(**changes)


CYCLIC = {"sectors": 3, "axis": [0, 0, 1], "origin": [0, 0, 0], "left": [[0, 1, -1], [4, -1, -1]],
          "right": [[2, 3, -1], [5, -1, -1]], "next_sector": [0, 1], "nodes": [[0, 1], [2, -1]],
          "faces": {"begin": [0, 1, 1], "node": [2], "weight": [1.0]}}


def cyclic(**changes):
    return checked_cyclic(CYCLIC | changes, 9, {"nodes": np.zeros((3, 3)), "changed": {"dof": np.empty(0)}}, {})


def test_a_sector_comes_back_from_its_file(tmp_path):
    joint = {"position": np.zeros((2, 3)), "axes": np.tile(np.eye(3), (2, 1, 1)), "area": [1.0, 1.0], "joint": [0, 0], "names": ["a"]}
    written = small(contact_dofs=None, mesh={**MESH, "nodes": np.zeros((3, 3))}, joint=joint, cyclic=CYCLIC | {"origin": [1, 2, 3]})
    written.write(tmp_path / "m.h5")
    read = Model.read(tmp_path / "m.h5").cyclic
    assert read["sectors"] == 3 and read["axis"].tolist() == [0, 0, 1] and read["origin"].tolist() == [1, 2, 3]
    for key in ("left", "right", "next_sector", "nodes"):
        np.testing.assert_array_equal(read[key], CYCLIC[key])
    for key, values in CYCLIC["faces"].items():
        np.testing.assert_array_equal(read["faces"][key], values)


@pytest.mark.parametrize("changes, message", [
    ({"sectors": 1}, "sectors must be a whole number from 2 on, found 1"),
    ({"axis": [0, 0, 2]}, "axis must be a unit vector"),
    ({"left": [[0, 1], [4, 5]], "right": [[2, 3], [6, 7]]}, r"dofs of shape \(p, 3\)"),
    ({"left": [0], "right": [2]}, r"dofs of shape \(p, 3\)"),
    ({"right": [[2, 3, 6], [5, -1, -1]]}, "held on both sides alike"),
    ({"right": [[2, 0, -1], [5, -1, -1]]}, "dofs 0 to 8, each once"),
    ({"right": [[2, 9, -1], [5, -1, -1]]}, "dofs 0 to 8, each once"),
    ({"nodes": [[0, 1], [3, -1]]}, "node rows up to 2"),
    ({"nodes": [[0, 1], [2, -2]]}, "-1 for a side that is held"),
    ({"nodes": [[0, 1], [-1, -1]]}, "node rows up to 2"),
    ({"nodes": [[0, 1], [1, -1]]}, "each contact node once, found node row 1 2 times"),
    ({"next_sector": [0, 2]}, "next_sector must be 0 or 1 for each of 2"),
    ({"faces": {"begin": [0, 1, 1], "node": [3], "weight": [1.0]}}, "node rows 0 to 2"),
    ({"faces": {"begin": [0, 1, 3], "node": [2], "weight": [1.0]}}, "weights between"),
    ({"faces": {"begin": [0, 2, 1], "node": [2], "weight": [1.0]}}, "weights between"),
])
def test_wrong_sectors_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        cyclic(**changes)


def test_a_sector_with_held_dofs_and_points_without_faces_is_taken():
    taken = cyclic()
    assert taken["sectors"] == 3 and taken["left"].tolist() == [[0, 1, -1], [4, -1, -1]] and taken["nodes"].tolist() == [[0, 1], [2, -1]]
    assert taken["faces"]["begin"].tolist() == [0, 1, 1]
    assert cyclic(faces=None)["faces"]["begin"].tolist() == [0, 0, 0]
    without = {key: value for key, value in CYCLIC.items() if key != "faces"}
    assert checked_cyclic(without, 9, {"nodes": np.zeros((3, 3)), "changed": {"dof": np.empty(0)}}, {})["faces"]["node"].size == 0


def test_symmetry_limit_is_relative_to_the_row():
    off = sp.csr_matrix(([1.0], ([0], [8])), shape=(9, 9))
    K = small().K * 1e12
    small(K=K + off)
    with pytest.raises(ValueError, match="row 0"):
        small(K=K + 1e4 * off)


def test_wrong_block_is_named():
    with pytest.raises(ValueError, match=r"Mcc must have shape \(3, 3\)"):
        Model.from_blocks(np.eye(2), np.zeros((2, 3)), np.eye(3), np.eye(2), np.zeros((2, 3)), np.eye(2))
    with pytest.raises(ValueError, match="3 columns"):
        Model.from_blocks(np.eye(2), np.zeros((2, 4)), np.eye(4), np.eye(2), np.zeros((2, 4)), np.eye(4))


def test_broken_write_keeps_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "m.h5"
    small().write(path)
    before = path.read_bytes()

    def break_off(file, parts):
        file[parts[0].name][0] = 99.0
        raise KeyboardInterrupt

    monkeypatch.setattr(hdf5_parts, "_fill", break_off)
    with pytest.raises(KeyboardInterrupt):
        small(force=np.ones(9)).write(path)
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]


def test_a_folder_is_no_file_to_write(tmp_path):
    (tmp_path / "models").mkdir()
    with pytest.raises(ValueError, match="models: is a folder; name a file in it, such as .*models/model.h5"):
        small().write(tmp_path / "models")
    assert list(tmp_path.iterdir()) == [tmp_path / "models"]


def test_reading_something_else_is_refused(tmp_path):
    (tmp_path / "text.h5").write_text("no")
    with pytest.raises(ValueError, match="text.h5: not an HDF5 file"):
        Model.read(tmp_path / "text.h5")
    with pytest.raises(ValueError, match="none.h5: no such HDF5 file"):
        Model.read(tmp_path / "none.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file.attrs["format"] = "dovetail-results"
    with pytest.raises(ValueError, match="must be dovetail-model, found dovetail-results"):
        Model.read(tmp_path / "other.h5")
    small().write(tmp_path / "m.h5")
    with h5py.File(tmp_path / "m.h5", "r+") as file:
        ir = file["K/ir"][()].astype(np.int64)
        del file["K/ir"]
        file["K/ir"] = np.r_[-1, ir[1:]]
    with pytest.raises(ValueError, match="/K: data, ir and jc do not fit together"):
        Model.read(tmp_path / "m.h5")


def run_distributed(folder, ranks, how):
    script = folder / "write.py"
    script.write_text(DISTRIBUTED)
    path = folder / f"{how}{ranks}.h5"
    command = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    done = subprocess.run(command + [sys.executable, str(script), str(path), how, str(ranks)], env=SURROUNDINGS,
                          capture_output=True, text=True, timeout=SECONDS)
    assert done.returncode == 0, done.stderr
    return path, done.stdout


@pytest.mark.parametrize("how", ["together", "turns"])
@pytest.mark.parametrize("ranks", [2, 3])
@pytest.mark.slow
def test_distributed_matrix_gives_the_serial_file(tmp_path, ranks, how):
    one, many = (contents(run_distributed(tmp_path, r, how)[0]) for r in (1, ranks))
    assert one.keys() == many.keys() and one["K/data"].size == 67
    for name, value in one.items():
        np.testing.assert_array_equal(many[name], value, err_msg=name)
        assert np.asarray(many[name]).dtype == np.asarray(value).dtype, name
    model = Model.read(tmp_path / f"{how}{ranks}.h5")
    assert model.K[4, 5] == -1.0 / 5 and model.force[22] == 22**2 and model.preload[22] == 22 / 7


@pytest.mark.slow
def test_fault_on_one_rank_is_raised_on_all(tmp_path):
    path, output = run_distributed(tmp_path, 2, "unsymmetric")
    assert not path.exists()
    for rank in (0, 1):
        assert f"refused on rank {rank}: K must be symmetric" in output


@pytest.mark.parametrize("names", [["x" * 70000], ["é" * 60] + ["a"] * 999], ids=["long", "many"])
def test_joint_names_beyond_an_attribute_are_refused(names):
    with pytest.raises(ValueError, match=f"{len(names)} joint names, the longest of .* shorten"):
        small(joint=JOINT | {"names": names})


def test_joint_names_up_to_there_are_written(tmp_path):
    names = ["x" * 64] + [f"joint {i}" for i in range(999)]
    small(joint=JOINT | {"names": names}).write(tmp_path / "m.h5")
    assert Model.read(tmp_path / "m.h5").joint["names"] == names
