"""inputs/blisk with its coarsest mesh: the wave of one sector, and the program on all 36 of them."""

import re
import subprocess
import sys

import launch
import pytest

from dovetail import Results
from dovetail.__main__ import main

FORCE, SWEEP = 100, (735, 752)  # kPa and Hz, where nodal diameter 4 of this mesh resonates and half of its contacts open


@pytest.mark.slow
def test_all_sectors_of_the_blisk_do_what_one_says(tmp_path, capsys):
    """972 contact points without cyclic symmetry, with the load of every sector: the wave is their solution to rounding errors."""
    inputs = launch.ROOT / "inputs/blisk"
    subprocess.run([sys.executable, inputs / "model.py", "--dofs", "7000", "--flank", "1x1", "--shroud", "1x1", "--side", "2x2", "-o",
                    tmp_path / "model.h5"], check=True, capture_output=True)
    text = (inputs / "case.toml").read_text()
    for key, value in (("fourier", f"[0, {FORCE}]"), ("omega", str(list(SWEEP))), ("motion", "[]")):
        text = re.sub(rf"^{key} = \[.*?\]", f"{key} = {value}", text, flags=re.MULTILINE)
    (tmp_path / "case.toml").write_text(text)
    subprocess.run([launch.BINARY, "run", "case.toml"], cwd=tmp_path, check=True, capture_output=True)
    results = Results(tmp_path / "results.h5")
    assert (results.wave.sectors, results.contact_points) == (36, 27)
    assert main(["wheel", str(results.path), "--whole", "--binary", str(launch.BINARY)]) == 0
    (row,) = [line.split() for line in capsys.readouterr().out.splitlines() if "too large" in line]
    assert float(row[-1]) < 1e-10
    assert results.points("stick")[int(row[1])] < 0.7
