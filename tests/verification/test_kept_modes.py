"""The modes of the stuck structure of many contact points are kept in stuck.h5 for the next run, and for no other structure."""

import re
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import chain
from launch import read_points
from launch import run as run_case

POINTS = 340  # with 3 modes just above the 1000 from which on they are kept


def run(path, ranks=None):
    run_case(SimpleNamespace(path=path), ranks=ranks)


def branch(folder):
    points = read_points(folder)
    return {name: points[name] for name in ("omega", "coefficients", "linear_iterations")}


def same(one, other):
    return all(np.array_equal(one[name], other[name]) for name in one)


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """A run from nothing: its case, its branch and what it kept."""
    folder = tmp_path_factory.mktemp("kept")
    case = chain.write(folder, POINTS, 1, 32, omega=(1.2, 1.9), most=4)
    run(case)
    return case, branch(folder), (folder / "stuck.h5").read_bytes()


def again(first, change=lambda path: None, ranks=None):
    """The branch of another run after a change of the file, and whether it left the file as it was."""
    case, _, kept = first
    path = case.parent / "stuck.h5"
    path.write_bytes(kept)
    change(path)
    before = path.read_bytes()
    run(case, ranks=ranks)
    return branch(case.parent), path.read_bytes() == before


@pytest.mark.slow
def test_next_run_takes_them(first):
    found, untouched = again(first)
    assert untouched and same(found, first[1])


@pytest.mark.slow
def test_they_are_really_read(first):
    """Wrong modes under the right fingerprint: the preconditioner is wrong, and the iterations tell."""
    def spoil(path):
        with h5py.File(path, "r+") as file:
            file["modes"][:50] *= 1.5

    found, untouched = again(first, spoil)
    assert untouched and not np.array_equal(found["linear_iterations"], first[1]["linear_iterations"])


@pytest.mark.parametrize("damage", [lambda path: path.write_bytes(path.read_bytes()[:5000]), lambda path: path.write_text("no HDF5")])
@pytest.mark.slow
def test_file_of_other_origin(first, damage):
    """Neither used nor replaced: whoever put it there may want it."""
    found, untouched = again(first, damage)
    assert untouched and same(found, first[1])
    assert not list(first[0].parent.glob("*.partial"))


@pytest.mark.slow
def test_other_springs(first, tmp_path):
    """Another structure: the file is made anew, and nothing of the old one is used."""
    case, _, kept = first
    text = re.sub("normal_stiffness = [^,]*", "normal_stiffness = 1.5e-2", case.read_text())
    for name in ("old", "none"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "case.toml").write_text(text)
        (tmp_path / name / "model.h5").write_bytes((case.parent / "model.h5").read_bytes())
    (tmp_path / "old/stuck.h5").write_bytes(kept)
    for name in ("old", "none"):
        run(tmp_path / name / "case.toml")
    assert (tmp_path / "old/stuck.h5").read_bytes() != kept
    assert same(branch(tmp_path / "old"), branch(tmp_path / "none"))


def test_few_points_keep_nothing(tmp_path):
    run(chain.write(tmp_path, 4, 1, 32, omega=(1.2, 1.9), most=2))
    assert not (tmp_path / "stuck.h5").exists()


@pytest.mark.slow
def test_two_ranks_share_the_file(first):
    found, untouched = again(first, ranks=2)
    assert untouched
    assert np.allclose(found["coefficients"], first[1]["coefficients"], rtol=0, atol=1e-7 * np.abs(first[1]["coefficients"]).max())


@pytest.mark.slow
def test_two_ranks_find_them_together(first, tmp_path):
    """From nothing, by all ranks: the same branch, and a file that one rank takes."""
    case = chain.write(tmp_path, POINTS, 1, 32, omega=(1.2, 1.9), most=4)
    run(case, ranks=2)
    together, kept = branch(tmp_path), (tmp_path / "stuck.h5").read_bytes()
    run(case)
    assert (tmp_path / "stuck.h5").read_bytes() == kept
    largest = np.abs(first[1]["coefficients"]).max()
    for found in (together, branch(tmp_path)):
        assert np.allclose(found["coefficients"], first[1]["coefficients"], rtol=0, atol=1e-7 * largest)
    squares = []
    for path in (tmp_path, first[0].parent):
        with h5py.File(path / "stuck.h5") as file:
            squares.append(file["squares"][()])
    assert np.allclose(*squares, rtol=1e-10)
