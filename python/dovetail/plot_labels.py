"""Labels of places in a picture that do not lie on each other."""

from matplotlib.path import Path
from matplotlib.transforms import Bbox

OFFSETS = ((4, 4), (4, -9), (-4, 4), (-4, -9))  # tried in this order [points]
SIZE = 7  # of the letters [points]
MOST = 5  # labels of a kind
HALF = 2.5  # of a marker that is kept free [points]


def place_labels(axis, kinds, free=(), background=None, lines=()):
    """Writes text beside places where it is free; where nothing is, there is no label.

    To be called when everything else is in the picture.

    Parameters
    ----------
    kinds : list of lists of (x, y, text), the most important first; MOST labels of each
    free : list of (x, y), places of markers that no label may cover
    background : colour, optional; behind the letters
    lines : list of ((x, y), (x, y)), straight lines that labels leave free where they can
    """
    if not any(kinds):
        return
    figure = axis.figure
    figure.draw_without_rendering()  # settles the layout, of which labels are no part
    renderer = figure.canvas.get_renderer()
    legend = axis.get_legend()
    taken, frame = [legend.get_window_extent(renderer)] if legend else [], axis.get_window_extent(renderer)
    half = HALF * figure.dpi / 72
    taken += [Bbox([[x - half, y - half], [x + half, y + half]]) for x, y in map(axis.transData.transform, free)]
    lines = [Path(axis.transData.transform(ends)) for ends in lines]
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
                              horizontalalignment="left" if dx > 0 else "right",
                              bbox=behind)
        label.set_in_layout(False)
        box = label.get_window_extent(renderer)
        inside = frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1
        cut = any(line.intersects_bbox(box, filled=False) for line in lines)
        if inside and not cut and not any(box.overlaps(other) for other in taken):
            taken.append(box)
            return True
        label.remove()
    return False
