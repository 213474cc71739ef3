"""Picture of what `range` has found. Readable in black and white."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, NullLocator

from .case_runs import has_peak
from .plot import LINES, ROOM, STYLE
from .plot_labels import no_formula
from .plot_units import dress
from .ranges_report import PERCENTILES, band, of_samples

SHADES = ("#ececec", "#c9c9c9")  # of all samples, and of those between the outer percentiles
LOW = 0.04  # of the height: where peaks of other slider positions are marked
FIRST = LINES[1]  # colour and dashes of first order
TICKS = 5  # of an axis of factors


def picture(found):
    """The figure of a `ranges.Found`: band of the curves, peaks of the samples, and peaks over one parameter each."""
    with plt.rc_context(STYLE):
        columns = max(2, len(found.curves))
        rows = 1 + bool(found.curves)
        figure = plt.figure(figsize=(4.6 * columns, 0.5 + 3.7 * rows), layout="constrained")
        grid = figure.add_gridspec(rows, 2 * columns)
        _band(figure.add_subplot(grid[0, :columns]), found)
        _histogram(figure.add_subplot(grid[0, columns:]), found)
        width = 2 * columns // max(len(found.curves), 1)
        for i, wanted in enumerate(wanted for wanted in found.ranges if wanted.name in found.curves):
            _over(figure.add_subplot(grid[1, i * width:(i + 1) * width]), found, wanted)
        figure.suptitle(no_formula(found.case.content.get("title", found.case.path.name)) + "\n" + in_title(found.ranges))
    return figure


def in_title(ranges):
    """The ranges in one line."""
    return ", ".join(_short(wanted) for wanted in ranges)


def _short(wanted):
    times, sign = "x" if wanted.kind == "factor" else "", "+" if wanted.kind == "offset" else ""
    return f"{wanted.name.replace('_', ' ')} {wanted.low:{sign}g}{times} to {wanted.high:{sign}g}{times}"


def _band(axis, found):
    values, omega = band(found), found.frequencies
    if values is not None:
        least, low, median, high, most = values
        axis.fill_between(omega, least, most, color=SHADES[0], linewidth=0, label="all samples")
        axis.fill_between(omega, low, high, color=SHADES[1], linewidth=0, label=f"{PERCENTILES[0]} to {PERCENTILES[-1]} %")
        axis.plot(omega, median, color="#5a5a5a", linestyle="--", linewidth=1, label="median")
    for number, record in enumerate(_of_sliders(found)):
        if record["curve"]:
            axis.plot(omega, np.array(record["curve"], dtype=float), color=LINES[2][0], linewidth=0.5,
                      label=None if number else "sliders alone")
    if found.middle["curve"]:
        axis.plot(omega, np.array(found.middle["curve"], dtype=float), color="black", label="middle of the ranges")
    label = "peaks" if found.good else None
    axis.plot(of_samples(found, "omega"), of_samples(found, "amplitude"), ".", color=FIRST[0], markersize=3, label=label)
    top = max([found.middle["amplitude"], *of_samples(found, "amplitude")])
    axis.set(ylim=(0, ROOM * top), xlabel=f"excitation frequency [{found.unit.omega}]")
    dress(axis.yaxis, f"amplitude of {found.dof}", found.length)
    if axis.get_legend_handles_labels()[0]:
        axis.legend(fontsize=8)


def _of_sliders(found):
    """Records of other slider positions that have a peak."""
    return [record for _, record in found.sliders if has_peak(record)]


def _histogram(axis, found):
    values = of_samples(found, "amplitude")
    if len(values) > 1:
        axis.hist(values, bins=min(40, max(8, len(values) // 6)), density=True, color=SHADES[1], edgecolor="white", linewidth=0.5)
        axis.axvline(np.mean(values), color="black", label=f"mean of {len(values)} samples")
        complete = len(found.first.amplitude) == len(found.ranges)
        if complete and found.first.deviation() > 0:
            first = [found.first.at(found.middle["amplitude"], found.places[i]) for i in found.good]
            axis.hist(first, bins=min(40, max(8, len(values) // 6)), density=True, histtype="step", color=FIRST[0], linestyle=FIRST[1],
                      linewidth=1.4)
            axis.plot([], [], color=FIRST[0], linestyle=FIRST[1], label="first order" + (", meaningless here" * found.first.meaningless))
    sliders = [record["amplitude"] for record in _of_sliders(found)]
    if sliders:
        axis.plot(sliders, np.full(len(sliders), LOW), "|", transform=axis.get_xaxis_transform(), color=LINES[2][0], markersize=14,
                  label="sliders alone")
    axis.xaxis.set_major_locator(MaxNLocator(5))
    axis.axvline(found.middle["amplitude"], color="#5a5a5a", linestyle=":", label="middle of the ranges")
    dress(axis.xaxis, "amplitude of the peak", found.length)
    axis.set(ylabel="density", yticks=[])
    axis.legend(fontsize=8)


def _over(axis, found, wanted):
    points = [(number, record) for number, record in found.curves[wanted.name] if record["status"] == 0]
    x, y = np.array([number for number, _ in points]), np.array([record["amplitude"] for _, record in points])
    inside = np.array([record["peak"] for _, record in points], bool)
    track = found.tracks.get(wanted.name)
    followed = track is not None and len(track.number) > 0
    axis.plot(x, np.where(inside, y, np.nan), color="black", marker="o", markersize=4, markerfacecolor="white",
              linestyle="none" if followed else "-")
    if followed:
        axis.plot(track.number, track.amplitude, color="black", zorder=1)
    axis.plot(x[~inside], y[~inside], "x", color="black", markersize=5)
    handles = [Line2D([], [], color="black", marker="o", markersize=4, markerfacecolor="white", linestyle="none" if followed else "-",
                      label="computed peaks")]
    if followed:
        handles.append(Line2D([], [], color="black", label="followed peak"))
    if not inside.all():
        handles.append(Line2D([], [], color="black", marker="x", linestyle="none", markersize=5, label="no peak inside the sweep"))
    if wanted.name in found.first.amplitude:
        xi = np.linspace(-1, 1, 51)
        line = found.middle["amplitude"] + np.sum(found.first.amplitude[wanted.name]) * xi
        axis.plot(wanted.at(xi), line, color=FIRST[0], linestyle=FIRST[1])
        handles.append(Line2D([], [], color=FIRST[0], linestyle=FIRST[1], label="first order"))
    kinds = {"value": "", "factor": ", factor", "offset": ", offset"}
    axis.set(xlabel=wanted.name.replace("_", " ") + kinds[wanted.kind], ylim=(0, ROOM * max([found.middle["amplitude"], *y])))
    if wanted.kind == "factor":
        axis.set_xscale("log")
        axis.set_xticks(np.geomspace(*wanted.at(np.array([-1.0, 1.0])), TICKS))  # both ends among them: powers alone may be a single one
        axis.xaxis.set_major_formatter("{x:.3g}")
        axis.xaxis.set_minor_locator(NullLocator())
    dress(axis.yaxis, "amplitude of the peak", found.length)
    axis.legend(handles=handles, fontsize=8)
