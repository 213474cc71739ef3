"""What `range` has found of a nonlinear mode: text, ranges.json, ranges.h5, ranges.png."""

import h5py
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from .plot import LINES, STYLE
from .plot_labels import no_formula
from .ranges_mode import COLUMNS
from .ranges_picture import SHADES, in_title
from .ranges_report import PERCENTILES, write_report
from .units import bracket

SHOWN = 7  # amplitudes in the table, first and last included
LEVELS = (0, *PERCENTILES, 100)


def write(found, out):
    """The report of a nonlinear mode."""
    write_report(out, in_words(found), numbers(found), lambda path: _tables(found, path), picture(found))


def band(found, name):
    """(len(LEVELS), m) over the amplitude: least, percentiles, largest of the samples; NaN where less than two come."""
    values = found.values(name)
    there = np.isfinite(values).sum(axis=0) > 1
    result = np.full((len(LEVELS), len(found.alpha)), np.nan)
    if there.any():
        result[:, there] = np.nanpercentile(values[:, there], LEVELS, axis=0)
    return result


def most_damped(found, record):
    """(largest damping ratio, modal amplitude there) of a record."""
    zeta = np.array(record["damping_ratio"], dtype=float)
    i = int(np.nanargmax(zeta))
    return float(zeta[i]), float(found.alpha[i])


def in_words(found):
    title, unit = found.case.content.get("title", ""), found.unit
    each = ", each contact point by itself" if found.each_point else ""
    lines = [f"ranges of {found.case.path}" + (f": {title}" if title else ""), *(f"  {wanted}" for wanted in found.ranges),
             f"nonlinear mode, modal amplitudes {found.alpha[0]:.5g} to {found.alpha[-1]:.5g}{bracket(unit.modal)}",
             "", f"samples: {len(found.samples)}, seed {found.seed}{each}"]
    if failed := [record for record in found.samples if record["status"] != 0]:
        lines.append(f"caution: {len(failed)} of them failed: {failed[0]['reason']}")
    rows = np.unique(np.linspace(0, len(found.alpha) - 1, SHOWN).astype(int))
    heads = ["least", *(f"{share} %" for share in PERCENTILES), "largest"]
    for name, head, factor in (("omega", f"frequency [{unit.omega}]", 1), ("damping_ratio", "damping ratio [%]", 100),
                               ("force_level", "force level", 1)):
        bands, middle = factor * band(found, name), factor * found.values(name, [found.middle])[0]
        lines += ["", f"{head} over the amplitude:", f"  {'amplitude':>12}{'middle':>11}" + "".join(f"{word:>11}" for word in heads)]
        lines += [f"  {found.alpha[i]:12.5g}{middle[i]:11.5g}" + "".join(f"{value:11.5g}" if np.isfinite(value) else f"{'-':>11}"
                                                                        for value in bands[:, i]) for i in rows]
    for name, points in found.curves.items():
        lines += ["", f"over {name}, the others in the middle:", f"  {name:>14}{'most damping [%]':>18}{'at amplitude':>14}"]
        for number, record in points:
            if record["status"] != 0:
                lines.append(f"  {number:14.6g}  failed: {record['reason']}")
            else:
                zeta, alpha = most_damped(found, record)
                lines.append(f"  {number:14.6g}{100 * zeta:18.5g}{alpha:14.5g}")
    return lines


def numbers(found):
    """What ranges.json holds."""
    def plain(values):
        return [float(value) if np.isfinite(value) else None for value in values]

    return {"case": found.case.path.name, "seed": found.seed, "each_point": found.each_point, "samples": len(found.samples),
            "failed": sum(record["status"] != 0 for record in found.samples), "modal_amplitude": found.alpha.tolist(),
            "ranges": [{"name": wanted.name, "kind": wanted.kind, "low": wanted.low, "high": wanted.high} for wanted in found.ranges],
            "middle": {name: found.middle[name] for name in COLUMNS}, "percentiles": LEVELS,
            "bands": {name: [plain(row) for row in band(found, name)] for name in COLUMNS},
            "curves": {name: [{"number": float(number), **{key: record.get(key) for key in ("status", "reason", *COLUMNS)}}
                              for number, record in points] for name, points in found.curves.items()}}


def _tables(found, path):
    with h5py.File(path, "w") as file:
        file.attrs["format"], file.attrs["case"] = "dovetail-ranges", found.case.path.name
        file["modal_amplitude"] = found.alpha
        for name in COLUMNS:
            file[f"samples/{name}"], file[f"band/{name}"] = found.values(name), band(found, name)
            file[f"middle/{name}"] = found.values(name, [found.middle])[0]
            file[f"band/{name}"].attrs["percentiles"] = LEVELS


def picture(found):
    """Bands of frequency, damping ratio and force level over the modal amplitude."""
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(1, 3, figsize=(13.5, 4.4), layout="constrained")
        for axis, name, factor, label in zip(panels, COLUMNS, (1, 100, 1), (f"frequency [{found.unit.omega}]", "damping ratio [%]",
                                                                          "force level, factor on the load")):
            least, low, median, high, most = factor * band(found, name)
            axis.fill_between(found.alpha, least, most, color=SHADES[0], linewidth=0, label="all samples")
            axis.fill_between(found.alpha, low, high, color=SHADES[1], linewidth=0, label=f"{PERCENTILES[0]} to {PERCENTILES[-1]} %")
            axis.plot(found.alpha, median, color="#5a5a5a", linestyle="--", linewidth=1, label="median")
            axis.plot(found.alpha, factor * found.values(name, [found.middle])[0], color="black", label="middle of the ranges")
            axis.set(xscale="log", xlabel="modal amplitude" + bracket(found.unit.modal), ylabel=label)
            axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.xaxis.set_major_formatter(FormatStrFormatter("%g"))
            axis.xaxis.set_minor_formatter(NullFormatter())
        if len(found.curves) == 1:
            [points] = found.curves.values()
            for (number, record), word, dashes in ((points[0], "lower", "--"), (points[-1], "upper", ":")):
                for axis, name, factor in zip(panels, COLUMNS, (1, 100, 1)) if record["status"] == 0 else ():
                    axis.plot(found.alpha, factor * found.values(name, [record])[0], color=LINES[1][0], linewidth=1, linestyle=dashes,
                              label=f"{word} end, {number:g}")
        panels[1].set_ylim(0, None)
        if np.isfinite(found.values("force_level", [found.middle])).any():
            panels[2].set_yscale("log")
        panels[0].legend(fontsize=8)
        figure.suptitle(no_formula(found.case.content.get("title", found.case.path.name)) + "\n" + in_title(found.ranges))
    return figure
