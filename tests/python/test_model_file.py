"""What comes back from a model file, which rank writes what, and files that are spoiled."""

import threading
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import scipy.sparse as sp
from test_model import CYCLIC, JOINT, MESH, contents, small

from dovetail import Model, hdf5_parts
from dovetail.hdf5_parts import Part

NODES = {"nodes": np.zeros((3, 3)), "cells": {}, "dof_node": np.zeros(9, int), "dof_direction": np.zeros(9, int)}
TWO_POINTS = {"position": np.zeros((2, 3)), "axes": np.tile(np.eye(3), (2, 1, 1)), "area": [1.0, 2.0], "joint": [0, 0], "names": ["a"]}


class Ranks:
    """Threads in place of ranks: what mpi4py's communicator does for them."""

    def __init__(self, size):
        self.size, self.meeting, self.brought = size, threading.Barrier(size), [None] * size

    def run(self, work):
        """work(comm) of every rank; what each gives back, or raises."""
        found = [None] * self.size

        def start(rank):
            try:
                found[rank] = work(OneRank(self, rank))
            except Exception as error:
                found[rank] = error

        threads = [threading.Thread(target=start, args=(rank,)) for rank in range(self.size)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return found


class OneRank:
    def __init__(self, ranks, rank):
        self.ranks, self.rank, self.size = ranks, rank, ranks.size

    def barrier(self):
        self.ranks.meeting.wait(60)

    def allgather(self, item):
        self.ranks.brought[self.rank] = item
        self.barrier()
        found = list(self.ranks.brought)
        self.barrier()
        return found


def full(comm):
    """A model of everything but sectors."""
    C, K_structural = sp.csr_matrix((9, 9)), sp.diags([1.0, 2.0, 1.0], [-1, 0, 1], shape=(9, 9))
    mesh = {**NODES, "cells": {"line": [[0, 1], [1, 2]]}, "sets": {"tip": [2]}, "materials": [(2.0, 0.3, 1.0, "steel")],
            "material": {"line": [0, -1]}, "integration": {"line": [0, 2]}}
    return small(contact_dofs=[[0, 1, 2], [8, 7, 6]], force=None, forces={"push": np.arange(9), "pull": -np.arange(9)}, C=C,
                 K_structural=K_structural, preload=np.arange(9) + 0.5, contact={"gap": [1.0, 2.0], "friction": [0.1, 0.2]}, mesh=mesh,
                 joint=TWO_POINTS, comm=comm)


@pytest.mark.parametrize("size", [2, 3])
def test_ranks_that_take_turns_write_the_file_of_one(tmp_path, size):
    full(None).write(tmp_path / "one.h5")
    assert Ranks(size).run(lambda comm: full(comm).write(tmp_path / "many.h5")) == size * [None]
    one, many = contents(tmp_path / "one.h5"), contents(tmp_path / "many.h5")
    assert one.keys() == many.keys() and sorted(file.name for file in tmp_path.iterdir()) == ["many.h5", "one.h5"]
    for name, value in one.items():
        np.testing.assert_array_equal(many[name], value, err_msg=name)
        assert np.asarray(many[name]).dtype == np.asarray(value).dtype, name


def test_a_fault_of_one_rank_is_one_of_all():
    K = sp.lil_matrix(small().K)
    K[8, 0] = 5.0
    found = Ranks(2).run(lambda comm: small(K=K, comm=comm))
    assert all(isinstance(error, ValueError) and "K must be symmetric" in str(error) for error in found)
    assert Ranks(2).run(lambda comm: hdf5_parts.agree(comm, None)) == [None, None]


def test_one_process_writes_without_mpi(monkeypatch):
    monkeypatch.setattr(h5py, "get_config", lambda: SimpleNamespace(mpi=False))  # whichever build of h5py is here
    assert isinstance(hdf5_parts.default_comm(), hdf5_parts.Alone) and isinstance(small(comm=None).comm, hdf5_parts.Alone)


def test_one_rank_writes_alone_whatever_hdf5_can(tmp_path, monkeypatch):
    monkeypatch.setattr(h5py, "get_config", lambda: SimpleNamespace(mpi=True))
    small(comm=hdf5_parts.Alone()).write(tmp_path / "m.h5")
    assert Model.read(tmp_path / "m.h5").force.tolist() == list(range(9))


def test_ranks_write_at_once_where_hdf5_can(tmp_path, monkeypatch):
    asked, met, plain = [], [], h5py.File
    comm = SimpleNamespace(rank=0, size=2, barrier=lambda: met.append(sorted(file.name for file in tmp_path.iterdir())))
    monkeypatch.setattr(h5py, "get_config", lambda: SimpleNamespace(mpi=True))
    monkeypatch.setattr(h5py, "File", lambda name, mode, driver, comm: asked.append((driver, comm)) or plain(name, mode))
    hdf5_parts.write(tmp_path / "f.h5", [Part("x", (2,), 0, np.arange(2.0))], {"": {"a": 1}}, comm)
    monkeypatch.undo()
    found = contents(tmp_path / "f.h5")
    assert asked == [("mpio", comm)] and found["x"].tolist() == [0, 1] and found["@a"] == 1
    assert met == [["f.h5.part"], ["f.h5"]]  # it has its name once all have written


def test_ranks_without_a_share_write_nothing(tmp_path):
    def write(comm):
        mine = np.arange(2.0) if comm.rank == 1 else np.zeros(0)
        hdf5_parts.write(tmp_path / "f.h5", [Part("g/x", (2,), 0, mine)], {"": {"a": 1}, "g": {"b": 2}}, comm)

    assert Ranks(3).run(write) == 3 * [None]
    found = contents(tmp_path / "f.h5")
    assert found["g/x"].tolist() == [0, 1] and found["@a"] == 1 and found["g@b"] == 2


def test_all_of_a_model_comes_back(tmp_path):
    written = full(None)
    assert written.force is None and [line for line in written.excitation().splitlines() if "pattern" in line] == [
        'pattern = "push"', 'pattern = "pull"']
    written.write(tmp_path / "m.h5")
    assert "force" not in contents(tmp_path / "m.h5")
    read = Model.read(tmp_path / "m.h5")
    assert read.force is None and {name: load.tolist() for name, load in read.forces.items()} == {
        "push": list(range(9)), "pull": [-i for i in range(9)]}
    assert read.C.nnz == 0 and read.C.shape == (9, 9) and abs(read.K_structural - written.K_structural).max() == 0
    assert read.preload.tolist() == [i + 0.5 for i in range(9)] and read.comm.size == 1
    assert read.contact.keys() == {"gap", "friction"} and read.contact["gap"].tolist() == [1.0, 2.0]
    assert read.contact["friction"].tolist() == [[0.1, 0.2], [0.1, 0.2]] and read.contact_points == 2 and read.cyclic is None
    assert read.mesh["integration"]["line"].tolist() == [0, 2] and read.mesh["material"]["line"].tolist() == [0, -1]
    assert read.joint["area"].tolist() == [1.0, 2.0] and read.joint["names"] == ["a"]


def test_nothing_is_written_that_was_not_given(tmp_path):
    small(mesh={**MESH, "materials": [(2.0, 0.3)], "cells": {"vertex": [[0]]}}).write(tmp_path / "m.h5")
    found = contents(tmp_path / "m.h5")
    assert {name.split("/")[0].split("@")[0] for name in found} == {"", "K", "M", "force", "preload", "contact", "mesh"}
    assert [name for name in found if name.startswith("contact")] == ["contact/dofs"]
    assert {name for name in found if name.startswith("mesh")} == {
        "mesh@materials", "mesh/nodes", "mesh/dof_node", "mesh/dof_direction", "mesh/cells/vertex", "mesh/materials",
        "mesh/material/vertex"}
    assert found["mesh/materials"].tolist() == [[2.0, 0.3, 0.0]] and found["@version"] == 1
    read = Model.read(tmp_path / "m.h5")
    assert read.joint is None and read.contact == {} and read.C is None and read.forces == {}
    small().write(tmp_path / "m.h5")
    assert Model.read(tmp_path / "m.h5").mesh is None


def test_a_file_without_units_is_of_the_si(tmp_path):
    small(units="mm").write(tmp_path / "m.h5")
    with h5py.File(tmp_path / "m.h5", "r+") as file:
        del file.attrs["units"]
    assert Model.read(tmp_path / "m.h5").units == "SI"


def replaced(name, change):
    def spoil(file):
        values = change(file[name][()])
        del file[name]
        file[name] = values
    return spoil


def changed(name, value):
    return lambda file: file[name.split("@")[0]].attrs.__setitem__(name.split("@")[1], value)


def joined(array, value):
    return np.append(array, np.asarray([value], array.dtype))


TORN = "/K: data, ir and jc do not fit together as a square sparse matrix of 9 rows"


@pytest.mark.parametrize("spoil, message", [
    (replaced("K/data", lambda a: a[:-1]), TORN),
    (replaced("K/ir", lambda a: a[:-1]), TORN),
    (replaced("K/ir", lambda a: np.where(a == 8, 9, a)), TORN),
    (replaced("K/jc", lambda a: np.r_[1, a[1:]].astype(np.uint64)), TORN),
    (replaced("K/jc", lambda a: np.r_[a[:-1], a[-1] + 1].astype(np.uint64)), TORN),
    (replaced("K/jc", lambda a: a[[0, 2, 1, *range(3, 10)]]), TORN),
    (replaced("K/jc", lambda a: np.r_[a[:2], a[1] - np.uint64(1), a[3:]]), TORN),
    (replaced("K/jc", lambda a: joined(a, a[-1])), TORN),
    (changed("K@MATLAB_sparse", 10), TORN.replace("9", "10")),
    (changed("K@MATLAB_sparse", -1), "/K: attribute MATLAB_sparse must be one whole number"),
    (replaced("K/ir", lambda a: a.astype(float)), "/K/ir: wanted whole numbers"),
    (lambda file: file.__delitem__("M"), "/M/data is missing"),
    (lambda file: file.__delitem__("contact/dofs"), "/contact/dofs is missing"),
    (lambda file: file.attrs.__delitem__("format"), "format must be dovetail-model, found unnamed"),
    (replaced("contact/dofs", lambda a: a[:, :2]), r"/contact/dofs: wanted shape \(any, 3\), found \(2, 2\)"),
    (changed("mesh@materials", [b"a", b"b"]), "/mesh/materials: wanted 1 names in the attribute materials of /mesh, found 2"),
    (lambda file: file["mesh"].attrs.__delitem__("materials"), "wanted 1 names in the attribute materials of /mesh, found 0"),
    (changed("contact@joints", np.zeros(0, "S1")), "joint numbers must lie in 0 to -1, as there are 0 names"),
    (replaced("mesh/nodes", lambda a: a[:, :2]), r"/mesh/nodes: wanted shape \(any, 3\)"),
    (replaced("mesh/cells/line", lambda a: a.ravel()), r"/mesh/cells/line: wanted shape \(any, any\)"),
    (replaced("contact/axes", lambda a: a[:, :2]), r"/contact/axes: wanted shape \(any, 3, 3\)"),
])
def test_spoiled_files_are_refused(tmp_path, spoil, message):
    full(None).write(tmp_path / "m.h5")
    with h5py.File(tmp_path / "m.h5", "r+") as file:
        spoil(file)
    with pytest.raises(ValueError, match=f"m.h5: .*{message}"):
        Model.read(tmp_path / "m.h5")


@pytest.mark.parametrize("spoil, message", [
    (changed("cyclic@axis", [0.0, 1.0]), "/cyclic: attribute axis must be three numbers, found"),
    (changed("cyclic@origin", ["a", "b", "c"]), "/cyclic: attribute origin must be three numbers, found"),
    (lambda file: file["cyclic"].attrs.__delitem__("axis"), "/cyclic: attribute axis must be three numbers, found nothing"),
    (changed("cyclic@sectors", 2.5), "/cyclic: attribute sectors must be one whole number"),
    (replaced("cyclic/left", lambda a: a[:, :2]), r"/cyclic/left: wanted shape \(any, 3\)"),
    (replaced("contact/nodes", lambda a: a[:, :1]), r"/contact/nodes: wanted shape \(any, 2\)"),
    (replaced("contact/faces/node", lambda a: a.astype(float)), "/contact/faces/node: wanted whole numbers"),
    (lambda file: file.__delitem__("cyclic/next_sector"), "/cyclic/next_sector is missing"),
])
def test_spoiled_sectors_are_refused(tmp_path, spoil, message):
    small(contact_dofs=None, mesh=NODES, joint=TWO_POINTS, cyclic=CYCLIC).write(tmp_path / "m.h5")
    with h5py.File(tmp_path / "m.h5", "r+") as file:
        spoil(file)
    with pytest.raises(ValueError, match=f"m.h5: .*{message}"):
        Model.read(tmp_path / "m.h5")


def test_faces_are_optional(tmp_path):
    without = {key: value for key, value in CYCLIC.items() if key != "faces"}
    small(contact_dofs=None, mesh=NODES, joint=TWO_POINTS, cyclic=without).write(tmp_path / "m.h5")
    assert not any("faces" in name for name in contents(tmp_path / "m.h5"))
    read = Model.read(tmp_path / "m.h5")
    assert read.cyclic["faces"]["begin"].tolist() == [0, 0, 0] and read.contact_points == 2 and read.contact_dofs is None


@pytest.mark.parametrize("changes, message", [
    ({"cyclic": CYCLIC}, "a cyclic model has no contact_dofs"),
    ({"cyclic": CYCLIC, "contact_dofs": None, "mesh": None}, "a cyclic model needs mesh and joint"),
    ({"cyclic": CYCLIC, "contact_dofs": None, "joint": None}, "a cyclic model needs mesh and joint"),
    ({"joint": {**JOINT, "position": np.zeros((2, 3))}}, r"joint position must have shape \(1, 3\), found \(2, 3\)"),
    ({"joint": {**JOINT, "axes": np.zeros((1, 3))}}, r"joint axes must have shape \(1, 3, 3\), found \(1, 3\)"),
    ({"joint": {**JOINT, "joint": [-1]}}, "joint numbers must lie in 0 to 0, as there are 1 names"),
])
def test_parts_that_do_not_go_together(changes, message):
    with pytest.raises(ValueError, match=message):
        small(**{"mesh": NODES, "joint": TWO_POINTS, **changes})
