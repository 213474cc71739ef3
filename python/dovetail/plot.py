"""Pictures of a results file: response curve, time history, friction loops. Readable in black and white."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.ticker import MaxNLocator  # noqa: E402

from . import curves  # noqa: E402
from .contact_motion import parameters_at  # noqa: E402
from .plot_labels import ROW, curves_in, legend_above, place_labels, no_formula  # noqa: E402
from .plot_units import dress, value_text  # noqa: E402
from .reference import LAWS  # noqa: E402
from .results import STABLE, UNCERTAIN, UNSTABLE  # noqa: E402
from .shown import default_dofs, rubbing_dofs  # noqa: E402
from .units import bracket  # noqa: E402

LINES = [("#000000", "-"), ("#c1440e", "--"), ("#1f6f9f", "-."), ("#6a9a1f", ":"), ("#8a4f9e", (0, (6, 1, 1, 1, 1, 1))),
         ("#7f7f7f", (0, (1, 1)))]  # colours of falling darkness, each with its own dash pattern
STYLE = {"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e3e3e3",
         "grid.linewidth": 0.7, "lines.linewidth": 1.5, "legend.frameon": False, "figure.dpi": 160, "axes.axisbelow": True}
LOOP_SAMPLES = 1024  # per period, so that corners of a friction loop look like corners
MARKERS = "s^Dvo"  # tell degrees of freedom apart where dashes are taken up by stability
DASHES = {STABLE: "-", UNSTABLE: (0, (5, 2.5)), UNCERTAIN: (0, (1, 1.5))}
ROOM = 1.1  # of the largest amplitude: height of a panel, so that labels of peaks have place
PANELS = {"node": "amplitude", "contact": "relative amplitude", "modal": "modal amplitude"}  # labels


def response(results, dofs=None, at=None, hz=False):
    """Amplitude over the excitation frequency, or the parameter that is varied; beneath, the share of points that slip or open.

    Of peaks that are followed over a parameter, their frequency, too.

    Where some points are not stable, unstable parts are dashed and uncertain ones dotted. Circles are peaks, triangles turning
    points (they point to where the curve goes on). Where the branch jumped there is a gap.

    Parameters
    ----------
    results : Results
    dofs : list of str, optional
        Default: `shown.default_dofs`. Nodes, contact points and modes get a panel each.
    at : float, optional
        A frequency in units of the model ([rad/s]), or a value of the parameter, to mark.
    hz : bool
        Frequency axis in Hz.
    """
    panels = _panels(results, dofs or default_dofs(results))
    hertz, hz = hz, hz and results.parameter is None
    frequency, scale = (results.frequency, results.unit.hertz(1.0)) if hz else (results.along, 1.0)
    mixed, tracked = results.stable is not None and np.any(results.stable != STABLE), results.tracked_amplitude is not None
    heights = [3.2 + ROW * len(names) for names in panels.values()] + ([1.6] if tracked else []) + [1]
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(len(heights), 1, sharex=True, figsize=(7.5, 1.0 + sum(heights)),
                                    gridspec_kw={"height_ratios": heights}, layout="constrained")
        labels = {}
        for axis, (kind, names) in zip(axes, panels.items()):
            highest = 0.0
            for i, dof in enumerate(names):
                curve = results.response(dof)
                highest = max(highest, curve.amplitude.max())
                label, tops = f"{dof}   {_top(results, curve, hz)}", curve.peaks()
                if tracked:
                    label, tops = f"peak of {dof}" if dof == results.watch else f"{dof} at the peak of {results.watch}", []
                if mixed:
                    _curve_by_stability(axis, results, frequency, curve.amplitude, i, label)
                else:
                    along, amplitude = curve.curve()
                    highest = max(highest, np.nanmax(amplitude))
                    axis.plot(scale * along, amplitude, **_line(i), label=label, marker="o" if len(results) == 1 else None)
                for omega, top in tops:
                    axis.plot(scale * omega, top, "o", color=_line(i)["color"], markersize=4, markerfacecolor="white")
                places = _places(axis, results, curve, frequency, i)
                labels.setdefault(axis, places)  # of the first: numbers of several curves would cover each other
            axis.set_ylim(0, ROOM * (highest or 1.0))
            if mixed:
                for verdict, words in ((UNSTABLE, "unstable"), (UNCERTAIN, "stability uncertain")):
                    if np.any(results.stable == verdict):
                        axis.plot([], [], color="black", linestyle=DASHES[verdict], label=words)
            dress(axis.yaxis, PANELS[kind], results.unit_of(names[0]))
            legend_above(axis)
        if tracked:
            along, omega = curve.omega_curve()
            axes[-2].plot(along, results.unit.hertz(omega) if hertz else omega, **_line(0))
            dress(axes[-2].yaxis, "frequency", "Hz" if hertz else results.unit.omega)
        for i, state in enumerate(("slip", "open")):
            axes[-1].plot(curves.with_gaps(frequency, results.jumps), curves.with_gaps(100 * results.points(state), results.jumps),
                          **_line(i), label=state)
        axes[-1].set(ylim=(-4, 104), yticks=(0, 50, 100), ylabel="points [%]",
                     xlabel=over(results) + bracket("Hz" if hz else results.along_unit))
        axes[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2)
        if at is not None:
            for axis in axes:
                axis.axvline(scale * at, color="#9a9a9a", linewidth=0.8)
        figure.suptitle(no_formula(results.title or results.path.name))
        for axis, places in labels.items():
            markers = [xy for line in axis.lines if line.get_linestyle() == "None" for xy in line.get_xydata()]
            place_labels(axis, places, markers, lines=curves_in(axis))
    return figure


def over(results):
    """The name of what the curve is drawn over."""
    if results.parameter is None:
        return "excitation frequency"
    if results.modal_amplitude is not None:
        return "modal amplitude"
    return f"{results.parameter_name.replace('_', ' ')}, {'offset' if results.parameter_unit == 'm' else 'factor'}"


def _panels(results, dofs):
    """Those of nodes, contact points and modes, by the word of their panel."""
    kinds = {kind: [] for kind in PANELS}
    for dof in dofs:
        reduced = curves.is_reduced(dof)
        kinds["node" if not reduced else "modal" if results.dof_index(dof) < results.modes else "contact"].append(dof)
    return {kind: names for kind, names in kinds.items() if names}


def _top(results, curve, hz):
    """In words: the largest peak, or that there is none."""
    peaks = curve.peaks()
    if peaks:
        place, top = max(peaks, key=lambda peak: peak[1])
        where = f"{results.unit.hertz(place):.5g} Hz" if hz else results.place(place, 5)
        return f"peak {value_text(top, curve.unit)} at {where}"
    return ", ".join(dict.fromkeys(words for _, _, words in curve.ends())) or "no peak"


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
        gaps = 1 + np.union1d(np.flatnonzero(verdicts != verdict), results.jumps[results.jumps < len(results) - 1])  # left out
        x, y = (np.insert(np.where(drawn, values, np.nan), gaps, np.nan) for values in (omega, amplitude))
        axis.plot(x, y, color=style["color"], linestyle=dashes)
    axis.plot(omega, amplitude, linestyle="none", markevery=0.15, **style)
    axis.plot([], [], **style, label=label)


def _places(axis, results, curve, frequency, i):
    """Marks turning points, and returns labels (x, y, text) of peaks and of them, two lists with the highest first."""
    peaks, folds = curve.located, results.events.of("fold").point
    style = {"color": _line(i)["color"], "markerfacecolor": "white", "linestyle": "none"}
    rising = frequency[np.minimum(folds + 1, len(frequency) - 1)] > frequency[folds]
    for to, marker in ((True, ">"), (False, "<")):
        axis.plot(frequency[folds[rising == to]], curve.amplitude[folds[rising == to]], marker, markersize=5, **style)
    kinds = ((peaks, lambda j: value_text(curve.amplitude[j], curve.unit)), (folds, lambda j: f"{frequency[j]:.5g}"))
    return [[(frequency[j], curve.amplitude[j], text(j)) for j in places[np.argsort(-curve.amplitude[places], kind="stable")]]
            for places, text in kinds]


def history(results, point, dofs=None, hz=False, sector=None):
    """One period of motion, measured from the preload state; of a cyclic structure in any sector, default 0."""
    dofs = dofs or default_dofs(results)
    with plt.rc_context(STYLE):
        figure, axis = plt.subplots(figsize=(7.5, 3.8), layout="constrained")
        for i, dof in enumerate(dofs):
            t, q = results.time_history(point, dof, 512, sector)
            period = 2 * np.pi / results.omega[point]
            axis.plot(np.append(t, period), np.append(q, q[0]), **_line(i), label=dof)
        axis.set(xlim=(0, period))
        kinds = {results.unit_of(dof) for dof in dofs}
        dress(axis.yaxis, "motion from preload", kinds.pop() if len(kinds) == 1 else "")
        dress(axis.xaxis, "time", results.unit.time)
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2)
        axis.set_title(point_title(results, point, hz, sector))
    return figure


def hysteresis(results, point, dofs=None, hz=False):
    """Friction loops: tangential force over displacement; heavy where the point slips, light where it sticks.

    `dofs` are tangential ones ("x2.t1"); default: `shown.rubbing_dofs`.
    """
    dofs = dofs or rubbing_dofs(results, point)
    if not dofs:
        raise ValueError(f"{results.path}: has no contact point, and so no friction loop")
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, len(dofs), figsize=(0.6 + 3.9 * len(dofs), 3.9), layout="constrained", squeeze=False)
        for axis, dof in zip(axes[0], dofs):
            _loop(axis, results, point, dof)
        figure.suptitle(point_title(results, point, hz))
    return figure


def _loop(axis, results, point, dof):
    index = results.dof_index(dof) - results.modes if curves.is_reduced(dof) else -1
    if index < 0 or index % 3 == 2:
        raise ValueError(f"a friction loop needs a tangential direction such as x1.t1, found {dof!r}")
    contact, direction = index // 3 + 1, index % 3
    law = LAWS[results.contact["law"][contact - 1]]
    if law in ("unilateral", "bilateral"):
        raise ValueError(f"contact point {contact} has no friction loop: its law is {law}")
    x, T = results.hysteresis(point, contact, direction, LOOP_SAMPLES)
    force, state = results.contact_force(point, contact, LOOP_SAMPLES)
    limit = parameters_at(results, point)[0]["friction"][contact - 1, direction] * force[:, 2]
    area = float(np.sum((T + np.roll(T, -1)) / 2 * (np.roll(x, -1) - x)))
    area = area if area > 1e-12 * np.ptp(x) * np.ptp(T) else 0.0  # round-off of a loop that is a line
    x, T, limit, state = (np.append(v, v[0]) for v in (x, T, limit, state[:, direction]))
    axis.fill(x, T, color="#ececec", linewidth=0)
    axis.plot(x, limit, x, -limit, color="#9a9a9a", linestyle=":", linewidth=1)
    axis.plot(x, T, color="black", linewidth=1)
    axis.plot(x, np.where(np.abs(state) == 1, T, np.nan), color="black", linewidth=2.8, solid_capstyle="round")
    axis.set_title(f"{dof}: {value_text(area, results.unit.energy)} per cycle", fontsize=10)
    axis.xaxis.set_major_locator(MaxNLocator(5))
    dress(axis.xaxis, "displacement", results.unit.length)
    dress(axis.yaxis, "friction force", results.unit.force)


def _line(i):
    color, dashes = LINES[i % len(LINES)]
    return {"color": color, "linestyle": dashes}


def point_title(results, point, hz, sector=None):
    """Which curve, and where on it; of a cyclic structure which sector, if one is named."""
    where = f"{results.frequency[point]:.6g} Hz" if hz and results.parameter is None else results.place(results.along[point], 6)
    return no_formula(f"{results.title or results.path.name}, at {where}") + ("" if sector is None else f", sector {sector}")
