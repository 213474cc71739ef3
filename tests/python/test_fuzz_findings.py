"""What the fuzzers of tests/fuzz found, once and for all: every input is taken, or refused in words that name its file."""

import importlib.util
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import hdf5_edits
import pytest
import read_hdf5

from dovetail.importers import convert
from dovetail.importers.apart import apart

from launch import BINARY, ROOT, SECONDS, SURROUNDINGS

FUZZ = ROOT / "tests" / "fuzz"
HARNESS = BINARY.parent / "tests" / "fuzz" / "fuzz_hdf5_file"
# Kind of file and edits (hdf5_edits.py) that once crashed the program, hung, exhausted the memory, or ended in an error from elsewhere.
HDF5 = {
    "model": ["/@version list", "/@version text", "/@format texts", "/@units words", "K@MATLAB_sparse list", "K@MATLAB_sparse int_max",
              "K@MATLAB_sparse long_max", "K/data scalar", "K/data nan_last", "K/data promises_1099511627776", "K/jc long_min_last",
              "K/jc long_max_all", "K/jc promises_2147483648", "K/jc promises_4611686018427387904", "K/ir as_reference", "K/ir raised",
              "K/ir dangling_link", "K/jc external_link", "force promises_4611686018427387904", "force unwritten", "force as_half",
              "contact/dofs promises_1099511627776", "contact/dofs empty", "contact/gap promises_2147483648_wide",
              "contact/friction scalar", "contact/gap committed_type", "contact/friction as_reference",
              "contact/tangential_stiffness minus_inf_last",
              "contact@joints without", "contact@joints empty", "contact/joint minus_one_all", "mesh/nodes scalar", "mesh/nodes deleted",
              "mesh/dof_node as_words", "mesh/dof_node raised", "mesh/sets/tip huge_last", "mesh/sets/tip long_max_all", "mesh/sets group",
              "mesh/changed/begin empty", "mesh/changed/column committed_type", "mesh/changed/dof as_words", "mesh/cells/tetra flat"],
    "reduced": ["/@format texts", "/@source matrix", "/@model words", "/@modes_counted list", "Kaa empty", "Kaa nan_all", "Kaa scalar",
                "Kxx nan_last", "Kxx promises_2147483648_wide", "R promises_1099511627776", "R nothing", "recovery as_int8",
                "recovery/Phi shorter", "recovery/contact_dofs shorter", "recovery/elastic_dofs tiny_last",
                "recovery/elastic_dofs long_max_last"],
    "results": ["/@harmonics list", "/@modes minus_one", "/@contact_points long_max", "/@samples without", "points/coefficients nan_all",
                "points/coefficients promises_1099511627776", "points/coefficients as_complex", "points/coefficients as_half",
                "points/omega nan_last", "points/omega as_half", "points/omega promises_1099511627776_wide", "points/open deleted",
                "points/contact empty", "points/contact/open promises_2147483648_wide", "contact/law long_max_all",
                "contact/law promises_1099511627776_wide", "contact/normal_stiffness scalar", "contact/friction as_reference"],
}


@pytest.fixture(scope="module")
def damaged(tmp_path_factory):
    """Paths of the files of HDF5, by kind and edit, and of good ones."""
    folder, paths = tmp_path_factory.mktemp("damaged"), {}
    for kind, labels in HDF5.items():
        paths[kind, "as it should be"] = folder / f"good_{kind}.h5"
        hdf5_edits.write(paths[kind, "as it should be"], kind, [])
        known = dict(hdf5_edits.all_edits(kind))
        for label in labels:
            paths[kind, label] = folder / f"{len(paths):03}.h5"
            hdf5_edits.write(paths[kind, label], kind, [known[label]])
    return paths


@pytest.mark.slow
def test_the_program_on_damaged_hdf5_files(damaged):
    if not HARNESS.is_file():
        pytest.skip(f"{HARNESS} is not built")
    files = [str(path) for path in damaged.values()]
    done = subprocess.run([HARNESS, *files], capture_output=True, text=True, errors="replace", timeout=SECONDS, env=SURROUNDINGS)
    last = re.findall(r"^Running: (\S+)", done.stderr, re.M)[-1]
    labels = {str(path): key for key, path in damaged.items()}
    assert done.returncode == 0 and "runtime error" not in done.stderr, f"{labels[last]}: {done.stderr[-3000:]}"
    assert last == max(files)  # replayed in the order of their names


@pytest.mark.parametrize("kind, label", [(kind, label) for kind, labels in HDF5.items() for label in (*labels, "as it should be")])
def test_python_on_damaged_hdf5_files(damaged, kind, label, monkeypatch):
    read_hdf5.without_patience(monkeypatch.setattr)
    assert not [text for _, _, text in read_hdf5.faults(damaged[kind, label])]


@pytest.mark.slow
def test_importers_on_the_corpus():
    files = sorted((FUZZ / "corpus" / "importers").glob("*/*~*"))
    done = subprocess.run([sys.executable, FUZZ / "replay_importers.py", *files], capture_output=True, text=True, timeout=SECONDS,
                          env=SURROUNDINGS)
    assert files and done.returncode == 0, done.stdout + done.stderr[-2000:]
    assert re.findall(r"^Running: (\S+)", done.stderr, re.M)[-1] == str(files[-1])


def test_a_reader_that_crashes_is_a_message():
    with pytest.raises(ValueError, match="job.cdb: its reader crashed"):
        apart(lambda: os.kill(os.getpid(), signal.SIGSEGV), "job.cdb")
    with pytest.raises(ValueError, match="job.cdb: its reader cannot read it: 'x'"):
        apart(lambda: {}["x"], "job.cdb")
    with pytest.raises(ValueError, match="^job.cdb: wanted more$"):
        apart(lambda: _raise(ValueError("job.cdb: wanted more")), "job.cdb")
    assert apart(lambda: list(range(1000000)), "job.cdb")[-1] == 999999


def _raise(error):
    raise error


def test_full_file_that_crashes_its_reader(tmp_path):
    if not importlib.util.find_spec("ansys"):
        pytest.skip("ansys-mapdl-reader is not installed (scripts/setup says why)")
    examples = Path(importlib.util.find_spec("ansys.mapdl.reader").origin).parent / "examples"
    good = (examples / "file.full").read_bytes()
    (tmp_path / "file.full").write_bytes(good[:219288] + 23 * b"9" + good[219288:])  # among the numbers of rows
    with pytest.raises(ValueError, match="file.full: its reader"):
        convert("ansys", [str(tmp_path / "file.full"), str(examples / "HexBeam.cdb")], tmp_path / "model.h5", setup="joints.toml")
