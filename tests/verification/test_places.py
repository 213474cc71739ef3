"""Turning points and maxima located on the curve, against closed forms and against finer steps.

With one harmonic a mass on a spring against a stop has a describing function: for an amplitude A about the mean m the stop's
force has the mean N0(m, A) and the first harmonic N1(m, A). The mean follows from the static balance, Omega from the dynamic one,
so that the whole curve is known as Omega(A).
"""

import sys
from types import SimpleNamespace

import h5py
import launch
import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import brentq, minimize_scalar

import cases
import chain
from dovetail import Model, Results

sys.path.insert(0, str(launch.ROOT / "scripts/bench"))
import atlas_scenes

FAR = 1e4  # [N/m] stiffness of directions that nothing excites
M, K, XI, FORCE = 1.0, 1.0, 0.03, 0.1


def events(folder, kind):
    """(omega, amplitude, point) of the located places of one kind."""
    with h5py.File(folder / "results.h5") as file:
        number = file["events/kind"].attrs["names"].decode().split().index(kind)
        chosen = file["events/kind"][()] == number
        return [np.asarray(file[f"events/{name}"])[chosen] for name in ("omega", "amplitude", "point")]


def mass(folder, stiffness, gap, omega, law="unilateral", harmonics=1, extra=""):
    """A mass of 1 kg on 1 N/m, force 0.1 cos, damping 0.03 K, against a stop."""
    K_full = np.diag([K, FAR, FAR, 1e3])
    Model(K_full, np.diag([M, 1, 1, 1]), np.array([[1, 2, 0]]), np.array([FORCE, 0, 0, 0]), np.zeros(4)).write(folder / "model.h5")
    return sweep(folder, stiffness, gap, omega, law, harmonics, extra)


def sweep(folder, stiffness, gap, omega, law="unilateral", harmonics=1, extra=""):
    """Dovetail's curve for the model in that folder, damping 0.03 K."""
    path = folder / "case.toml"
    path.write_text(f"""model = "model.h5"
reduction.modes = 1
damping.stiffness = {XI}
excitation.fourier = [0, 1]
contact = {{ law = "{law}", normal_stiffness = {stiffness}, gap = {gap} }}
harmonic_balance.harmonics = {harmonics}
newton = {{ step_tolerance = 1e-11, residual_tolerance = 1e-11 }}
scaling.kind = "none"
continuation = {{ omega = {list(omega)}{extra} }}
""")
    return launch.run(SimpleNamespace(path=path))


class Bilinear:
    """The curve of one harmonic in closed form; see above."""

    def __init__(self, stiffness, gap):
        self.kn, self.gap = stiffness, gap

    def stop(self, m, A):
        """Mean and first harmonic of the stop's force for the motion m + A cos."""
        phi = np.arccos(np.clip((self.gap - m) / A, -1, 1))  # it presses for |theta| < phi
        d = m - self.gap
        return (self.kn / np.pi * (d * phi + A * np.sin(phi)),
                self.kn / np.pi * (2 * d * np.sin(phi) + A * (phi + np.sin(phi) * np.cos(phi))))

    def mean(self, A):
        return brentq(lambda m: K * m + self.stop(m, A)[0], -10 * self.kn * A, 0, xtol=1e-15)

    def squares(self, A):
        """Both Omega^2 at which the amplitude is A; complex where there are none."""
        k = K * A + self.stop(self.mean(A), A)[1]
        # (k - M W A)^2 + W (XI K A)^2 = F^2 with W = Omega^2
        return np.roots([M ** 2 * A ** 2, (XI * K * A) ** 2 - 2 * k * M * A, k ** 2 - FORCE ** 2])

    def omega(self, A, side):
        W = np.sort_complex(self.squares(A))[0 if side < 0 else 1]
        return np.sqrt(W.real) if abs(W.imag) < 1e-12 else np.nan

    def peak(self):
        """(Omega, A) where both legs meet."""
        A = brentq(lambda A: self.discriminant(A), 0.2, 50, xtol=1e-14)
        return np.sqrt(self.squares(A).real.mean()), A

    def discriminant(self, A):
        a, b, c = np.poly(self.squares(A)).real
        return b * b - 4 * a * c


@pytest.mark.parametrize("stiffness, gap", [(2.0, 1.0), (0.5, 1.0), (5.0, 0.5)])
@pytest.mark.slow
def test_peak_and_turning_points_of_a_mass_against_a_stop(tmp_path, stiffness, gap):
    done = mass(tmp_path, stiffness, gap, [0.6, 2.5])
    assert done.summary["end"] == "arrived"
    curve = Bilinear(stiffness, gap)
    omega, amplitude, point = events(tmp_path, "peak")
    assert len(omega) == 1
    np.testing.assert_allclose((omega[0], amplitude[0]), curve.peak(), rtol=1e-6)
    results = Results(tmp_path / "results.h5")
    assert results.omega[point[0]] == omega[0]  # the place is a point of the branch
    assert results.amplitude("x1.n")[point[0]] == pytest.approx(amplitude[0], rel=1e-9)

    top = curve.peak()[1]
    folds = []
    for side in (-1, 1):  # extremes of Omega(A) on either leg, away from the peak
        A = np.linspace(gap * 1.0001, top * 0.99999, 4000)
        W = np.array([curve.omega(a, side) for a in A])
        for i in range(1, len(A) - 1):
            if (W[i] - W[i - 1]) * (W[i + 1] - W[i]) < 0:
                sign = np.sign(W[i] - W[i - 1])
                best = minimize_scalar(lambda a: -sign * curve.omega(a, side), bounds=(A[i - 1], A[i + 1]), method="bounded",
                                       options={"xatol": 1e-13})
                folds.append(sign * -best.fun)
    found = events(tmp_path, "fold")[0]
    assert len(found) == done.summary["folds"] >= len(folds) - 1 and len(folds) >= 1
    for fold in folds:
        assert np.min(np.abs(found - fold)) < 1e-6 * fold


def test_peak_of_a_linear_oscillator(tmp_path):
    """A stop that also pulls is a spring: Omega^2 = k/m - (xi K/m)^2 / 2 at the largest amplitude F / (xi K sqrt(k/m - ...))."""
    mass(tmp_path, 2.0, 0.0, [1.2, 2.2], law="bilateral", harmonics=3)
    k, c = K + 2.0, XI * K
    square = k / M - (c / M) ** 2 / 2
    omega, amplitude, _ = events(tmp_path, "peak")
    np.testing.assert_allclose(omega, [np.sqrt(square)], rtol=1e-8)
    np.testing.assert_allclose(amplitude, [FORCE / np.sqrt((k - square * M) ** 2 + square * c ** 2)], rtol=1e-9)


@pytest.mark.slow
def test_places_do_not_depend_on_the_steps(tmp_path):
    """Lift-off with 15 harmonics: the same folds and peaks from steps ten times as fine."""
    found = []
    for name, extra in (("coarse", ""), ("fine", ", step = 0.01, adaptive = false")):
        (tmp_path / name).mkdir()
        done = mass(tmp_path / name, 2.0, 1.0, [0.8, 1.4], harmonics=15, extra=extra)
        assert done.summary["end"] == "arrived"
        found.append([np.column_stack(events(tmp_path / name, kind)[:2]) for kind in ("fold", "peak")])
    for coarse, fine in zip(*found):
        assert len(coarse) == len(fine) >= 1
        np.testing.assert_allclose(coarse, fine, rtol=1e-6)


@pytest.mark.slow
def test_branch_points_of_two_masses_in_step(tmp_path):
    """Two such masses, mirror images, joined by a spring: in step they move as one does. Where they may part, the equations for a small
    difference, linear ones with the spring twice, are singular: branch points of the curve in step, in closed form with one harmonic."""
    spring, stop, gap = 0.01, 2.0, 1.0
    K_full, M_full, f = np.diag([K + spring, FAR, FAR, K + spring, FAR, FAR, 1e3]), np.eye(7), np.zeros(7)
    K_full[0, 3] = K_full[3, 0] = -spring
    f[[0, 3]] = FORCE
    Model(K_full, M_full, np.array([[1, 2, 0], [4, 5, 3]]), f, np.zeros(7)).write(tmp_path / "model.h5")
    done = sweep(tmp_path, stop, gap, [0.6, 2.5])
    assert done.summary["end"] == "arrived"
    curve = Bilinear(stop, gap)

    def parting(A, side):
        """Determinant of the equations for a difference of means, of amplitudes, and across, at the motion m + A cos."""
        omega, m, h = curve.omega(A, side), curve.mean(A), 1e-6
        by_m = (np.array(curve.stop(m + h, A)) - curve.stop(m - h, A)) / (2 * h)
        by_A = (np.array(curve.stop(m, A + h)) - curve.stop(m, A - h)) / (2 * h)
        k = K + 2 * spring
        inertia, damping = k - M * omega ** 2, XI * k * omega
        return np.linalg.det([[k + by_m[0], by_A[0], 0], [by_m[1], inertia + by_A[1], damping],
                              [0, -damping, inertia + curve.stop(m, A)[1] / A]])

    expected = []
    for side in (-1, 1):
        A = gap + (curve.peak()[1] * 0.99999 - gap) * np.linspace(1e-4, 1, 1000) ** 2  # more of them where it just touches
        values = [parting(a, side) for a in A]
        expected += [curve.omega(brentq(parting, A[i], A[i + 1], args=(side,), xtol=1e-13), side)
                     for i in range(len(A) - 1) if values[i] * values[i + 1] < 0]
    found, _, point = events(tmp_path, "branch")
    assert len(expected) >= 2 and len(found) == done.summary["branch_points"]
    np.testing.assert_allclose(np.sort(found), np.sort(expected), rtol=1e-5)  # located to 1e-5 of a step
    apart = Results(tmp_path / "results.h5")
    np.testing.assert_allclose(apart.amplitude("x1.n")[point], apart.amplitude("x2.n")[point], rtol=1e-6)  # in step there


def test_unknowns_that_move_alike_are_named_by_the_first(tmp_path):
    """Last bits, which a processor decides, do not say which of two equal blades has the peak."""
    path = chain.write(tmp_path, 1, harmonics=3)
    one = chain.model(1)
    twins = Model(sp.block_diag([one.K] * 2, "csc"), sp.block_diag([one.M] * 2, "csc"), np.array([[0, 1, 2], [6, 7, 8]]),
                  np.append(one.force, one.force * (1 + 1e-9)), np.tile(one.preload, 2))
    twins.write(path.with_name("model.h5"))
    launch.run(SimpleNamespace(path=path), out="out")
    results = Results(tmp_path / "out/results.h5")
    first, second = (results.response(f"x{i}.t1").amplitude for i in (1, 2))
    assert 0 < (second - first).max() < 1e-6 * first.max()
    assert results.watched.startswith("x1."), results.watched


@pytest.mark.parametrize("omega, told", [([1.5, 2.5], True), ([1.6, 2.0], False)])
def test_an_end_is_told_where_it_lies_above_all_peaks(tmp_path, omega, told):
    """Both curves fall at first, behind a peak at 1.47 rad/s, and have others."""
    done = launch.run(cases.always_stuck(tmp_path, omega=omega, fourier=[0, 1], harmonics=1))
    assert done.summary["peaks"] > 0 and ("  no peak, falling from the beginning of the curve" in done.out) == told


@pytest.mark.parametrize("name", ["048", "158", "246"])
def test_a_maximum_is_met_where_something_else_takes_over_within_the_step(tmp_path, name):
    """What moves most passes its maximum, then another unknown moves more and rises. All maxima of finer steps are met."""
    built = atlas_scenes.build(atlas_scenes.scenes()[name])
    path = atlas_scenes.write(built, tmp_path)
    usual = launch.run(SimpleNamespace(path=path), out="usual").summary
    path.write_text(path.read_text() + "\n[accuracy]\nbetween = 1e-6\n")
    finer = launch.run(SimpleNamespace(path=path), out="finer").summary
    assert 3 * usual["points"] < finer["points"]
    peaks, expected = ([(peak["unknown"], peak["omega"]) for peak in run["located"]["peaks"]] for run in (usual, finer))
    for unknown, omega in expected:
        assert any(unknown == of and abs(omega - at) < 1e-4 * omega for of, at in peaks), (unknown, omega, peaks)
