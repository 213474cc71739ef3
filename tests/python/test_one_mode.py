"""Forced responses from one nonlinear mode: against linear responses, direct peaks of another program, and the equations themselves."""

import re

import h5py
import numpy as np
import pytest

import cases
import launch
import synthetic_results
from backbones import mode, system_of
from dovetail import Results, reference
from dovetail.__main__ import main
from dovetail.modes import Backbone, complex_amplitudes
from dovetail.plot_several import several_modes
from dovetail.reduced_system import equations, stuck
from test_sensitivity import DATA, given

POINTS = 12  # of a backbone


@pytest.fixture(scope="module", params=["dof5", pytest.param("chain", marks=pytest.mark.slow)])
def scene(request):
    """(data, Backbone, row that is watched) at H = 5; 64 samples move frequency and damping ratio by less than 1e-3."""
    data = np.load(DATA / f"{request.param}.npz")
    onset = float(data["onset_alpha"])
    alphas = np.concatenate([onset * np.array([0.5, 0.999]), np.geomspace(1.02 * onset, data["alpha"].max(), POINTS)])
    return data, mode(system_of(data, 64, 5), alphas), int(data["watch"])


def rms(motion, row):
    return np.linalg.norm(motion.coefficients[row, 1:])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["dof5", "chain"])
def test_backbones_of_these_tests_are_those_given(name):
    data = np.load(DATA / f"{name}.npz")
    onset = float(data["onset_alpha"])
    alphas = np.unique(np.concatenate([onset * np.array([0.5, 0.999]), np.geomspace(1.02 * onset, data["alpha"].max(), POINTS),
                                       data["alpha"][data["alpha"] > onset]]))
    found = mode(system_of(data, 256), alphas)
    for alpha, omega, zeta in zip(data["alpha"], data["omega"], data["zeta"]):
        assert found.at(alpha)[:2] == pytest.approx((omega, zeta), rel=3e-4)


def test_peaks_for_any_force(scene):
    """Figures of the method: amplitude within 1.3e-2, frequency within 5e-3 of the peaks computed directly."""
    data, backbone, row = scene
    for force, (omega, amplitude) in zip(data["forces"], data["peak"]):
        if not 0.5 <= force <= 1.5:
            continue
        [peak] = backbone.peaks(force)
        assert rms(peak, row) == pytest.approx(amplitude, rel=1.3e-2) and peak.omega == pytest.approx(omega, rel=5e-3)
        best = backbone.highest(row, force)
        assert rms(best, row) == pytest.approx(amplitude, rel=1.3e-2) and best.omega == pytest.approx(omega, rel=5e-3)
        s1, s2 = backbone.force_levels(peak.alpha)
        zeta = backbone.at(peak.alpha)[1]
        assert s2 == pytest.approx(force) and s1 == pytest.approx(force / np.sqrt(1 - zeta**2))


def test_error_estimates_are_the_errors(scene):
    """Along the curve, with and without the other modes: flanks err by 0.04 to 0.16 without, by less than 0.005 with them."""
    _, backbone, _ = scene
    [piece] = backbone.curve(1.0)
    top = max(piece, key=lambda motion: motion.alpha)
    for share in (0.9, 1.0, 1.03):
        motion = min(piece, key=lambda other: abs(other.omega - share * top.omega))
        bare = backbone.motion(motion.alpha, motion.omega, 1.0, others=False)
        errors = []
        for guess in (motion, bare):
            true = backbone.refine(guess).coefficients
            errors.append(np.linalg.norm((true - guess.coefficients)[:, 1:]) / np.linalg.norm(guess.coefficients[:, 1:]))
            assert backbone.error(guess) == pytest.approx(errors[-1], rel=0.25)
        assert errors[0] < errors[1]
        if share == 0.9:
            assert errors[0] < 0.005 and 0.04 < errors[1] < 0.17


def test_refined_motions_solve_the_equations(scene):
    data, backbone, row = scene
    [peak] = backbone.peaks(1.0)
    refined = backbone.refine(peak)
    system = backbone.system
    assert np.linalg.norm(system.residual(refined.coefficients, refined.omega)) < 1e-8 * np.linalg.norm(system.excitation)
    assert np.linalg.norm(system.residual(peak.coefficients, peak.omega)) > 1e-4 * np.linalg.norm(system.excitation)
    assert abs(refined.amplitude(row) / peak.amplitude(row) - 1) == pytest.approx(backbone.error(peak, row), rel=0.3, abs=2e-3)


def test_a_harmonic_of_the_load_may_excite_the_mode():
    """The third, with a fifth of the load in the first: peaks within 3.5 % at a third of the frequency."""
    data = np.load(DATA / "dof5.npz")
    system = system_of(data, 64, 9)
    load = system.excitation.sum(axis=1)
    system.excitation[:] = 0
    system.excitation[:, 2], system.excitation[:, 6] = 0.2 * load, load
    onset = float(data["onset_alpha"])
    backbone = mode(system, np.concatenate([onset * np.array([0.5, 0.999]), np.geomspace(1.02 * onset, 20, 6)]))
    row = int(data["watch"])
    [peak] = backbone.peaks(0.6, harmonic=3)
    [direct] = backbone.peaks(0.6, harmonic=1)
    assert peak.omega == pytest.approx(backbone.at(peak.alpha)[0] / 3, rel=1e-2) and direct.alpha < peak.alpha
    near = [backbone.refine(backbone.motion(peak.alpha, share * peak.omega, 0.6, 3)) for share in (0.992, 0.996, 1.0, 1.004)]
    best = max(near, key=lambda motion: rms(motion, row))
    assert rms(peak, row) == pytest.approx(rms(best, row), rel=0.035) and peak.omega == pytest.approx(best.omega, rel=8e-3)
    assert 0 < near.index(best) < 3
    assert backbone.excited == 1
    backbone.load[:, 0] = 0
    assert backbone.excited == 3


# --------------------------------------------------------------------------------------------------- linear, and made up
def test_a_linear_structure_comes_out_exactly(tmp_path):
    """Points that stick, damping a M, several harmonics in the load and a constant one: the whole response, far from the mode as well."""
    case = cases.always_stuck(tmp_path, stiffness=0.0, mass=0.05)
    system = case.system()
    squares, phi = np.linalg.eigh(np.linalg.solve(np.linalg.cholesky(system.M), np.linalg.solve(np.linalg.cholesky(system.M), stuck(
        system, np.ones((4, 3)))).T))
    omega = np.sqrt(squares[0])
    shape = np.linalg.solve(np.linalg.cholesky(system.M).T, phi[:, 0])
    q = np.zeros((2, *system.shape))
    q[:, :, 0] = np.linalg.solve(stuck(system, np.ones((4, 3))), system.excitation[:, 0])
    q[:, :, 1] = np.outer([0.5, 50.0], shape)
    backbone = Backbone(np.array([0.5, 50.0]), [omega] * 2, [0.05 / (2 * omega)] * 2, q, system)
    assert backbone.system.preload.g[:, 2].min() > 0
    [piece] = backbone.curve(1.0)
    assert len(piece) > 40 and piece[0].omega < 0.5 * omega < 2 * omega < piece[-1].omega
    for motion in piece[::9]:
        exact = system.solve(motion.omega)
        np.testing.assert_allclose(motion.coefficients, exact, atol=1e-9 * np.abs(exact).max())
    [peak] = backbone.peaks(1.0)
    f, zeta = np.abs(shape @ complex_amplitudes(system.excitation[None])[0][:, 1]), 0.05 / (2 * omega)
    assert peak.alpha == pytest.approx(f / (2 * zeta * omega**2 * np.sqrt(1 - zeta**2)), rel=1e-9)
    assert peak.omega == pytest.approx(omega * np.sqrt(1 - 2 * zeta**2), rel=1e-12)


def made_up(force=(1.0, 0.0, 0.0)):
    """One mass whose damping ratio rises and falls so steeply that several amplitudes belong to one force."""
    reduced = reference.Reduced(np.ones(1), np.zeros((1, 3)), np.eye(3), np.eye(3), np.zeros(1), np.array(force), np.zeros(3))
    contact = reference.Contact.uniform(1, 1.0, 1.0, 0.5)
    system = reference.HarmonicBalance(reduced, contact, reference.Preload(*np.zeros((2, 1, 3)), np.zeros((1, 2))), 0.0, [0, 1], 1, 16)
    alpha = np.geomspace(0.1, 40, 41)
    zeta = 0.01 + 0.2 * np.exp(-(np.log(alpha) / 0.4) ** 2)
    q = np.zeros((41, 4, 3))
    q[:, 1, 1] = alpha
    return Backbone(alpha, 1.5 - 0.05 * np.log(alpha), zeta, q, system)


def test_several_amplitudes_and_separate_curves():
    backbone = made_up()
    levels = backbone.levels()[1]
    force = 0.5 * (levels[backbone.grid > 1.5].min() + levels[backbone.grid < 1.5].max())
    low, middle, high = backbone.peaks(force, others=False)
    assert low.alpha < middle.alpha < high.alpha
    main, island = backbone.curve(force, others=False)
    assert max(motion.alpha for motion in main) == pytest.approx(low.alpha, rel=1e-9)
    alphas = [motion.alpha for motion in island]
    assert (min(alphas), max(alphas)) == pytest.approx((middle.alpha, high.alpha), rel=1e-9)
    for motion in (*main, *island):
        omega, zeta, _ = backbone.at(motion.alpha)
        assert abs(omega**2 - motion.omega**2 + 2j * zeta * omega * motion.omega) * motion.alpha == pytest.approx(force, rel=1e-6)
    assert backbone.peaks(1e6) == []
    with pytest.raises(ValueError, match="no peak on the backbone"):
        backbone.highest(1, 1e6)


def test_refusals():
    backbone = made_up()
    with pytest.raises(ValueError, match="is not between"):
        backbone.at(41.0)
    with pytest.raises(ValueError, match="harmonic must lie in 1 to 1, found 2"):
        backbone.peaks(1.0, harmonic=2)
    with pytest.raises(ValueError, match="does no work on this mode"):
        made_up(force=(0.0, 1.0, 0.0)).peaks(1.0)
    with pytest.raises(ValueError, match="two points or more"):
        Backbone([1.0], [1.0], [0.1], np.zeros((1, 4, 3)), backbone.system)


# ------------------------------------------------------------------------------------------------------------- from files
@pytest.mark.parametrize("overrides", [{"ratios": [[1, 0.02], [3, 0.01]], "mass": 0.01}, {"ratios": [[2, 0.05]], "of": "fixed"},
                                       {"damped_springs": True, "structural": 0.02},
                                       {"loads": {"up": [0, 1], "down": [0.3, 0, 0.5]}}], ids=lambda value: " ".join(value))
def test_results_solve_the_equations_that_are_read(tmp_path, overrides):
    structure = cases.random_structure()
    if "loads" in overrides:
        structure.force = np.stack([structure.force, structure.force[::-1]])
    done = launch.run(cases.several_points(tmp_path, structure=structure, omega=[1.0, 1.04], **overrides))
    results = Results(done.folder / "results.h5")
    system = equations(results)
    for point in (0, len(results) - 1):
        residual = system.residual(results.coefficients_at(point), results.omega[point])
        assert np.linalg.norm(residual) < 1e-8 * np.linalg.norm(system.excitation)
    with pytest.raises(ValueError, match=r"follows no nonlinear mode"):
        Backbone.read(results)


def test_read_from_results(tmp_path, scene):
    """As a run with [mode] leaves them."""
    data, backbone, row = scene
    name = "chain" if len(data["par"]) > 1 else "dof5"
    case, _ = given(tmp_path, name)
    par, preload = data["par"], backbone.system.preload
    contact = {"normal_stiffness": par[:, 0], "tangential_stiffness": par[:, 1:3], "friction": par[:, 3:5], "gap": par[:, 5]}
    n = len(backbone.alpha)
    path = synthetic_results.write(tmp_path / "results.h5", backbone.omega, backbone.coefficients, backbone.system.modes, contact,
                                   xp=preload.xp.ravel(), w=preload.w, reduced="reduced.h5", samples=64, modal_amplitude=backbone.alpha,
                                   damping_ratio=backbone.damping_ratio, slip=np.r_[0.0, 0.0, np.ones(n - 2)],
                                   stick=np.r_[1, 1, np.zeros(n - 2)])
    with h5py.File(path, "r+") as file:
        file.attrs["case"] = case.path.read_text()
        file["preload/g"][...] = preload.g.ravel()
    read = Backbone.read(path)
    assert read.linear_below
    for ours, wanted in zip(read.peaks(0.6), backbone.peaks(0.6), strict=True):
        np.testing.assert_allclose(ours.coefficients, wanted.coefficients, rtol=1e-9, atol=1e-12)
        assert read.error(ours) == pytest.approx(backbone.error(wanted), rel=1e-6)


def test_peaks_over_the_force_are_drawn_as_they_are(tmp_path, scene):
    """Up to the first slip the peak is in proportion to the force; the band is that of the estimates."""
    from dovetail.mode_picture import peaks_over_force

    _, backbone, row = scene
    force, amplitude, error = peaks_over_force(backbone, row).T
    stuck_part = backbone.grid < backbone.alpha[0]
    np.testing.assert_allclose((amplitude / force)[stuck_part], amplitude[0] / force[0], rtol=1e-9)
    i = int(np.flatnonzero(np.isfinite(error))[-2])
    [peak] = backbone.peaks(force[i])
    assert (peak.amplitude(row), backbone.error(peak, row)) == pytest.approx((amplitude[i], error[i]), rel=1e-6)


@pytest.mark.slow
def test_the_mode_of_a_run(tmp_path):
    """[mode] of the program, five degrees of freedom to three times the load: peaks for three forces, from one run of some 20 points."""
    case, data = given(tmp_path, "dof5")
    text = case.path.read_text()
    case.path.write_text(re.sub(r"omega = .*|step = .*|samples = .*|\[sensitivity\]\nof = .*", "", text)
                         + "\n[mode]\nnumber = 1\namplitude = [0.5, 60]\n")
    results = Results(launch.run(case).folder / "results.h5")
    backbone, row = Backbone.read(results), int(data["watch"])
    assert backbone.linear_below and len(backbone.alpha) < 60
    levels = [backbone.force_levels(alpha)[0] for alpha in results.modal_amplitude]
    np.testing.assert_allclose(levels, results.force_level, rtol=1e-6)
    for force, (omega, amplitude) in zip(data["forces"], data["peak"]):
        best = backbone.highest(row, force)
        assert rms(best, row) == pytest.approx(amplitude, rel=1.3e-2) and best.omega == pytest.approx(omega, rel=5e-3)
    assert main(["plot", str(results.path), "--kind", "mode", "--dof", "a1", "-o", str(tmp_path / "mode.png")]) == 0
    assert (tmp_path / "mode.png").read_bytes().startswith(b"\x89PNG")
    axes = several_modes([results, results], ["one", "two"]).axes
    numbers = {tick.get_text() for tick in axes[1].get_xticklabels()}
    assert {"10", "20"} <= numbers and not any("^" in number for number in numbers)
    for axis, points in zip(axes, (results.omega, 100 * results.damping_ratio)):
        dots = [line for line in axis.lines if line.get_linestyle() == "None"]
        assert len(dots) == 2 and np.array_equal(dots[0].get_ydata(), points)
        lines = [line for line in axis.lines if line.get_linestyle() != "None"]
        assert len({line.get_linestyle() for line in lines}) == 2
        np.testing.assert_allclose([lines[0].get_ydata()[0], lines[0].get_ydata()[-1]], points[[0, -1]], rtol=1e-9)
    both = [str(results.path)] * 2
    assert main(["plot", *both, "--kind", "mode", "-o", str(tmp_path / "modes.png")]) == 0 and (tmp_path / "modes.png").is_file()
