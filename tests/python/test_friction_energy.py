"""Energy that friction takes from a wheel, by sector, joint and period."""

import numpy as np
import pytest
from ring import N
from ring_results import computed

from dovetail.friction_energy import by_joint, per_period
from dovetail.info import describe


def test_energy_of_a_wheel(tmp_path):
    """That of the loops of all contact points, and in all sectors as often as there are sectors."""
    results = computed(tmp_path)
    energy = per_period(results)
    point = int(np.argmax(energy))
    loops = 0.0
    for contact in range(1, results.contact_points + 1):
        for direction in (0, 1):
            x, T = results.hysteresis(point, contact, direction, 8192)
            loops += np.sum((T + np.roll(T, -1)) / 2 * (np.roll(x, -1) - x))
    assert energy[point] > 0 and energy[point] == pytest.approx(loops, rel=2e-2)
    assert sum(by_joint(results, point).values()) == pytest.approx(energy[point], rel=1e-12)
    line = next(line for line in describe(results.path).splitlines() if "friction energy" in line)
    said = f"at most {energy[point]:.4g} J per period and sector, at {results.place(results.omega[point], 6)}; in {N} sectors "
    assert said + f"{N * energy[point]:.4g} J; power {N * energy[point] * results.frequency[point]:.4g} W" in line
