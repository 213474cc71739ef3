"""Chart of a study: error over time per point, a panel for each kind of error. Readable in black and white."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from . import study_errors
from .plot import LINES, STYLE
from .plot_labels import no_formula

MARKERS = ("o", "s", "^", "D", "v", "<", ">", "P", "X", "p", "h")  # by number of harmonics
TITLES = {"amplitude": "peak amplitude", "frequency": "resonance frequency", "curve": "whole curve", "dissipation": "dissipated energy"}
LEAST = 1e-12  # errors below are drawn here: rounding
EDGES = tuple(color for color, _ in LINES)  # by solver
SMALL, USUAL, LARGE = 5.0, 7.5, 9.0  # marker sizes, by number of modes
DARKEST = 0.4  # grey that fills the markers of the most samples; those of the fewest are white


def picture(report):
    """The figure for a Report.

    Shape tells harmonics; fill the evaluation of contact forces, from white (fewest samples) to black (exact); size the modes and colour
    of the rim the solver, where these vary. The line is the frontier: the least error for a time.
    """
    style = MarkerStyle([row.setting for row in report.compared])
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(2, 2, sharex=True, figsize=(9.5, 7.6), layout="constrained")
        for axis, kind in zip(axes.flat, study_errors.KINDS):
            _panel(axis, kind, [row for row in report.compared if row.errors[kind] is not None], style)
        for axis in axes[-1]:
            axis.set_xlabel("processor time per point [ms]")
            axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.xaxis.set_major_formatter(FormatStrFormatter("%g"))
            axis.xaxis.set_minor_formatter(NullFormatter())
        for axis in axes[:, 0]:
            axis.set_ylabel("relative error")
        figure.suptitle(f"{no_formula(report.title)}\nerrors against the reference: {report.reference.setting}")
        axes[0, 1].legend(handles=style.legend(), loc="upper left", bbox_to_anchor=(1.02, 1.0), handlelength=1.2)
    return figure


def _panel(axis, kind, rows, style):
    axis.set(xscale="log", yscale="log", title=TITLES[kind])
    if not rows:
        axis.text(0.5, 0.5, "none in the reference", transform=axis.transAxes, ha="center")
        return
    time = np.array([1e3 * row.seconds_per_point for row in rows])
    error = np.array([max(row.errors[kind], LEAST) for row in rows])
    best = frontier(time, error)
    axis.set_ylim(10.0 ** np.floor(np.log10(error.min() / 1.2)), 10.0 ** np.ceil(np.log10(1.2 * error.max())))  # two labels at least
    axis.step([*time[best], 1.15 * time.max()], [*error[best], error[best[-1]]], where="post", color="#7f7f7f", linewidth=1.2, zorder=1)
    for x, y, row in zip(time, error, rows):
        axis.plot(x, y, linestyle="none", **style.of(row.setting))
        if row.setting.tolerance is not None:
            axis.annotate(f"{row.setting.tolerance:g}", (x, y), xytext=(7, 4), textcoords="offset points", fontsize=8)


def frontier(time, error):
    """Numbers of the settings that no other beats in both time and error, by rising time; (n,) arrays."""
    best, least = [], np.inf
    for i in np.lexsort((error, time)):
        if error[i] < least:
            best.append(i)
            least = error[i]
    return best


class MarkerStyle:
    """How settings are told apart."""

    def __init__(self, settings):
        self.harmonics = sorted({s.harmonics for s in settings if s.tolerance is None})
        self.adaptive = any(s.tolerance is not None for s in settings)
        self.samples = sorted({s.samples for s in settings}, key=lambda n: (n == "exact", n))
        self.modes = sorted({s.modes for s in settings})
        self.solvers = sorted({s.solver for s in settings})

    def _fill(self, samples):
        """White for the fewest samples, darker for more, black for exact."""
        numbers = [n for n in self.samples if n != "exact"]
        return "0" if samples == "exact" else str(1 - (1 - DARKEST) * numbers.index(samples) / max(len(numbers) - 1, 1))

    def _size(self, modes):
        return SMALL + (LARGE - SMALL) * self.modes.index(modes) / (len(self.modes) - 1) if len(self.modes) > 1 else USUAL

    def of(self, setting):
        """Keywords for `plot`."""
        solver = self.solvers.index(setting.solver)
        if setting.tolerance is not None:
            return {"marker": "*", "markersize": 1.6 * self._size(setting.modes), "markerfacecolor": "white", "zorder": 3,
                    "markeredgecolor": EDGES[solver], "markeredgewidth": 0.9 + 0.7 * solver}
        return {"marker": MARKERS[self.harmonics.index(setting.harmonics) % len(MARKERS)], "markersize": self._size(setting.modes),
                "markerfacecolor": self._fill(setting.samples), "markeredgecolor": EDGES[solver], "markeredgewidth": 0.9 + 0.7 * solver}

    def legend(self):
        """One entry for every value that varies."""
        def entry(label, marker="o", fill="white", size=USUAL, edge="black", width=0.9):
            return Line2D([], [], linestyle="none", label=label, marker=marker, markersize=size, markerfacecolor=fill,
                          markeredgecolor=edge, markeredgewidth=width)

        entries = [entry(f"H {h}", MARKERS[i % len(MARKERS)]) for i, h in enumerate(self.harmonics)]
        if self.adaptive:
            entries.append(entry("by tolerance", "*", size=1.6 * USUAL))
        entries += [entry("fill: exact" if n == "exact" else f"fill: N {n}", fill=self._fill(n)) for n in self.samples]
        if len(self.modes) > 1:
            entries += [entry(f"size: {n} modes", size=self._size(n)) for n in self.modes]
        if len(self.solvers) > 1:
            entries += [entry(f"rim: {name}", edge=EDGES[i], width=0.9 + 0.7 * i) for i, name in enumerate(self.solvers)]
        return [*entries, Line2D([], [], color="#7f7f7f", linewidth=1.2, label="frontier")]
