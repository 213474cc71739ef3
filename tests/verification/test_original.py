"""The original's algorithm, kept in dovetail.reference: it gives the figures its authors' program gives, and stops where that one stops."""

import numpy as np
import pytest

import cases
import truth
from dovetail import reference


def sweep(case, step, points=10000):
    """Frequencies, solutions and Newton iterations of the original until it is through, or stops; and whether it was through."""
    s = case.settings
    original = reference.Original(case.reduced, case.contact, case.preload, s["stiffness"], s["fourier"], s["harmonics"], s["samples"])
    done, complaint = [], None
    try:
        for point in original.branch(*s["omega"], step):
            done.append(point)
            if len(done) == points:
                break
    except RuntimeError as stopped:
        complaint = str(stopped)
    omega, q, newton = (np.array(part) for part in zip(*done)) if done else 3 * (np.array([]),)
    return omega, q, newton, complaint


@pytest.mark.slow
def test_as_delivered(tmp_path):
    """436 points and 1300 iterations, and the peaks and where they are, all as published."""
    omega, q, newton, complaint = sweep(cases.dof5(tmp_path), 0.05)
    assert complaint is None and omega[0] == 0.9 and omega[-1] == 1.3
    assert (len(omega), newton.sum()) == (436, 1300)
    expected = {0: (2.699938, 1.02150), 1: (0.080870, 1.01925), 2: (5.724547, 1.02647), 3: (3.913528, 1.02647), 4: (1.920393, 1.02647)}
    for row, (amplitude, at) in expected.items():
        peaks = [truth.peak(solution[row]) for solution in q]
        assert max(peaks) == pytest.approx(amplitude, abs=5.1e-7)
        assert omega[np.argmax(peaks)] == pytest.approx(at, abs=5.1e-6)


@pytest.mark.parametrize("stiffness, last", [(100.0, 1.1599), (1000.0, 1.1783)])
@pytest.mark.slow
def test_stops_at_the_first_lift_off(tmp_path, stiffness, last):
    """Both on the way to 1.3; the last point before lift-off lies where the authors' program has it. Beyond it Newton's method fails,
    or with other last bits arrives at a frequency far away."""
    omega, q, _, complaint = sweep(cases.dof5(tmp_path, normal_stiffness=stiffness), 0.05)
    away = np.flatnonzero(np.abs(np.diff(omega)) > 0.1)
    assert len(away) > 0 or complaint == "Newton's method did not converge in 50 iterations"
    assert omega[away[0] if len(away) else -1] == pytest.approx(last, abs=5.1e-5)


def test_finds_no_first_point_with_a_stiff_contact_at_a_small_interference(tmp_path):
    omega, _, _, complaint = sweep(cases.dof5(tmp_path, normal_stiffness=1000.0, gap=-0.0035), 0.05)
    assert len(omega) == 0 and complaint


def test_finds_no_first_point_where_a_gap_closes(tmp_path):
    case = cases.dof5(tmp_path, normal_stiffness=100.0, gap=0.2, tangential_stiffness=[50.0, 50.0], friction=[0.3, 0.3])
    case.structure.preload[:] = 0
    omega, _, _, complaint = sweep(cases.full(tmp_path, "no preload", case.structure, {}, **case.settings), 0.05)
    assert len(omega) == 0 and complaint


def test_long_steps_turn_back(tmp_path):
    """With steps 40 times as long it runs backwards without a word; rounding decides whether it stops then."""
    omega, _, _, _ = sweep(cases.dof5(tmp_path), 2.0)
    assert len(omega) >= 5 and np.count_nonzero(np.diff(omega) < 0) >= 3


@pytest.mark.slow
def test_ten_times_the_force_takes_tiny_steps(tmp_path):
    """In the plain norm the large motion rules the arc: after 3182 points the published run had come to 0.949."""
    case = cases.dof5(tmp_path)
    case.structure.force[:] *= 10
    omega, _, _, _ = sweep(cases.full(tmp_path, "ten times the force", case.structure, {}, **case.settings), 0.05, points=3182)
    assert len(omega) == 3182 and omega[-1] == pytest.approx(0.949, abs=5e-4)
