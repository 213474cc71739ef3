"""Curves of several results in one picture: levels of force, numbers of harmonics, variants of a joint; their damping, if of modes."""

import matplotlib.pyplot as plt
import numpy as np

from .mode_picture import from_onset, number_decades
from .modes import Backbone
from .plot import LINES, MARKERS, ROOM, STYLE, over
from .plot_labels import NARROW, ROW, WIDE, folded, legend_above, rows_of
from .plot_units import dress, round_text
from .units import bracket

MARKED = 12  # markers along a curve, where dash patterns do not suffice
STEP = 0.4  # of the largest amplitude at most: from one curve of a waterfall to the next
ROUND = (5, 2, 1)  # times a power of ten: steps to choose from
STRIP = 0.45  # height of a picture for each of them [inch]


def several(runs, labels=None, dof=None, hz=False, waterfall=False):
    """Amplitude of one unknown or node over the frequency, or the parameter that is varied, a line for each of several Results.

    Parameters
    ----------
    runs : list of Results
        Of the same unit, over the same thing.
    labels : list of str, optional
        Default: their titles, or where these are alike, their folders or files.
    dof : str, optional
        Default: what the first of them watches.
    hz : bool
        Frequency axis in Hz.
    waterfall : bool
        Each curve above the one before, on a zero line of its own.

    Raises ValueError where they cannot stand on the same axes. Circles are peaks.
    """
    labels, dof = _labels(runs, labels), dof or runs[0].watched
    hz = hz and runs[0].parameter is None
    with plt.rc_context(STYLE):
        figure = (_waterfall if waterfall else _overlaid)(runs, labels, dof, hz)
        axis = figure.axes[0]
        axis.set_xlabel(over(runs[0]) + bracket("Hz" if hz else runs[0].along_unit))
    return figure


def _overlaid(runs, labels, dof, hz):
    labels = [folded(label, WIDE) for label in labels]
    rows, columns = rows_of(labels)
    figure, axis = plt.subplots(figsize=(7.5, 4.6 + ROW * rows), layout="constrained")
    highest = 0.0
    for i, (run, label) in enumerate(zip(runs, labels)):
        along, amplitude, peaks = _curve(run, dof, hz)
        axis.plot(along, amplitude, label=label, **_line(i, len(along), len(run) == 1))
        for place, top in peaks:
            axis.plot(place, top, "o", color=LINES[i % len(LINES)][0], markersize=4, markerfacecolor="white")
        highest = max(highest, np.nanmax(amplitude))
    axis.set_ylim(0, ROOM * (highest or 1.0))
    dress(axis.yaxis, f"amplitude of {dof}", runs[0].unit_of(dof))
    legend_above(axis, columns)
    return figure


def _waterfall(runs, labels, dof, hz):
    """The first at the bottom, and before the others; the label of the axis says how far their zero lines are apart."""
    figure, axis = plt.subplots(figsize=(7.5, 3.0 + STRIP * len(runs)), layout="constrained")
    curves = [_curve(run, dof, hz) for run in runs]
    highest = max(np.nanmax(amplitude) for _, amplitude, _ in curves) or 1.0
    step = _round_below(STEP * highest)
    left, right = min(np.nanmin(along) for along, _, _ in curves), max(np.nanmax(along) for along, _, _ in curves)
    for i, ((along, amplitude, peaks), label) in enumerate(zip(curves, labels)):
        zero = step * i
        axis.fill_between(along, zero, zero + amplitude, color="white", linewidth=0, zorder=2 - 0.01 * i)
        axis.plot([left, right], [zero, zero], color="#9a9a9a", linewidth=0.7, zorder=2 - 0.01 * i)
        axis.plot(along, zero + amplitude, color="black", zorder=2.005 - 0.01 * i, label=label, marker="o" if len(along) == 1 else None)
        for place, top in peaks:
            axis.plot(place, zero + top, "ko", markersize=4, markerfacecolor="white", zorder=2.006 - 0.01 * i)
        axis.annotate(folded(label, NARROW), (1.0, zero), xycoords=("axes fraction", "data"), xytext=(4, 0),
                      textcoords="offset points", va="center")
    axis.set(ylim=(0, step * (len(runs) - 1) + ROOM * highest), yticks=[step * i for i in range(len(runs))], yticklabels=[])
    axis.grid(axis="y", visible=False)
    axis.set_ylabel(f"amplitude of {dof}\n{round_text(step, runs[0].unit_of(dof))} from line to line")
    return figure


def _round_below(number):
    power = 10.0 ** np.floor(np.log10(number))
    return power * next(digit for digit in ROUND if digit * power <= number * (1 + 1e-9))


def several_modes(runs, labels=None, hz=False):
    """Frequency and damping ratio over the modal amplitude, a line for each of several Results of runs with [mode]; dots are points."""
    labels = [folded(label, WIDE) for label in _labels(runs, labels)]
    rows, columns = rows_of(labels)
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(2, 1, sharex=True, figsize=(7.5, 6.6 + ROW * rows), layout="constrained")
        begin = np.inf
        for i, (run, label) in enumerate(zip(runs, labels)):
            backbone, scale = Backbone.read(run), run.unit.hertz(1.0) if hz else 1.0
            begin = min(begin, from_onset(backbone))
            alpha = backbone.grid[backbone.grid >= backbone.alpha[0]]
            omega, zeta = np.array([backbone.at(value)[:2] for value in alpha]).T
            for axis, curve, points in zip(axes, (scale * omega, 100 * zeta), (scale * backbone.omega, 100 * backbone.damping_ratio)):
                axis.plot(alpha, curve, label=label, **_line(i, len(alpha)))
                axis.plot(backbone.alpha, points, "o", color=LINES[i % len(LINES)][0], markersize=3, markerfacecolor="white")
        axes[0].set(xscale="log", xlim=(begin, None), ylabel="frequency" + bracket("Hz" if hz else runs[0].unit.omega))
        axes[1].set(ylim=(0, None), ylabel="damping ratio [%]", xlabel="modal amplitude" + bracket(runs[0].unit.modal))
        number_decades(axes[1])
        legend_above(axes[0], columns)
    return figure


def _labels(runs, labels):
    """One for each, after a check that one picture holds all."""
    labels, first = labels or names_of(runs), runs[0]
    if len(labels) != len(runs):
        raise ValueError(f"--labels: {len(labels)} for {len(runs)} files; one for each is wanted")
    for run in runs:
        run.need_points()
        if (run.unit, run.parameter_name) != (first.unit, first.parameter_name):
            raise ValueError(f"{run.path}: has units {run.units} and is over {run.parameter_name or 'the frequency'}, {first.path} has "
                             f"{first.units} and is over {first.parameter_name or 'the frequency'}; no picture holds both")
    return labels


def _curve(run, dof, hz):
    """Where and how high it is drawn, and its peaks."""
    curve, scale = run.response(dof), run.unit.hertz(1.0) if hz else 1.0
    along, amplitude = curve.curve()
    return scale * along, amplitude, [(scale * place, top) for place, top in curve.peaks()]


def _line(i, count, single=False):
    """How the line of the i-th looks: by colour and dashes, then by markers, too."""
    colour, dashes = LINES[i % len(LINES)]
    marker = MARKERS[(i // len(LINES) - 1) % len(MARKERS)] if i >= len(LINES) else None
    return {"color": colour, "linestyle": dashes, "marker": "o" if single else marker, "markevery": max(1, count // MARKED),
            "markersize": 4}


def names_of(runs):
    """What tells results apart: titles, or folders, or files, or whole paths."""
    candidates = ([run.title for run in runs], [run.path.resolve().parent.name for run in runs], [run.path.stem for run in runs])
    for names in candidates:
        if all(names) and len(set(names)) == len(names):
            return names
    return [str(run.path) for run in runs]
