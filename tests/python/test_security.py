"""Files of others: what they cannot do. See SECURITY.md."""

import json
import os
import subprocess

import h5py
import numpy as np
import pytest

import cases
from dovetail import Results
from dovetail.__main__ import main
from dovetail.hdf5_read import dataset, members
from dovetail.info import describe
from launch import ROOT, run

COMMAND = "\x1b]0;owned\x07"  # renames the window of a terminal
FEW = {"harmonics": 2, "omega": [0.8, 0.85], "max_points": 4}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    return run(cases.dof5(tmp_path_factory.mktemp("run"), **FEW), out="out").folder


def test_text_of_files_commands_no_terminal(done, tmp_path, capsys):
    path = tmp_path / "results.h5"
    path.write_bytes((done / "results.h5").read_bytes())
    with h5py.File(path, "r+") as file:
        file.attrs["title"] = f"a{COMMAND}b\u202ec"
        file.attrs["units"] = COMMAND
        file.create_group(f"named/{COMMAND}")
    said = describe(path)
    assert "\x1b" not in said and "\u202e" not in said and "]0;owned" in said
    assert Results(path).case == Results(done / "results.h5").case and "\n" in Results(path).case
    with h5py.File(path, "r") as file, pytest.raises(ValueError, match="holds what is no text"):
        members(file, "named")


def test_the_program_says_no_commands_either(tmp_path):
    case = cases.dof5(tmp_path, **FEW)
    case.edit('title = "five degrees of freedom"', 'title = "a\\u001b]0;owned\\u0007b"')
    said = run(case, out="out").out
    assert "\x1b" not in said and "a?]0;owned?b" in said
    case.edit('title = "a', '"\\u001b[2J" = "a')
    said = run(case, out="out", status=2).err
    assert "\x1b" not in said and "?[2J" in said


@pytest.mark.parametrize("kind", ["raw", "virtual"])
def test_values_in_other_files_are_not_read(kind, tmp_path):
    case = cases.dof5(tmp_path, **FEW)
    other = tmp_path / "secret"
    with h5py.File(tmp_path / "model.h5", "r+") as file:
        values = file["force"][()]
        del file["force"]
        if kind == "raw":
            other.write_bytes(values.tobytes())
            file.create_dataset("force", values.shape, "f8", external=[(str(other), 0, h5py.h5f.UNLIMITED)])
        else:
            with h5py.File(other, "w") as source:
                source["force"] = values
            layout = h5py.VirtualLayout((1 << 40,), "f8")  # fill values take no place in any file, and 8 TiB of memory
            layout[:values.size] = h5py.VirtualSource(str(other), "force", values.shape)
            file.create_virtual_dataset("force", layout)
    with h5py.File(tmp_path / "model.h5", "r") as file, pytest.raises(ValueError, match="in other files"):
        dataset(file, "force")
    assert "its values are in other files" in run(case, status=2).err


@pytest.mark.parametrize("command, name", [(["plot", "-o"], "a.png"), (["export", "-o"], "a.csv")])
@pytest.mark.parametrize("there", [True, False])
def test_no_link_is_followed_for_writing(done, command, name, there, tmp_path, capsys):
    target, link = tmp_path / "of_another", tmp_path / name
    if there:
        target.write_text("kept")
    link.symlink_to(target)
    assert main([command[0], str(done / "results.h5"), *command[1:], str(link)]) == 2
    assert "symbolic link" in capsys.readouterr().err
    assert target.read_text() == "kept" if there else not target.exists()


def test_a_run_follows_no_link(tmp_path):
    case = cases.dof5(tmp_path, **FEW)
    (tmp_path / "out").mkdir()
    for name in ("results.h5", "summary.json", "state.h5.partial"):
        (tmp_path / "out" / name).symlink_to(tmp_path / "of_another")
        assert "is a symbolic link" in run(case, out="out", status=2).err
        os.unlink(tmp_path / "out" / name)
    assert not (tmp_path / "of_another").exists()


def test_what_it_is_made_of_is_listed():
    listed = json.loads(subprocess.run([ROOT / "scripts/sbom"], check=True, capture_output=True, text=True).stdout)
    found = {part["name"]: part["version"] for part in listed["components"]}
    assert listed["bomFormat"] == "CycloneDX" and all(found.values())
    assert any(name.startswith("libpetsc") for name in found) and "python3-numpy" in found and found["pyNastran"] == "1.4.1"
    assert len(found) == len(listed["components"]) and np.isin("required", [part["scope"] for part in listed["components"]])
