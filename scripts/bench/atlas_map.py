"""The map of the atlas: each scene a mark in the plane of contact stiffness and load, by method, and shares over the other dimensions."""

import matplotlib

matplotlib.use("Agg")
import atlas_table
import matplotlib.pyplot as plt
import numpy as np
from atlas_methods import DOVETAIL, METHODS, ORIGINAL, PLAIN
from matplotlib.transforms import blended_transform_factory

TITLES = {ORIGINAL: "the original", PLAIN: "plain adaptive", DOVETAIL: "Dovetail"}
SHADES = {ORIGINAL: ("#b2182b", "///"), PLAIN: ("#f4a582", "..."), DOVETAIL: ("#2166ac", "")}
MARKS = {  # shape, colour, size and name of each outcome; shapes tell them apart in black and white
    "arrived": ("o", "#9ecae1", 9, "finished"),
    "jumped": ("^", "#6a3d9a", 26, "finished on another branch, without a word"),
    "turned back": ("<", "#ff7f00", 26, "ran backwards"),
    "limit": ("+", "#636363", 34, "not within the time limit"),
    "stopped": ("x", "#e31a1c", 26, "stopped on the way"),
    "no start": ("s", "#000000", 15, "no first point"),
    "crashed": ("*", "#000000", 60, "crashed"),
}
SPAN = 3.0  # decades of force over static force shown; beyond, marks stand at the edge
BAND = (SPAN + 0.5, SPAN + 1.7)  # where scenes with an open gap and no static force stand, the small forces below
DIMENSIONS = ("separation", "friction", "damping", "contact points", "structure", "first step", "units")


def place(scene):
    """Coordinates of a scene: log10 k_n/K, and log10 of force over static force, or a place in the band of open gaps."""
    x = np.log10(scene["stiffness"])
    if scene["press"] <= 0:
        return x, np.interp(np.log10(scene["force"]), (-2, 2), BAND)
    return x, np.clip(np.log10(scene["force"] / scene["press"]), -SPAN, SPAN)


def panel(axis, rows, method):
    shown = [row for row in rows if row[method] is not None]
    for outcome, (shape, colour, size, _) in MARKS.items():
        places = np.array([place(row["scene"]) for row in shown if atlas_table.outcome(row, method) == outcome])
        if len(places):
            edge = {} if shape in "+x" else {"edgecolors": "#3182bd" if outcome == "arrived" else "black", "linewidths": 0.5}
            axis.scatter(*places.T, marker=shape, c=colour, s=size, zorder=2 if outcome == "arrived" else 3, **edge)
    axis.axhspan(*BAND, color="#f0f0f0", zorder=0)
    axis.text(0.02, np.mean(BAND), "open gap", transform=blended_transform_factory(axis.transAxes, axis.transData), va="center", size=7,
              color="#525252")
    number, part = atlas_table.share(rows, method)
    axis.set_title(f"{TITLES[method]}: {100 * part:.0f} % of {number} scenes", size=10)
    axis.set_xlim(-2.2, 4.2)
    axis.set_ylim(-SPAN - 0.3, BAND[1] + 0.2)
    axis.set_xticks(range(-2, 5), [f"$10^{{{k}}}$" for k in range(-2, 5)])
    axis.set_yticks(range(-3, 4), [f"$10^{{{k}}}$" for k in range(-3, 4)])
    axis.set_xlabel("$k_n / K$")
    axis.grid(color="#e0e0e0", linewidth=0.5)
    axis.set_axisbelow(True)


def bars(axis, rows):
    """Share of scenes finished, class by class of every other dimension."""
    ticks, labels, x = [], [], 0.0
    for dimension in DIMENSIONS:
        begins = x
        for label, test in atlas_table.groups()[dimension].items():
            chosen = [row for row in rows if test(row["scene"])]
            if not chosen:
                continue
            for i, method in enumerate(METHODS):
                colour, hatch = SHADES[method]
                axis.bar(x + 0.27 * (i - 1), 100 * atlas_table.share(chosen, method)[1], 0.27, color=colour, hatch=hatch, edgecolor="white",
                         linewidth=0.3, label=TITLES[method] if x == 0 else None)
            ticks.append(x)
            labels.append(f"{label} ({len(chosen)})")
            x += 1
        axis.text((begins + x - 1) / 2, 104, dimension, ha="center", size=8, weight="bold")
        x += 0.8
    axis.set_xticks(ticks, labels, rotation=55, ha="right", size=7)
    axis.set_xlim(-0.8, x - 1)
    axis.set_ylim(0, 124)
    axis.set_yticks(range(0, 101, 25))
    axis.set_ylabel("finished [%]")
    axis.grid(axis="y", color="#e0e0e0", linewidth=0.5)
    axis.set_axisbelow(True)


def draw(rows, path):
    figure = plt.figure(figsize=(12, 8.2))
    grid = figure.add_gridspec(2, 3, height_ratios=(1.35, 1), hspace=0.42, wspace=0.08, left=0.06, right=0.99, top=0.96, bottom=0.17)
    axes = [figure.add_subplot(grid[0, i]) for i in range(3)]
    for axis, method in zip(axes, METHODS):
        panel(axis, rows, method)
        if axis is not axes[0]:
            axis.tick_params(labelleft=False)
    axes[0].set_ylabel("force / static force on the contacts")
    handles = [plt.Line2D([], [], linestyle="", marker=shape, color=colour, markeredgecolor=colour if shape in "+x" else "black",
                          markeredgewidth=1.2 if shape in "+x" else 0.5, label=name)
               for outcome, (shape, colour, _, name) in MARKS.items()
               if any(atlas_table.outcome(row, method) == outcome for row in rows for method in METHODS)]
    figure.legend(handles=handles, loc="center", bbox_to_anchor=(0.525, 0.508), ncol=len(handles), frameon=False, fontsize=8,
                  handletextpad=0.1)
    below = figure.add_subplot(grid[1, :])
    bars(below, rows)
    below.legend(loc="upper right", fontsize=7, ncol=3)
    figure.savefig(path, dpi=100)
    plt.close(figure)
