"""scripts/bench/field on the chain with one contact point: its methods agree as far as they should. No time is judged."""

import sys

import numpy as np
import pytest

import launch

sys.path.insert(0, str(launch.ROOT / "scripts/bench"))
import field
import field_methods


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    if not (launch.BINARY.parent / "CMakeCache.txt").exists():
        pytest.skip(f"{launch.BINARY.parent} is no build folder")
    launch.words_of(["cmake", "--build", str(launch.BINARY.parent), "--target", "integrate"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(field_methods, "BINARY", launch.BINARY)
        patch.setattr(field_methods, "INTEGRATE", launch.BINARY.with_name("integrate"))
        patch.setattr(field_methods, "OUTPUT", tmp_path_factory.mktemp("field"))
        patch.setattr(field_methods, "WALK", 2)
        yield field_methods.Chain(1)


@pytest.fixture(scope="module")
def truth(scene):
    return scene.dovetail(40)[0]


def error(found, truth):
    return np.abs(found[0] / truth - 1).max()


@pytest.mark.slow
def test_peak_is_where_others_find_it(scene):
    assert scene.peak == pytest.approx(1.3079, abs=0.01) and max(scene.dovetail(10)[0]) == pytest.approx(0.7759, rel=1e-2)


@pytest.mark.slow
def test_reference_solves_the_same_equations(scene):
    np.testing.assert_allclose(scene.sampled(3)[0], scene.numpy(3)[0], rtol=1e-6)


@pytest.mark.slow
def test_errors_fall_with_harmonics(scene, truth):
    errors = [error(scene.dovetail(harmonics), truth) for harmonics in (1, 3, 10, 20)]
    assert all(later < earlier / 5 for earlier, later in zip(errors, errors[1:])) and errors[-1] < 1e-5


@pytest.mark.slow
def test_time_integration_agrees(scene, truth):
    assert error(scene.events(1e-9), truth) < 1e-6
    rough, fine = (error(scene.newmark(accuracy), truth) for accuracy in (1e-1, 1e-2))
    assert fine < rough / 3 and fine < 0.05


def test_cheapest_within_an_error(tmp_path):
    def row(method, setting, error, seconds):
        return dict(points=4, method=method, setting=setting, error=error, seconds=seconds, lowest=seconds, highest=seconds, runs=1)

    ours, sampled = "Dovetail", f"Dovetail, N = {field.SAMPLES}"
    rows = [row(ours, 1, 0.05, 0.001), row(ours, 3, 5e-3, 0.003), row(ours, 5, 2e-3, 0.002), row(sampled, 5, 3e-4, 0.004),
            {"points": 4, "method": "pyHarm, N = 128", "setting": 5, "why": "no convergence"}]
    best = [field.cheapest(rows, 4, ours, within) for within in (1e-1, 1e-2, 1e-3)]
    assert [found and found["setting"] for found in best] == [1, 5, None]
    published = field.elsewhere(rows, 4)
    assert {(found["method"], found["error"]) for found in published} == {("tmdsimpy", 3e-4), ("pyHarm 1.2.2", 3e-4), ("NLvib", 3e-4)}
    assert field.prices(rows)[1].split()[-6:] == ["1", "(1)", "2", "(5)", "-", "-"]
    assert any(line.endswith("no convergence") for line in field.table(rows + published))
    field.draw(rows + published, tmp_path / "field.png")
    assert (tmp_path / "field.png").stat().st_size > 10_000
