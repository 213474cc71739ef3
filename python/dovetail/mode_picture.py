"""Picture of a nonlinear mode: frequency and damping over its amplitude, and the peaks of the response over the force."""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from .modes import Backbone
from .motion import row_of
from .plot import LINES, STYLE
from .plot_labels import no_formula
from .plot_units import dress
from .units import bracket

JUDGED = 24  # peaks whose error is estimated, for the band
LINEAR = 1e-6  # relative change of the frequency, below which a mode counts as linear


def peaks_over_force(backbone, row, harmonic=1):
    """(m, 3): force, amplitude of an unknown at the peak, and its estimated relative error, NaN where none was made; by rising modal
    amplitude. `row` as for `Motion.amplitude`."""
    grid, (_, force) = backbone.grid, backbone.levels(harmonic)
    begin = int(np.searchsorted(grid, from_onset(backbone)))
    judged = set(np.linspace(begin, len(grid) - 1, JUDGED).astype(int))
    rows = []
    for i, (alpha, s) in enumerate(zip(grid, force)):
        omega, zeta, _ = backbone.at(alpha)
        motion = backbone.motion(alpha, omega * np.sqrt(max(1 - 2 * zeta**2, 0.0)) / harmonic, s, harmonic)
        rows.append((s, motion.amplitude(row), backbone.error(motion, row) if i in judged and backbone.judges else np.nan))
    return np.array(rows)


def mode_picture(results, dof, harmonic=None, hz=False):
    """The figure of the results of a run with [mode]; `dof` is a name as in `Results`. `harmonic` of the load: by default the lowest that
    it has. Without peaks where the load does no work on the mode, or is none."""
    backbone = Backbone.read(results)
    row = row_of(results, dof)
    shown = backbone.grid >= from_onset(backbone)
    grid = backbone.grid[shown]
    try:
        shaken = backbone.excited if harmonic is None else harmonic
        backbone.levels(shaken)
        layout = [["frequency", "damping", "peaks"], ["frequency", "damping", "errors"]]
    except ValueError as reason:
        if harmonic is not None:
            raise
        print(f"{results.path}: {reason}; the picture has frequency and damping alone", file=sys.stderr)
        layout = [["frequency", "damping"]] * 2
    omega, zeta = np.array([backbone.at(alpha)[:2] for alpha in grid]).T
    with plt.rc_context(STYLE):
        figure, places = plt.subplot_mosaic(layout, figsize=(4.5 * len(layout[0]), 4.4), gridspec_kw={"height_ratios": [3, 1]},
                                            layout="constrained")
        axes = list(places.values())
        points = {"marker": "o", "markersize": 3.5, "markerfacecolor": "white", "linestyle": "none", "color": "black"}
        for axis, curve, marks, label in ((axes[0], results.unit.hertz(omega) if hz else omega,
                                           results.unit.hertz(backbone.omega) if hz else backbone.omega,
                                           "frequency" + bracket("Hz" if hz else results.unit.omega)),
                                          (axes[1], 100 * zeta, 100 * backbone.damping_ratio, "damping ratio [%]")):
            axis.plot(grid, curve, color="black")
            inside = backbone.alpha >= grid[0]
            axis.plot(backbone.alpha[inside], marks[inside], **points)
            axis.set(xscale="log", xlabel="modal amplitude" + bracket(results.unit.modal), ylabel=label)
        axes[1].set_ylim(0, None)
        if axes[2:]:
            _peaks(*axes[2:], backbone, row, shaken, shown)
            dress(axes[2].yaxis, f"amplitude of {dof} at the peak", results.unit_of(dof))
        for axis in axes:
            number_decades(axis)
        figure.suptitle(no_formula(results.title or results.path.name))
    return figure


def number_decades(axis):
    """Numbers at 1, 2 and 5 of every decade of a logarithmic axis to the right."""
    axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axis.xaxis.set_minor_formatter(NullFormatter())


def from_onset(backbone):
    """The amplitude from which on a picture is of interest: below all that is not linear."""
    linear = backbone.alpha[np.abs(backbone.omega / backbone.omega[0] - 1) < LINEAR] if backbone.linear_below else backbone.alpha[:1]
    return (1.0 if not backbone.linear_below else 0.3) * linear.max()


def _peaks(axis, errors, backbone, row, harmonic, shown):
    force, amplitude, error = peaks_over_force(backbone, row, harmonic)[shown].T
    known = np.isfinite(error)
    if known.any():
        spread = np.interp(np.log(backbone.grid[shown]), np.log(backbone.grid[shown][known]), error[known])
        low, high = (amplitude * np.clip(1 + sign * spread, 0.02, None) for sign in (-1, 1))
        axis.fill(np.concatenate([force, force[::-1]]), np.concatenate([low, high[::-1]]), color="#c9c9c9", linewidth=0,
                  label="estimated error")
        errors.plot(force[known], 100 * error[known], color="black", marker="o", markersize=3, linewidth=1)
    axis.plot(force, amplitude, color="black", linewidth=1, label="peak")
    if backbone.linear_below:
        axis.plot(force, amplitude[0] / force[0] * force, color=LINES[1][0], linestyle=LINES[1][1], label="all points stuck")
    axis.set(xscale="log", yscale="log", ylim=(0.6 * amplitude.min(), 1.6 * amplitude.max()))
    axis.legend(fontsize=8)
    errors.set(xscale="log", xlim=axis.get_xlim(), xlabel="force, factor on the load", ylabel="error [%]", ylim=(0, None))
    axis.tick_params(labelbottom=False)
