"""Resonances of the structure stuck, slipping and open: against the full model's matrices, and what is warned of."""


import h5py
import numpy as np
import pytest
import scipy.linalg

import cases
import chain
from dovetail import Results, reference
from launch import BINARY, run, words_of

ALL_MODES = {"modes": 12, "harmonics": 1, "samples": 8, "omega": [0.9, 0.9], "fourier": [0, 1]}
STATES = ("stuck", "slipping", "open")


def frequencies(K, M):
    """[rad/s], ascending."""
    return np.sqrt(np.maximum(scipy.linalg.eigvalsh(K, M), 0))


def expected(case):
    """Of the full model, with the springs of the points that bear a force at rest."""
    s, contact = case.structure, case.contact
    closed = case.preload.g[:, 2] > 0
    found = {}
    for state, tangential, normal in (("stuck", 1, 1), ("slipping", 0, 1), ("open", 0, 0)):
        springs = np.zeros(len(s.K))
        springs[s.contact_dofs] = closed[:, None] * np.column_stack([tangential * contact.kt, normal * contact.kn])
        found[state] = frequencies(s.K + np.diag(springs), s.M)
    return found, int(closed.sum())


def kinds(summary):
    return [warning["kind"] for warning in summary["warnings"]]


def warned(text):
    return [line for line in text.splitlines() if line.startswith("warning: ")]


# ---------------------------------------------------------------------------------------------------------- frequencies
@pytest.mark.parametrize("ranks", [None, 2])
def test_frequencies_are_those_of_the_full_model(tmp_path, ranks):
    """All modes kept, and some of the points open at rest."""
    case = cases.several_points(tmp_path, **ALL_MODES, gap=[-0.1, 2.0, -0.2, 0.1])
    wanted, closed = expected(case)
    assert 0 < closed < 4
    done = run(case, ranks=ranks)
    found = done.summary["resonances"]
    assert found["closed_points"] == closed
    assert found["clamping"] == pytest.approx(np.maximum(case.preload.g[:, 2], 0).sum(), rel=1e-7)
    for state in STATES:
        assert len(found[state]) == 10
        np.testing.assert_allclose(found[state], wanted[state][:10], rtol=1e-8)
        (told,) = [line for line in done.out.splitlines() if line.startswith(f"resonances {state} ")]
        assert f"1: {wanted[state][0] / (2 * np.pi):.6g} Hz = {wanted[state][0]:.6g} rad/s" in told


@pytest.mark.parametrize("ranks", [None, pytest.param(2, marks=pytest.mark.slow)])
def test_many_contact_points(tmp_path, ranks):
    """360 contact dofs: found by block Lanczos. Few modes are kept, and the full model's frequencies met to 1e-4."""
    points = 120
    path = chain.write(tmp_path, points, harmonics=1, omega=(0.05, 0.05))
    found = run(cases.Case(path, None, None, {}), ranks=ranks).summary["resonances"]
    with h5py.File(tmp_path / "reduced.h5") as file:
        kaa, mxa, kxx, mxx = file["Kaa"][()], file["Max"][()].T, file["Kxx"][()], file["Mxx"][()]
    n = len(kaa)
    M = np.block([[np.eye(n), mxa.T], [mxa, mxx]])
    model = chain.model(points)
    for state, tangential, normal in (("stuck", 1 / points, 2 / points), ("slipping", 0, 2 / points), ("open", 0, 0)):
        springs = np.tile([tangential, tangential, normal], points)
        reduced = frequencies(scipy.linalg.block_diag(np.diag(kaa), kxx + np.diag(springs)), M)[:10]
        np.testing.assert_allclose(found[state], reduced, rtol=1e-8)
        whole = frequencies(model.K.toarray() + np.diag(np.r_[springs, 0, 0, 0]), model.M.toarray())[:10]
        np.testing.assert_allclose(found[state], whole, rtol=1e-4)


def test_stuck_modes_are_counted_as_ratios_count_them(tmp_path):
    """Beside the first three stuck frequencies, undamped modes ring; a ratio for mode 2 bounds the motion at the second alone."""
    settings = {"stiffness": 0.0, "fourier": [0, 0.01], "ratios": [[2, 0.01]]}
    w = run(cases.always_stuck(tmp_path, omega=[1.0, 1.0], **settings)).summary["resonances"]["stuck"]
    amplitudes = []
    for i in range(3):
        case = cases.always_stuck(tmp_path, omega=2 * [w[i] * (1 + 1e-4)], **settings)
        amplitudes.append(np.abs(run(case, out=f"at{i}").points["coefficients"][0, :, 1:3]).max())
    assert amplitudes[1] < 0.05 * min(amplitudes[0], amplitudes[2])


def test_modes_that_ratios_count_are_told_where_points_are_open(tmp_path):
    """damping.ratios takes all points for closed."""
    case = cases.several_points(tmp_path, **ALL_MODES, gap=[-0.1, 2.0, -0.2, 0.1], ratios=[[1, 0.01]], estimates=False)
    s, contact = case.structure, case.contact
    springs = np.zeros(len(s.K))
    springs[s.contact_dofs] = np.column_stack([contact.kt, contact.kn])
    first = frequencies(s.K + np.diag(springs), s.M)[0]
    (line,) = [line for line in run(case).out.splitlines() if line.startswith("resonances closed ")]
    assert f"1: {first / (2 * np.pi):.6g} Hz = {first:.6g} rad/s" in line and "(1 of 4 are open at rest)" in line
    closed = cases.several_points(tmp_path, **ALL_MODES, gap=-1.0, ratios=[[1, 0.01]], estimates=False)
    assert "resonances closed " not in run(closed).out


def held_by_friction(folder, force, law="coulomb", k=0.0, **settings):
    """One mass of 1 kg, pressed on one contact point with 800 N, with springs k of its own and mu = 0.3."""
    case = cases.single_mass(folder, 1, friction=0.3, law=law, **settings)
    with h5py.File(folder / "reduced.h5", "r+") as file:
        file["Kxx"][()] = k * np.eye(3)
        file["Fx"][()] = force
    return case


def test_rigid_motions_are_zero(tmp_path):
    case = held_by_friction(tmp_path, [100.0, 0, 0], omega=[2, 3])
    found = run(case).summary["resonances"]
    np.testing.assert_allclose(found["stuck"], [1, *np.sqrt([30, 30, 120])], rtol=1e-12)
    assert found["slipping"][:2] == [0, 0] and found["open"][:3] == [0, 0, 0]


# -------------------------------------------------------------------------------------------------------------- command
@pytest.mark.parametrize("ranks", [None, pytest.param(2, marks=pytest.mark.slow)])
def test_modes_prints_a_table_and_spares_what_is_there(tmp_path, ranks):
    case = cases.several_points(tmp_path, **ALL_MODES | {"omega": [0.9, 1.3], "max_points": 2})
    wanted, _ = expected(case)
    done = run(case, out="out")
    before = {path: path.stat().st_mtime_ns for path in done.folder.iterdir()}
    out = run(case, command="modes", out="out", ranks=ranks).out
    assert {path: path.stat().st_mtime_ns for path in done.folder.iterdir()} == before
    assert "still fits the model, reused" in out
    rows = [line.replace("*", " ").split() for line in out.splitlines() if line.split() and line.split()[0].isdigit()]
    table = np.array([[float(word) for word in row] for row in rows])
    assert table.shape == (10, 7)
    np.testing.assert_array_equal(table[:, 0], range(1, 11))
    for i, state in enumerate(STATES):
        np.testing.assert_allclose(table[:, 2 + 2 * i], wanted[state][:10], rtol=1e-5)
        np.testing.assert_allclose(table[:, 1 + 2 * i], wanted[state][:10] / (2 * np.pi), rtol=1e-5)
    inside = sum(((0.9 <= wanted[state][:10]) & (wanted[state][:10] <= 1.3)).sum() for state in STATES)
    assert inside > 0 and sum(line.count("*") for line in out.splitlines() if line.split() and line.split()[0].isdigit()) == inside


def test_modes_reduces_where_nobody_has(tmp_path):
    case = cases.several_points(tmp_path, **ALL_MODES)
    run(case, command="modes", out="out")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["reduced.h5"]


def test_modes_of_a_given_reduced_file_writes_nothing(tmp_path):
    case = held_by_friction(tmp_path, [100.0, 0, 0])
    before = sorted(tmp_path.rglob("*"))
    run(case, command="modes", out="out")
    assert sorted(tmp_path.rglob("*")) == before


def test_modes_refuses_wrong_input(tmp_path):
    case = cases.several_points(tmp_path, **ALL_MODES)
    case.edit("friction", "fricton")
    assert "fricton" in run(case, command="modes", status=2).err
    for option in ("--dry-run", "--restart"):
        assert option in words_of([BINARY, "modes", str(case.path), option], 2)[1]
    negative = held_by_friction(tmp_path, [100.0, 0, 0])
    with h5py.File(tmp_path / "reduced.h5", "r+") as file:
        file["Mxx"][()] = np.diag([1.0, -1, 1])
    assert "the reduced mass matrix" in run(negative, command="modes", status=2).err


def test_dry_run_shows_them_where_there_is_a_reduced_file(tmp_path):
    case = cases.several_points(tmp_path, **ALL_MODES)
    assert "resonances come with the reduction" in run(case, "--dry-run").out
    run(case, command="reduce")
    lines = [line for line in run(case, "--dry-run").out.splitlines() if line.startswith("resonances ")]
    assert [line.split()[1] for line in lines] == list(STATES)
    assert lines == [line for line in run(case).out.splitlines() if line.startswith("resonances ")]


# ------------------------------------------------------------------------------------------------------------- warnings
def test_no_resonance_in_the_sweep(tmp_path):
    case = cases.several_points(tmp_path, **ALL_MODES)
    found = run(case).summary["resonances"]
    slipping, stuck = found["slipping"][0], found["stuck"][0]
    assert slipping < stuck

    def said(low, high, **changes):
        other = cases.several_points(tmp_path, **ALL_MODES | {"omega": [low, high]} | changes)
        return [line for line in warned(run(other, command="modes").out) if "no resonance" in line]

    (line,) = said(0.1 * slipping, 0.2 * slipping)
    assert f"{slipping:.6g} rad/s" in line
    assert said(slipping + 0.3 * (stuck - slipping), slipping + 0.7 * (stuck - slipping)) == []  # where it is while some points slip
    assert said(0.9 * stuck, 1.1 * stuck) == []
    assert said(0.1, 0.1) == []  # one point is no sweep
    assert said(0.45 * stuck, 0.55 * stuck, harmonics=2, fourier=[0, 1, 0, 0, 0.1]) == []  # met by harmonic 2
    assert len(said(0.45 * stuck, 0.55 * stuck)) == 1


def test_harmonics_of_the_load_meet_resonances(tmp_path):
    case = cases.several_points(tmp_path, **ALL_MODES | {"harmonics": 2, "fourier": [0, 0, 0, 1, 0], "max_points": 1})
    w = run(case).summary["resonances"]["stuck"][0]
    case = cases.several_points(tmp_path, **ALL_MODES | {"harmonics": 2, "fourier": [0, 0, 0, 1, 0], "omega": [0.45 * w, 0.55 * w],
                                                     "max_points": 2})
    done = run(case)
    assert done.summary["resonances"]["in_sweep"]["stuck"][0] == 1
    assert "rad/s in the sweep by harmonic 2" in done.out


def test_no_point_slips(tmp_path):
    for folder in ("stuck", "slips", "smooth"):
        (tmp_path / folder).mkdir()
    stuck = run(cases.always_stuck(tmp_path / "stuck"))
    assert kinds(stuck.summary) == ["no_slip"] and len([line for line in warned(stuck.out) if "slips" in line]) == 1
    slips = run(cases.several_points(tmp_path / "slips"))
    assert slips.points["slip"].max() > 0 and kinds(slips.summary) == [] and warned(slips.out) == []
    smooth = cases.always_stuck(tmp_path / "smooth", law="bilateral", friction=None, tangential_stiffness=None)
    assert kinds(run(smooth).summary) == []


def test_no_peak_between_slipping_and_stuck(tmp_path):
    """Where a resonance may lie while some points slip, but none does: told by the table, and once the curve is there."""
    for omega, listed, said in (([2, 3], False, ["no_slip", "no_resonance"]), ([5, 6], True, []), ([2, 2], False, ["no_slip"])):
        case = held_by_friction(tmp_path, [100.0, 0, 0], omega=omega)
        table = run(case, command="modes").out
        assert ("; * lies in it" in table) == listed and warned(table) == []
        assert ("none of these lies in it, the nearest is at 0.159155 Hz = 1 rad/s" in table) == ("no_resonance" in said)
        done = run(case)
        assert kinds(done.summary) == said and done.summary["peaks"] == 0
        assert ("warning: the curve has no peak, and no resonance" in done.out) == ("no_resonance" in said)


def test_no_slip_counts_all_parts_of_a_run(tmp_path):
    """The points that slip are of the part before the restart."""
    settings = {"fourier": [0, 0.5], "omega": [1.0, 2.6], "estimates": False}
    case = cases.several_points(tmp_path, **settings)
    points = run(case, out="whole").points
    slipping = np.flatnonzero(points["contact/slip"].max(axis=1) > 0)
    assert slipping[-1] + 2 < len(points["omega"])
    cut = cases.several_points(tmp_path, **settings, max_points=int(slipping[-1]) + 2)
    run(cut, out="parts")
    rest = run(cases.several_points(tmp_path, **settings), "--restart", out="parts")
    assert rest.summary["parts"] == 2 and kinds(rest.summary) == []


def test_nothing_presses_the_joint(tmp_path):
    for folder in ("open", "pressed"):
        (tmp_path / folder).mkdir()
    done = run(cases.always_open(tmp_path / "open"))
    assert "not_pressed" in kinds(done.summary) and any("nothing presses the joint" in line for line in warned(done.out))
    found = done.summary["resonances"]
    assert found["closed_points"] == 0 and found["stuck"] == found["open"]
    assert "not_pressed" not in kinds(run(cases.always_stuck(tmp_path / "pressed")).summary)


@pytest.mark.parametrize("law, force, slides", [
    ("coulomb", [239.0, 0, 0], False), ("coulomb", [241.0, 0, 0], True), ("coulomb", [239.0, 239, 0], False),
    ("cone", [239.0, 0, 0], False), ("cone", [180.0, 180, 0], True), ("coulomb", [0.0, 0, 900], False)])
def test_force_beyond_the_clamping_of_a_body_held_by_its_joint(tmp_path, law, force, slides):
    """mu N = 240 N. A force along the normal makes it lift off, which friction does not hold."""
    case = held_by_friction(tmp_path, force, law)
    told = [line for line in warned(run(case, "--dry-run").out) if "slides as a whole" in line]
    assert len(told) == slides
    if slides:
        assert "holds 240 N" in told[0] or law == "cone"
    held = held_by_friction(tmp_path, force, law, k=1.0)  # by springs besides
    assert not any("slides" in line for line in warned(run(held, "--dry-run").out))


def test_force_and_preload_along_the_joint_add_up(tmp_path):
    case = held_by_friction(tmp_path, [200.0, 0, 0])
    with h5py.File(tmp_path / "reduced.h5", "r+") as file:
        file["R"][()] = [-60.0, 0, -800]
    (told,) = [line for line in warned(run(case, "--dry-run").out) if "slides as a whole" in line]
    assert "pushed with 260 N" in told and "holds 240 N" in told


def undamped(folder, force, omega, **settings):
    """Five masses of 1 kg with resonances of their own, the last three in contact, pressed on and stuck."""
    structure = cases.Structure(K=np.diag([1.0, 4, 9, 16, 25]), M=np.eye(5), contact_dofs=np.array([[2, 3, 4]]),
                                force=np.array(force), preload=np.array([0, 0, 0, 0, 1e6]))
    return cases.full(folder, "without damping", structure, settings, modes=2, stiffness=0.0, fourier=[0, 1], normal_stiffness=1.0,
                      tangential_stiffness=1.0, friction=0.3, gap=0.0, initial=0.0, harmonics=1, omega=omega)


@pytest.mark.parametrize("force, omega, settings, told", [
    ([1.0, 0, 0, 0, 0], [0.53, 1.47], {}, [1.0]),
    ([1.0, 1, 0, 0, 0], [0.53, 2.61], {}, [1.0, 2.0]),
    ([1.0, 1, 0, 0, 0], [2.61, 0.53], {}, [1.0, 2.0]),
    ([1.0, 0, 0, 0, 0], [1.53, 2.61], {}, []),  # no work on the mode there
    ([1.0, 0, 0, 0, 0], [0.53, 0.97], {}, []),
    ([1.0, 0, 0, 0, 0], [0.53, 1.47], {"stiffness": 1e-3}, []),
    ([1.0, 0, 0, 0, 0], [0.53, 1.47], {"ratios": [[1, 1e-3]]}, [])])
def test_resonances_without_damping_are_not_stepped_over_in_silence(tmp_path, force, omega, settings, told):
    done = run(undamped(tmp_path, force, omega, **settings))
    lines = [warning["text"] for warning in done.summary["warnings"] if warning["kind"] == "undamped_resonance"]
    assert [float(line.split(", at ")[1].split()[0]) for line in lines] == pytest.approx(told, rel=1e-8)
    assert [line for line in warned(done.out) if "without damping" in line] == ["warning: " + line for line in lines]


@pytest.mark.parametrize("ranks", [None, pytest.param(2, marks=pytest.mark.slow)])
def test_without_contact_points(tmp_path, ranks):
    """Four modes by themselves, of which the load drives two."""
    none = np.zeros((0, 0))
    cases.write_reduced(tmp_path, reference.Reduced(kaa=[1.0, 4, 9, 16], max=np.zeros((4, 0)), mxx=none, kxx=none,
                                                    fa=[1.0, 0, 1, 0], fx=np.zeros(0), r=np.zeros(0)))
    case = cases.write(tmp_path, "modes alone", "reduced.h5", None, None, {}, fourier=[0, 1], normal_stiffness=1.0,
                       tangential_stiffness=1.0, friction=0.3, harmonics=1, omega=[1.53, 3.57], stiffness=0.0)
    done = run(case, ranks=ranks)
    assert kinds(done.summary) == ["undamped_resonance"] and ", at 3 rad/s" in done.summary["warnings"][0]["text"]
    for state in STATES:
        np.testing.assert_allclose(done.summary["resonances"][state], [1, 2, 3, 4], rtol=1e-12)
        assert done.summary["resonances"]["in_sweep"][state] == [2, 3]
    case.edit("stiffness = 0.0", "stiffness = 0.01")
    assert kinds(run(case, ranks=ranks).summary) == []


def test_friction_that_bounds_a_resonance_is_no_missing_damping(tmp_path):
    """The points beside the resonance slip."""
    case = cases.single_mass(tmp_path, 2, stiffness=0.0, friction=0.3, omega=[5, 12])
    done = run(case)
    w = done.summary["resonances"]["stuck"]
    assert any(5 < value < 12 for value in w) and done.points["slip"].max() > 0
    assert "undamped_resonance" not in kinds(done.summary)


# ------------------------------------------------------------------------------------------------------------------- Hz
@pytest.mark.slow
def test_hertz_gives_the_same_bits(tmp_path):
    hertz, at = [0.13, 0.22], [0.15, 0.2]
    in_hertz = cases.several_points(tmp_path, unit="Hz", omega=hertz, at=at)
    one = run(in_hertz, out="hertz")
    turn = 2 * np.pi
    other = run(cases.several_points(tmp_path, unit="rad/s", omega=[turn * f for f in hertz], at=[turn * f for f in at]), out="radians")
    assert set(one.points["omega"]) >= {turn * f for f in hertz + at}
    for name in one.points.keys() - {"seconds"}:
        np.testing.assert_array_equal(one.points[name], other.points[name], err_msg=name)
    assert one.summary["resonances"] == other.summary["resonances"] and one.summary["located"] == other.summary["located"]
    assert "frequency [Hz]" in one.out and "Omega [rad/s]" in other.out
    peaks = [line for line in one.out.splitlines() if line.startswith("  peak ")]
    assert peaks and all(" Hz = " in line for line in peaks)


def test_hertz_is_told_as_it_was_written(tmp_path):
    case = cases.several_points(tmp_path, unit="Hz", omega=[0.13, 0.22], at=[0.15, 0.2])
    rows = {line.split("  ")[0]: line for line in run(case, "--dry-run").out.splitlines()}
    assert "[0.13, 0.22]" in rows["continuation.omega"] and "[Hz]" in rows["continuation.omega"]
    assert "[0.15, 0.2]" in rows["continuation.at"] and "[Hz]" in rows["continuation.at"]
    case = cases.several_points(tmp_path, unit="Hz", omega=[0.13, 0.22], at=[0.15, 0.3])
    assert "outside continuation.omega = [0.13, 0.22] Hz" in run(case, status=2).err
    case = cases.several_points(tmp_path, unit="hz")
    assert 'must be "rad/s" or "Hz"' in run(case, status=2).err


def test_a_run_goes_on_in_the_other_unit(tmp_path):
    run(cases.several_points(tmp_path, unit="Hz", omega=[0.13, 0.15], max_points=3), out="out")
    turn = 2 * np.pi
    done = run(cases.several_points(tmp_path, omega=[turn * 0.13, turn * 0.15]), "--restart", out="out")
    assert done.summary["parts"] == 2 and Results(tmp_path / "out/results.h5").omega[-1] == turn * 0.15
