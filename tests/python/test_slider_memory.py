"""What sliders remember of a small change, in terms linear in lambda, against the exponential function itself."""

import numpy as np
import pytest

from dovetail.slider_memory import SliderMemory, Stick

SHIFT = 1e-3 + 7e-4j
STICKS = [Stick(0, 0, 0.3, 0.7, 2.0, 0.5), Stick(0, 0, 1.0, 3.5, 2.0, -0.5), Stick(0, 1, 5.0, 7.4, 3.0, 0.2),
          Stick(2, 1, 0.1, 6.3, 1.5, 0.0)]
POINTS = 3


def forces(memory, x, t):
    """Amplitudes (w, N_x, 3) of -v with lambda / Omega = SHIFT + t."""
    w, c = len(x), np.zeros(memory.size, complex)
    for _ in range(100):
        c = memory.follow(t * c, x)
    blocks, out = np.zeros((POINTS, 3, w, 3, w), complex), np.zeros((w, POINTS, 3), complex)
    memory.add_to(blocks)
    memory.push(t * c, out)
    return out + np.einsum("pikjl,lpj->kpi", blocks, x)


def expected(x, k, exponent):
    nodes, weights = np.polynomial.legendre.leggauss(60)
    out = np.zeros_like(x)
    for one in STICKS:
        theta = one.begin + (nodes + 1) * (one.end - one.begin) / 2
        value = np.exp(1j * k * one.begin) @ (x[:, one.point, one.t] + one.by_n * x[:, one.point, 2])
        v = one.kt * value * np.exp(-exponent * (theta - one.begin))
        out[:, one.point, one.t] -= np.exp(-1j * np.outer(k, theta)) @ (weights * v) * (one.end - one.begin) / (4 * np.pi)
    return out


@pytest.mark.parametrize("k", [np.arange(-9, 10), np.arange(-9, 9) + 0.5], ids=["whole", "half"])
@pytest.mark.parametrize("t, within", [(0, 1e-13), (0.1j, 1e-10), (-0.4, 1e-6), (0.3 + 0.25j, 1e-6)])
def test_forces_are_those_of_what_a_slider_remembers(k, t, within):
    random = np.random.default_rng(5)
    x = random.normal(size=(len(k), POINTS, 3)) + 1j * random.normal(size=(len(k), POINTS, 3))
    right = expected(x, k, SHIFT + t)
    np.testing.assert_allclose(forces(SliderMemory(STICKS, k, SHIFT), x, t), right, rtol=0, atol=within * np.abs(right).max())


def test_nothing_is_remembered_where_nothing_sticks():
    memory, x = SliderMemory([], np.arange(-2, 3), SHIFT), np.ones((5, POINTS, 3), complex)
    assert memory.size == 0 and not forces(memory, x, 0.2).any()
