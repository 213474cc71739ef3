"""First points where Newton's method does not converge from rest with all harmonics. Which way leads to one is a matter of last bits: so
many scenes are begun, and what holds on any way is tested."""

import sys

import pytest

from launch import BINARY, ROOT
from residuals import residuals

sys.path.insert(0, str(ROOT / "scripts/bench"))
import atlas_methods
import atlas_scenes

from dovetail import Results

WAYS = ["one harmonic", "fewer harmonics", "time integration"]  # the first is how it should be, and nothing is said
SCENES = ["006", "011", "012", "039", "049", "058", "083", "087", "104", "168", "189", "194", "212", "213", "226", "233", "274"]
SECONDS = 3  # of the processor, for each
SAID = "Newton does not converge from rest; the first point comes from "


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    """By name: the scene, what the run says of the way to its first point, and that point; those only that have one."""
    found = {}
    for name in SCENES:
        folder = tmp_path_factory.mktemp(name)
        built = atlas_scenes.build(atlas_scenes.scenes()[name])
        case = atlas_scenes.write(built, folder)
        case.write_text(case.read_text() + "max_points = 1\n")
        run = atlas_methods.limited([BINARY, "run", case, "--out", folder], SECONDS)
        if run.status == 0:
            ways = [line.split(SAID)[1] for line in run.output.splitlines() if SAID in line]
            found[name] = built, ways, Results(folder / "results.h5")
    return found


@pytest.mark.slow
def test_every_way_leads_to_some(begun):
    taken = [next(way for way in WAYS if said.startswith(way)) for _, ways, _ in begun.values() for said in ways or WAYS[:1]]
    assert {"one harmonic", "time integration"} <= set(taken), taken  # few scenes are left for the other
    assert len(begun) >= 0.75 * len(SCENES), set(SCENES) - set(begun)


@pytest.mark.slow
def test_first_points_are_solutions(begun):
    for name, (built, _, found) in begun.items():
        H = int(found.points("harmonics")[0])
        assert residuals(built, found.omega, found.coefficients[:, :, :2 * H + 1], samples=32768) < 1e-4, name
