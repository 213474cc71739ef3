"""Pictures before a run: the skin of a mesh with its contact points, and joints with their normals, areas and gaps."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: E402
from mpl_toolkits.mplot3d.proj3d import proj_transform  # noqa: E402

from .cells import outer_faces  # noqa: E402
from .contact_map import COLOURS, dress, marker_area, panel_height, scale  # noqa: E402
from .joint_plane import in_plane  # noqa: E402
from .letters import lend_letters  # noqa: E402
from .plot import LINES, STYLE  # noqa: E402
from .plot_labels import no_formula  # noqa: E402
from .plot_units import dress as dress_axis, formatter, labelled  # noqa: E402
from .units import parse, with_unit  # noqa: E402

MOST_TRIANGLES = 40000  # drawn; beyond it nodes are merged on a coarser and coarser lattice
LIGHT = np.array([-0.3, -0.75, 0.6])
ELEVATION, AZIMUTH = 22.0, -58.0  # of the eye [degrees]
HIGHEST = 0.92  # of a picture in space: above, the title
METAL = np.array([0.62, 0.67, 0.73])


def mesh_picture(mesh, joint=None, up="z", title="", units="SI"):
    """The outer skin of a mesh, shaded, and its contact points.

    Parameters
    ----------
    mesh, joint : dict
        As in `Model`; joint may be None.
    up : "x", "y" or "z"
        The axis that points upwards.
    units : str
        Of the model.
    """
    triangles = skin(mesh["nodes"], mesh["cells"])
    if not len(triangles):
        raise ValueError(f"the mesh has no cells with faces, only {', '.join(sorted(mesh['cells'])) or 'none'}")
    order = {"x": [1, 2, 0], "y": [2, 0, 1], "z": [0, 1, 2]}[up]  # what is drawn as x, y, z
    corners = _finer(triangles[:, :, order], np.ptp(triangles.reshape(-1, 3), axis=0).max() / 50)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    eye = np.radians([ELEVATION, AZIMUTH])
    eye = np.array([np.cos(eye[0]) * np.cos(eye[1]), np.cos(eye[0]) * np.sin(eye[1]), np.sin(eye[0])])
    seen = normal @ eye > 0
    corners, normal = corners[seen], normal[seen]
    brightness = 0.45 + 0.55 * np.clip(normal @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1)
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(7.5, 6.5))
        axis = figure.add_subplot(projection="3d", proj_type="ortho", computed_zorder=False)
        colours = np.clip(METAL * brightness[:, None] * 1.25, 0, 1)
        axis.add_collection3d(Poly3DCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.3))
        if joint is not None:
            _points(axis, joint["position"][:, order], joint["joint"], joint["names"])
        _view(axis, triangles.reshape(-1, 3)[:, order], ["xyz"[i] for i in order], parse(units).length)
        _head(figure, axis, triangles.reshape(-1, 3)[:, order], title)
    return figure


def _head(figure, axis, places, title):
    """The title, and the legend if there is one, close above the mesh, which may leave much of its square empty."""
    lend_letters(figure)
    figure.draw_without_rendering()
    to_figure = axis.transData + figure.transFigure.inverted()
    top = to_figure.transform(np.column_stack(proj_transform(*places.T, axis.get_proj())[:2]))[:, 1].max() + 0.02
    height = 0.0
    if legend := axis.get_legend():
        box = legend.get_window_extent().transformed(figure.transFigure.inverted())
        height, top = box.height, min(top, HIGHEST - box.height)
        legend.set_bbox_to_anchor((box.x0, top, 0, height), figure.transFigure)
    if title:
        figure.suptitle(no_formula(title), y=min(top + height, HIGHEST) + 0.02, va="bottom")


def joint_picture(joints, units="SI"):
    """Joints before they are used: for each its points with normals in space, and area and gap in its plane.

    joints : list of Joint, or one
    units : str
        Of the model.
    """
    unit = parse(units)
    joints = list(joints) if isinstance(joints, (list, tuple)) else [joints]
    flat = [in_plane(joint.position, joint.axes) for joint in joints]
    tall = [max(panel_height(places, 2.9), 2.8) for places in flat]
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(11.5, 0.4 + sum(tall)), layout="constrained")
        figure.get_layout_engine().set(rect=(0.33, 0, 0.67, 1))  # to its left the pictures in space, which no layout can measure
        grid = figure.add_gridspec(len(joints), 2, height_ratios=tall)
        for row, (joint, places) in enumerate(zip(joints, flat)):
            height = tall[row] / sum(tall)
            box = (0.02, 1 - sum(tall[:row + 1]) / sum(tall) + 0.1 * height, 0.27, 0.8 * height)
            _in_space(figure.add_axes(box, projection="3d", proj_type="ortho"), joint, unit.length)
            size = float(np.ptp(joint.position, axis=0).max()) or 1.0
            _in_plane(figure.add_subplot(grid[row, 0]), places, joint.area, "area", unit.area, size**2, unit.length)
            _in_plane(figure.add_subplot(grid[row, 1]), places, joint.contact["gap"], "gap", unit.length, size, unit.length)
    return figure


def skin(nodes, cells):
    """Triangles (f, 3, 3) of the outer faces, in corner nodes only, no more than about MOST_TRIANGLES."""
    return nodes[skin_rows(nodes, cells, MOST_TRIANGLES)]


def skin_rows(nodes, cells, most):
    """Rows of nodes (f, 3) of these triangles, no more than about `most` unless the mesh is tiny."""
    rows = [np.empty((0, 3), dtype=np.int64)]
    for faces in outer_faces(nodes, cells):
        rows.append(faces[:, [0, 1, 2]])
        if faces.shape[1] in (4, 8):
            rows.append(faces[:, [0, 2, 3]])
    triangles = np.concatenate(rows)
    extent = np.ptp(nodes[triangles.ravel()], axis=0).max() if len(triangles) else 0.0
    lattice = 256
    while len(triangles) > most and lattice > 8:
        triangles = _merged(nodes, triangles, extent / lattice)
        lattice = int(lattice / 1.4)
    return triangles


def _finer(triangles, size):
    """Triangles (f, 3, 3) cut in four until no edge is longer than `size`: the nearer of two is found out only between small ones."""
    done = []
    while len(triangles) and sum(map(len, done)) + len(triangles) < MOST_TRIANGLES:
        long = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1) > size
        done.append(triangles[~long])
        a, b, c = triangles[long].transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        triangles = np.concatenate([np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return np.concatenate([*done, triangles])


def _merged(nodes, triangles, size):
    """Without triangles smaller than a box of the lattice: all nodes in a box become the one nearest to its middle."""
    used = np.unique(triangles)
    box = np.floor((nodes[used] - nodes[used].min(axis=0)) / size)
    off_centre = np.linalg.norm((nodes[used] - nodes[used].min(axis=0)) / size - box - 0.5, axis=1)
    _, group = np.unique(box, axis=0, return_inverse=True)
    order = np.lexsort((off_centre, group))
    first = used[order[np.unique(group[order], return_index=True)[1]]]
    target = np.arange(len(nodes))
    target[used] = first[group]
    merged = target[triangles]
    whole = (merged[:, 0] != merged[:, 1]) & (merged[:, 1] != merged[:, 2]) & (merged[:, 0] != merged[:, 2])
    merged = merged[whole]
    return merged[np.unique(np.sort(merged, axis=1), axis=0, return_index=True)[1]]


def _points(axis, places, number, names):
    for i, name in enumerate(names):
        mine = number == i
        colour, marker = LINES[(i + 1) % len(LINES)][0], "os^Dv<>"[i % 7]
        axis.scatter(*places[mine].T, s=12 if mine.sum() < 500 else 3, color=colour, marker=marker, edgecolors="white", linewidths=0.3,
                     depthshade=False, label=f"{name} ({mine.sum()})", zorder=10)
    axis.legend(loc="upper left", title="contact points", alignment="left")


def _in_space(axis, joint, length):
    size = np.ptp(joint.position, axis=0).max() or 1.0
    axis.scatter(*joint.position.T, s=8, color="black", depthshade=False)
    axis.quiver(*joint.position.T, *(0.12 * size * joint.axes[:, 2].T), color=LINES[1][0], linewidths=0.8, arrow_length_ratio=0.3)
    axis.set_in_layout(False)
    axis.set_title(f"{joint.name}: {len(joint)} points, normals", fontsize=10)
    _view(axis, np.vstack([joint.position, joint.position + 0.12 * size * joint.axes[:, 2]]), "xyz", length, ELEVATION + 10)


def _view(axis, places, names, length, elevation=ELEVATION):
    """Equal scales, the eye in its place, ticks along the longer sides only."""
    low, high = places.min(axis=0), places.max(axis=0)
    least = 0.15 * (high - low).max() or 1.0
    middle, half = (low + high) / 2, np.maximum(high - low, least) / 2
    for set_limits, m, h in zip((axis.set_xlim, axis.set_ylim, axis.set_zlim), middle, half):
        set_limits(m - h, m + h)
    axis.set_box_aspect(half, zoom=0.95)
    axis.view_init(elevation, AZIMUTH)
    for line, name, h in zip((axis.xaxis, axis.yaxis, axis.zaxis), names, half):
        line.set_pane_color((1, 1, 1, 0))
        if h < 0.4 * half.max():
            line.set_major_locator(plt.NullLocator())
            continue
        dress_axis(line, name, length)
        line.labelpad = 8  # clear of the numbers
        line.set_major_locator(plt.MaxNLocator(3))
    axis.zaxis.set_tick_params(pad=1)
    plt.setp(axis.get_zticklabels(), ha="left")


def _in_plane(axis, places, values, label, unit, size, length):
    """One quantity of the contact points; differences below round-off of `size` are none."""
    low, high = float(np.min(values)), float(np.max(values))
    style = {"s": marker_area(places, 2.9), "edgecolors": "black", "linewidths": 0.5}
    if high - low > 1e-10 * size:
        scale(axis, axis.scatter(*places.T, c=values, cmap=COLOURS, **style), labelled(label, unit), formatter(unit))
    else:
        axis.scatter(*places.T, color=COLOURS(0.3), **style)
        value = 0.0 if abs(high) < 1e-10 * size else high
        axis.set_title(f"{label}: {formatter(unit)(value) if formatter(unit) else with_unit(f'{value:.4g}', unit)} everywhere", fontsize=10)
    dress(axis, places, length=length)
