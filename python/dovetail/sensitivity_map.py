"""Map of a joint: by how much each contact point moves a peak, at its place in the plane of the joint."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from .contact_map import COLOURS, dress, legend_below, marker_area, panel_height, scale  # noqa: E402
from .joint_plane import in_plane, lying  # noqa: E402
from .motion import find_joint  # noqa: E402
from .plot import STYLE  # noqa: E402
from .plot_labels import no_formula  # noqa: E402

PARAMETERS = ("friction", "tangential_stiffness", "normal_stiffness")  # those of which one per cent means something everywhere
STATES = (("more of it raises the peak", "^"), ("lowers it", "v"), ("does nothing", "x"))  # with their markers
NOTHING = 1e-6  # of the largest: round-off, or none at all


def sensitivity_map(results, peak=None, model=None, hz=False):
    """By how many per cent a peak's amplitude changes when friction, tangential or normal stiffness of a contact point grows by one
    per cent: size as colour, sign as marker; a row of panels for each joint, with the sum over its points.

    Parameters
    ----------
    results : Results
        Of a case with `[sensitivity]`.
    peak : int, optional
        Row of `results.sensitivity`; default the largest peak.
    model : path-like, optional
        The model file; default the one the reduced file names.
    hz : bool
        Frequency in Hz.
    """
    found = results.sensitivity
    if found is None or len(found) == 0:
        raise ValueError(f"{results.path}: has no sensitivities" +
                         ("; write [sensitivity] with `of`, an unknown such as \"x1.t2\", in the case file" if found is None
                          else ": no peak with a derivative was located"))
    peak = int(np.argmax(found.amplitude)) if peak is None else peak
    joint = find_joint(results, model)
    by_point = {name: found.of_points(name)[peak] for name in PARAMETERS}
    numbers = np.unique(joint["joint"])
    flat = [in_plane(joint["position"][joint["joint"] == number], joint["axes"][joint["joint"] == number]) for number in numbers]
    flat, names = zip(*(lying(places) for places in flat))
    tall = [panel_height(places, 2.9) for places in flat]
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(12.6, 1.2 + sum(tall)), layout="constrained")
        grid = figure.add_gridspec(len(numbers) + 1, len(PARAMETERS), height_ratios=[*tall, 0.35])
        for column, (name, values) in enumerate(by_point.items()):
            top = max(np.nanmax(np.abs(values), initial=0.0), np.finfo(float).tiny)
            for i, (number, places) in enumerate(zip(numbers, flat)):
                axis, mine = figure.add_subplot(grid[i, column]), joint["joint"] == number
                _panel(axis, places, names[i], values[mine], top, results.unit.length)
                axis.set_title(f"{joint['names'][number] if column == 0 else ''}\n{name.replace('_', ' ')}: "
                               f"together {np.nansum(values[mine]):+.3g} % per %", loc="left", fontsize=10)
                scale(axis, plt.cm.ScalarMappable(norm=plt.Normalize(0, top), cmap=COLOURS), "peak [% per %]")
        legend_below(figure, grid, STATES)
        place = f"{results.unit.hertz(found.omega[peak]):.6g} Hz" if hz else results.place(found.omega[peak], 6)
        figure.suptitle(f"{no_formula(results.title or results.path.name)}, peak of {results.watch or 'what is watched'} at {place}")
    return figure


def _panel(axis, places, names, values, top, length):
    size = marker_area(places, 2.9)
    small = ~(np.abs(values) > NOTHING * top)  # NaN too
    edge = {"edgecolors": "black", "linewidths": 0.8 if size > 20 else 0.3}
    for mine, (_, marker) in zip((~small & (values > 0), ~small & (values < 0), small), STATES):
        if marker == "x":
            axis.scatter(*places[mine].T, s=0.6 * size, marker=marker, c="black", linewidths=1.2)
        else:
            axis.scatter(*places[mine].T, s=size, marker=marker, c=np.abs(values[mine]), cmap=COLOURS, vmin=0, vmax=top, **edge)
    dress(axis, places, names, length)
