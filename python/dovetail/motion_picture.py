"""Picture, and film, of the structure as it moves: the outer skin, enlarged, of all sectors of a wheel or of one."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.animation import FuncAnimation, PillowWriter  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

from . import fourier  # noqa: E402
from .contact_map import COLOURS  # noqa: E402
from .letters import lend_letters  # noqa: E402
from .mesh_picture import AZIMUTH, ELEVATION, LIGHT, skin_rows  # noqa: E402
from .moving_mesh import largest_at, moving_mesh  # noqa: E402
from .plot import STYLE, point_title  # noqa: E402
from .plot_units import formatter, labelled  # noqa: E402

MOST = 400_000  # triangles of all sectors, before thin parts are merged away
ENLARGED = 0.06  # of the size: the largest motion as it is drawn, at most
FRAMES, SECONDS, FILM_DPI = 24, 2.0, 90  # of a film: instants of a period, how long it is shown
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
    skin = _Skin(results, point, sector, up, model)
    return _drawn(skin, [skin.instant], results, point, hz)[0]


def motion_film(results, point, path, sector=None, up="z", hz=False, model=None):
    """Writes one period as an animated GIF, which repeats; arguments as `motion_picture`."""
    skin = _Skin(results, point, sector, up, model)
    thetas = fourier.phases(FRAMES)
    figure, polygons, looks = _drawn(skin, thetas, results, point, hz)

    def show(i):
        corners, colours = looks[i]
        polygons.set_verts(corners)
        polygons.set(facecolors=colours, edgecolors=colours)
        return [polygons]

    lend_letters(figure)
    with plt.rc_context({"savefig.bbox": None}):
        FuncAnimation(figure, show, FRAMES).save(path, PillowWriter(fps=FRAMES / SECONDS), dpi=FILM_DPI)
    plt.close(figure)


class _Skin:
    """Triangles of the outer faces of some sectors, and how they look to the eye at a phase of the period.

    instant : phase of the largest motion; top : that motion
    """

    def __init__(self, results, point, sector, up, model):
        self.mesh = mesh = moving_mesh(results, point, model, surface=True)
        self.whole = results.wave is not None and sector is None
        self.sectors = range(results.wave.sectors) if self.whole else [sector or 0]
        triangles = skin_rows(mesh.nodes, mesh.cells, MOST // len(self.sectors))
        self.rows = (triangles + len(mesh.nodes) * np.arange(len(self.sectors))[:, None, None]).reshape(-1, 3)
        self.places = np.concatenate([mesh.places(j) for j in self.sectors])
        self.eye, self.right, self.above = view(mesh.axis if self.whole else None, "xyz".index(up))
        self.instant = largest_at(mesh)
        largest = self.moved(self.instant)
        self.top = max(np.linalg.norm(largest, axis=1).max(), np.finfo(float).tiny)
        self.factor = enlargement(self.places, largest)
        light = LIGHT[0] * self.right + LIGHT[2] * self.above - LIGHT[1] * self.eye  # from the left and above, in front
        self.light = light / np.linalg.norm(light)

    def moved(self, theta):
        """(k, 3) how far all nodes are from their mean places."""
        return np.concatenate([self.mesh.displacement(theta, j, mean=False) for j in self.sectors])

    def look(self, theta):
        """Corners (f, 3, 2) of the triangles that are seen, the farthest first, and their colours, of motions up to `top`."""
        moved = self.moved(theta)
        corners, values = (self.places + self.factor * moved)[self.rows], np.linalg.norm(moved, axis=1)[self.rows].mean(axis=1)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
        seen = np.flatnonzero(normal @ self.eye > 0)
        seen = seen[np.argsort(corners[seen].mean(axis=1) @ self.eye)]
        colours = COLOURS(values[seen] / self.top)
        colours[:, :3] *= 0.5 + 0.5 * np.clip(normal[seen] @ self.light, 0, 1)[:, None]
        return np.stack([corners[seen] @ self.right, corners[seen] @ self.above], axis=2), colours


def _drawn(skin, thetas, results, point, hz):
    """A figure of the first of some phases, its polygons, and the looks of all."""
    looks = [skin.look(theta) for theta in thetas]
    flat = np.concatenate([corners.reshape(-1, 2) for corners, _ in looks])
    low, high = flat.min(axis=0), flat.max(axis=0)
    wide, tall = high - low
    corners, colours = looks[0]
    with plt.rc_context(STYLE):
        figure, axis = plt.subplots(figsize=(2.1 + 5.4 * np.clip(wide / tall, 0.75, 1.6), 6.4), layout="constrained")
        polygons = PolyCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.25)
        axis.add_collection(polygons)
        axis.set_aspect("equal")
        axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        axis.axis("off")
        unit = results.unit.length
        scale = plt.cm.ScalarMappable(norm=plt.Normalize(0, skin.top), cmap=COLOURS)
        bar = figure.colorbar(scale, ax=axis, shrink=0.6, aspect=30, format=formatter(unit))
        bar.set_label(labelled("distance from the mean place", unit))
        what = f"{len(skin.sectors)} sectors, engine order {results.wave.engine_order}" if skin.whole else f"sector {skin.sectors[0]}"
        what = f"{what}; " if results.wave is not None else ""
        figure.suptitle(f"{point_title(results, point, hz)}\n{what}motion {skin.factor:g} times as large")
    return figure, polygons, looks


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
