"""A whole bladed disk under a travelling load, friction in roots and between shrouds, against an independent program."""

import h5py
import numpy as np
import pytest

import cases
import launch
import whole_rotor


@pytest.mark.slow
@pytest.mark.parametrize("name, point", [("eo-1_two_loads", 1), ("eo1_root", -1), ("eo2_separation", 1), ("eo2_separation", -1),
                                         ("eo3_aliased", -1)])
def test_all_sectors_move_as_an_independent_program_says(tmp_path, name, point):
    """From a motion a thousandth away. Its preload is what friction lowered in steps finds."""
    omega, X = float(whole_rotor.DATA[f"{name}/omega"][point]), whole_rotor.DATA[f"{name}/X_rotor"][point]
    case = cases.Case(whole_rotor.write(tmp_path, name, omega, samples=3072), None, None, {})
    flat = X.reshape(-1, X.shape[-1])
    launch.run(case, command="reduce")
    whole_rotor.write_start(tmp_path, name, omega, 1.001 * flat)
    done = launch.run(case)
    found = done.points["coefficients"][-1][-len(flat):]
    np.testing.assert_allclose(found, flat, rtol=0, atol=1e-8 * np.abs(flat).max())
    with h5py.File(tmp_path / "results.h5") as file:
        xp = file["preload/xp"][()].reshape(whole_rotor.N, -1, 3)
    expected = whole_rotor.DATA[f"{name}/xp"]
    np.testing.assert_allclose(xp, np.broadcast_to(expected, xp.shape), rtol=0, atol=1e-9 * np.abs(expected).max())


@pytest.mark.slow
def test_a_preload_that_newton_does_not_find_is_found_by_lower_friction(tmp_path):
    case = cases.Case(whole_rotor.write(tmp_path, "eo2_separation", 2000.0, samples=64), None, None, {})
    assert "friction lowered in steps" in launch.run(case, command="modes").out
