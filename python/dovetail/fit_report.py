"""What `fit` has found, as text, fit.json, fitted.toml and a picture: what curves and a backbone share."""

import json

import numpy as np

from . import case_changes, fit_backbone_report, fit_curves_report
from .case_changes import CONTACT, DAMPING, contact_values, split
from .plot_labels import no_formula
from .saved_picture import save_picture
from .study_runs import value_text
from .units import with_unit

TITLE = 90  # letters in a line above the picture
TIED = 0.95  # correlation above which two parameters can hardly be told apart


def write(found, out):
    """fit.txt, fit.json, fitted.toml and fit.png; prints the text, and where they are."""
    text = "\n".join(in_words(found))
    (out / "fit.txt").write_text(text + "\n")
    (out / "fit.json").write_text(json.dumps(numbers(found), indent=2) + "\n")
    (out / "fitted.toml").write_text(fitted_toml(found), encoding="utf-8")
    figure = of_kind(found).picture(found)
    figure.suptitle(no_formula(title(found)), fontsize=10)
    save_picture(figure, out / "fit.png")
    print(text)
    print(f"\n{out}: fitted.toml (what to write into the case), fit.txt, fit.json, fit.png")


def of_kind(found):
    """The module that speaks of what was measured."""
    return fit_backbone_report if found.backbone else fit_curves_report


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


def title(found):
    """Of the picture: as many unknowns in a line as there is room for."""
    lines = []
    for i, unknown in enumerate(found.unknowns):
        word = f"{unknown} {found.factor[i]:.4g}x ({interval(found, i)})"
        if lines and len(lines[-1]) + len(word) <= TITLE:
            lines[-1] += f", {word}"
        else:
            lines.append(word)
    return "\n".join(lines)


def cautions(found):
    """Of the search itself."""
    lines = [] if found.converged else ["caution: not converged: no fit, and no intervals; begin elsewhere, or with fewer parameters"]
    return lines + [f"caution: {found.unknowns[i]} is at the limit of a factor of 100: no fit" for i in found.at_limit]


def in_words(found):
    kind = of_kind(found)
    what = "half the peak-to-peak" if found.harmonic is None else f"harmonic {found.harmonic}"
    width = max(24, *(len(str(unknown)) for unknown in found.unknowns)) + 2
    lines = [*kind.heading(found, f"{found.dof}, {what}"), f"{'':<{width}}{'value':>16}{'factor':>10}   95 % of the factor"]
    for i, unknown in enumerate(found.unknowns):
        number, unit = base(found, unknown)
        value = "" if number is None else with_unit(f"{number * found.factor[i]:.5g}", unit)
        lines.append(f"{unknown!s:<{width}}{value:>16}{found.factor[i]:10.4g}   {interval(found, i)}")
    lines += cautions(found) + kind.beyond(found)
    lines += [f"caution: the {kind.NAME} hardly depends on {found.unknowns[i]}: leave it out, or measure {kind.ELSEWHERE}"
              for i in found.undetermined]
    for i in range(len(found.unknowns)):
        for j in range(i):
            if abs(found.correlation[i, j]) > TIED:
                lines.append(f"caution: {found.unknowns[j]} and {found.unknowns[i]} can hardly be told apart (correlation "
                             f"{found.correlation[i, j]:.3f}): measure {kind.ELSEWHERE}, or leave one out")
    return lines + kind.missed(found)


def plain(values):
    """For JSON."""
    return [float(value) if np.isfinite(value) else None for value in values]


def numbers(found):
    """All of it, for fit.json."""
    return {**of_kind(found).numbers(found), "case": found.case.path.name, "watched": found.dof, "harmonic": found.harmonic,
            "runs": found.runs, "converged": found.converged,
            "parameters": [{"name": unknown.name, "joint": unknown.joint, "factor": float(found.factor[i]),
                            "value": None if (number := base(found, unknown)[0]) is None else number * float(found.factor[i]),
                            "low": plain(found.low)[i], "high": plain(found.high)[i], "deviation": plain(found.deviation)[i],
                            "at_limit": i in found.at_limit}
                           for i, unknown in enumerate(found.unknowns)],
            "correlation": found.correlation.tolist()}


def fitted_toml(found):
    """Lines for the case file."""
    lines = [f"# Fitted to {', '.join(file.name for file in of_kind(found).files(found))}: to be written into {found.case.path.name}."]
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
