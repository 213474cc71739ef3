"""A curve drawn with characters, for terminals."""

import numpy as np

from .curves import pieces

LEFT = 12  # columns for numbers of the vertical axis
STEPS = 4  # of a line between two points, for each column or row that it crosses


def text_plot(x, y, width=80, height=20, jumps=(), labels=("", "")):
    """Lines of text: y, not negative, over x as a curve of asterisks, the last point as @.

    x, y : (n,), n at least 1; jumps : points behind which the curve goes on elsewhere; labels : of both axes. Points that are
    not finite are left out.
    """
    columns, rows = max(10, width - LEFT - 2), max(4, height - 3)
    finite = np.isfinite(x) & np.isfinite(y)
    if not finite.any():
        return ["  no finite number to draw"]
    low, high, top = x[finite].min(), x[finite].max(), y[finite].max() or 1.0
    across = (x - low) / (high - low if high > low else 1.0) * (columns - 1)
    up = y / top * (rows - 1)
    grid = np.full((rows, columns), " ")
    for piece in pieces(len(x), np.asarray(jumps, dtype=int)):
        a, b = across[piece], up[piece]
        drawn = finite[piece]
        for i in np.flatnonzero(drawn):
            j = i + 1 if i + 1 < len(a) and drawn[i + 1] else i
            n = 1 + STEPS * int(np.ceil(max(abs(a[j] - a[i]), abs(b[j] - b[i]))))
            grid[np.linspace(b[i], b[j], n).round().astype(int), np.linspace(a[i], a[j], n).round().astype(int)] = "*"
    if finite[-1]:
        grid[int(round(up[-1])), int(round(across[-1]))] = "@"
    marks = {rows - 1: f"{top:.4g}", (rows - 1) // 2: f"{top * ((rows - 1) // 2) / (rows - 1):.4g}", 0: "0"}
    lines = [" " * 2 + labels[1]]
    lines += [f"{marks.get(row, ''):>{LEFT - 1}} |{''.join(grid[row])}".rstrip() for row in reversed(range(rows))]
    ends = f"{low:.6g}", f"{high:.6g}"
    middle = labels[0][:max(0, columns - sum(map(len, ends)) - 2)]
    lines.append(" " * LEFT + "+" + "-" * columns)
    lines.append(" " * (LEFT + 1) + ends[0] + middle.center(columns - sum(map(len, ends))) + ends[1])
    return lines
