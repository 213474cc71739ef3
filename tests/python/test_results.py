"""Reading results: amplitudes, peaks, loops, recovery of the full model, files still being written."""

import subprocess
import sys

import h5py
import numpy as np
import pytest
import scipy.linalg
import synthetic_results

from dovetail import Results, hdf5_read, plot
from dovetail.info import describe

CONTACT = {"normal_stiffness": np.array([2.0]), "tangential_stiffness": np.array([[3.0, 4.0]]), "friction": np.array([[0.5, 0.25]]),
           "gap": np.array([0.0])}
TWO = {name: np.repeat(values, 2, axis=0) for name, values in CONTACT.items()}  # contact points


def one_point(path, coefficients, modes=1, omega=(1.0,), **more):
    return Results(synthetic_results.write(path, omega, coefficients, modes, CONTACT, **more))


def brute_force(coefficients, n):
    theta = 2 * np.pi * np.arange(n) / n
    value = np.zeros((len(coefficients), n))
    for k in range(1, (coefficients.shape[1] - 1) // 2 + 1):
        value += coefficients[:, [2 * k - 1]] * np.cos(k * theta) + coefficients[:, [2 * k]] * np.sin(k * theta)
    return np.ptp(value, axis=1) / 2


@pytest.mark.parametrize("harmonics", [0, 1, 3, 10])
@pytest.mark.parametrize("mean", [0.0, 1.0, 1e4])
def test_amplitude_is_half_the_peak_to_peak_whatever_the_mean(tmp_path, harmonics, mean):
    coefficients = np.random.default_rng(harmonics).standard_normal((40, 4, 2 * harmonics + 1))
    coefficients[:, :, 0] *= mean
    results = one_point(tmp_path / "r.h5", coefficients, omega=np.arange(1, 41.0))
    n = 1 << 16
    sampled = brute_force(coefficients[:, 0], n)
    missed = (np.pi / n) ** 2 / 2 * np.abs(coefficients[:, 0, 1:]).sum(axis=1) * harmonics**2  # sampling error at most
    found = results.amplitude("a1")
    assert np.all(found >= sampled * (1 - 1e-14)) and np.all(found <= sampled + missed + 1e-12 * sampled)


def test_amplitude_closed_forms(tmp_path):
    # cos - cos(3 .)/9 is flat-topped; sin + 0.3 sin(2 .) has its extreme where cos th = (-1 + sqrt(1 + 8 0.6^2)) / (4 0.6);
    # cos + cos(2 .) goes from -9/8 to 2: half of it is 25/16, not 2
    rows = np.zeros((3, 4, 7))
    rows[0, 0, [1, 5]] = 1, -1 / 9
    rows[1, 0, [2, 4]] = 1, 0.3
    rows[2, 0, [0, 1, 3]] = 7, 1, 1
    c = (-1 + np.sqrt(1 + 8 * 0.6**2)) / (4 * 0.6)
    exact = np.sqrt(1 - c**2) * (1 + 0.6 * c)
    results = one_point(tmp_path / "r.h5", rows, omega=[1.0, 2.0, 3.0])
    np.testing.assert_allclose(results.amplitude("a1"), [8 / 9, exact, 25 / 16], rtol=2e-15)


@pytest.mark.slow
def test_amplitude_with_two_nearly_equal_extremes(tmp_path):
    """The larger one may lie between the points of the search grid while the smaller one is met exactly."""
    coefficients = np.random.default_rng(0).standard_normal((4000, 4, 7))
    results = one_point(tmp_path / "r.h5", coefficients, omega=np.arange(1, 4001.0))
    found, sampled = results.amplitude("a1"), brute_force(coefficients[:, 0], 4096)
    assert np.all(found >= sampled * (1 - 1e-14)) and np.all(found <= sampled * (1 + 1e-5))


def test_harmonics_and_time_history_follow_the_convention(tmp_path):
    coefficients = np.zeros((1, 4, 5))
    coefficients[0, 3] = [2.0, 3.0, 4.0, 0.0, -1.0]
    results = one_point(tmp_path / "r.h5", coefficients, omega=[2.0])
    assert results.harmonic("x1.n", 0) == 1.0 and results.harmonic("x1.n", 1) == 5.0 and results.harmonic(3, 2) == 1.0
    t, q = results.time_history(0, "x1.n", 10)
    np.testing.assert_allclose(t, np.pi * np.arange(10) / 10)
    np.testing.assert_allclose(q, 1 + 3 * np.cos(2 * t) + 4 * np.sin(2 * t) - np.sin(4 * t), atol=1e-14)
    with pytest.raises(ValueError, match="harmonic must be a whole number from 0 to 2, found 3"):
        results.harmonic("x1.n", 3)


def test_peak_of_a_curve_that_leans_over(tmp_path):
    s = np.linspace(-1.1, 1.0, 8)
    coefficients = np.zeros((8, 4, 3))
    coefficients[:, 1, 1] = 5 - (s - 0.2) ** 2
    omega = 3 - (s - 0.3) ** 2  # folds just beyond the peak
    results = one_point(tmp_path / "r.h5", coefficients, omega=omega, arclength=s)
    np.testing.assert_allclose(results.peak("x1.t1"), [3 - 0.01, 5], rtol=1e-12)
    assert results.peak_point("x1.t1") == np.argmin(np.abs(s - 0.2))


def test_an_end_of_the_sweep_is_no_peak(tmp_path):
    omega, coefficients = np.linspace(1, 2, 11), np.zeros((11, 4, 3))
    coefficients[:, 1, 1] = omega
    coefficients[:, 2, 1] = 3 - omega
    coefficients[:, 3, 1] = (omega - 1.3) ** 2 * (2.5 - omega) + 1  # falls, rises, and rises most at the end
    coefficients[:, 0, 1] = np.minimum(omega - 1, 1.61 - omega) + 10 * np.maximum(omega - 1.75, 0)  # a peak, and higher beyond it
    results = one_point(tmp_path / "r.h5", coefficients, omega=omega, units="t, mm, s, N")
    assert results.peaks("x1.t1") == results.peaks("x1.t2") == results.peaks("x1.n") == []
    with pytest.raises(ValueError, match="x1.t1 has no peak .* still rising at the end of the curve, 2 mm at 2 rad/s"):
        results.peak("x1.t1")
    with pytest.raises(ValueError, match="x1.t2 has no peak .* falling from the beginning of the curve, 2 mm at 1 rad/s"):
        results.peak_point("x1.t2")
    assert results.largest_point("x1.t1") == 10 and results.largest_point("x1.t2") == 0
    assert [words.split()[0] for *_, words in results.ends("x1.n")] == ["falling", "still"]
    assert results.peak("a1")[0] == pytest.approx(1.3, abs=0.05) and results.peak_point("a1") == 3 != results.largest_point("a1")
    said = describe(results.path)
    assert "no peak: x1.t1" in said and "still rising at the end of the curve, 2 mm at 2 rad/s (0.3183099 Hz)" in said
    assert "peak of x1.t1" not in said
    rising_again = coefficients[:, 0, 1].copy()
    for tail, told in ((0.3, True), (0.05, False)):  # an end above the peak, and one below it
        coefficients[:, 1, 1] = rising_again * np.where(omega < 1.75, 1, tail)
        said = describe(one_point(tmp_path / f"{tail}.h5", coefficients, omega=omega).path)
        assert "peak of x1.t1" in said and ("no peak: x1.t1" in said) == told, said
    figure = plot.response(results, ["x1.t1"])
    assert "still rising at the end" in figure.axes[0].get_legend().get_texts()[0].get_text()


def test_a_peak_does_not_lie_across_a_jump(tmp_path):
    coefficients = np.zeros((6, 4, 3))
    coefficients[:, 1, 1] = [1, 2, 3, 1, 1.5, 1.2]
    events = [("leap", 2, 3.0, 0.0, -1)]
    results = one_point(tmp_path / "r.h5", coefficients, omega=np.arange(1, 7.0), events=events)
    assert [round(omega) for omega, _ in results.peaks("x1.t1")] == [5] and list(results.jumps) == [2]


def test_pictures_have_gaps_where_the_branch_jumped(tmp_path):
    coefficients = np.zeros((8, 4, 3))
    coefficients[:, 1, 1] = [1, 2, 3, 1, 1.5, 1.2, 1.0, 0.5]
    events = [("leap", 2, 3.0, 0.0, -1), ("integration", 5, 6.0, 0.0, -1), ("leap", 7, 8.0, 0.0, -1)]
    results = one_point(tmp_path / "r.h5", coefficients, omega=np.arange(1, 9.0), events=events)

    def pieces(axis, label):
        line = next(line for line in axis.lines if line.get_label().startswith(label))
        breaks = np.flatnonzero(np.isnan(line.get_ydata(orig=False)))
        return [len(piece) for piece in np.split(line.get_ydata(orig=False), breaks)]

    axes = plot.response(results, ["x1.t1"]).axes
    assert pieces(axes[0], "x1.t1") == pieces(axes[-1], "slip") == [3, 4, 3]  # the NaN counts with the piece behind it
    results.stable = np.array([1, 1, 1, 0, 0, 0, 0, 0])
    drawn = [line for line in plot.response(results, ["x1.t1"]).axes[0].lines if len(line.get_xdata()) > 8]
    for line in drawn:  # nobody draws from point 2 to 3, or from 5 to 6
        x = line.get_xdata(orig=False)
        for before in (3.0, 6.0):
            assert not any(a == before and b == before + 1 for a, b in zip(x, x[1:]))


def test_labels_of_folds_do_not_pile_up(tmp_path):
    s = np.linspace(0, 1, 400)
    coefficients = np.zeros((400, 4, 3))
    coefficients[:, 1, 1] = 1 + 0.001 * s
    omega = 5 + 3 * s + 0.04 * np.sin(120 * s)  # many folds close together
    folds = 1 + np.flatnonzero(np.diff(omega)[1:] * np.diff(omega)[:-1] < 0)
    assert len(folds) > 5
    events = [("fold", int(i), omega[i], 1 + s[i], -1) for i in folds]
    results = one_point(tmp_path / "r.h5", coefficients, omega=omega, events=events)
    figure = plot.response(results, ["x1.t1"])
    figure.canvas.draw()
    axis, renderer = figure.axes[0], figure.canvas.get_renderer()
    boxes = [text.get_window_extent(renderer) for text in axis.texts]
    assert boxes and not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    assert not any(box.overlaps(axis.get_legend().get_window_extent(renderer)) for box in boxes)


def bent_curve(tmp_path, title="synthetic"):
    """A curve that bends back: a peak and two turning points close to each other, as of a joint that opens."""
    s = np.linspace(0, 1, 200)
    coefficients = np.zeros((200, 4, 3))
    coefficients[:, 1, 1] = np.exp(-80 * (s - 0.5) ** 2)
    coefficients[:, 2, 1] = 0.6 * coefficients[:, 1, 1]
    omega = 5 + 2 * (s - 0.5) - 0.5 * coefficients[:, 1, 1]
    folds = 1 + np.flatnonzero(np.diff(omega)[1:] * np.diff(omega)[:-1] < 0)
    events = [("fold", int(i), omega[i], coefficients[i, 1, 1], -1) for i in folds] + [("peak", 100, omega[100], 1.0, 1)]
    return one_point(tmp_path / "r.h5", coefficients, omega=omega, events=events, watch="x1.t1", title=title)


def test_labels_and_legends_cover_no_curve_and_no_marker(tmp_path):
    figure = plot.response(bent_curve(tmp_path), ["x1.t1", "x1.t2"])
    figure.canvas.draw()
    axis, renderer = figure.axes[0], figure.canvas.get_renderer()
    assert len(axis.texts) == 3
    boxes = [*(text.get_window_extent(renderer) for text in axis.texts), axis.get_legend().get_window_extent(renderer)]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    for line in axis.lines:
        path = line.get_transform().transform_path(line.get_path())
        drawn = line.get_linestyle() != "None"
        for box in boxes:
            assert not (drawn and path.intersects_bbox(box, filled=False)) and not any(box.contains(*xy) for xy in path.vertices)
    title = figure._suptitle.get_window_extent(renderer)
    assert not title.overlaps(boxes[-1]) and boxes[-1].x1 <= figure.bbox.x1


@pytest.mark.parametrize("title", ["costs 5 $ and 6 $", r"$\frac$", "$x_1$"])
def test_titles_are_no_formulas(tmp_path, title):
    figure = plot.response(bent_curve(tmp_path, title), ["x1.t1"])
    figure.canvas.draw()
    assert figure._suptitle._preprocess_math(figure._suptitle.get_text()) == (title, False)


def test_the_loop_that_is_drawn_is_that_of_the_point_that_rubs(tmp_path):
    coefficients = np.zeros((1, 7, 3))
    coefficients[0, 1, 1] = 1.0  # the first slips, pressed in by 0.5
    coefficients[0, 4, 1] = 9.0  # the second moves most, and is open
    xp = np.array([0, 0, 0.5, 0, 0, -1.0])
    path = synthetic_results.write(tmp_path / "r.h5", [1.0], coefficients, 1, TWO, xp=xp)
    assert [axis.get_title().split(":")[0] for axis in plot.hysteresis(Results(path), 0).axes] == ["x1.t1"]
    with h5py.File(path, "a") as file:
        file.attrs["watch"] = "x2.t1"
    assert [axis.get_title().split(":")[0] for axis in plot.hysteresis(Results(path), 0).axes] == ["x2.t1"]


def test_peaks_name_their_unknown(tmp_path):
    omega, coefficients = np.linspace(1, 3, 21), np.zeros((21, 7, 3))
    coefficients[:, 2, 1] = 1 / (1 + 50 * (omega - 1.5) ** 2)
    coefficients[:, 4, 1] = 3 / (1 + 50 * (omega - 2.5) ** 2)
    events = [("peak", 5, omega[5], 1.0, 2), ("fold", 9, omega[9], 0.1, -1), ("peak", 15, omega[15], 3.0, 4)]
    results = Results(synthetic_results.write(tmp_path / "r.h5", omega, coefficients, 1, TWO, events=events, units="t, mm, s, N"))
    assert list(results.located_peaks("x1.t2")) == [5] and list(results.located_peaks("x2.t1")) == [15]
    assert results.watched == "x2.t1" == plot.default_dofs(results)[0]
    said = describe(results.path)
    assert "located peak of x1.t2" in said and "1 mm at 1.5 rad/s (0.238732415 Hz)" in said
    assert "located peak of x2.t1" in said and "peak of x2.t1 " in said
    label = plot.response(results).axes[0].get_legend().get_texts()[0].get_text()
    assert label.startswith("x2.t1   peak 3 mm at 2.5 rad/s")


def test_names_and_their_errors(tmp_path):
    results = Results(synthetic_results.write(tmp_path / "r.h5", [1.0, 2.0], np.zeros((2, 8, 3)), 2, TWO))
    assert results.dof_names() == ["a1", "a2", "x1.t1", "x1.t2", "x1.n", "x2.t1", "x2.t2", "x2.n"]
    assert [results.dof_index(name) for name in results.dof_names()] == list(range(8))
    assert [results.dof_index(number) for number in range(8)] == list(range(8))
    for name in ("a3", "a0", "x3.t1", "x0.n", "x1.t3", "x1", "b1", 8, -1):
        with pytest.raises(KeyError, match="there are a1 to a2, and x1 to x2"):
            results.dof_index(name)
    without_modes = one_point(tmp_path / "no_modes.h5", np.zeros((1, 3, 3)), modes=0)
    with pytest.raises(KeyError, match="'a1'; there are x1 to x1 each"):
        without_modes.dof_index("a1")
    assert results.at(1.6) == 1
    with pytest.raises(KeyError, match="arclength, linear_iterations"):
        results.points("speed")
    with pytest.raises(ValueError, match="point must be a whole number from -2 to 1, found 2"):
        results.time_history(2, "a1")
    with pytest.raises(ValueError, match="contact point must be a whole number from 1 to 2, found 0"):
        results.dissipated(0, 0)
    with pytest.raises(ValueError, match="reduced file it was computed from is not there"):
        results.elastic(0)


@pytest.mark.parametrize("amplitude, direction", [(3.0, 0), (3.0, 1), (0.05, 0)])
def test_friction_loop_has_the_area_of_the_closed_form(tmp_path, amplitude, direction):
    coefficients = np.zeros((1, 4, 3))
    coefficients[0, 1 + direction, 2] = amplitude
    xp = np.array([0.1, 0.2, 1.5])  # normal force 3
    results = one_point(tmp_path / "r.h5", coefficients, xp=xp, w=xp[None, :2])
    stiffness, limit = CONTACT["tangential_stiffness"][0, direction], CONTACT["friction"][0, direction] * 3.0
    exact = 4 * limit * max(0.0, amplitude - limit / stiffness)
    x, T = results.hysteresis(0, 1, direction, n=4096)
    assert np.sum((T + np.roll(T, -1)) / 2 * (np.roll(x, -1) - x)) == pytest.approx(exact, rel=1e-5, abs=1e-12)
    x, T = results.hysteresis(0, 1, direction)
    assert x.size == 256 and np.abs(T).max() == pytest.approx(min(limit, stiffness * amplitude), rel=1e-12)
    assert x.mean() == pytest.approx(xp[direction])
    force, state = results.contact_force(0, 1, 64)
    np.testing.assert_allclose(force[:, 2], 3.0)
    assert force.shape == (64, 3) and set(np.unique(state[:, direction])) == ({-1, 0, 1} if exact else {0})


def test_sectors_of_what_is_none_are_refused(tmp_path):
    results = one_point(tmp_path / "r.h5", np.ones((1, 4, 3)))
    assert results.wave is None
    for asked in (results.coefficients_at, results.motion, lambda point, sector: results.hysteresis(point, 1, sector=sector),
                  lambda point, sector: results.time_history(point, "x1.t1", sector=sector)):
        with pytest.raises(ValueError, match="is not of a sector of a cyclic structure, so there is no sector 0"):
            asked(0, sector=0)


@pytest.mark.parametrize("sectors, order, words", [(1, 1, "sectors must be a whole number from 2 on, found 1"),
                                                   (6, 1.5, "engine_order must be one whole number, found 1.5")])
def test_waves_that_are_none_are_refused(tmp_path, sectors, order, words):
    path = synthetic_results.write(tmp_path / "r.h5", (1.0,), np.ones((1, 4, 3)), 1, CONTACT)
    with h5py.File(path, "r+") as file:
        file.attrs["sectors"], file.attrs["engine_order"] = sectors, order
    with pytest.raises(ValueError, match=words):
        Results(path)


def test_activity_is_what_the_run_stored(tmp_path):
    """Not what marching would give: numbers that no motion could have."""
    path = synthetic_results.write(tmp_path / "r.h5", [1.0, 2.0], np.ones((2, 7, 3)), 1, TWO)
    wanted = {"stick": [[0.5, 0.25], [1, 0]], "slip": [[0.5, 0.25], [0, 0]], "open": [[0, 0.5], [0, 1]], "events": [[4, 6], [0, 0]],
              "dissipation": [[7.5, 0.125], [0, 0]]}
    with h5py.File(path, "r+") as file:
        for name, values in wanted.items():
            file["points/contact"][name][()] = values
    results = Results(path)
    for point in (0, 1, -1):
        activity = results.contact_activity(point)
        for name, values in wanted.items():
            np.testing.assert_array_equal(getattr(activity, name), values[point])
    assert results.dissipated(0, 2) == 0.125 and activity.events.dtype.kind == "i"
    with pytest.raises(ValueError, match="point must be a whole number from -2 to 1, found 2"):
        results.contact_activity(2)


def test_files_of_older_versions(tmp_path):
    """They have no activity and no law: all but the activity is there, with the law that was the only one."""
    path = synthetic_results.write(tmp_path / "r.h5", [1.0], np.ones((1, 4, 3)), 1, CONTACT)
    with h5py.File(path, "r+") as file:
        del file["points/contact"], file["contact/law"]
    results = Results(path)
    assert results.contact["law"].tolist() == [0] and results.contact_force(0, 1)[0].shape == (256, 3)
    with pytest.raises(ValueError, match="has no /points/contact: .* older version; run the case again"):
        results.contact_activity(0)
    with pytest.raises(ValueError, match="has no /points/contact"):
        results.dissipated(0, 1)


@pytest.mark.parametrize("harmonics, instants", [(1, 256), (6, 256), (7, 512), (25, 1024), (26, 2048)])
def test_exact_runs_are_drawn_with_enough_instants(tmp_path, harmonics, instants):
    coefficients = np.zeros((1, 4, 2 * harmonics + 1))
    exact = one_point(tmp_path / "exact.h5", coefficients, samples=0)
    assert exact.samples == 0 and exact.drawing_samples == instants
    assert exact.hysteresis(0, 1)[0].size == exact.contact_force(0, 1)[0].shape[0] == instants
    assert "exact" in describe(exact.path)
    sampled = one_point(tmp_path / "sampled.h5", coefficients, samples=77)
    assert sampled.hysteresis(0, 1)[0].size == 77 and "77 samples" in describe(sampled.path)


def test_the_law_of_each_point_is_kept(tmp_path):
    """Four points with the same motion, which opens the unilateral ones for a time and pulls at the bilateral one."""
    coefficients = np.zeros((1, 12, 3))
    coefficients[0, ::3, 1] = coefficients[0, 1::3, 2] = 3.0  # circles in the plane
    coefficients[0, 2::3, 2] = 2.0
    xp = np.tile([0.0, 0.0, 1.0], 4)
    contact = {"law": np.arange(4), "normal_stiffness": np.full(4, 2.0), "tangential_stiffness": np.full((4, 2), 3.0),
               "friction": np.full((4, 2), 0.5), "gap": np.zeros(4)}
    results = Results(synthetic_results.write(tmp_path / "r.h5", [1.0], coefficients, 0, contact, xp=xp, samples=0))
    forces, states = zip(*(results.contact_force(0, contact + 1) for contact in range(4)))
    for force in forces[:3]:
        assert force[:, 2].min() == 0 and force[:, 2].max() == pytest.approx(6.0)
    assert forces[3][:, 2].min() == pytest.approx(-2.0) and not np.any(forces[2][:, :2]) and not np.any(forces[3][:, :2])
    length = [np.hypot(*force[:, :2].T) - 0.5 * force[:, 2] for force in forces[:2]]
    assert length[0].max() > 0.1 and length[1].max() < 1e-12  # two bounds, one bound
    assert 2 in states[2] and set(np.unique(states[2])) == {0, 2} and not states[3].any()
    assert "coulomb (1), cone (1), unilateral (1), bilateral (1)" in describe(results.path)
    with pytest.raises(ValueError, match="contact point 3 has no friction loop: its law is unilateral"):
        plot.hysteresis(results, 0, ["x3.t1"])
    plot.plt.close("all")


def test_recovery_gives_the_motion_of_the_full_model(tmp_path):
    """Linear structure, no contact force, all modes kept: the reduction is exact, so the full solution must come back."""
    rng = np.random.default_rng(5)
    n, xi, omega = 10, 0.02, 1.7
    K, M = (A @ A.T + n * np.eye(n) for A in rng.standard_normal((2, n, n)))
    F, P = rng.standard_normal((2, n))
    c, modes = np.array([[7, 2, 4]]), 7
    e = np.setdiff1d(np.arange(n), c)
    ee, ec, cc = np.ix_(e, e), np.ix_(e, c[0]), np.ix_(c[0], c[0])
    squares, Phi = scipy.linalg.eigh(K[ee], M[ee])
    Psi = -np.linalg.solve(K[ee], K[ec])
    xe0 = np.linalg.solve(K[ee], P[e])
    xp = np.linalg.solve(K[cc] + K[ec].T @ Psi, P[c[0]] - K[ec].T @ xe0)
    V = np.zeros((n, modes + 3))  # u = V [a; x_c]
    V[np.ix_(e, np.arange(modes))], V[np.ix_(e, modes + np.arange(3))] = Phi, Psi
    V[np.ix_(c[0], modes + np.arange(3))] = np.eye(3)
    q = np.linalg.solve(V.T @ (K * (1 + 1j * omega * xi) - omega**2 * M) @ V, V.T @ F)
    with h5py.File(tmp_path / "reduced.h5", "w") as file:
        for name, values in {"elastic_dofs": e, "contact_dofs": c, "xe0": xe0, "Phi": Phi, "Psi": Psi}.items():
            file[f"recovery/{name}"] = values
    coefficients = np.stack([np.zeros(modes + 3), q.real, -q.imag], axis=1)[None]
    results = one_point(tmp_path / "r.h5", coefficients, modes, omega=[omega], xp=xp, reduced="reduced.h5")

    times = np.array([0.0, 0.4, 2.9])
    u = np.linalg.solve(K * (1 + 1j * omega * xi) - omega**2 * M, F)
    expected = np.linalg.solve(K, P) + np.real(np.exp(1j * omega * times)[:, None] * u)
    np.testing.assert_allclose(results.full(0, times=times), expected, atol=1e-12)
    np.testing.assert_allclose(results.elastic(0, times=times), expected[:, e], atol=1e-12)
    np.testing.assert_allclose(results.full(0, n=4), results.full(0, times=np.arange(4) * np.pi / 2 / omega), atol=1e-12)
    assert results.motion(0).shape == (64, modes + 3) and results.elastic(0).shape == (64, n - 3)
    np.testing.assert_allclose(results.unknowns(0, [4, 1]), results.full(0)[:, [4, 1]], atol=1e-12)

    with h5py.File(tmp_path / "reduced.h5", "r+") as file:
        for name, axis in (("elastic_dofs", e), ("xe0", xe0), ("Phi", Phi), ("Psi", Psi)):
            del file[f"recovery/{name}"]
            file[f"recovery/{name}"] = axis[1:]
    with pytest.raises(ValueError, match="keeps 6 elastic degrees of freedom only"):
        results.full(0)


def test_file_caught_in_the_middle_of_a_write(tmp_path):
    path = synthetic_results.write(tmp_path / "r.h5", [1.0, 2.0, 3.0], np.ones((3, 4, 3)), 1, CONTACT, residual=np.zeros(2))
    results = Results(path)
    assert len(results) == 2 and results.coefficients.shape == (2, 4, 3) and results.points("seconds").shape == (2,)
    assert results.amplitude("a1").shape == results.omega.shape == (2,)
    with h5py.File(path, "r+") as file:
        events = file["points/contact/events"][:1]
        del file["points/contact/events"]
        file["points/contact/events"] = events
    assert len(Results(path)) == 1 and Results(path).contact_activity(-1).events.shape == (1,)


def test_opens_while_another_program_writes(tmp_path):
    path = synthetic_results.write(tmp_path / "r.h5", [1.0], np.ones((1, 4, 3)), 1, CONTACT)
    writer = subprocess.Popen([sys.executable, "-c", "import h5py, sys; f = h5py.File(sys.argv[1], 'r+'); print('open', flush=True); "
                               "sys.stdin.read()", str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        assert writer.stdout.readline() == "open\n"
        assert Results(path).amplitude("a1").shape == (1,)
    finally:
        writer.communicate("")


def test_wrong_files_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(hdf5_read, "READ_PAUSE", 0)
    with pytest.raises(ValueError, match="none.h5: no such file"):
        Results(tmp_path / "none.h5")
    (tmp_path / "text.h5").write_text("no")
    with pytest.raises(ValueError, match="not a readable results file"):
        Results(tmp_path / "text.h5")
    path = synthetic_results.write(tmp_path / "r.h5", [1.0], np.ones((1, 4, 3)), 1, CONTACT)
    with h5py.File(path, "r+") as file:
        file.attrs["harmonics"] = 4
    with pytest.raises(ValueError, match=r"shape \(any, 4, 9\), found \(1, 4, 3\)"):
        Results(path)


def replaced(name, values, **options):
    """What puts another dataset, or a group, in the place of one of a results file."""
    def replace(file):
        del file[name]
        if values is None:
            file.create_group(name)
        else:
            file.create_dataset(name, data=values, **options)
    return replace


def elsewhere(file):
    del file["points/seconds"]
    layout = h5py.VirtualLayout((1,), "f8")
    layout[:] = h5py.VirtualSource("other.h5", "x", (1,))
    file.create_virtual_dataset("points/seconds", layout)


def outside(file):
    del file["points/seconds"]
    file.create_dataset("points/seconds", (1,), "f8", external=[("other.bin", 0, 8)])


@pytest.mark.parametrize("spoil, message", [
    (replaced("points/omega", None), "/points/omega: wanted numbers, found a group"),
    (replaced("points/omega", h5py.Empty("f8")), "/points/omega: wanted numbers, found"),
    (replaced("points/omega", ["a"]), "/points/omega: wanted numbers, found"),
    (replaced("points/omega", [np.nan]), "/points/omega is not finite everywhere"),
    (replaced("points/coefficients", np.ones((1, 4, 4))), r"shape \(any, 4, 3\), found \(1, 4, 4\)"),
    (replaced("points/contact", [1.0]), "/points/contact: wanted a group, found"),
    (lambda file: file["points/contact"].create_dataset(b"\xff", data=[[1.0]]), "/points/contact: the name .* holds what is no text"),
    (replaced("contact/law", [4]), "/contact/law must hold numbers from 0 to 3"),
    (replaced("contact/law", [-1]), "/contact/law must hold numbers from 0 to 3"),
    (replaced("contact/law", np.array([2**63], np.uint64)), "/contact/law: 9223372036854775808 is too large"),
    (elsewhere, "/points/seconds: its values are in other files"),
    (outside, "/points/seconds: its values are in other files"),
    (lambda file: file.attrs.update(modes=[1, 1]), "attribute modes must be one whole number from 0 on, found"),
    (lambda file: file.attrs.update(modes=1.0), "attribute modes must be one whole number from 0 on, found"),
    (lambda file: file.attrs.update(modes=-1), "attribute modes must be one whole number from 0 on, found -1"),
])
def test_spoiled_files_are_refused(tmp_path, spoil, message):
    path = synthetic_results.write(tmp_path / "r.h5", [1.0], np.ones((1, 4, 3)), 1, CONTACT)
    with h5py.File(path, "r+") as file:
        spoil(file)
    with pytest.raises(ValueError, match=message):
        Results(path)


def test_the_peak_is_the_highest(tmp_path):
    omega, coefficients = np.linspace(1, 3, 41), np.zeros((41, 4, 3))
    coefficients[:, 1, 1] = 3 / (1 + 50 * (omega - 1.5) ** 2) + 1 / (1 + 50 * (omega - 2.5) ** 2)
    results = one_point(tmp_path / "r.h5", coefficients, omega=omega, events=[("peak", 10, omega[10], 3.0, -1)])
    assert results.peak("x1.t1") == pytest.approx((1.5, 3.02), rel=0.01) and len(results.peaks("x1.t1")) == 2
    assert results.watched == "x1.t1"  # peaks of nodes name no unknown


@pytest.mark.parametrize("name, unit, wanted", [
    ("modal_amplitude", "m kg^1/2", "modal_amplitude 0.25 m √kg"), ("gap", "m", "gap 0.25 m"), ("friction", "-", "friction 0.25")])
def test_a_place_has_its_unit(tmp_path, name, unit, wanted):
    contact = {"normal_stiffness": np.ones(1), "tangential_stiffness": np.ones((1, 2)), "friction": np.ones((1, 2)), "gap": np.zeros(1)}
    path = synthetic_results.write(tmp_path / "r.h5", [1.0], np.ones((1, 4, 3)), 1, contact, parameter=[0.25])
    with h5py.File(path, "r+") as file:
        file.attrs.update({"parameter": name, "parameter_unit": unit})
    results = Results(path)
    assert results.place(results.along[0], 6) == wanted
    assert plot.point_title(results, 0, hz=True).endswith(f", at {wanted}")


def test_a_run_without_a_point_yet(tmp_path):
    results = one_point(tmp_path / "r.h5", np.zeros((0, 4, 3)), omega=[])
    assert len(results) == 0 and results.jumps.tolist() == []
    for ask in (lambda: results.at(1.0), lambda: results.largest_point("a1"), lambda: results.peak("a1"), results.need_points):
        with pytest.raises(ValueError, match="no point has been computed yet"):
            ask()


def test_harmonics_are_those_of_the_table(tmp_path):
    path = tmp_path / "r.h5"
    assert one_point(path, np.ones((1, 4, 7))).harmonics == 3
    for told, refused in ((2, False), (3, False), (4, True)):  # a run that adds harmonics widens the table first
        with h5py.File(path, "r+") as file:
            file.attrs["harmonics"] = told
        if refused:
            with pytest.raises(ValueError, match="points/coefficients"):
                Results(path)
        else:
            assert Results(path).harmonics == 3


def test_located_peaks_are_of_the_unknown_asked_for(tmp_path):
    events = [("peak", 0, 1.0, 1.0, 0), ("peak", 1, 2.0, 1.0, -1), ("peak", 2, 3.0, 1.0, 1), ("turn", 3, 4.0, 1.0, -1)]
    results = one_point(tmp_path / "r.h5", np.ones((4, 4, 3)), omega=np.arange(4.0), events=events, watch="7.x")
    assert results.located_peaks("a1").tolist() == [0] and results.located_peaks("x1.t1").tolist() == [2]
    assert results.located_peaks("7.x").tolist() == [1] and results.located_peaks("7.y").tolist() == []
