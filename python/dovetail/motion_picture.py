"""Picture of the structure as it moves: the outer skin at an instant of the period, enlarged, of all sectors of a wheel or of one."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

from . import fourier  # noqa: E402
from .contact_map import COLOURS  # noqa: E402
from .mesh_picture import AZIMUTH, ELEVATION, LIGHT, skin_rows  # noqa: E402
from .moving_mesh import PHASES, moving_mesh  # noqa: E402
from .plot import STYLE, point_title  # noqa: E402
from .plot_units import formatter, labelled  # noqa: E402

MOST = 400_000  # triangles of all sectors, before thin parts are merged away
ENLARGED = 0.06  # of the size: the largest motion as it is drawn, at most
OFF_AXIS, LIFTED = np.radians(28.0), np.radians(18.0)  # of the eye, from the axis of a wheel


def motion_picture(results, point, sector=None, up="z", hz=False, model=None):
    """The skin at the instant of its largest motion from the mean, in colours of that motion.

    Parameters
    ----------
    results : Results
    point : int
    sector : int, optional
        Of a cyclic structure; default all sectors.
    up : "x", "y" or "z"
        The axis that points upwards; of a wheel if it does not turn about it.
    hz : bool
        Frequency in Hz.
    model : path-like, optional
    """
    mesh = moving_mesh(results, point, model, surface=True)
    whole = results.wave is not None and sector is None
    sectors = range(results.wave.sectors) if whole else [sector or 0]
    triangles = skin_rows(mesh.nodes, mesh.cells, MOST // len(sectors))
    theta = largest_at(mesh)
    places = np.concatenate([mesh.places(j) for j in sectors])
    moved = np.concatenate([mesh.displacement(theta, j, mean=False) for j in sectors])
    rows = (triangles + len(mesh.nodes) * np.arange(len(sectors))[:, None, None]).reshape(-1, 3)
    size, factor = np.linalg.norm(moved, axis=1), enlargement(places, moved)
    eye, right, above = view(mesh.axis if whole else None, "xyz".index(up))
    corners = (places + factor * moved)[rows]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    seen = normal @ eye > 0
    corners, normal, values = corners[seen], normal[seen], size[rows[seen]].mean(axis=1)
    order = np.argsort(corners.mean(axis=1) @ eye)
    light = LIGHT[0] * right + LIGHT[2] * above - LIGHT[1] * eye  # from the left and above, in front
    bright = 0.5 + 0.5 * np.clip(normal @ (light / np.linalg.norm(light)), 0, 1)
    top = max(size.max(), np.finfo(float).tiny)
    colours = COLOURS(values / top)
    colours[:, :3] *= bright[:, None]
    flat = np.stack([corners @ right, corners @ above], axis=2)
    low, high = flat.reshape(-1, 2).min(axis=0), flat.reshape(-1, 2).max(axis=0)
    wide, tall = high - low
    with plt.rc_context(STYLE):
        figure, axis = plt.subplots(figsize=(2.1 + 5.4 * np.clip(wide / tall, 0.75, 1.6), 6.4), layout="constrained")
        axis.add_collection(PolyCollection(flat[order], facecolors=colours[order], edgecolors=colours[order], linewidths=0.25))
        axis.set_aspect("equal")
        axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        axis.axis("off")
        unit = results.unit.length
        scale = plt.cm.ScalarMappable(norm=plt.Normalize(0, top), cmap=COLOURS)
        bar = figure.colorbar(scale, ax=axis, shrink=0.6, aspect=30, format=formatter(unit))
        bar.set_label(labelled("distance from the mean place", unit))
        what = f"{len(sectors)} sectors, engine order {results.wave.engine_order}" if whole else f"sector {sectors[0]}"
        what = f"{what}; " if results.wave is not None else ""
        figure.suptitle(f"{point_title(results, point, hz)}\n{what}motion {factor:g} times as large")
    return figure


def largest_at(mesh):
    """Phase [rad] at which the node that moves most of all is farthest from its mean place."""
    node = int(np.argmax(mesh.amplitude()))
    course = fourier.basis(len(mesh.series) // 2, fourier.phases(PHASES))
    course[:, 0] = 0.0
    return fourier.phases(PHASES)[np.argmax(np.linalg.norm(course @ mesh.series[:, node], axis=1))]


def enlargement(places, moved):
    """1, 2 or 5 times a power of ten, by which the largest motion is drawn as ENLARGED times the size, or less."""
    largest = np.linalg.norm(moved, axis=1).max()
    if not largest > 0:
        return 1.0
    wanted = ENLARGED * np.ptp(places, axis=0).max() / largest
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(f"{max(step for step in (1, 2, 5) if step * decade <= wanted * (1 + 1e-9)) * decade:g}")


def view(axis, up):
    """Unit vectors to the eye, to the right and upwards in the picture: nearly along the axis of a wheel."""
    above = np.eye(3)[up]
    if axis is None:
        a, e = np.radians([AZIMUTH, ELEVATION])
        side, front = np.eye(3)[(up + 1) % 3], np.eye(3)[(up + 2) % 3]
        eye = np.cos(e) * (np.cos(a) * side + np.sin(a) * front) + np.sin(e) * above
    else:
        if np.linalg.norm(np.cross(axis, above)) < 0.5:
            above = np.eye(3)[np.argmin(np.abs(axis))]
        above = above - (above @ axis) * axis
        above /= np.linalg.norm(above)
        eye = np.cos(LIFTED) * (np.cos(OFF_AXIS) * axis + np.sin(OFF_AXIS) * np.cross(above, axis)) + np.sin(LIFTED) * above
    above = above - (above @ eye) * eye
    above /= np.linalg.norm(above)
    return eye, np.cross(above, eye), above
