"""Labels of places in a picture that do not lie on each other, and legends that cover nothing."""

import textwrap

import numpy as np
from matplotlib.path import Path
from matplotlib.transforms import Bbox

from .letters import lend_letters

OFFSETS = ((4, 4), (4, -9), (-4, 4), (-4, -9), (0, 6), (9, -3), (-9, -3), (0, -12))  # tried in this order [points]
SIZE = 7  # of the letters [points]
MOST = 5  # labels of a kind
HALF = 2.5  # of a marker that is kept free [points]
ROW = 0.22  # height of a row of a legend [inch]
WIDE = 72  # letters of a line of a legend above a panel
NARROW = 28  # letters of labels of which two stand side by side above a panel


def no_formula(text):
    """Text of the user's for a picture, in which dollars make no formula."""
    return text.replace("$", r"\$")


def folded(text, most):
    """A label of the user's in lines of `most` letters: a longer one would leave no room for the panel."""
    return "\n".join(textwrap.wrap(no_formula(text), most, break_on_hyphens=False)) or " "


def rows_of(labels):
    """Rows and columns of the legend above a panel."""
    columns = 2 if len(labels) > 2 and max(map(len, labels)) <= NARROW else 1
    return sum(1 + label.count("\n") for label in labels[::columns]), columns


def legend_above(axis, columns=1):
    """The legend over the panel, where no curve is."""
    axis.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2, borderpad=0.2, ncols=columns, handlelength=3.2)


def curves_in(axis):
    """Lines of a panel, as `place_labels` wants them; those broken by NaN in pieces."""
    pieces = []
    for line in axis.lines:
        xy = np.ma.filled(np.ma.asarray(line.get_xydata(), float), np.nan)
        if line.get_linestyle() != "None" and line.get_transform() == axis.transData:
            known = np.isfinite(xy).all(axis=1)
            pieces += [piece[np.isfinite(piece).all(axis=1)] for piece in np.split(xy, np.flatnonzero(~known))]
    return [piece for piece in pieces if len(piece) > 1]


def place_labels(axis, kinds, free=(), background=None, lines=()):
    """Writes text beside places where it is free; where nothing is, there is no label.

    To be called when everything else is in the picture.

    Parameters
    ----------
    kinds : list of lists of (x, y, text), the most important first; MOST labels of each
    free : list of (x, y), places of markers that no label may cover
    background : colour, optional; behind the letters
    lines : list of (k, 2), lines from place to place that labels leave free where they can
    """
    if not any(kinds):
        return
    figure = axis.figure
    lend_letters(figure)
    figure.draw_without_rendering()  # settles the layout, of which labels are no part
    renderer = figure.canvas.get_renderer()
    legend = axis.get_legend()
    taken, frame = [legend.get_window_extent(renderer)] if legend else [], axis.get_window_extent(renderer)
    half = HALF * figure.dpi / 72
    taken += [Bbox([[x - half, y - half], [x + half, y + half]]) for x, y in map(axis.transData.transform, free)]
    lines = [Path(axis.transData.transform(places)) for places in lines]
    for wanted in kinds:
        written = 0
        for place in wanted:
            written += any(_written(axis, place, taken, others, frame, renderer, background) for others in ([lines, []] if lines else [[]]))
            if written == MOST:
                break


def _written(axis, place, taken, lines, frame, renderer, background):
    """Whether there is room for a label; its box is `taken` then."""
    x, y, text = place
    behind = {"facecolor": background, "edgecolor": "none", "alpha": 0.85, "pad": 0.5} if background else None
    for dx, dy in OFFSETS:
        label = axis.annotate(text, (x, y), xytext=(dx, dy), textcoords="offset points", fontsize=SIZE,
                              horizontalalignment="left" if dx > 0 else "right" if dx < 0 else "center", bbox=behind)
        label.set_in_layout(False)
        box = label.get_window_extent(renderer)
        inside = frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1
        cut = any(line.intersects_bbox(box, filled=False) for line in lines)
        if inside and not cut and not any(box.overlaps(other) for other in taken):
            taken.append(box)
            return True
        label.remove()
    return False
