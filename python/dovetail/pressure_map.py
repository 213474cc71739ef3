"""Picture of the joints under their preload: pressure at every contact point, those that are closed and those that are not."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from .contact_map import COLOURS, dress, legend_below, marker_area, panel_height, scale  # noqa: E402
from .joint_plane import lying  # noqa: E402
from .motion import find_joint  # noqa: E402
from .plot import STYLE  # noqa: E402
from .plot_labels import no_formula  # noqa: E402
from .plot_units import formatter, labelled  # noqa: E402
from .preload_state import joint_states  # noqa: E402
from .units import with_unit  # noqa: E402

STATES = (("closed", "o"), ("open, inside", "x"), ("open, at the edge", "+"))  # with their markers


def pressure_map(results, model=None):
    """Pressure of the preload state, or the normal force where areas are not known; a panel for each joint.

    Parameters
    ----------
    results : Results
    model : path-like, optional
        The model file; default the one the reduced file names.
    """
    joint = find_joint(results, model)
    states = joint_states(results, joint)
    per_area = all(state.pressure is not None for state in states)
    values = [state.pressure if per_area else state.normal for state in states]
    largest = max(max(value.max() for value in values), np.finfo(float).tiny)
    flat, names = zip(*(lying(state.places) for state in states))
    tall = [panel_height(places, 6.0) for places in flat]
    unit = results.unit.stress if per_area else results.unit.force
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(8.6, 1.2 + sum(tall)), layout="constrained")
        grid = figure.add_gridspec(len(states) + 1, 1, height_ratios=[*tall, 0.35])
        counts = np.zeros(len(STATES), dtype=int)
        for i, state in enumerate(states):
            axis = figure.add_subplot(grid[i, 0])
            counts += _panel(axis, flat[i], names[i], state, values[i], largest, results.unit.length)
            scale(axis, plt.cm.ScalarMappable(norm=plt.Normalize(0, largest), cmap=COLOURS), formatter=formatter(unit))
            what = labelled(f"{'pressure' if per_area else 'normal force of each point'} under preload", unit)
            axis.set_title(f"{state.name}: {what}\n"
                           f"{np.count_nonzero(state.closed)} of {len(state.closed)} points closed, normal force "
                           f"{with_unit(f'{state.normal.sum():.5g}', results.unit.force)}", loc="left", fontsize=10)
        legend_below(figure, grid, STATES, list(counts))
        figure.suptitle(f"{no_formula(results.title or results.path.name)}, preload")
    return figure


def _panel(axis, places, names, state, values, top, length):
    """Draws the points of a joint; returns how many there are of each state."""
    size = marker_area(places, 6.0)
    kinds = [state.closed, ~state.closed & ~state.edge, ~state.closed & state.edge]
    edge = {"edgecolors": "black", "linewidths": 0.8 if size > 20 else 0.3}
    axis.scatter(*places[kinds[0]].T, s=size, marker="o", c=values[kinds[0]], cmap=COLOURS, vmin=0, vmax=top, **edge)
    for mine, (_, marker) in zip(kinds[1:], STATES[1:]):
        axis.scatter(*places[mine].T, s=0.6 * size, marker=marker, c="black", linewidths=1.2)
    dress(axis, places, names, length)
    return np.array([np.count_nonzero(mine) for mine in kinds])
