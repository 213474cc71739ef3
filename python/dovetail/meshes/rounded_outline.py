"""Bodies whose section is a symmetric polygon with rounded corners, as volumes of gmsh's OpenCASCADE kernel."""

import gmsh
import numpy as np


def extrude_outline(half, length):
    """Tag of the volume between x = -length/2 and length/2.

    half : list of (y, z, radius)
        Corners on the side y > 0, in the order of the outline, with the radius of rounding, 0 for none; the other side is its image.
    """
    occ = gmsh.model.occ
    corners = np.array([*half, *((-y, z, radius) for y, z, radius in reversed(half))])
    x = -length / 2
    curves, ends = [], []
    for before, corner, after in zip(np.roll(corners, 1, axis=0), corners, np.roll(corners, -1, axis=0)):
        start, centre, end = rounding(before[:2], corner[:2], after[:2], corner[2])
        first = occ.addPoint(x, *start)
        if corner[2] > 0:
            last = occ.addPoint(x, *end)
            curves.append((occ.addCircleArc(first, occ.addPoint(x, *centre), last),))
        else:
            last = first
            curves.append(())
        ends.append((first, last))
    loop = []
    for arc, (_, last), (following, _) in zip(curves, ends, ends[1:] + ends[:1]):
        loop += [*arc, occ.addLine(last, following)]
    face = occ.addPlaneSurface([occ.addCurveLoop(loop)])
    return next(tag for dim, tag in occ.extrude([(2, face)], length, 0, 0) if dim == 3)


def rounding(before, corner, after, radius):
    """Start, centre and end, each (2,), of the arc of `radius` that rounds a corner between two others."""
    back, on = (end - corner for end in (before, after))
    back, on = back / np.linalg.norm(back), on / np.linalg.norm(on)
    half_angle = np.arccos(np.clip(back @ on, -1, 1)) / 2
    distance = radius / np.tan(half_angle)
    middle = (back + on) / np.linalg.norm(back + on)
    return corner + distance * back, corner + radius / np.sin(half_angle) * middle, corner + distance * on
