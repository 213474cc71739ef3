"""Curves of several results in one picture."""

import numpy as np
import pytest

import synthetic_results
from dovetail import Results
from dovetail.__main__ import main
from dovetail.plot_several import names_of, several

CONTACT = {"normal_stiffness": np.ones(1), "tangential_stiffness": np.ones((1, 2)), "friction": np.ones((1, 2)), "gap": np.zeros(1)}
OMEGA = np.linspace(1, 3, 41)


def written(folder, height, **more):
    folder.mkdir()
    coefficients = np.zeros((len(OMEGA), 4, 3))
    coefficients[:, 1, 1] = height / np.hypot(1 - (OMEGA / 2) ** 2, 0.1)
    return Results(synthetic_results.write(folder / "results.h5", OMEGA, coefficients, 1, CONTACT, watch="x1.t1", **more))


def test_each_has_its_line_label_and_peak(tmp_path):
    runs = [written(tmp_path / f"level{i}", i + 1.0) for i in range(8)]
    figure = several(runs)
    [axis] = figure.axes
    lines = [line for line in axis.lines if len(line.get_xdata()) > 1]
    np.testing.assert_allclose([line.get_ydata().max() for line in lines], [10 * (i + 1) for i in range(8)], rtol=1e-6)
    assert [text.get_text() for text in axis.get_legend().get_texts()] == [f"level{i}" for i in range(8)]
    assert len({(line.get_color(), line.get_linestyle(), line.get_marker()) for line in lines}) == 8
    peaks = [line.get_xdata()[0] for line in axis.lines if len(line.get_xdata()) == 1]
    assert len(peaks) == 8 and np.allclose(peaks, 2.0, atol=0.01)
    assert axis.get_ylabel() == "amplitude of x1.t1" and axis.get_xlabel() == "excitation frequency [rad/s]"
    in_hertz = several(runs[:2], hz=True).axes[0]
    np.testing.assert_allclose(in_hertz.lines[0].get_xdata(), OMEGA / (2 * np.pi))


def test_names_are_what_tells_them_apart(tmp_path):
    a, b = (written(tmp_path / name, 1.0, title=f"level {name}") for name in "ab")
    assert names_of([a, b]) == ["level a", "level b"]
    assert names_of([a, a]) == [str(a.path)] * 2


def test_the_command_draws_and_refuses(tmp_path, capsys):
    a, b = (str(written(tmp_path / name, 1.0).path) for name in "ab")
    picture = tmp_path / "both.png"
    assert main(["plot", a, b, "--labels", "one", "two", "-o", str(picture)]) == 0 and picture.stat().st_size > 10000
    other = str(written(tmp_path / "other", 1.0, units="mm, N, s").path)
    for words, message in (([a, b, "--labels", "one"], "one for each"), ([a, b, "--kind", "map"], "found --kind map"),
                           ([a, b, "--kind", "mode"], "follows no nonlinear mode"), ([a, b, "--at", "2"], "--at 2"),
                           ([a, b, "--kind", "mode", "--dof", "x1.t1"], "without --dof"),
                           ([a, other], "no picture holds both"), ([a, b, "--dof", "x1.t1", "x1.n"], "one unknown")):
        assert main(["plot", *words]) == 2
        assert message in capsys.readouterr().err


def test_a_waterfall_lifts_each_curve_by_a_round_step(tmp_path):
    runs = [written(tmp_path / f"level{i}", i + 1.0) for i in range(3)]  # peaks of 10, 20, 30 m
    figure = several(runs, ["one", "$2", "three"], waterfall=True)
    figure.canvas.draw()
    axis, renderer = figure.axes[0], figure.canvas.get_renderer()
    curves = [line.get_ydata() for line in axis.lines if not line.get_label().startswith("_")]
    np.testing.assert_allclose([curve.max() for curve in curves], [10, 30, 50], rtol=1e-6)
    assert axis.get_ylabel() == "amplitude of x1.t1\n10 m from line to line"
    assert axis.get_ylim()[1] > 50 and axis.get_xlabel() == "excitation frequency [rad/s]"
    boxes = [text.get_window_extent(renderer) for text in axis.texts]
    assert len(boxes) == 3 and not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    assert all(figure.bbox.contains(box.x1, box.y1) for box in boxes)
    assert axis.texts[1].get_text() == r"\$2"


def test_a_waterfall_of_one_file_and_of_no_motion(tmp_path):
    still = written(tmp_path / "still", 0.0)
    assert main(["plot", str(still.path), "--kind", "waterfall"]) == 0
    assert (tmp_path / "still" / "results_several_waterfall.png").stat().st_size > 5000


@pytest.mark.filterwarnings("error")  # of a layout without room
@pytest.mark.parametrize("waterfall", [False, True])
def test_long_labels_leave_room_for_the_curves(tmp_path, waterfall):
    long = ["a run whose name says all that was changed in its case file, " * 3, "x" * 200, ""]
    figure = several([written(tmp_path / f"level{i}", i + 1.0) for i in range(3)], long, waterfall=waterfall)
    figure.canvas.draw()
    axis = figure.axes[0].get_window_extent()
    assert axis.width > 0.5 * figure.bbox.width and axis.height > 0.4 * figure.bbox.height
    said = figure.axes[0].texts if waterfall else [figure.axes[0].get_legend()]
    assert said and all(part.get_window_extent().x1 < figure.bbox.x1 for part in said)


def test_a_legend_covers_no_curve(tmp_path):
    for count, columns in ((2, 1), (8, 2)):
        figure = several([written(tmp_path / f"{count} level{i}", i + 1.0) for i in range(count)])
        figure.canvas.draw()
        axis, renderer = figure.axes[0], figure.canvas.get_renderer()
        legend = axis.get_legend().get_window_extent(renderer)
        assert legend.y0 >= axis.get_window_extent(renderer).y1 and legend.x1 <= figure.bbox.x1
        assert axis.get_legend()._ncols == columns


@pytest.mark.parametrize("words", [["--labels", "one"]])
def test_one_file_may_have_a_label(tmp_path, words):
    assert main(["plot", str(written(tmp_path / "a", 1.0).path), *words]) == 0
