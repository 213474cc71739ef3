"""Reading numbers and words of files that may be damaged, incomplete, or of others: what is taken, what is refused, and in which words."""

import h5py
import numpy as np
import pytest

from dovetail import hdf5_read
from dovetail.hdf5_read import attribute, dataset, members, numbers, opened, patiently, text, whole, words


@pytest.fixture
def file(tmp_path):
    with h5py.File(tmp_path / "f.h5", "w") as file:
        yield file


def test_numbers_of_every_kind(file):
    for kind, values, wanted in (("f", [1.5, -2], np.float64), ("f", np.array([1, 2], np.uint8), np.float64),
                                 ("f", [True, False], np.float64), ("i", np.array([-1, 2], np.int16), np.int64),
                                 ("i", np.array([7, 2**63 - 1], np.uint64), np.int64),
                                 ("i", np.zeros(0, np.uint64), np.int64), ("f", 3.5, np.float64)):
        file["x"] = values
        found = numbers(file, "x", kind=kind)
        assert found.dtype == wanted and np.array_equal(found, values)
        del file["x"]


@pytest.mark.parametrize("values, kind, message", [
    ([1.5], "i", "/g/x: wanted whole numbers, found values of type float64"),
    ([True], "i", "/g/x: wanted whole numbers, found values of type"),
    ([b"a"], "f", "/g/x: wanted numbers, found values of type"), ([1j], "f", "/g/x: wanted numbers, found values of type"),
    (h5py.Empty("f8"), "f", "/g/x: wanted numbers, found nothing"), (None, "f", "/g/x: wanted numbers, found a group"),
    (np.array([2**63], np.uint64), "i", "/g/x: 9223372036854775808 is too large")])
def test_what_is_no_number(file, values, kind, message):
    group = file.create_group("g")
    group.create_group("x") if values is None else group.create_dataset("x", data=values)
    with pytest.raises(ValueError, match=message):
        numbers(group, "x", kind=kind)


@pytest.mark.parametrize("wanted, fits", [
    (None, True), ((2, 3), True), ((None, 3), True), ((None, None), True), ((2, ...), True), ((None, 3, ...), True), ((...,), True),
    ((), False),
    ((3, 2), False), ((None, 2), False), ((2,), False), ((2, 3, None), False), ((3, ...), False), ((2, 3, 1, ...), False)])
def test_shapes(file, wanted, fits):
    file["x"] = np.ones((2, 3))
    if fits:
        assert dataset(file, "x", wanted).shape == (2, 3)
    else:
        with pytest.raises(ValueError, match=r"^/x: wanted shape \(.*\), found \(2, 3\)$"):
            dataset(file, "x", wanted)


def test_a_shape_is_said_in_words(file):
    file["x"] = np.ones((2, 3))
    with pytest.raises(ValueError, match=r"wanted shape \(any, 4, \.\.\.\)"):
        dataset(file, "x", (None, 4, ...))


def test_what_is_missing_or_leads_nowhere(file):
    file["lost"], file["outside"] = h5py.SoftLink("/nowhere"), h5py.ExternalLink("none.h5", "x")
    for name in ("x", "lost", "outside"):
        with pytest.raises(KeyError, match=f"/{name} is missing"):
            dataset(file, name)


def test_values_must_fit_into_the_file(file):
    file.create_dataset("x", (10**9,), "f8", chunks=True)
    file.flush()
    with pytest.raises(ValueError, match=r"/x: has shape \(1000000000,\), more than the file can hold"):
        dataset(file, "x")
    file.create_dataset("packed", data=np.zeros(10**6), compression="gzip", compression_opts=9)
    file.flush()
    assert numbers(file, "packed").size == 10**6


def test_a_file_holds_4096_times_its_size_at_most(file, monkeypatch):
    file["x"] = np.ones(1024)  # 8 KiB of values
    for size, fits in ((2, True), (1, False)):
        monkeypatch.setattr(hdf5_read.os.path, "getsize", lambda path, size=size: size)
        if fits:
            assert dataset(file, "x").shape == (1024,)
        else:
            with pytest.raises(ValueError, match=r"/x: has shape \(1024,\), more than the file can hold"):
                dataset(file, "x")


def test_large_numbers_are_numbers(file):
    file["x"] = [1e300, 2.0]
    assert numbers(file, "x").tolist() == [1e300, 2.0]


def test_members(file):
    file["g/a"], file["g/b"], file["x"] = 1, 2, 3
    assert members(file, "g") == ["a", "b"] and members(file, "none") == []
    with pytest.raises(ValueError, match="/x: wanted a group, found values of type int64"):
        members(file, "x")


def test_attributes_and_words(file):
    file.attrs.update({"number": 3, "bytes": b"a\xc3\xa9", "text": "b", "list": ["c", "d"], "none": h5py.Empty("S1")})
    file.attrs.create("empty", np.zeros(0, "S1"))
    assert attribute(file, "number") == 3 and attribute(file, "missing") is None and attribute(file, "none", 5) == 5
    wanted = {"bytes": "aé", "text": "b", "list": "c", "missing": "else", "none": "else", "empty": "else", "number": "3"}
    assert {name: words(file, name, "else") for name in wanted} == wanted
    assert words(file, "missing") == ""


def test_text_can_be_printed():
    assert text(b"a\xffb") == "a\ufffdb" and text("a\x1b[2Jb\x07") == "a\ufffd[2Jb\ufffd" and text("\u202eb\x9b") == "\ufffdb\ufffd"
    assert text("a\tb\nc\r\nd") == "a\tb\nc\r\nd" and text("a\rb") == "a\ufffdb" and text("\udcff") == "\ufffd" and text("é") == "é"


@pytest.mark.parametrize("value", [-1, 1.0, [1, 2], "3", [], True])
def test_a_whole_number_is_one_from_zero_on(file, value):
    file.attrs.update({"x": value, "zero": 0, "one": [np.uint8(7)]})
    assert whole(file, "zero") == 0 and whole(file, "one") == 7
    for name in ("x", "missing"):
        with pytest.raises(ValueError, match=f"/: attribute {name} must be one whole number from 0 on, found "):
            whole(file, name)


def test_a_long_attribute_is_cut_in_the_message(file):
    file.attrs["x"] = "y" * 100
    with pytest.raises(ValueError, match=f"found {40 * 'y'}$"):
        whole(file, "x")


def test_what_is_wrong_names_the_file_once(tmp_path):
    path = tmp_path / "f.h5"
    with pytest.raises(ValueError, match="f.h5: cannot be read: .*[Uu]nable to open file"):
        with opened(path):
            pass
    h5py.File(path, "w").close()
    for error, said in ((OSError(2, "lost"), f"{path}: cannot be read: lost"),
                        (KeyError("/x is missing"), f"{path}: cannot be read: /x is missing"),
                        (RuntimeError(), f"{path}: cannot be read: "),
                        (ValueError("bad"), f"{path}: bad"), (ValueError(f"bad {path}"), f"bad {path}")):
        with pytest.raises(ValueError) as found:
            with opened(path):
                raise error
        assert str(found.value) == said


def test_a_file_that_is_being_written_is_tried_again(tmp_path, monkeypatch):
    pauses = []
    monkeypatch.setattr(hdf5_read.time, "sleep", pauses.append)
    path, faults = tmp_path / "f.h5", []
    h5py.File(path, "w").close()

    def fail(file):
        faults.append(file)
        if len(faults) < 10:
            raise (OSError, KeyError, RuntimeError)[len(faults) % 3]("half written")
        return "read"

    assert patiently(path, fail) == "read" and pauses == 9 * [0.1] and not any(faults)  # closed each time
    with pytest.raises(ValueError, match="f.h5: not a readable table: /x is missing"):
        patiently(path, lambda file: dataset(file, "x"), "table")
    assert len(pauses) == 18
    for error, said in ((OSError(2, "lost"), "lost"), (RuntimeError(), "")):
        def give_up(file, error=error):
            raise error

        with pytest.raises(ValueError) as found:
            patiently(path, give_up)
        assert str(found.value) == f"{path}: not a readable results file: {said}"
    tried = len(pauses)
    with pytest.raises(ValueError, match="f.h5: /: attribute x must be"):
        patiently(path, lambda file: whole(file, "x"))
    with pytest.raises(ValueError, match="is a folder; a results file is wanted"):
        patiently(tmp_path, len)
    with pytest.raises(ValueError, match="none: no such file"):
        patiently(tmp_path / "none", len)
    assert len(pauses) == tried  # nothing of these gets better
