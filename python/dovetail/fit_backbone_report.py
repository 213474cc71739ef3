"""What `fit` says of a measured backbone: words, numbers, picture."""

import numpy as np

from .fit_backbone import NAMES
from .plot_units import BASE_UNITS, dress
from .units import with_unit

NAME, ELSEWHERE = "backbone", "at other amplitudes"  # what was measured, and where else it might be
MARGIN = 1.15  # beside the measured amplitudes in the picture


def files(found):
    return [found.backbone.file]


def heading(found, watched):
    one = found.backbone
    return [f"fit of {found.case.path} to {one.file}: backbone of {len(one.measured.amplitude)} amplitudes, {watched}",
            *(f"  {NAMES[name]}: relative error {misfit:.3g} in the mean of squares" for name, misfit in one.misfit.items()),
            f"{found.runs} runs"]


def beyond(found):
    if not found.backbone.beyond:
        return []
    (low, high), (first, last) = found.backbone.beyond
    return [f"caution: the measured amplitudes, {first:.6g} to {last:.6g}, reach beyond those of the mode of the case, {low:.6g} to "
            f"{with_unit(f'{high:.6g}', found.length)}"]


def missed(found):
    words = {"omega": "does not come to", "damping_ratio": "has no damping, or less than a tenth of what was measured, at"}
    return [f"caution: the fitted mode {words[name]} {count} of the amplitudes" for name, values in found.backbone.model.items()
            if (count := np.count_nonzero(~np.isfinite(values)))]


def numbers(found):
    one = found.backbone
    return {"measured": one.file.name, "amplitude": one.measured.amplitude.tolist(),
            **{name: {"measured": values.tolist(), "fitted": [float(value) if np.isfinite(value) else None for value in one.model[name]],
                      "misfit": one.misfit[name]} for name, values in one.measured.quantities.items()}}


def picture(found):
    """Measured points beside the mode of the case and of the fit: frequency and damping ratio over the amplitude of what is watched."""
    import matplotlib.pyplot as plt
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

    from .plot import LINES, STYLE

    one = found.backbone
    measured = one.measured
    ends = measured.amplitude[0] / MARGIN, measured.amplitude[-1] * MARGIN
    in_hertz = found.unit.hertz if measured.hertz else lambda omega: omega
    shown = {"omega": (in_hertz, f"frequency [{'Hz' if measured.hertz else found.unit.omega}]"),
             "damping_ratio": (lambda zeta: 100 * zeta, "damping ratio [%]")}
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(len(measured.quantities), 1, sharex=True, figsize=(7.5, 1.2 + 2.5 * len(measured.quantities)),
                                      layout="constrained", squeeze=False)
        for axis, (name, values) in zip(panels[:, 0], measured.quantities.items()):
            scaled, label = shown[name]
            for curve, words, (color, dashes) in ((one.start, "case as it stands", LINES[1]), (one.curve, "fit", LINES[0])):
                size, numbers = curve[0], scaled(curve[2 + list(NAMES).index(name)])
                inside = (size >= ends[0]) & (size <= ends[1])
                axis.plot(np.where(inside, size, np.nan), numbers, color=color, linestyle=dashes, label=words)
            axis.plot(measured.amplitude, scaled(values), "o", color="black", markersize=4, markerfacecolor="white", label="measured")
            axis.set(xscale="log", ylabel=label)
        axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.xaxis.set_minor_formatter(NullFormatter())
        if found.length not in BASE_UNITS:
            axis.xaxis.set_major_formatter(FormatStrFormatter("%g"))
        dress(axis.xaxis, f"amplitude of {found.dof}" + ("" if found.harmonic is None else f", harmonic {found.harmonic}"), found.length)
        if "damping_ratio" in measured.quantities:
            axis.set_ylim(0, None)
        panels[0, 0].legend()
    return figure
