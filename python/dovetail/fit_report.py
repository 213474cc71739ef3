"""What `fit` has found, as text, fit.json, fitted.toml and a picture."""

import json

import numpy as np

from . import case_changes
from .case_changes import CONTACT, DAMPING, contact_values, split
from .plot_units import dress
from .study_runs import value_text
from .units import with_unit

TIED = 0.95  # correlation above which two parameters can hardly be told apart


def write(found, out):
    """fit.txt, fit.json, fitted.toml and fit.png; prints the text, and where they are."""
    text = "\n".join(in_words(found))
    (out / "fit.txt").write_text(text + "\n")
    (out / "fit.json").write_text(json.dumps(numbers(found), indent=2) + "\n")
    (out / "fitted.toml").write_text(fitted_toml(found), encoding="utf-8")
    picture(found).savefig(out / "fit.png")
    print(text)
    print(f"\n{out}: fitted.toml (what to write into the case), fit.txt, fit.json, fit.png")


def base(found, unknown):
    """What the case has of an unknown: a number and its unit where it is the same at all of its points, else None."""
    if unknown.name not in CONTACT:
        return None, ""
    key, directions = split(unknown.name)
    values = found.contact[key][found.contact["law"] <= 1] if key in case_changes.FRICTION else found.contact[key]
    if unknown.points is not None:
        values = found.contact[key][unknown.points]
    values = values[:, directions] if values.ndim == 2 else values
    unit = found.unit.stiffness if key.endswith("stiffness") else ""
    return (float(values.flat[0]), unit) if np.ptp(values) <= 1e-12 * np.abs(values).max() else (None, "")


def interval(found, i):
    return "none" if np.isnan(found.high[i]) else f"{found.low[i]:.4g} to {found.high[i]:.4g}"


def cautions(found):
    """Of the search itself."""
    lines = [] if found.converged else ["caution: not converged: no fit, and no intervals; begin elsewhere, or with fewer parameters"]
    lines += [f"caution: {found.unknowns[i]} is at the limit of a factor of 100: no fit" for i in found.at_limit]
    for curve in found.curves:
        if curve.beyond:
            (low, high), (first, last) = curve.beyond
            lines.append(f"caution: the measured frequencies{of_file(found, curve)}, {first:.6g} to {last:.6g}, reach beyond "
                         f"continuation.omega, {low:g} to {high:g}")
    return lines


def of_file(found, curve):
    """Which of several curves, in words."""
    return f" of {curve.file}" if len(found.curves) > 1 else ""


def in_words(found):
    what = "half the peak-to-peak" if found.harmonic is None else f"harmonic {found.harmonic}"
    width = max(24, *(len(str(unknown)) for unknown in found.unknowns)) + 2
    several = len(found.curves) > 1
    files = f"{len(found.curves)} curves" if several else str(found.curves[0].file)
    count = sum(len(curve.measured.omega) for curve in found.curves)
    lines = [f"fit of {found.case.path} to {files}: {count} frequencies, {found.dof}, {what}",
             *(f"  {curve.file}: force {curve.force:g}x, {len(curve.measured.omega)} frequencies, relative error {curve.misfit:.3g}"
               for curve in found.curves if several),
             f"relative error {found.misfit:.3g} in the mean of squares; {found.runs} runs",
             f"{'':<{width}}{'value':>16}{'factor':>10}   95 % of the factor"]
    for i, unknown in enumerate(found.unknowns):
        number, unit = base(found, unknown)
        value = "" if number is None else with_unit(f"{number * found.factor[i]:.5g}", unit)
        lines.append(f"{unknown!s:<{width}}{value:>16}{found.factor[i]:10.4g}   {interval(found, i)}")
    lines += cautions(found)
    lines += [f"caution: the curve hardly depends on {found.unknowns[i]}: leave it out, or measure at another force"
              for i in found.undetermined]
    for i in range(len(found.unknowns)):
        for j in range(i):
            if abs(found.correlation[i, j]) > TIED:
                lines.append(f"caution: {found.unknowns[j]} and {found.unknowns[i]} can hardly be told apart (correlation "
                             f"{found.correlation[i, j]:.3f}): measure at another force, or leave one out")
    for curve in found.curves:
        if missed := np.count_nonzero(~np.isfinite(curve.model)):
            lines.append(f"caution: the fitted curve has no point at {missed} of the frequencies{of_file(found, curve)}")
    return lines


def numbers(found):
    """All of it, for fit.json."""
    def plain(values):
        return [float(value) if np.isfinite(value) else None for value in values]

    curves = [{"measured": curve.file.name, "force": curve.force, "misfit": curve.misfit, "omega": plain(curve.measured.omega),
               "amplitude": plain(curve.measured.amplitude), "fitted": plain(curve.model)} for curve in found.curves]
    of_curves = curves[0] if len(curves) == 1 else {"curves": curves}
    return {**of_curves, "case": found.case.path.name, "watched": found.dof, "harmonic": found.harmonic,
            "misfit": found.misfit, "runs": found.runs, "converged": found.converged,
            "parameters": [{"name": unknown.name, "joint": unknown.joint, "factor": float(found.factor[i]),
                            "value": None if (number := base(found, unknown)[0]) is None else number * float(found.factor[i]),
                            "low": plain(found.low)[i], "high": plain(found.high)[i], "deviation": plain(found.deviation)[i],
                            "at_limit": i in found.at_limit}
                           for i, unknown in enumerate(found.unknowns)],
            "correlation": found.correlation.tolist()}


def fitted_toml(found):
    """Lines for the case file."""
    lines = [f"# Fitted to {', '.join(curve.file.name for curve in found.curves)}: to be written into {found.case.path.name}."]
    intervals = [f"# {unknown}: factor {found.factor[i]:.5g}, 95 %: {interval(found, i)}"
                 for i, unknown in enumerate(found.unknowns)]
    changed = case_changes.apply(found.case.content, found.contact, found.changes)
    lines += intervals
    if keys := list(contact_values(found.contact, found.changes)):
        lines += ["", "[contact]", *(f"{key} = {value_text(changed['contact'][key])}" for key in keys)]
    if "damping" in found.changes:
        lines += ["", "[damping]", *(f"{key} = {value_text(changed['damping'][key])}" for key in DAMPING if key in changed["damping"])]
    if "force" in found.changes:
        lines += ["", "[excitation]", *(f"{key} = {value_text(value)}" for key, value in changed["excitation"].items())]
    return "\n".join(lines) + "\n"


def picture(found):
    """Measured points beside the curves of the case and of the fit; beneath, relative errors."""
    import matplotlib.pyplot as plt

    from .curves import with_gaps
    from .plot import LINES, STYLE

    def line(axis, curve, measured, **look):
        inside = (curve.omega >= measured.omega[0]) & (curve.omega <= measured.omega[-1])
        values = np.where(inside, curve.amplitude if found.harmonic is None else curve.harmonic(found.harmonic), np.nan)
        axis.plot(with_gaps(curve.omega, curve.jumps), with_gaps(values, curve.jumps), **look)

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
        figure.suptitle(", ".join(f"{unknown} {found.factor[i]:.4g}x ({interval(found, i)})"
                                  for i, unknown in enumerate(found.unknowns)), fontsize=10)
    return figure
