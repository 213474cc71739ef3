"""Picture of the sector: assembled, and the root drawn out of its slot with flanks and contact points."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from dovetail.cells import outer_faces  # noqa: E402

COLORS = {"blade": (0.66, 0.74, 0.84), "disk": (0.84, 0.81, 0.74), "airfoil": (0.95, 0.80, 0.47), "flanks": (0.84, 0.28, 0.12)}
LIGHT = np.array([0.15, -0.75, 0.65]) / np.linalg.norm([0.15, -0.75, 0.65])
PIXEL = 1e-4  # [m]
OUT = np.array([-0.075, 0, 0])  # how far the root is drawn out [m]


def draw(solid, joints, path):
    """Write a PNG. solid: dovetail.Structure; joints: list of Joint, the first one on the side that is seen."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 6.4), gridspec_kw={"width_ratios": [1, 1.45]}, layout="constrained")
    whole, frame = _scene(solid, 0 * OUT, azimuth=-62, elevation=22)
    _show(left, whole, solid.nodes @ frame)
    left.set_title("sector, pressure side in yellow", fontsize=10)
    apart, frame = _scene(solid, OUT, azimuth=-52, elevation=14)
    blade = solid.nodes[solid.node_sets["blade"]]
    _show(right, apart, np.vstack([blade[blade[:, 2] < 0.325] + OUT, solid.nodes[solid.node_sets["disk"]]]) @ frame)
    points = (joints[0].position + OUT) @ frame
    right.plot(points[:, 0], points[:, 1], "o", color="black", markersize=2.2)
    right.set_title("root drawn out of its slot, flanks in red with contact points", fontsize=10)
    figure.savefig(path, dpi=100, pil_kwargs={"optimize": True})
    plt.close(figure)


def _scene(solid, out, azimuth, elevation):
    """Corners (t, 3, 3) and colours (t, 3) of the triangles that look at the eye, in one array (t, 4, 3), and the axes of the view (3, 3):
    right, up, towards the eye, as columns."""
    a, e = np.radians([azimuth, elevation])
    eye, right = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)]), np.array([-np.sin(a), np.cos(a), 0])
    frame = np.column_stack([right, np.cross(eye, right), eye])
    flanks = np.concatenate([rows for name, rows in solid.node_sets.items() if name.startswith(("flank", "slot"))])
    parts = []
    for body, move in (("blade", out), ("disk", 0 * out)):
        for faces in outer_faces(solid.nodes, solid.cells, _mask(solid, solid.node_sets[body])):
            X = solid.nodes[faces[:, :3]] + move
            normal = np.cross(X[:, 1] - X[:, 0], X[:, 2] - X[:, 0])
            normal /= np.linalg.norm(normal, axis=1, keepdims=True)
            color = np.tile(COLORS[body], (len(faces), 1))
            for name, rows in (("airfoil", solid.node_sets["airfoil"]), ("flanks", flanks)):
                color[_mask(solid, rows)[faces].all(axis=1)] = COLORS[name]
            color *= (0.5 + 0.45 * np.clip(normal @ LIGHT, 0, 1) + 0.05 * np.clip(normal @ eye, 0, 1))[:, None]
            parts.append(np.concatenate([X @ frame, color[:, None]], axis=1)[normal @ eye > 0])
    return np.concatenate(parts), frame


def _show(axis, triangles, bounds):
    """The triangles (t, 4, 3) of `_scene`, nearest ones in front, as far as they lie within the box around `bounds` (n, 3)."""
    low, high = bounds[:, :2].min(axis=0), bounds[:, :2].max(axis=0)
    columns, rows = np.ceil((high - low) / PIXEL).astype(int)
    image, depth = np.ones((rows, columns, 3)), np.full((rows, columns), -np.inf)
    for *corners, color in triangles:
        _fill(image, depth, np.array(corners), color, low)
    axis.imshow(image, origin="lower", extent=(low[0], high[0], low[1], high[1]), interpolation="antialiased")
    axis.axis("off")


def _fill(image, depth, corners, color, low):
    """One triangle into the image, where nothing nearer is there yet; darker along its edges."""
    at = (corners[:, :2] - low) / PIXEL
    begin = np.maximum(np.floor(at.min(axis=0)).astype(int), 0)
    end = np.minimum(np.ceil(at.max(axis=0)).astype(int) + 1, image.shape[1::-1])
    if np.any(begin >= end):
        return
    x, y = np.meshgrid(*(np.arange(b, e) + 0.5 for b, e in zip(begin, end)))
    (ax, ay), (bx, by), (cx, cy) = at
    twice = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    if twice <= 0:
        return
    doubles = np.stack([(cx - bx) * (y - by) - (cy - by) * (x - bx), (ax - cx) * (y - cy) - (ay - cy) * (x - cx),
                        (bx - ax) * (y - ay) - (by - ay) * (x - ax)])  # twice the areas of the parts, anticlockwise positive
    z = np.tensordot(corners[:, 2], doubles / twice, 1)
    window = slice(begin[1], end[1]), slice(begin[0], end[0])
    seen = (doubles >= 0).all(axis=0) & (z > depth[window])
    sides = np.linalg.norm([at[2] - at[1], at[0] - at[2], at[1] - at[0]], axis=1)
    edge = (doubles / sides[:, None, None]).min(axis=0) < 0.7
    depth[window][seen] = z[seen]
    image[window][seen] = np.where(edge[seen, None], 0.86, 1.0) * np.clip(color, 0, 1)


def _mask(solid, rows):
    mask = np.zeros(len(solid.nodes), dtype=bool)
    mask[rows] = True
    return mask
