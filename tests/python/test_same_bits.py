"""Same input, same number of ranks: same bits. Environments of other sizes move stack and heap from run to run."""

import subprocess
import sys

import h5py
import pytest
from cases import Case
from launch import ROOT, SURROUNDINGS, run

CASE = """{model}
[damping]
stiffness = 1e-6
[excitation]
fourier = [0, 0, 5]
[contact]
normal_stiffness = 4e8
tangential_stiffness = [4e5, 4e5]
friction = [0.1, 0.1]
gap = 0
[harmonic_balance]
harmonics = 5
[continuation]
omega = [4000, 4250]
"""


@pytest.fixture(scope="module")
def posts(tmp_path_factory):
    """The model of inputs/two_solids: SCOTCH orders smaller ones the same with several threads, too."""
    path = tmp_path_factory.mktemp("posts") / "model.h5"
    subprocess.run([sys.executable, ROOT / "inputs/two_solids/model.py", "-o", path], check=True, capture_output=True, env=SURROUNDINGS)
    return path


def case_of(folder, model):
    path = folder / "case.toml"
    path.write_text(CASE.format(model=model))
    return Case(path, None, None, {})


def run_of(case, i, ranks, *options, **where):
    return run(case, *options, prefix=["env", f"PADDING={'x' * (137 * i)}"], ranks=ranks, out=f"out{ranks}.{i}", **where)


def bits(path):
    """Every dataset but times, as bytes."""
    found = {}

    def take(name, item):
        if isinstance(item, h5py.Dataset) and name != "points/seconds":
            found[name] = item.asstr()[()] if h5py.check_string_dtype(item.dtype) else item[()].tobytes()
    with h5py.File(path) as file:
        file.visititems(take)
    return found


def expect_same_bits(paths):
    first, *others = map(bits, paths)
    for i, other in enumerate(others, 2):
        assert other.keys() == first.keys()
        assert not [name for name in first if other[name] != first[name]], f"run {i}"


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.slow
def test_twenty_reductions_are_one(tmp_path, posts, ranks):
    case = case_of(tmp_path, f'model = "{posts}"\n[reduction]\nmodes = 5')
    expect_same_bits([run_of(case, i, ranks, command="reduce").folder / "reduced.h5" for i in range(20)])


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.slow
def test_ten_sweeps_are_one(tmp_path, posts, ranks):
    reduced = run(case_of(tmp_path, f'model = "{posts}"\n[reduction]\nmodes = 5'), command="reduce").folder / "reduced.h5"
    case = case_of(tmp_path, f'reduced = "{reduced}"')
    expect_same_bits([run_of(case, i, ranks).folder / "results.h5" for i in range(10)])
