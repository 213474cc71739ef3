"""What `fit` says of measured response curves: words, numbers, picture."""

import numpy as np

from .curves import with_gaps
from .plot_units import dress

NAME, ELSEWHERE = "curve", "at another force"  # what was measured, and where else it might be


def files(found):
    return [curve.file for curve in found.curves]


def misfit(found):
    """Root mean square of the relative errors of all curves."""
    return float(np.sqrt(np.average([curve.misfit**2 for curve in found.curves], weights=[len(curve.model) for curve in found.curves])))


def of_file(found, curve):
    """Which of several curves, in words."""
    return f" of {curve.file}" if len(found.curves) > 1 else ""


def heading(found, watched):
    several = len(found.curves) > 1
    named = f"{len(found.curves)} curves" if several else str(found.curves[0].file)
    count = sum(len(curve.measured.omega) for curve in found.curves)
    return [f"fit of {found.case.path} to {named}: {count} frequencies, {watched}",
            *(f"  {curve.file}: force {curve.force:g}x, {len(curve.measured.omega)} frequencies, relative error {curve.misfit:.3g}"
              for curve in found.curves if several),
            f"relative error {misfit(found):.3g} in the mean of squares; {found.runs} runs"]


def beyond(found):
    lines = []
    for curve in found.curves:
        if curve.beyond:
            (low, high), (first, last) = curve.beyond
            lines.append(f"caution: the measured frequencies{of_file(found, curve)}, {first:.6g} to {last:.6g}, reach beyond "
                         f"continuation.omega, {low:g} to {high:g}")
    return lines


def missed(found):
    return [f"caution: the fitted curve has no point at {count} of the frequencies{of_file(found, curve)}"
            for curve in found.curves if (count := np.count_nonzero(~np.isfinite(curve.model)))]


def numbers(found):
    curves = [{"measured": curve.file.name, "force": curve.force, "misfit": curve.misfit, "omega": curve.measured.omega.tolist(),
               "amplitude": curve.measured.amplitude.tolist(),
               "fitted": [float(value) if np.isfinite(value) else None for value in curve.model]} for curve in found.curves]
    return {**(curves[0] if len(curves) == 1 else {"curves": curves}), "misfit": misfit(found)}


def picture(found):
    """Measured points beside the curves of the case and of the fit; beneath, relative errors."""
    import matplotlib.pyplot as plt

    from .plot import LINES, STYLE

    def line(axis, curve, measured, **look):
        if found.harmonic is None:
            omega, values = curve.curve()
        else:
            omega, values = with_gaps(curve.omega, curve.jumps), with_gaps(curve.harmonic(found.harmonic), curve.jumps)
        axis.plot(omega, np.where((omega >= measured.omega[0]) & (omega <= measured.omega[-1]), values, np.nan), **look)

    with plt.rc_context(STYLE):
        figure, (axis, errors) = plt.subplots(2, 1, sharex=True, figsize=(7.5, 5.6), gridspec_kw={"height_ratios": [3.2, 1]},
                                              layout="constrained")
        several = len(found.curves) > 1
        for i, one in enumerate(found.curves):
            color = LINES[(0, 2, *range(3, len(LINES)))[i % (len(LINES) - 1)]][0]  # the second one is that of the case
            line(axis, one.start, one.measured, color=LINES[1][0], linestyle=LINES[1][1], label=None if i else "case as it stands")
            line(axis, one.curve, one.measured, color=color, label=f"fit, force {one.force:g}x" if several else "fit")
            axis.plot(one.measured.omega, one.measured.amplitude, "o", color=color, markersize=4, markerfacecolor="white",
                      label=one.file.name if several else "measured")
            errors.plot(one.measured.omega, 100 * (one.model / one.measured.amplitude - 1), "o", color=color, markersize=3)
        axis.set(ylim=(0, None))
        dress(axis.yaxis, f"amplitude of {found.dof}" + ("" if found.harmonic is None else f", harmonic {found.harmonic}"), found.length)
        axis.legend()
        errors.axhline(0, color="#9a9a9a", linewidth=0.8, zorder=0)
        errors.set(xlabel=f"excitation frequency [{found.unit.omega}]", ylabel="error [%]")
    return figure
