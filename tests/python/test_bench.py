"""The table of scripts/bench/reduction on a made-up summary, its numbers worked out by hand. Nothing is timed."""

import json
import sys

import pytest

from launch import ROOT

sys.path.insert(0, str(ROOT / "scripts/bench"))
import measure
import reduction

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
