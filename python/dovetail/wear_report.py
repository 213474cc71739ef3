"""What `wear` has found, as text, tables and a picture."""

import csv

import numpy as np

from .motion import find_joint
from .plot_labels import no_formula
from .plot_units import dress, labelled
from .saved_picture import save_picture
from .units import with_unit

CURVES = ("cycles", "amplitude", "frequency", "clamp_load", "power", "largest_depth", "volume")


def columns(found):
    """Name to (unit, numbers over the cycles)."""
    unit, moments = found.results.unit, found.moments
    values = {"cycles": ("", [moment.cycles for moment in moments]),
              "amplitude": (found.results.unit_of(found.dof), [moment.amplitude for moment in moments]),
              "frequency": ("Hz", [unit.hertz(moment.omega) for moment in moments]),
              "clamp_load": (unit.force, [moment.clamp for moment in moments]),
              "power": ("W" if unit.energy == "J" else f"{unit.energy}/s" if unit.known else "",
                        [unit.hertz(moment.omega) * moment.energy.sum() for moment in moments]),
              "largest_depth": (unit.length, [moment.depth.max() for moment in moments]),
              "volume": (f"{unit.length}^3" if unit.known else "", found.volume)}
    return {name: (label, np.array(numbers, dtype=float)) for name, (label, numbers) in values.items()}


def write(found, out):
    """wear.csv, depth.csv, wear.txt and wear.png; prints the text, and where they are."""
    joint = _joint(found.results)
    table = columns(found)
    _table(out / "wear.csv", {name: (unit, values) for name, (unit, values) in table.items()})
    _table(out / "depth.csv", _points(found, joint))
    text = "\n".join(in_words(found, table))
    (out / "wear.txt").write_text(text + "\n")
    save_picture(picture(found, table, joint), out / "wear.png")
    print(text)
    print(f"\n{out}: wear.csv (over the cycles), depth.csv (of every contact point), wear.txt, wear.png")


def in_words(found, table):
    first, last, unit = found.moments[0], found.moments[-1], found.results.unit
    motion = "the peak" if found.at is None else f"{found.results.place(first.omega, 6)}"
    head = [f"wear of {found.results.title or found.results.path}: {last.cycles:.6g} cycles of the motion at {motion} of {found.dof}",
            f"{len(found.moments) - 1} blocks; in each a point loses at most {100 * found.share:g} % of how far it is pressed in",
            f"{'':<16}{'unworn':>14}{'worn':>14}"]
    names = {name: name.replace("_", " ") for name in CURVES[1:]}
    rows = [f"{names[name]:<16}{values[0]:>14.5g}{values[-1]:>14.5g}" + (f"  [{label}]" if label else "")
            for name, (label, values) in table.items() if name in names]
    deepest = int(np.argmax(last.depth))
    depth, linear = (with_unit(f"{value:.5g}", unit.length) for value in (last.depth[deepest], last.cycles * first.rate[deepest]))
    return head + rows + [f"deepest at contact point {deepest + 1}, {depth}; linear from the unworn state it would be {linear}"]


def _joint(results):
    try:
        return find_joint(results)
    except ValueError:  # places are not known
        return None


def _points(found, joint):
    """Columns of depth.csv."""
    last, unit = found.moments[-1], found.results.unit
    table = {"contact": ("", np.arange(1, len(last.depth) + 1))}
    if joint is not None:
        table |= {axis: (unit.length, joint["position"][:, i]) for i, axis in enumerate("xyz")}
    return table | {"area": (unit.area.replace("²", "^2"), found.area), "depth": (unit.length, last.depth),
                    "depth_per_cycle": (unit.length, last.rate)}


def _table(path, table):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([f"{name} [{unit}]" if unit else name for name, (unit, _) in table.items()])
        writer.writerows([f"{value:.12g}" for value in row] for row in zip(*(values for _, values in table.values())))


def picture(found, table, joint):
    """Five curves over the cycles, and the depth of every contact point."""
    import matplotlib.pyplot as plt

    from .plot import STYLE

    what = {"largest_depth": "largest depth", "amplitude": f"amplitude of {found.dof}", "frequency": "frequency",
            "clamp_load": "clamp load", "power": "friction power"}
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(2, 3, figsize=(11, 6), layout="constrained")
        for axis, (name, label) in zip(axes.flat, what.items()):
            unit, values = table[name]
            axis.plot(table["cycles"][1], values, "o-", color="black", markersize=3)
            dress(axis.yaxis, label, unit)
            axis.set_xlabel("cycles")
            axis.ticklabel_format(axis="x", style="sci", scilimits=(-3, 4))
            axis.locator_params(axis="x", nbins=5)
            spread = np.ptp(values)
            if spread < 1e-6 * np.abs(values).max():  # ticks of round-off say nothing
                axis.set_ylim(0, 1.2 * np.abs(values).max())
        _map(axes.flat[-1], found, joint)
        figure.suptitle(no_formula(found.results.title or found.results.path.name))
    return figure


def _map(axis, found, joint):
    """Depths at their places in the plane of the joint, of several joints or of unknown places one beside the other by number."""
    import matplotlib.pyplot as plt

    from .contact_map import COLOURS, dress as dress_places, marker_area, scale
    from .joint_plane import in_plane, lying
    from .plot_units import formatter

    depth, unit = found.moments[-1].depth, found.results.unit.length
    if joint is None or len(joint["names"]) > 1 or len(depth) < 3:
        axis.bar(np.arange(1, len(depth) + 1), depth, color="#7f7f7f", edgecolor="black", linewidth=0.5)
        axis.set_xlabel("contact point")
        axis.xaxis.get_major_locator().set_params(integer=True)
        return dress(axis.yaxis, "depth", unit)
    places, names = lying(in_plane(joint["position"], joint["axes"]))
    top = max(depth.max(), np.finfo(float).tiny)
    axis.scatter(*places.T, s=marker_area(places, 3.0), c=depth, cmap=COLOURS, vmin=0, vmax=top, edgecolors="black", linewidths=0.6)
    dress_places(axis, places, names, unit)
    axis.set_title(labelled("depth", unit), loc="left", fontsize=10)
    scale(axis, plt.cm.ScalarMappable(norm=plt.Normalize(0, top), cmap=COLOURS), formatter=formatter(unit))
