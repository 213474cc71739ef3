"""The benches: tables of made-up figures, worked out by hand, and a short run of the contact kernel's. No time is judged."""

import json
import math
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from launch import BINARY, ROOT

sys.path.insert(0, str(ROOT / "scripts/bench"))
import contact_kernel
import measure
import reduction
import scale
import scale_model
import sweeps
import uneven

SECONDS = {"1 model": [0.5, 0.4], "2a analysis": [1.0, 1.0], "2c factorisation": [1.5, 2.0], "2d modes": [3.0, 3.0],
           "2e constraint modes": [4.0, 3.5], "2f projections": [0.25, 0.25], "2h writing": [0.125, 0.125],
           "2 reduction": [11.0, 11.0]}
SUMMARY = {"stages": [{"name": name, "seconds": seconds, "cpu": [s / 2 for s in seconds],
                       "peak_mib": [1000, 1250] if name == "2 reduction" else [1, 1]} for name, seconds in SECONDS.items()],
           "reduction": {"ordering": "METIS", "flops": 6e10, "backward_error": 2e-16, "kept_psi": False, "forecast_mib": [1600, 1500]}}


@pytest.fixture
def run(tmp_path):
    (tmp_path / "summary.json").write_text(json.dumps(SUMMARY))
    return reduction.figures(*measure.summary_of(tmp_path))


def test_table(run):
    model = {"dofs": 19_797, "points": 486, "seconds": 4.44, "peak_mib": 297.4}
    lines = reduction.table([{"model": model, "ranks": 2, "run": reduction.middle_run([run])}], machine=60.0)
    shown = {line[:34].strip(): line[34:].strip() for line in lines}
    expected = {"dofs": "19797", "contact points": "486", "ranks": "2", "ordering": "METIS", "largest rank [MiB]": "297",
                "factorisation [s]": "2.00", "GFLOP/s": "30.0", "of dgemm, per rank": "25%", "Psi [s]": "4.00", "Psi": "in blocks",
                "between these [s]": "0.62", "total [s]": "11.50", "CPU time, all ranks [s]": "11.45",
                "peak memory, largest rank [MiB]": "1250", "forecast for it [MiB]": "1500", "forecast / peak": "1.20",
                "backward error": "2e-16"}
    assert {name: shown[name] for name in expected} == expected


def test_middle_run_takes_every_median_by_itself(run):
    def other(total, psi, ordering):
        return {**run, "total": total, "seconds": {**run["seconds"], "Psi": psi}, "ordering": ordering}

    middle = reduction.middle_run([other(9.0, 7.0, "METIS"), other(12.0, 5.0, "METIS"), other(30.0, 6.0, "SCOTCH")])
    assert (middle["total"], middle["lowest"], middle["highest"]) == (12.0, 9.0, 30.0)
    assert middle["seconds"]["Psi"] == 6.0 and middle["ordering"] == "METIS/SCOTCH"


@pytest.fixture(scope="module")
def contact_rows():
    """Measured rows of a quick run, built in the folder of the program under test, by kind, harmonics and samples (0: exact)."""
    if not (BINARY.parent / "CMakeCache.txt").exists():
        pytest.skip(f"{BINARY.parent} is no build folder")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contact_kernel, "PROGRAM", BINARY.parent / "contact_kernel")
        rows, peak, _, _ = contact_kernel.measured_rows(contact_kernel.settings(["--quick"]))
    assert all(value > 0 for value in peak.values())
    json.dumps(rows, allow_nan=False)
    return {(row["kind"], row["harmonics"], row["samples"]): row for row in rows}


@pytest.mark.slow
def test_contact_kernel_measures_every_kind_both_ways(contact_rows):
    kinds = ["stuck", "nearly slips", "simple slip", "slip", "separation"]
    assert list(contact_rows) == [(kind, H, N) for H in (5, 10) for kind in kinds for N in (0, 64, 256)]
    for row in contact_rows.values():
        assert all(0 < row[name] < math.inf for name in ("residual", "jacobian", "product"))
        assert 0 < row["operations"]["residual"] <= row["operations"]["jacobian"]
    lines = contact_kernel.table(contact_rows.values())
    assert sum(line.startswith("  exact") for line in lines) == 10 and sum("N = " in line for line in lines) == 20


@pytest.mark.slow
def test_contact_kernel_motions_are_of_their_kind(contact_rows):
    for (kind, _, _), row in contact_rows.items():
        least, most = {"simple slip": (4, 8), "slip": (8, 20), "separation": (4, 30)}.get(kind, (0, 0))
        assert least <= row["events"] <= most
        assert (row["open"] > 0) == (kind == "separation") and (row["slip"] > 0) == (most > 0)


@pytest.mark.slow
def test_contact_kernel_errors(contact_rows):
    for (kind, H, N), row in contact_rows.items():
        if N == 0:
            assert row["force_error"]["worst"] < 1e-12
            continue
        assert row["naive"]["difference"] < 1e-11  # the same law, written twice
        if row["events"] == 0:
            assert row["force_error"]["worst"] < 1e-11 and row["jacobian_error"]["worst"] < 1e-11
        elif N == 256:
            coarse = contact_rows[kind, H, 64]
            for name in ("force_error", "jacobian_error"):
                assert 0 < row[name]["median"] < coarse[name]["median"] / 2 and row[name]["median"] < 0.05


def test_operations_of_a_sampled_point_in_slip():
    # H = 1, N = 10: n = 3; transforms 3 * 3 * 10, law 22 * 10; then 10 * 9 for blocks, (36 + 30) for each of 2 rank-one terms,
    # 6 * 3 for each of 4 events; five products with 36, and 18 for each rank-one term
    assert contact_kernel.operations("slip", 1, 10, events=4, runs=2) == (310, 310 + 90 + 132 + 72, 180 + 36)


def test_turning_points():
    assert sweeps.turning_points([1.0, 2.0, 3.0, 2.5, 2.5, 2.0, 2.25, 4.0]) == 2
    assert sweeps.turning_points([1.0]) == sweeps.turning_points([3.0, 2.0, 1.0]) == 0


def test_worst_share_of_a_rank():
    costs = np.array([[1.0, 1.0, 4.0, 2.0], [3.0, 1.0, 2.0, 2.0]])  # two points of the curve, four contact points
    assert uneven.worst_share(costs, 2) == pytest.approx((6 / 4 + 4 / 4) / 2)
    assert uneven.worst_share(costs, 4) == pytest.approx((4 / 2 + 3 / 2) / 2)


def test_effects_of_high_harmonics_are_those_of_a_direct_solve():
    made = np.random.default_rng(3)
    n, harmonics, omega = 8, 4, 0.7
    K, M = (np.eye(n) + 0.1 * (part + part.T) for part in made.standard_normal((2, n, n)))
    forces = made.standard_normal((6, 2 * harmonics + 1))
    found = uneven.effects(K, M, omega, forces, 2)
    assert found.shape == (2, n, 4)
    for point in range(2):
        pushed = np.zeros((n, 2 * harmonics + 1))
        pushed[2 + 3 * point:5 + 3 * point] = forces[3 * point:3 * point + 3]
        for i, column in enumerate(range(5, 9)):
            k = (column + 1) // 2
            assert found[point, :, i] == pytest.approx(np.linalg.solve(K - (k * omega) ** 2 * M, pushed[:, column]), abs=1e-10)


def test_left_if_the_points_with_most_keep_theirs():
    made = np.zeros((4, 2, 1))
    made[:, 0, 0] = 1.0, 10.0, 2.0, 3.0
    assert uneven.left(made, 0.25) == pytest.approx(6 / 16)
    assert uneven.left(made, 0.5) == pytest.approx(3 / 16)


def test_collective_calls_of_a_stage_and_where_they_come_from(tmp_path):
    lines = ["4 scaling\tAllreduce\t7\t56\tVecNorm\t10", "5 branch\tAllreduce\t3\t24\tVecNorm\t10\t25", "5 branch\tBcast\t2\t16\t?\t25",
             "5 branch\tIsend\t5\t400\t?\t10"]
    (tmp_path / "calls.0").write_text("\n".join(lines) + "\n")
    calls, given = scale.counted(tmp_path / "calls.0")
    assert scale.total(calls) == 5 and scale.total(given) == 40
    assert scale.total(calls, collective=False) == 5
    names = {"10": "solve", "25": "step"}.get
    assert [line.split() for line in scale.places(calls, names, 2)] == [["5.00", "Isend", "?", "solve"],
                                                                       ["3.00", "Allreduce", "VecNorm", "solve", "<", "step"]]


@pytest.fixture
def cluster():
    """A machine that computes and sends, and whose memory is never waited for."""
    return SimpleNamespace(cores=64, memory=1e9, core_memory=1e9, flops=100.0, latency=10.0, network=1e9, contact=0.0, linear=20.0,
                           solves=5.0, residuals=4.0)


def test_a_point_on_many_ranks(cluster):
    alone, _ = scale_model.point(200, 5, 1, cluster)
    assert alone["products"] == pytest.approx(20 * 4 * 200 * 200 * 11 / 100e9, rel=1e-9)
    assert alone["residuals"] == pytest.approx(4 * 4 * 200 * 200 * 11 / 50e9, rel=1e-9)
    assert alone["messages"] == 0
    many, whole = scale_model.point(200, 5, 8, cluster)
    assert whole and many["vectors"] == pytest.approx(alone["vectors"], rel=1e-3)
    assert many["products"] == pytest.approx(alone["products"] / 8, rel=1e-9)
    assert many["messages"] == pytest.approx((20 + 4 + scale_model.OTHER_CALLS) * 3 * 10e-6, rel=1e-3)
    far, whole = scale_model.point(3000, 5, 8, cluster)
    assert not whole and far["messages"] == pytest.approx((5 * 20 + 4 + scale_model.OTHER_CALLS) * 3 * 10e-6, rel=1e-3)


def test_a_reduction_on_many_ranks(cluster):
    alone = scale_model.reduction(152526, 1518, 50, 1, cluster)  # operations over 50 GFLOP/s
    assert alone["factors"] == pytest.approx(6.63e10 / 50e9, rel=1e-2)  # as MUMPS counts them
    assert alone["projections"] == pytest.approx(2 * 152526 * 1518**2 / 50e9, rel=1e-12)
    for name, seconds in scale_model.reduction(152526, 1518, 50, 8, cluster).items():
        assert seconds == pytest.approx(alone[name] / 8, rel=1e-12)
    smaller = scale_model.reduction(62919, 1518, 50, 1, cluster)
    assert smaller["factors"] == pytest.approx(1.535e10 / 50e9, rel=0.15) and smaller["Psi"] < alone["Psi"] * 62919 / 152526


def test_the_model_has_the_numbers_of_the_program():
    assert f"many_dofs = {scale_model.MANY};" in (ROOT / "src/stuck/near_basis.hpp").read_text()
    assert scale_model.bytes_a_rank(scale_model.MANY, 1) < scale_model.bytes_a_rank(scale_model.MANY - 1, 1)
    source = (ROOT / "src/modal/modal_share.cpp").read_text()
    found = {name: float(value) for name, value in re.findall(r"constexpr \w+ (\w+) = (\d+);", source)}
    assert found == {"least": scale_model.LEAST, "iterations": scale_model.ITERATIONS_TO_FACTOR, "brief": scale_model.BRIEF}
