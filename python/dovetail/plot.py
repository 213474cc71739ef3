"""Pictures of a results file: response curve, time history, friction loops. Readable in black and white."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.ticker import EngFormatter, MaxNLocator  # noqa: E402

from .reference import LAWS  # noqa: E402
from .results import DIRECTIONS, STABLE, UNCERTAIN, UNSTABLE  # noqa: E402

LINES = [("#000000", "-"), ("#c1440e", "--"), ("#1f6f9f", "-."), ("#6a9a1f", ":"), ("#8a4f9e", (0, (6, 1, 1, 1, 1, 1))),
         ("#7f7f7f", (0, (1, 1)))]  # colours of falling darkness, each with its own dash pattern
STYLE = {"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e3e3e3",
         "grid.linewidth": 0.7, "lines.linewidth": 1.5, "legend.frameon": False, "figure.dpi": 160, "axes.axisbelow": True}
LOOP_SAMPLES = 1024  # per period, so that corners of a friction loop look like corners
MARKERS = "s^Dvo"  # tell degrees of freedom apart where dashes are taken up by stability
DASHES = {STABLE: "-", UNSTABLE: (0, (5, 2.5)), UNCERTAIN: (0, (1, 1.5))}
MOST_LABELS = 5  # of each kind of place
NEGLIGIBLE = 0.01  # a direction that moves less than this part of the largest one is left out of the default picture


def default_dofs(results):
    """The three directions of the contact point that moves most, without those that hardly move."""
    size = np.sqrt(np.sum(results.coefficients[:, results.modes:, 1:] ** 2, axis=2)).max(axis=0)
    j = int(np.argmax(size)) // 3
    moving = size[3 * j:3 * j + 3] > NEGLIGIBLE * size.max()
    return [f"x{j + 1}.{d}" for d, moves in zip(DIRECTIONS, moving) if moves] or [f"x{j + 1}.t1"]


def response(results, dofs=None, at=None, hz=False):
    """Amplitude over excitation frequency; beneath, the share of contact points that slip or are open at some time.

    Where some points are not stable, unstable parts are dashed and uncertain ones dotted. Circles are peaks, triangles turning
    points (they point to where the curve goes on).

    Parameters
    ----------
    results : Results
    dofs : list of str, optional
        Default: `default_dofs`. Modal and contact unknowns get a panel each.
    at : float, optional
        A frequency [rad/s] to mark.
    hz : bool
        Frequency axis in Hz instead of rad/s.
    """
    dofs = dofs or default_dofs(results)
    kinds = {"contact": [], "modal": []}
    for dof in dofs:
        kinds["modal" if results.dof_index(dof) < results.modes else "contact"].append(dof)
    panels = [names for names in kinds.values() if names]
    scale, unit = (1 / (2 * np.pi), "Hz") if hz else (1.0, "rad/s")
    mixed = results.stable is not None and np.any(results.stable != STABLE)
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(len(panels) + 1, 1, sharex=True, figsize=(7.5, 2.0 + 3.2 * len(panels)),
                                    gridspec_kw={"height_ratios": [3.2] * len(panels) + [1]}, layout="constrained")
        for axis, names in zip(axes, panels):
            for i, dof in enumerate(names):
                omega, top = results.peak(dof)
                label = f"{dof}   peak {_value(results, dof, top)} at {scale * omega:.5g} {unit}"
                amplitude = results.amplitude(dof)
                if mixed:
                    _curve_by_stability(axis, results, scale * results.omega, amplitude, i, label)
                else:
                    axis.plot(scale * results.omega, amplitude, **_line(i), label=label, marker="o" if len(results) == 1 else None)
                axis.plot(scale * omega, top, "o", color=_line(i)["color"], markersize=4, markerfacecolor="white")
                _places(axis, results, dof, scale * results.omega, amplitude, i)
            axis.set_ylim(bottom=0)
            if mixed:
                for verdict, words in ((UNSTABLE, "unstable"), (UNCERTAIN, "stability uncertain")):
                    if np.any(results.stable == verdict):
                        axis.plot([], [], color="black", linestyle=DASHES[verdict], label=words)
            axis.set_ylabel("amplitude" + _unit(results, names[0]))
            _ticks_in_metres(axis.yaxis, results, names[0])
            axis.legend(loc="best", handlelength=3.2, frameon=True, framealpha=0.85, edgecolor="none")
        for i, state in enumerate(("slip", "open")):
            axes[-1].plot(scale * results.omega, 100 * results.points(state), **_line(i), label=state)
        axes[-1].set(ylim=(-4, 104), yticks=(0, 50, 100), ylabel="points [%]", xlabel=f"excitation frequency [{unit}]")
        axes[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2)
        if at is not None:
            for axis in axes:
                axis.axvline(scale * at, color="#9a9a9a", linewidth=0.8)
        figure.suptitle(results.title or results.path.name)
    return figure


def verdicts_between(results):
    """Verdict on the piece of curve behind each point but the last, (n-1,).

    At a turning point, or where stability changes, a verdict is a toss-up: there the other end of the piece decides.
    """
    here, there = results.stable[:-1].copy(), results.stable[1:].copy()
    limits = np.isin(np.arange(len(results)), results.events.of("fold", "stability", "branch").point)
    here[limits[:-1]], there[limits[1:]] = there[limits[:-1]], here[limits[1:]]
    return np.where(here == there, here, np.where((here == UNCERTAIN) | (there == UNCERTAIN), UNCERTAIN, UNSTABLE))


def _curve_by_stability(axis, results, omega, amplitude, i, label):
    verdicts = verdicts_between(results)
    style = {"color": _line(i)["color"], "marker": MARKERS[i % len(MARKERS)], "markersize": 4}
    for verdict, dashes in DASHES.items():
        drawn = np.zeros(len(results), bool)
        drawn[:-1] = verdicts == verdict
        drawn[1:] |= verdicts == verdict
        if not drawn.any():
            continue
        gaps = 1 + np.flatnonzero(verdicts != verdict)  # pieces left out
        x, y = (np.insert(np.where(drawn, values, np.nan), gaps, np.nan) for values in (omega, amplitude))
        axis.plot(x, y, color=style["color"], linestyle=dashes)
    axis.plot(omega, amplitude, linestyle="none", markevery=0.15, **style)
    axis.plot([], [], **style, label=label)


def _places(axis, results, dof, omega, amplitude, i):
    """Marks located peaks and turning points, the largest with their values."""
    peaks, folds = results.located_peaks(dof), results.events.of("fold").point
    style = {"color": _line(i)["color"], "markerfacecolor": "white", "linestyle": "none"}
    axis.plot(omega[peaks], amplitude[peaks], "o", markersize=4, **style)
    rising = omega[np.minimum(folds + 1, len(omega) - 1)] > omega[folds]
    for to, marker in ((True, ">"), (False, "<")):
        axis.plot(omega[folds[rising == to]], amplitude[folds[rising == to]], marker, markersize=5, **style)
    if i > 0:  # numbers of several curves would cover each other
        return
    for places, value in ((peaks, lambda j: _value(results, dof, amplitude[j])), (folds, lambda j: f"{omega[j]:.5g}")):
        for j in places[np.argsort(-amplitude[places])][:MOST_LABELS]:
            axis.annotate(value(j), (omega[j], amplitude[j]), xytext=(4, 4), textcoords="offset points", fontsize=7)


def history(results, point, dofs=None, hz=False):
    """One period of motion, measured from the preload state."""
    dofs = dofs or default_dofs(results)
    with plt.rc_context(STYLE):
        figure, axis = plt.subplots(figsize=(7.5, 3.8), layout="constrained")
        for i, dof in enumerate(dofs):
            t, q = results.time_history(point, dof, 512)
            period = 2 * np.pi / results.omega[point]
            axis.plot(np.append(t, period), np.append(q, q[0]), **_line(i), label=dof)
        axis.set(xlim=(0, period), xlabel="time", ylabel="displacement from preload" + _common_unit(results, dofs))
        axis.xaxis.set_major_formatter(EngFormatter("s"))
        if all(results.dof_index(dof) >= results.modes for dof in dofs):
            _ticks_in_metres(axis.yaxis, results, dofs[0])
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2)
        axis.set_title(_point_title(results, point, hz))
    return figure


def hysteresis(results, point, dofs=None, hz=False):
    """Friction loops: tangential force over displacement; heavy where the point slips, light where it sticks.

    `dofs` are tangential ones ("x2.t1"); default: those of `default_dofs`.
    """
    if not dofs:
        moving = default_dofs(results)
        dofs = [dof for dof in moving if not dof.endswith(".n")] or [moving[0].replace(".n", ".t1")]
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, len(dofs), figsize=(0.6 + 3.9 * len(dofs), 3.9), layout="constrained", squeeze=False)
        for axis, dof in zip(axes[0], dofs):
            _loop(axis, results, point, dof)
        figure.suptitle(_point_title(results, point, hz))
    return figure


def _loop(axis, results, point, dof):
    index = results.dof_index(dof) - results.modes
    if index < 0 or index % 3 == 2:
        raise ValueError(f"a friction loop needs a tangential direction such as x1.t1, found {dof!r}")
    contact, direction = index // 3 + 1, index % 3
    law = LAWS[results.contact["law"][contact - 1]]
    if law in ("unilateral", "bilateral"):
        raise ValueError(f"contact point {contact} has no friction loop: its law is {law}")
    x, T = results.hysteresis(point, contact, direction, LOOP_SAMPLES)
    force, state = results.contact_force(point, contact, LOOP_SAMPLES)
    limit = results.contact["friction"][contact - 1, direction] * force[:, 2]
    area = float(np.sum((T + np.roll(T, -1)) / 2 * (np.roll(x, -1) - x)))
    area = area if area > 1e-12 * np.ptp(x) * np.ptp(T) else 0.0  # round-off of a loop that is a line
    x, T, limit, state = (np.append(v, v[0]) for v in (x, T, limit, state[:, direction]))
    axis.fill(x, T, color="#ececec", linewidth=0)
    axis.plot(x, limit, x, -limit, color="#9a9a9a", linestyle=":", linewidth=1)
    axis.plot(x, T, color="black", linewidth=1)
    axis.plot(x, np.where(np.abs(state) == 1, T, np.nan), color="black", linewidth=2.8, solid_capstyle="round")
    energy = EngFormatter("J", places=3)(area) if results.units == "SI" else f"{area:.4g}"
    axis.set_title(f"{dof}: {energy} per cycle", fontsize=10)
    axis.set(xlabel="displacement" + _unit(results, dof), ylabel="friction force" + (" [N]" if results.units == "SI" else ""))
    axis.xaxis.set_major_locator(MaxNLocator(5))
    _ticks_in_metres(axis.xaxis, results, dof)


def _line(i):
    color, dashes = LINES[i % len(LINES)]
    return {"color": color, "linestyle": dashes}


def _in_metres(results, dof):
    return results.units == "SI" and results.dof_index(dof) >= results.modes


def _ticks_in_metres(axis, results, dof):
    """Tick labels as 20 µm where the quantity is a length."""
    if _in_metres(results, dof):
        axis.set_major_formatter(EngFormatter("m"))


def _value(results, dof, number):
    return EngFormatter("m", places=3)(number) if _in_metres(results, dof) else f"{number:.4g}"


def _unit(results, dof):
    """Behind a label; lengths carry theirs on the ticks."""
    return "" if results.units != "SI" or _in_metres(results, dof) else r" [m $\sqrt{\mathrm{kg}}$]"


def _common_unit(results, dofs):
    units = {_unit(results, dof) for dof in dofs}
    return units.pop() if len(units) == 1 else ""


def _point_title(results, point, hz):
    where = f"{results.frequency[point]:.6g} Hz" if hz else f"{results.omega[point]:.6g} rad/s"
    return f"{results.title or results.path.name}, at {where}"
