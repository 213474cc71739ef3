"""Map of a joint: what every contact point does over one period, at its place in the plane of the joint."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.ticker import MaxNLocator  # noqa: E402

from .joint_plane import in_plane, lying  # noqa: E402
from .motion import find_joint  # noqa: E402
from .plot import STYLE, point_title  # noqa: E402
from .plot_units import dress as dress_axis, formatter, labelled  # noqa: E402

STATES = (("sticks", "o"), ("slips", "s"), ("opens at times", "^"), ("open throughout", "x"))  # with their markers
COLOURS = plt.get_cmap("YlOrBr")  # falls in brightness all the way: readable in grey


def contact_map(results, point, model=None, hz=False):
    """Share of the period in which every contact point slips, and its friction work per area; one row of panels for each joint.

    Parameters
    ----------
    results : Results
    point : int
        Index of the point of the branch.
    model : path-like, optional
        The model file; default the one the reduced file names.
    hz : bool
        Frequency in Hz.
    """
    joint = find_joint(results, model)
    state, slipping, work = over_period(results, point)
    per_area = bool(np.all(joint["area"] > 0))
    work = work / joint["area"] if per_area else work
    numbers = np.unique(joint["joint"])
    flat = [in_plane(joint["position"][joint["joint"] == number], joint["axes"][joint["joint"] == number]) for number in numbers]
    flat, names = zip(*(lying(places) for places in flat))
    tall = [panel_height(places) for places in flat]
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(9.6, 1.0 + sum(tall)), layout="constrained")
        grid = figure.add_gridspec(len(numbers) + 1, 2, height_ratios=[*tall, 0.35])
        largest = max(work.max(), np.finfo(float).tiny)
        for i, (number, places) in enumerate(zip(numbers, flat)):
            row = [figure.add_subplot(grid[i, column]) for column in (0, 1)]
            mine = joint["joint"] == number
            length = results.unit.length
            shares = _panel(row[0], places, names[i], 100 * slipping[mine], state[mine], 100.0, length)
            works = _panel(row[1], places, names[i], work[mine], state[mine], largest, length)
            row[0].set_title(f"{joint['names'][number]}: slips [% of the period]", loc="left", fontsize=10)
            scale(row[0], shares)
            unit = results.unit.work_per_area if per_area else results.unit.energy
            row[1].set_title(labelled("friction work per period" + " and area" * per_area, unit), loc="left", fontsize=10)
            scale(row[1], works, formatter=formatter(unit))
        legend_below(figure, grid, STATES, [np.count_nonzero(state == i) for i in range(len(STATES))])
        figure.suptitle(point_title(results, point, hz))
    return figure


def over_period(results, point):
    """For each contact point: state (N_x,) as a number in STATES, share of the period slipping (N_x,), work (N_x,) [J]."""
    activity = results.contact_activity(point)
    throughout = activity.open > 1 - 1e-9  # up to round-off
    state = np.select([throughout, activity.open > 0, activity.slip > 0], [3, 2, 1], 0)
    return state, activity.slip, np.maximum(activity.dissipation, 0.0)  # round-off of a loop without area


def legend_below(figure, grid, states, counts=None):
    """What the markers stand for, (name, marker) of each state, and how many points it has if given, in the last row of the grid."""
    handles = [plt.Line2D([], [], marker=marker, linestyle="", color="black", markerfacecolor="#d0d0d0", markersize=7,
                          label=name if count is None else f"{name} ({count})")
               for (name, marker), count in zip(states, counts or [None] * len(states))]
    below = figure.add_subplot(grid[-1, :])
    below.axis("off")
    below.legend(handles=handles, loc="center", ncols=len(states))


def panel_height(places, width=3.6):
    """Height of a panel [inch] that shows the places in equal scales, within reason."""
    x, y = np.maximum(np.ptp(places, axis=0), 1e-12)
    return float(np.clip(width * y / x, 1.2, 4.5)) + 0.8


def scale(axis, drawn, label="", formatter=None):
    """A colour bar as high as the panel is."""
    bar = axis.figure.colorbar(drawn, cax=axis.inset_axes([1.05, 0, 0.05, 1]), format=formatter)
    bar.locator = MaxNLocator(5)
    bar.update_ticks()
    bar.set_label(label)


def dress(axis, places, names=("t1", "t2"), length="m"):
    """Equal scales, a margin, ticks in the unit of length."""
    x, y = np.ptp(places, axis=0)
    margin = 0.12 * max(x, y) or 1.0
    for axis_, values in ((axis.set_xlim, places[:, 0]), (axis.set_ylim, places[:, 1])):
        axis_(values.min() - margin, values.max() + margin)
    axis.set_aspect("equal")
    for line, name in ((axis.xaxis, names[0]), (axis.yaxis, names[1])):
        dress_axis(line, name, length)
    axis.locator_params(axis="x", nbins=int(np.clip(5 * x / max(y, 1e-12), 2, 4)))
    axis.locator_params(axis="y", nbins=int(np.clip(5 * y / max(x, 1e-12), 2, 6)))


def marker_area(places, width=3.6):
    """Size of a marker [points^2] at which neighbours just stay apart."""
    largest = max(np.ptp(places, axis=0).max(), 1e-12)
    between = 72 * width / np.sqrt(max(len(places) * np.prod(np.maximum(np.ptp(places, axis=0) / largest, 0.05)) ** -1, 1.0))
    return float(np.clip((0.45 * between) ** 2, 4, 120))


def _panel(axis, places, names, values, state, top, length):
    size = marker_area(places)
    for i, (_, marker) in enumerate(STATES):
        mine = state == i
        edge = {"edgecolors": "black", "linewidths": 0.8 if size > 20 else 0.3} if marker != "x" else {"linewidths": 1.2}
        colour = {"c": values[mine], "cmap": COLOURS, "vmin": 0, "vmax": top} if marker != "x" else {"c": "black"}
        axis.scatter(*places[mine].T, s=size * (1.0 if marker != "x" else 0.6), marker=marker, **colour, **edge)
    dress(axis, places, names, length)
    return plt.cm.ScalarMappable(norm=plt.Normalize(0, top), cmap=COLOURS)
