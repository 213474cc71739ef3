"""Picture of the stress of a part: its skin in colours, with the worst points, and the Haigh diagram of all nodes."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

from .contact_map import COLOURS  # noqa: E402
from .fatigue import Strength  # noqa: E402
from .life import asked_strengths  # noqa: E402
from .mesh_picture import LIGHT, skin_rows  # noqa: E402
from .motion import find_model, read_model_parts  # noqa: E402
from .motion_picture import MOST, view  # noqa: E402
from .plot import LINES, STYLE, point_title  # noqa: E402
from .plot_units import dress, formatter, labelled  # noqa: E402
from .saved_picture import save_picture  # noqa: E402

UNKNOWN = (0.85, 0.85, 0.85)  # colour of faces without stress
CIRCLE = {"marker": "o", "linestyle": "", "markersize": 9, "markerfacecolor": "none", "markeredgecolor": "black"}
FINE = 20_000  # triangles, each of one colour, that look smooth


def save(path, results, point, found, arguments):
    """Writes the picture of a Life, as the options of the command `stress` say."""
    save_picture(stress_picture(results, point, found, asked_strengths(arguments), arguments.up, arguments.hz), path)


def stress_picture(results, point, found, strengths=None, up="z", hz=False):
    """The figure of a Life.

    Parameters
    ----------
    results : Results
    point : int
    found : life.Life
    strengths : Strength or dict of them by material, optional
        Whose lines are drawn.
    up : "x", "y" or "z"
        The axis that points upwards.
    hz : bool
        Frequency in Hz.
    """
    mesh, _ = read_model_parts(find_model(results))
    unit = results.unit.stress
    with plt.rc_context(STYLE):
        figure, (part, haigh) = plt.subplots(1, 2, figsize=(12.0, 5.4), width_ratios=[1.35, 1], layout="constrained")
        used = found.utilisation is not None
        bar = figure.colorbar(_part(part, found, mesh, "xyz".index(up)), ax=part, shrink=0.7, aspect=30,
                              format=None if used else formatter(unit))
        bar.set_label("utilisation" if used else labelled("amplitude", unit))
        _haigh(haigh, found, strengths, unit)
        figure.suptitle(f"{point_title(results, point, hz)}; criterion {found.criterion}")
    return figure


def _part(axis, found, mesh, up):
    """Draws the skin, and gives what its colours mean."""
    triangles = skin_rows(mesh["nodes"], mesh["cells"], MOST)
    eye, right, above = view(None, up)
    pair = found.of_nodes(np.arange(len(mesh["nodes"])))
    values = np.where(pair >= 0, found.ranked[pair], np.nan)
    corners, value = _finer(mesh["nodes"][triangles], values[triangles])
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    seen = np.flatnonzero(normal @ eye > 0)
    seen = seen[np.argsort(corners[seen].mean(axis=1) @ eye)]
    scale = plt.cm.ScalarMappable(norm=plt.Normalize(0, max(np.nanmax(values), np.finfo(float).tiny)), cmap=COLOURS)
    colours = np.where(np.isnan(value[seen])[:, None], (*UNKNOWN, 1.0), scale.to_rgba(np.nan_to_num(value[seen])))
    light = LIGHT[0] * right + LIGHT[2] * above - LIGHT[1] * eye
    colours[:, :3] *= 0.6 + 0.4 * np.clip(normal[seen] @ (light / np.linalg.norm(light)), 0, 1)[:, None]
    flat = np.stack([corners[seen] @ right, corners[seen] @ above], axis=2)
    axis.add_collection(PolyCollection(flat, facecolors=colours, edgecolors=colours, linewidths=0.25))
    worst = mesh["nodes"][found.stress.node[found.worst(1)]]
    axis.plot(worst @ right, worst @ above, **CIRCLE)
    axis.set_title("the worst node in a circle, be it seen or not", loc="left", fontsize=10)
    axis.set_aspect("equal")
    axis.autoscale_view()
    axis.axis("off")
    return scale


def _finer(corners, values):
    """Triangles (f, 3, 3) cut in four until they are FINE or more, and the mean of each of values at the corners (f, 3)."""
    both = np.concatenate([corners, values[:, :, None]], axis=2)
    while 0 < len(both) < FINE:
        a, b, c = both.transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        both = np.concatenate([np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return both[..., :3], both[..., 3].mean(axis=1)


def _haigh(axis, found, strengths, unit):
    """Amplitude over mean of all nodes, with the lines of Goodman."""
    axis.plot(found.mean, found.amplitude, ".", markersize=3, color="#7f7f7f", label="nodes", rasterized=True)
    worst = found.worst(1)
    axis.plot(found.mean[worst], found.amplitude[worst], label="worst node", **CIRCLE)
    left = min(found.mean.min(), 0.0)
    named = {"Goodman": strengths} if isinstance(strengths, Strength) else {
        f"Goodman, {one.name}": strengths[one.name] for one in found.stress.materials if strengths and one.name in strengths}
    for (name, strength), (colour, dashes) in zip(named.items(), LINES[1:]):
        axis.plot([left, 0, strength.tensile], [strength.fatigue, strength.fatigue, 0], color=colour, linestyle=dashes, label=name)
    axis.set_ylim(bottom=0)
    dress(axis.xaxis, "mean", unit)
    dress(axis.yaxis, "amplitude", unit)
    axis.locator_params(axis="x", nbins=4)
    axis.set_title("Haigh diagram", loc="left", fontsize=10)
    axis.legend(loc="best")
