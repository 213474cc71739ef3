"""The reduction of a finite-element model as a user meets it: ranks, memory, whose motion is kept. The mathematics is tested in
tests/unit/test_reduction.cpp.
"""

import re
import subprocess
import sys

import brick
import h5py
import numpy as np
import pytest
from cases import Case
from launch import ROOT, SURROUNDINGS, run

from dovetail import Joint, Results

CASE = """model = "model.h5"
[reduction]
modes = 6
{reduction}
[damping]
stiffness = 1e-6
[excitation]
fourier = [0, 0, 1]
[harmonic_balance]
harmonics = 1
samples = 64
[continuation]
omega = [2000, 2000]
[output]
{output}
"""
MATRICES = ("Kaa", "Max", "Mxx", "Kxx", "Fa", "Fx", "R")


def blade_model(folder, *options):
    path = folder / "model.h5"
    subprocess.run([sys.executable, ROOT / "inputs/blade_root/model.py", "--dofs", "20000", *options, "-o", path], env=SURROUNDINGS,
                   check=True, stdout=subprocess.DEVNULL)
    return path


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A coarse blade in its slot, 30 contact points."""
    return blade_model(tmp_path_factory.mktemp("small"), "--dofs", "6000", "--flank", "1x4", "--points", "3x5")


@pytest.fixture(scope="module")
def blade(tmp_path_factory):
    """A finer one, whose factors take more memory than a process that does nothing."""
    return blade_model(tmp_path_factory.mktemp("blade"), "--points", "3x5")


@pytest.fixture(scope="module")
def all_points(tmp_path_factory):
    """The same with all 266: Psi is the largest thing there is."""
    return blade_model(tmp_path_factory.mktemp("all_points"))


@pytest.fixture
def make(tmp_path, small):
    """A case on the small model, or another, in a folder of its own."""
    def case(name, reduction="", output="", model=small):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "model.h5").symlink_to(model)
        path = folder / "case.toml"
        path.write_text(CASE.format(reduction=reduction, output=output))
        return Case(path, None, None, {})
    return case


def matrices(done):
    with h5py.File(done.folder / "reduced.h5") as file:
        return {name: file[name][()] for name in MATRICES}


def kept(done):
    """Rows of Phi and Psi by dof."""
    with h5py.File(done.folder / "reduced.h5") as file:
        part = file["recovery"]
        return dict(zip(part["elastic_dofs"][()], np.hstack([part["Phi"][()], part["Psi"][()], part["xe0"][()][:, None]])))


def peak_of(done, stage="2 reduction"):
    return np.array(next(s["peak_mib"] for s in done.summary["stages"] if s["name"] == stage))


def expect_same(first, second, tolerance=1e-9):
    for name in MATRICES:
        scale = abs(first[name]).max()
        assert abs(first[name] - second[name]).max() <= tolerance * scale, name


@pytest.mark.slow
def test_ranks_and_partition_do_not_matter(make):
    one, *others = (run(make(f"on{ranks}"), ranks=ranks, command="reduce") for ranks in (1, 2, 3))
    shared = run(make("shared"), "-kee_whole", "false", ranks=2, command="reduce")
    assert "share one factor" in shared.out and not any("share one factor" in other.out for other in others)
    for other in [*others, shared]:
        expect_same(matrices(one), matrices(other))
        assert other.summary["reduction"]["backward_error"] < 1e-14


@pytest.mark.parametrize("ranks, whole", [(1, "true"), (2, "true"), (2, "false")])
@pytest.mark.slow
def test_memory_is_known_before(make, blade, ranks, whole):
    done = run(make("case", model=blade), "-kee_whole", whole, ranks=ranks, command="reduce")
    forecast = np.array(done.summary["reduction"]["forecast_mib"])
    assert len(forecast) == ranks
    np.testing.assert_allclose(forecast.sum(), peak_of(done).sum(), rtol=0.3)
    assert "GiB over all ranks" in done.out and f"ordering {done.summary['reduction']['ordering']}" in done.out


@pytest.mark.slow
def test_dry_run_forecasts_the_same_memory(make, blade):
    case = make("case", model=blade)
    (said,) = [line for line in run(case, "--dry-run", command="reduce").out.splitlines() if "over all ranks, " in line]
    done = run(case, command="reduce")
    assert float(said.split()[1]) == pytest.approx(sum(done.summary["reduction"]["forecast_mib"]) / 1024, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 2])
def test_less_memory_than_psi_needs(make, all_points, ranks):
    roomy = run(make("roomy", model=all_points), ranks=ranks, command="reduce")
    assert roomy.summary["reduction"]["kept_psi"]
    refused = run(make("refused", reduction="memory = 0.01", model=all_points), "--dry-run", ranks=ranks, command="reduce", status=3).err
    least = float(re.search(r"would take ([\d.]+) GiB", refused)[1])
    # Where a process begins differs by a few per cent from run to run; Psi takes a third more than the least on both numbers of ranks.
    tight = run(make("tight", reduction=f"memory = {1.1 * least}", model=all_points), ranks=ranks, command="reduce")
    assert not tight.summary["reduction"]["kept_psi"] and "a block at a time" in tight.out
    assert peak_of(tight).sum() < peak_of(roomy).sum()
    expect_same(matrices(roomy), matrices(tight))


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.slow
def test_refused_when_it_cannot_fit(make, blade, ranks):
    case = make("little", reduction="memory = 0.01", model=blade)
    done = run(case, ranks=ranks, status=3)
    for words in ("would take", "0.01 GiB for it", "-kee_mat_mumps_icntl_22 1", "fewer contact points", "reduction.memory"):
        assert words in done.err
    assert done.err.count("would take") == 1
    assert ("-kee_whole false" in done.err) == (ranks == 2)
    assert not (done.folder / "reduced.h5").exists()


@pytest.mark.slow
def test_out_of_core(make):
    case = make("case")
    expect_same(matrices(run(make("in"), command="reduce")), matrices(run(case, "-kee_mat_mumps_icntl_22", 1, command="reduce")))


@pytest.mark.slow
def test_modes_are_counted_on_request(make):
    assert "none missed" in run(make("case", reduction="check_modes = true"), ranks=2, command="reduce").out
    plain = make("plain")
    assert "none missed" not in run(plain, command="reduce").out
    plain.path.write_text(plain.path.read_text().replace("[reduction]", "[reduction]\ncheck_modes = true"))
    for said in ("none missed", "reused"):  # a file whose modes were not counted does not do, one whose modes were does
        assert said in run(plain, command="reduce").out


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 3])
def test_modes_by_other_eigensolvers(make, ranks):
    ours = matrices(run(make("ours"), ranks=ranks, command="reduce"))
    for eigensolver, tolerance in {"krylovschur": 1e-11, "lobpcg": 1e-7}.items():
        done = run(make(eigensolver), "-modes_eps_type", eigensolver, "-modes_eps_view", "-modes_eps_monitor", ranks=ranks,
                   command="reduce")
        expect_same(ours, matrices(done), tolerance)
        assert f"type: {eigensolver}" in done.out and "nconv=" in done.out


@pytest.mark.slow
def test_slepc_says_what_it_does(make):
    done = run(make("case"), "-modes_eps_view", "-modes_eps_monitor", "-modes_eps_converged_reason", ranks=2, command="reduce")
    for words in ("type: blocklanczos", "block of 16 vectors", "the factors of K_ee", "nconv=", "CONVERGED_TOL"):
        assert words in done.out
    assert "was not used" not in done.err


@pytest.mark.slow
def test_modes_that_do_not_converge(make):
    done = run(make("case"), "-modes_eps_max_it", 1, command="reduce", status=3)
    for words in ("of 6 fixed-interface modes converged", "blocklanczos", "-modes_eps_max_it", "reduction.modes"):
        assert words in done.err
    assert not (done.folder / "reduced.h5").exists()


@pytest.mark.slow
def test_options_that_contradict_the_case(make):
    assert "reduction.modes says" in run(make("nev"), "-modes_eps_nev", 3, command="reduce", status=2).err
    assert "blocklanczos" in run(make("type"), "-modes_eps_type", "lancsos", command="reduce", status=2).err


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 2])
def test_motion_of_what_is_named(make, small, ranks):
    """A set, and a node of the joint, whose motion is made of the dofs of both sides."""
    with h5py.File(small) as file:
        tip, flank = file["mesh/sets/tip"][()], file["mesh/sets/flank_left"][()]
        moved = set(file["mesh/changed/dof"][()])
        dof_node = file["mesh/dof_node"][()]
        node = next(n for n in flank if moved & set(np.flatnonzero(dof_node == n)))
        elastic = len(dof_node) - file["contact/dofs"].size
    named = make("named", output=f'motion = ["tip", {node}]')
    everything = make("everything", output='motion = "all"')
    done = [run(case, ranks=ranks) for case in (named, everything)]
    (some, full), (rows, all_rows) = (Results(one.folder / "results.h5") for one in done), map(kept, done)
    assert len(all_rows) == elastic and 3 * len(tip) <= len(rows) <= 3 * len(tip) + 6
    scale = max(abs(row).max() for row in all_rows.values())
    for dof, row in rows.items():
        np.testing.assert_allclose(row, all_rows[dof], atol=1e-9 * scale)
    for nodes in ("tip", [node]):
        wanted = full.displacement(0, nodes, n=16)
        assert abs(wanted).max() > 0
        np.testing.assert_allclose(some.displacement(0, nodes, n=16), wanted, rtol=0, atol=1e-6 * abs(wanted).max())
    with pytest.raises(ValueError):
        some.displacement(0, "airfoil")


@pytest.mark.slow
def test_no_motion(make):
    assert kept(run(make("none", output="motion = []"), command="reduce")) == {}


@pytest.mark.slow
def test_other_motion_needs_another_reduction(make):
    case = make("case", output='motion = ["tip"]')
    run(case, command="reduce")
    assert "reused" in run(case, command="reduce").out
    case.path.write_text(case.path.read_text().replace('["tip"]', '["disk"]'))
    assert "reused" not in run(case, command="reduce").out


@pytest.mark.parametrize(("motion", "words"), [
    ('["tipp"]', ['there is no node set "tipp"', "output.motion"]),
    ("[99999999]", ["node 99999999 is not in", "output.motion"]),
    ('"some"', ['must be "all", or a list', "output.motion"]),
    ("[-1]", ["output.motion", "-1"]),
])
def test_motion_refused(tmp_path, motion, words):
    solid = brick.pair().clamped("bottom").with_force("top", [1, 0, 0])
    solid.join(Joint.between(solid.surface("upper"), solid.surface("lower"), normal_stiffness=1e4, tangential_stiffness=1e4, friction=0.3,
                             gap=0)).write(tmp_path / "model.h5")
    path = tmp_path / "case.toml"
    path.write_text(CASE.format(reduction="", output=f"motion = {motion}"))
    done = run(Case(path, None, None, {}), command="reduce", status=2)
    assert all(word in done.err for word in words), done.err
