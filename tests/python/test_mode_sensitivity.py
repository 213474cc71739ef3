"""What a nonlinear mode depends on: closed form of one Jenkins element, and modes that are solved again with other parameters."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

import cases
import launch
from dovetail import reference
from dovetail.mode_sensitivity import mode_sensitivity, solved_mode
from dovetail.modes import Backbone, real_coefficients
from dovetail.reduced_system import equations, reduced_of
from dovetail.results import Results


def test_closed_form_of_one_jenkins_element(tmp_path):
    """H = 1, a > u_s = mu N / k_t: by mu, k_t, and by k_n and the gap through N, against differences of the closed
    form; samples move them by 3e-3."""
    case = cases.single_mass(tmp_path, 2, friction=0.2, tangential_stiffness=30.0, omega=None, step=None, harmonics=1, samples="exact",
                             solver="assembled", kind="auto", stiffness=None)
    with h5py.File(tmp_path / "reduced.h5", "r+") as file:
        file["Fx"][...] = [1.0, 0, 0]
    case.path.write_text(case.path.read_text() + "\n[mode]\nnear = 8.4\namplitude = [1, 40]\n")
    done = launch.run(case)
    a, base = 20.0, {"kn": 120.0, "kt": 30.0, "mu": 0.2, "gap": 0.0}

    def closed(kn, kt, mu, gap):
        N = kn * (800 - 40 * gap) / (40.0 + kn)
        us = mu * N / kt
        T = np.arccos(1 - 2 * us / a)
        square = 40.0 + kt / np.pi * (T - np.sin(2 * T) / 2)
        return np.array([np.sqrt(square), 2 * mu * N * (a - us) / (np.pi * square * a**2)])

    found = mode_sensitivity(done.folder / "results.h5", [a], samples=2048)
    assert (found.omega[0], found.damping_ratio[0]) == pytest.approx(closed(**base), rel=1e-4)
    for name, key in (("normal_stiffness", "kn"), ("tangential_stiffness", "kt"), ("friction", "mu"), ("gap", "gap")):
        h = 1e-5 * (base[key] or 1.0)
        wanted = (closed(**base | {key: base[key] + h}) - closed(**base | {key: base[key] - h})) / (2 * h)
        ours = [by[name][0].reshape(-1)[0] for by in (found.omega_by, found.damping_ratio_by)]
        np.testing.assert_allclose(ours, wanted, rtol=5e-3, err_msg=name)
    assert found.relative("friction")[0, 0, 0] == pytest.approx(0.2 * found.damping_ratio_by["friction"][0, 0, 0] / found.damping_ratio[0])


@pytest.mark.slow
def test_derivatives_are_differences_of_modes_solved_again(tmp_path):
    """Five degrees of freedom, slip and varying normal force: every parameter, the preload state going along."""
    case = cases.dof5(tmp_path, omega=None, step=None, harmonics=3, samples="exact", kind="auto", **cases.TIGHT)
    case.path.write_text(case.path.read_text() + "\n[mode]\nnumber = 1\namplitude = [0.5, 25]\n")
    results = Results(launch.run(case).folder / "results.h5")
    amplitudes, samples = [12.0, 20.0], 128
    found = mode_sensitivity(results, amplitudes, samples)
    backbone, system = Backbone.read(results, samples), equations(results, samples)
    with h5py.File(tmp_path / "reduced.h5") as file:
        reduced, _ = reduced_of(file, results)
    for i, alpha in enumerate(amplitudes):
        omega, zeta, shape = backbone.at(alpha)
        shape = shape.copy()
        shape[:, 1:] *= alpha
        for name, field, place in (("normal_stiffness", "kn", 0), ("tangential_stiffness", "kt", (0, 0)), ("friction", "mu", (0, 1)),
                                   ("gap", "gap", 0)):
            ends = []
            for h in (1e-4, -1e-4):
                values = np.array(getattr(system.contact, field), dtype=float)
                values[place] += h
                contact = replace(system.contact, **{field: values})
                other = equations(results, samples)
                other.contact, other.preload = contact, reference.contact_preload(reduced, contact, results.xp)
                ends.append(solved_mode(other, real_coefficients(shape), omega, zeta, alpha)[1:3])
            wanted = (np.array(ends[0]) - np.array(ends[1])) / 2e-4
            ours = [by[name][i].reshape(np.shape(system.contact.__dict__[field]))[place]
                    for by in (found.omega_by, found.damping_ratio_by)]
            np.testing.assert_allclose(ours, wanted, rtol=1e-3, atol=1e-6, err_msg=name)


def test_refusals(tmp_path):
    done = launch.run(cases.dof5(tmp_path, omega=[1.0, 1.01], harmonics=1, samples="exact"))
    with pytest.raises(ValueError, match="follows no nonlinear mode"):
        mode_sensitivity(done.folder / "results.h5", [1.0])
