"""Curves of several results in one picture: levels of force, numbers of harmonics, variants of a joint."""

import matplotlib.pyplot as plt
import numpy as np

from .plot import LINES, MARKERS, ROOM, STYLE, over
from .plot_units import dress
from .units import bracket

MARKED = 12  # markers along a curve, where dash patterns do not suffice


def several(runs, labels=None, dof=None, hz=False):
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

    Raises ValueError where they cannot stand on the same axes. Circles are peaks.
    """
    labels = labels or names_of(runs)
    if len(labels) != len(runs):
        raise ValueError(f"--labels: {len(labels)} for {len(runs)} files; one for each is wanted")
    first, dof = runs[0], dof or runs[0].watched
    for run in runs:
        run.need_points()
        if (run.unit, run.parameter_name) != (first.unit, first.parameter_name):
            raise ValueError(f"{run.path}: has units {run.units} and is over {run.parameter_name or 'the frequency'}, {first.path} has "
                             f"{first.units} and is over {first.parameter_name or 'the frequency'}; no picture holds both")
    hz = hz and first.parameter is None
    with plt.rc_context(STYLE):
        figure, axis = plt.subplots(figsize=(7.5, 4.6), layout="constrained")
        highest = 0.0
        for i, (run, label) in enumerate(zip(runs, labels)):
            curve, scale = run.response(dof), run.unit.hertz(1.0) if hz else 1.0
            colour, dashes = LINES[i % len(LINES)]
            marker = MARKERS[(i // len(LINES) - 1) % len(MARKERS)] if i >= len(LINES) else None
            along, amplitude = curve.curve()
            axis.plot(scale * along, amplitude, color=colour, linestyle=dashes, label=label, marker="o" if len(run) == 1 else marker,
                      markevery=max(1, len(along) // MARKED), markersize=4)
            for place, top in curve.peaks():
                axis.plot(scale * place, top, "o", color=colour, markersize=4, markerfacecolor="white")
            highest = max(highest, np.nanmax(amplitude))
        axis.set_ylim(0, ROOM * (highest or 1.0))
        axis.set_xlabel(over(first) + bracket("Hz" if hz else first.along_unit))
        dress(axis.yaxis, f"amplitude of {dof}", first.unit_of(dof))
        axis.legend(loc="best", handlelength=3.2, frameon=True, framealpha=0.85, edgecolor="none")
    return figure


def names_of(runs):
    """What tells results apart: titles, or folders, or files, or whole paths."""
    candidates = ([run.title for run in runs], [run.path.resolve().parent.name for run in runs], [run.path.stem for run in runs])
    for names in candidates:
        if all(names) and len(set(names)) == len(names):
            return names
    return [str(run.path) for run in runs]
