"""Frequency over nodal diameter: the line of engine orders, what a sweep crosses, and the picture."""

import h5py
import numpy as np
import pytest
import synthetic_results
from matplotlib import pyplot as plt
from matplotlib.path import Path

from dovetail import Results
from dovetail.__main__ import main
from dovetail.campbell_picture import campbell
from dovetail.diameters_picture import crossings, diameters, folded, zigzag
from dovetail.info import describe

CONTACT = {"normal_stiffness": np.array([2.0]), "tangential_stiffness": np.array([[3.0, 4.0]]), "friction": np.array([[0.5, 0.25]]),
           "gap": np.array([0.0])}
TABLE = np.array([[4.0, 21.0], [5.0, 22.0], [6.5, 26.0], [7.0, 30.0]])  # of nodal diameters 0 to 3


def results(path, order, sectors=6, table=TABLE, omega=(5.0, 7.0), harmonics=4, units="SI"):
    synthetic_results.write(path, omega, np.ones((len(omega), 4, 2 * harmonics + 1)), 1, CONTACT, units=units)
    with h5py.File(path, "r+") as file:
        file.attrs["sectors"], file.attrs["engine_order"] = sectors, order
        file["cyclic/frequencies"] = table
    return Results(path)


def test_engine_orders_fold_at_half_the_sectors():
    assert folded([0, 1, 3, 4, 6, 8, 11], 6).tolist() == [0, 1, 3, 2, 0, 2, 1]
    assert folded([2, 3, 5], 5).tolist() == [2, 2, 0]
    h, orders = zigzag(5, 6)
    assert h.tolist() == [0, 2.5, 0, 1] and orders.tolist() == [0, 2.5, 5, 6]


@pytest.mark.parametrize("order, expected", [
    (1, [(1, 1, 5.0), (3, 3, None), (4, 2, 26.0)]), (-1, [(1, 1, 5.0), (3, 3, None), (4, 2, 26.0)]),
    (2, [(1, 2, 6.5), (3, 0, 21.0), (4, 2, 26.0)]), (0, [(3, 0, 21.0), (4, 0, 21.0)])])
def test_what_a_sweep_crosses(tmp_path, order, expected):
    """Harmonic k sweeps from 5 k to 7 k, on nodal diameter k EO mod 6."""
    wave = results(tmp_path / "r.h5", order).wave
    assert [abs(h) for h in wave.index] == folded(order * np.arange(5), 6).tolist()
    assert crossings(wave, 5.0, 7.0) == [place for place in expected if place[2]]


def test_the_picture(tmp_path):
    """Lines at both rotor speeds, and a dot at each crossing; in hertz all of it."""
    found = results(tmp_path / "r.h5", 2)
    for hz in (False, True):
        figure, scale = diameters(found, hz), 1 / (2 * np.pi) if hz else 1.0
        axis = figure.axes[0]
        lines = {line.get_label(): line for line in axis.lines}
        slow, fast = (lines[f"engine orders, rotor at {scale * speed:.4g} {'Hz' if hz else 'rad/s'}"] for speed in (2.5, 3.5))
        np.testing.assert_allclose(slow.get_xdata(), [0, 3, 0, 2])
        np.testing.assert_allclose(fast.get_ydata(), scale * 3.5 * np.array([0, 3, 6, 8]))
        dots = lines["crossed in the sweep"].get_xydata()
        np.testing.assert_allclose(dots, [[2, scale * 6.5], [0, scale * 21], [2, scale * 26]])
        assert axis.get_ylabel() == f"frequency [{'Hz' if hz else 'rad/s'}]"
        assert {text.get_text().split(":")[0] for text in axis.texts} == {"EO 2", "EO 4", "EO 6", "EO 8"}
        plt.close(figure)


@pytest.mark.parametrize("order, sectors", [(1, 6), (4, 12), (-5, 6), (0, 6), (7, 6)])
def test_labels_do_not_lie_on_each_other(tmp_path, order, sectors):
    rows = sectors // 2 + 1
    table = np.sort(np.random.default_rng(1).uniform(3, 60, (rows, 20)))
    figure = diameters(results(tmp_path / "r.h5", order, sectors, table, omega=(5.0, 12.0), harmonics=8))
    renderer = figure.canvas.get_renderer()
    boxes = [text.get_window_extent(renderer) for text in figure.axes[0].texts]
    assert len(boxes) > 2 and not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    plt.close(figure)


def test_the_command_and_what_info_says(tmp_path, capsys):
    path = results(tmp_path / "r.h5", -5, units="mm, ms, kg").path
    assert main(["plot", str(path), "--kind", "diameters"]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "r_diameters.png") and (tmp_path / "r_diameters.png").is_file()
    said = describe(path)
    assert "6 sectors, engine order -5" in said and "0, 1, 2, 3, -2 of harmonics 0 to 4" in said


def test_refusals(tmp_path):
    path = synthetic_results.write(tmp_path / "r.h5", (1.0,), np.ones((1, 4, 3)), 1, CONTACT)
    with pytest.raises(ValueError, match="is not of a sector of a cyclic structure, so it has no nodal diameters"):
        diameters(Results(path))
    assert "sectors" not in describe(path)
    older = results(tmp_path / "older.h5", 1).path
    with h5py.File(older, "r+") as file:
        del file["cyclic"]
    with pytest.raises(ValueError, match="has no /cyclic/frequencies"):
        diameters(Results(older))


def test_campbell(tmp_path):
    """Harmonic k rises with k EO times the rotor speed, and meets the frequencies of its own nodal diameter alone."""
    found = results(tmp_path / "r.h5", 2)
    for hz in (False, True):
        figure = campbell(found, hz)
        scale, turning = (1 / (2 * np.pi), 60 / (2 * np.pi)) if hz else (1.0, 1.0)
        axis = figure.axes[0]
        rising = sorted((line.get_ydata()[1] / line.get_xdata()[1] for line in axis.lines if len(line.get_xdata()) == 2))
        np.testing.assert_allclose(rising, scale / turning * np.array([2, 4, 6, 8]))
        dots = {(round(float(x), 6), round(float(y), 6)): line.get_markerfacecolor() != "white" for line in axis.lines
                for x, y in line.get_xydata() if len(line.get_xdata()) == 1}
        wanted = {}  # speed and frequency of each crossing, and whether the rotor is between 2.5 and 3.5 there
        for order, row in ((2, TABLE[2]), (4, TABLE[2]), (6, TABLE[0]), (8, TABLE[2])):
            wanted |= {(round(turning * f / order, 6), round(scale * f, 6)): 2.5 <= f / order <= 3.5 for f in row if f / order < 1.2 * 3.5}
        assert dots == wanted and any(dots.values()) and not all(dots.values())
        assert axis.get_xlabel() == f"rotor speed [{'1/min' if hz else 'rad/s'}]"
        said = [text.get_text() for text in axis.get_legend().get_texts()]
        assert said[-4:] == ["level: closed points stuck", "sweep of the run", "crossed in the sweep", "crossed elsewhere"]
        plt.close(figure)


def test_campbell_of_a_mode_has_no_sweep(tmp_path):
    """Its frequencies are those of the mode over its amplitude."""
    path = synthetic_results.write(tmp_path / "r.h5", (6.4, 6.3), np.ones((2, 4, 9)), 1, CONTACT, modal_amplitude=[0.1, 0.2])
    with h5py.File(path, "r+") as file:
        file.attrs.update({"sectors": 6, "engine_order": 2, "parameter": "modal_amplitude", "parameter_unit": "m kg^1/2"})
        file["cyclic/frequencies"] = TABLE
    figure = campbell(Results(path))
    said = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert said[-2:] == ["level: closed points stuck", "crossed"] and not figure.axes[0].patches
    dots = [line for line in figure.axes[0].lines if len(line.get_xdata()) == 1]
    assert dots and all(line.get_markerfacecolor() == "white" for line in dots)
    plt.close(figure)


def test_labels_of_campbell_leave_lines_free(tmp_path):
    """Where there is room, as here."""
    figure = campbell(results(tmp_path / "r.h5", 2, harmonics=3))
    axis = figure.axes[0]
    renderer = figure.canvas.get_renderer()
    lines = [Path(axis.transData.transform(line.get_xydata())) for line in axis.lines if len(line.get_xdata()) == 2]
    lines += [Path(axis.transData.transform(part)) for rows in axis.collections for part in rows.get_segments()]
    boxes = [text.get_window_extent(renderer) for text in axis.texts]
    assert len(boxes) > 2 and not any(line.intersects_bbox(box, filled=False) for line in lines for box in boxes)
    plt.close(figure)


@pytest.mark.parametrize("order, sectors", [(1, 6), (4, 12), (-5, 6), (7, 6)])
def test_labels_of_campbell_do_not_lie_on_each_other(tmp_path, order, sectors):
    table = np.sort(np.random.default_rng(1).uniform(3, 60, (sectors // 2 + 1, 20)))
    figure = campbell(results(tmp_path / "r.h5", order, sectors, table, omega=(5.0, 12.0), harmonics=8))
    renderer = figure.canvas.get_renderer()
    boxes = [text.get_window_extent(renderer) for text in figure.axes[0].texts]
    assert len(boxes) > 2 and not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    plt.close(figure)


def test_campbell_by_the_command_and_without_rotor_speed(tmp_path, capsys):
    path = results(tmp_path / "r.h5", -5).path
    assert main(["plot", str(path), "--kind", "campbell", "--hz"]) == 0 and (tmp_path / "r_campbell.png").is_file()
    still = results(tmp_path / "still.h5", 0).path
    assert main(["plot", str(still), "--kind", "campbell"]) == 2
    assert "under engine order 0 the load does not travel" in capsys.readouterr().err
