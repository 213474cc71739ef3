"""PETSc within the package: processes that run alone share no folder, and child processes find their surroundings unchanged."""

import os
import subprocess
import sys

import pytest

from dovetail.petsc_begin import ALONE, RANKS, petsc
from launch import SECONDS, SURROUNDINGS

pytest.importorskip("petsc4py", reason="needs petsc4py")
CODE = """import os
before = dict(os.environ)
from dovetail import petsc_begin
print(petsc_begin.petsc().COMM_WORLD.size, petsc_begin.petsc().Vec().create().comm.size, os.environ == before)
"""


def said(**surroundings):
    bare = {name: value for name, value in SURROUNDINGS.items() if name not in ALONE} | surroundings
    return subprocess.run([sys.executable, "-c", CODE], env=bare, capture_output=True, text=True, timeout=SECONDS)


def test_alone_it_needs_no_folder_of_open_mpi(tmp_path):
    (tmp_path / "file").touch()
    done = said(OMPI_MCA_orte_tmpdir_base=str(tmp_path / "file/folder"))
    assert done.returncode == 0 and done.stdout.split() == ["1", "1", "True"], done.stderr


def test_what_the_user_set_stays():
    done = said(OMPI_MCA_pml="ob1", OMPI_MCA_orte_create_session_dirs="1")
    assert done.returncode == 0 and done.stdout.split()[-1] == "True", done.stderr


@pytest.mark.parametrize("name", RANKS)
def test_under_mpirun_nothing_is_added(monkeypatch, name):
    seen = []
    monkeypatch.setattr("petsc4py.init", lambda *_: seen.append(os.environ.get("DOVETAIL_TEST")))
    monkeypatch.setitem(ALONE, "DOVETAIL_TEST", "1")
    petsc()
    monkeypatch.setenv(name, "1")
    petsc()
    assert seen == ["1", None]
