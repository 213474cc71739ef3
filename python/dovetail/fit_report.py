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
    if found.beyond:
        (low, high), (first, last) = found.beyond
        lines.append(f"caution: the measured frequencies, {first:.6g} to {last:.6g}, reach beyond continuation.omega, {low:g} to {high:g}")
    return lines


def in_words(found):
    what = "half the peak-to-peak" if found.harmonic is None else f"harmonic {found.harmonic}"
    width = max(24, *(len(str(unknown)) for unknown in found.unknowns)) + 2
    lines = [f"fit of {found.case.path} to {found.file}: {len(found.measured.omega)} frequencies, {found.dof}, {what}",
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
    if missed := np.count_nonzero(~np.isfinite(found.model)):
        lines.append(f"caution: the fitted curve has no point at {missed} of the frequencies")
    return lines


def numbers(found):
    """All of it, for fit.json."""
    def plain(values):
        return [float(value) if np.isfinite(value) else None for value in values]

    return {"case": found.case.path.name, "measured": found.file.name, "watched": found.dof, "harmonic": found.harmonic,
            "misfit": found.misfit, "runs": found.runs, "converged": found.converged,
            "parameters": [{"name": unknown.name, "joint": unknown.joint, "factor": float(found.factor[i]),
                            "value": None if (number := base(found, unknown)[0]) is None else number * float(found.factor[i]),
                            "low": plain(found.low)[i], "high": plain(found.high)[i], "deviation": plain(found.deviation)[i],
                            "at_limit": i in found.at_limit}
                           for i, unknown in enumerate(found.unknowns)],
            "correlation": found.correlation.tolist(), "omega": plain(found.measured.omega),
            "amplitude": plain(found.measured.amplitude), "fitted": plain(found.model)}


def fitted_toml(found):
    """Lines for the case file."""
    lines = [f"# Fitted to {found.file.name}: to be written into {found.case.path.name}."]
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
    """Measured points beside the curve of the case and of the fit; beneath, relative errors."""
    import matplotlib.pyplot as plt

    from .curves import with_gaps
    from .plot import LINES, STYLE

    def amplitude(curve):
        return curve.amplitude if found.harmonic is None else curve.harmonic(found.harmonic)

    with plt.rc_context(STYLE):
        figure, (axis, errors) = plt.subplots(2, 1, sharex=True, figsize=(7.5, 5.6), gridspec_kw={"height_ratios": [3.2, 1]},
                                              layout="constrained")
        low, high = found.measured.omega[[0, -1]]
        for curve, (color, dashes), label in ((found.start, LINES[1], "case as it stands"), (found.curve, LINES[0], "fit")):
            inside = (curve.omega >= low) & (curve.omega <= high)
            values = np.where(inside, amplitude(curve), np.nan)
            axis.plot(with_gaps(curve.omega, curve.jumps), with_gaps(values, curve.jumps), color=color, linestyle=dashes, label=label)
        axis.plot(found.measured.omega, found.measured.amplitude, "o", color="black", markersize=4, markerfacecolor="white",
                  label="measured")
        axis.set(ylim=(0, None))
        dress(axis.yaxis, f"amplitude of {found.dof}" + ("" if found.harmonic is None else f", harmonic {found.harmonic}"), found.length)
        axis.legend()
        errors.axhline(0, color="#9a9a9a", linewidth=0.8)
        errors.plot(found.measured.omega, 100 * (found.model / found.measured.amplitude - 1), "o", color="black", markersize=3)
        errors.set(xlabel=f"excitation frequency [{found.unit.omega}]", ylabel="error [%]")
        figure.suptitle(", ".join(f"{unknown} {found.factor[i]:.4g}x ({interval(found, i)})"
                                  for i, unknown in enumerate(found.unknowns)), fontsize=10)
    return figure
