"""The harmonic balance in stuck modes: the same branches as with the assembled system, on any number of ranks."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import cases
import chain
from dovetail import Results
from launch import ROOT, SURROUNDINGS, run

SAME = 1e-7  # relative


def compare(case_of, folder, wanted, ranks, options=(), one=None):
    """Runs a case in both forms and compares all coefficients at the frequencies that both give exactly. options : of the modal form;
    one : points of the assembled one that are there already"""
    one = one or run(SimpleNamespace(path=case_of(folder / "assembled", "assembled"))).points
    other = run(SimpleNamespace(path=case_of(folder / "modal", "modal")), *options, ranks=ranks).points
    for omega in wanted:
        at, there = np.flatnonzero(one["omega"] == omega), np.flatnonzero(other["omega"] == omega)
        assert len(at) == len(there) > 0
        for i, j in zip(at, there):
            expected = one["coefficients"][i]
            np.testing.assert_allclose(other["coefficients"][j], expected, rtol=0, atol=SAME * np.abs(expected).max())
    return one, other


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 2])
def test_few_motions_in_the_preconditioner(tmp_path, ranks):
    """As with 250 dofs and more: the same curve, with far fewer iterations."""
    points = {}
    for modes in (0, 10):
        path = chain.write(tmp_path / str(modes), 40, omega=(1.2, 1.9), at=[1.4, 1.5, 1.6, 1.7])
        points[modes] = run(SimpleNamespace(path=path), "-hb_modal_lowest", modes, "-hb_factors_most", 0, ranks=ranks).points
    for omega in (1.4, 1.5, 1.6, 1.7):
        one, other = (points[modes]["coefficients"][points[modes]["omega"] == omega] for modes in (0, 10))
        assert len(one) == len(other) == 1
        np.testing.assert_allclose(other, one, rtol=0, atol=SAME * np.abs(one).max())
    assert points[10]["linear_iterations"].sum() < 0.7 * points[0]["linear_iterations"].sum()
    assert abs(len(points[10]["omega"]) - len(points[0]["omega"])) <= 0.1 * len(points[0]["omega"])


def chain_of_five(folder, solver):
    return chain.write(folder, 5, solver=solver, at=[1.0, 1.3, 1.5, 1.8])


@pytest.fixture(scope="module")
def assembled_chain(tmp_path_factory):
    return run(SimpleNamespace(path=chain_of_five(tmp_path_factory.mktemp("chain"), "assembled"))).points


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.slow
def test_chain(assembled_chain, tmp_path, ranks):
    """Slip and separation at every point, two resonances."""
    one, other = compare(chain_of_five, tmp_path, [0.8, 1.0, 1.3, 1.5, 1.8, 2.6], ranks, one=assembled_chain)
    assert one["slip"].max() > 0.9 and one["open"].max() > 0.9
    peaks = [points["coefficients"][:, -3, 1:3].max() for points in (one, other)]
    np.testing.assert_allclose(peaks[1], peaks[0], rtol=1e-3)  # both have stepped over the peak with the same care


def test_five_degrees_of_freedom(tmp_path):
    """As delivered but for samples and tolerances. Where a direction does not slip, its mean is any of many."""
    def case(folder, solver):
        folder.mkdir()
        return cases.dof5(folder, samples="exact", step_tolerance=1e-10, residual_tolerance=1e-10, at=[1.0, 1.01, 1.02, 1.05],
                          solver=solver).path

    compare(case, tmp_path, [0.9, 1.0, 1.01, 1.02, 1.05, 1.3], ranks=None)


@pytest.mark.slow
def test_two_solids(tmp_path):
    """Nine points of a real joint that slip and open."""
    example = ROOT / "inputs/two_solids"
    model = tmp_path / "model.h5"
    subprocess.run([sys.executable, example / "model.py", "-o", model], env=SURROUNDINGS, check=True, capture_output=True)
    text = (example / "case.toml").read_text()

    def case(folder, solver):
        folder.mkdir()
        changed = text.replace('"model.h5"', '"../model.h5"').replace("harmonics = 10", f'harmonics = 5\nsolver = "{solver}"')
        (folder / "case.toml").write_text(changed.replace("[4000, 4250]", "[4050, 4150]\nat = [4090, 4107, 4120]"))
        return folder / "case.toml"

    one, _ = compare(case, tmp_path, [4050, 4090, 4107, 4120, 4150], ranks=2)
    assert one["slip"].max() > 0.1


@pytest.fixture(scope="module")
def blade(tmp_path_factory):
    """Case maker: a coarse blade in its slot, 54 contact points on two flanks of which some 60 % slip at its resonance."""
    folder = tmp_path_factory.mktemp("blade")
    subprocess.run([sys.executable, ROOT / "inputs/blade_root/model.py", "--dofs", "6000", "--flank", "1x4", "-o", folder / "model.h5"],
                   env=SURROUNDINGS, check=True, capture_output=True)

    def case(where, solver):
        where.mkdir(parents=True)
        (where / "case.toml").write_text(f"""model = "{folder / "model.h5"}"
reduction = {{ modes = 12 }}
damping = {{ stiffness = 1e-6 }}
excitation = {{ fourier = [0, 0, 1] }}
harmonic_balance = {{ harmonics = 2, solver = "{solver}" }}
continuation = {{ omega = [2245, 2248], at = [2246, 2246.5, 2247] }}
output = {{ motion = [] }}
""")
        return where / "case.toml"

    return case


@pytest.fixture(scope="module")
def assembled_blade(blade, tmp_path_factory):
    return run(SimpleNamespace(path=blade(tmp_path_factory.mktemp("assembled") / "blade", "assembled"))).points


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 3])
def test_blade_root(blade, assembled_blade, tmp_path, ranks):
    one, _ = compare(blade, tmp_path, [2245, 2246, 2246.5, 2247, 2248], ranks, one=assembled_blade)
    assert one["slip"].max() > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 2])
def test_blade_root_with_few_motions_in_the_preconditioner(blade, assembled_blade, tmp_path, ranks):
    """As with 250 dofs and more."""
    options = ["-hb_modal_lowest", 4, "-hb_factors_most", 0]
    _, other = compare(blade, tmp_path, [2245, 2246, 2246.5, 2247, 2248], ranks, options, assembled_blade)
    assert other["linear_iterations"].sum() < 6 * other["newton_iterations"].sum()


@pytest.mark.slow
def test_mass_that_lifts_off(tmp_path):
    """Check 1 of the single mass: two great turning points, and small ones among corners close to each other."""
    points, folds = {}, {}
    for solver in ("assembled", "modal"):
        (tmp_path / solver).mkdir()
        done = run(cases.single_mass(tmp_path / solver, 1, omega=[16, 5], kind="auto", solver=solver, at=[12.5, 7.0, 6.0]))
        assert done.summary["end"] == "arrived" and done.summary["leaps"] == done.summary["integrations"] == 0
        points[solver], folds[solver] = done.points, Results(done.folder / "results.h5").events.of("fold").omega
    for omega in (12.5, 7.0, 6.0):
        one, other = (points[solver]["coefficients"][points[solver]["omega"] == omega][0] for solver in points)
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-6 * np.abs(one).max())
    assert len(folds["modal"]) > 2
    np.testing.assert_allclose(folds["modal"], folds["assembled"], rtol=1e-8)
