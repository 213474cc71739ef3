"""What `range` has found, as text, ranges.json and ranges.h5."""

import json

import h5py
import numpy as np

from .case_runs import has_peak
from .saved_picture import save_picture
from .units import with_unit

PERCENTILES = (5, 50, 95)


def write(found, out):
    """The report of the peaks."""
    from .ranges_picture import picture

    write_report(out, in_words(found), numbers(found), lambda path: _tables(found, path), picture(found))


def write_report(out, lines, numbers, tables, figure):
    """ranges.txt, ranges.json, ranges.h5 (written by `tables`) and ranges.png; prints the text, and where they are."""
    text = "\n".join(lines)
    (out / "ranges.txt").write_text(text + "\n")
    (out / "ranges.json").write_text(json.dumps(numbers, indent=2) + "\n")
    tables(out / "ranges.h5")
    save_picture(figure, out / "ranges.png")
    print(text)
    print(f"\n{out}: ranges.txt, ranges.json, ranges.h5, ranges.png")


def of_samples(found, name):
    """(n,) of the samples with a peak: amplitude, omega or rms."""
    return np.array([found.samples[i][name] for i in found.good])


def band(found):
    """(len(PERCENTILES) + 2, m) amplitudes over `found.frequencies`: least, percentiles, largest of the samples; None without curves."""
    curves = [record["curve"] for record in found.samples if record["status"] == 0 and record["curve"]]
    if len(curves) < 2:
        return None
    curves = np.array(curves, dtype=float)
    there = np.isfinite(curves).any(axis=0)
    values = np.full((len(PERCENTILES) + 2, curves.shape[1]), np.nan)
    values[:, there] = np.nanpercentile(curves[:, there], (0, *PERCENTILES, 100), axis=0)
    return values


def _spread_in_words(values, unit):
    least, *middle, most = np.percentile(values, (0, *PERCENTILES, 100))
    words = ", ".join(f"{value:.5g} ({share} %)" for share, value in zip(PERCENTILES, middle))
    mean = with_unit(f"{np.mean(values):.5g}", unit)
    return [f"  mean {mean}, standard deviation {np.std(values, ddof=1):.3g}", f"  {least:.5g}, {words}, {most:.5g}"]


def in_words(found):
    title, unit = found.case.content.get("title", ""), found.unit
    middle = with_unit(f"{found.middle['amplitude']:.5g}", found.length)
    each = ", each contact point by itself" if found.each_point else ""
    lines = [f"ranges of {found.case.path}" + (f": {title}" if title else ""), *(f"  {wanted}" for wanted in found.ranges),
             f"{found.dof}, largest peak; in the middle of the ranges {middle} at {found.middle['omega']:.6g} {unit.omega}", ""]
    lines += [f"samples: {len(found.samples)}, seed {found.seed}{each}"]
    lines += _losses(found)
    if len(found.good) > 1:
        for name, word, in_unit in (("amplitude", "amplitude", found.length), ("omega", "frequency", unit.omega)):
            lines += [word + ":", *_spread_in_words(of_samples(found, name), in_unit)]
    return [*lines, "", *_first_order(found)] + _curves(found) + _sliders(found)


def _sliders(found):
    """What other states of the preload make of the peak."""
    if not found.sliders:
        return []
    good = [(name, record) for name, record in found.sliders if has_peak(record)]
    lines = ["", f"sliders: {len(found.sliders)} states of friction that the preload may leave, ranges in the middle"]
    if lost := [name for name, record in found.sliders if not has_peak(record)]:
        lines.append(f"caution: no peak with {', '.join(lost)}")
    for name, word in (("amplitude", "amplitude"), ("omega", "frequency")):
        values = [record[name] / found.middle[name] - 1 for _, record in good]
        if values:
            least, most = int(np.argmin(values)), int(np.argmax(values))
            lines.append(f"  {word} {100 * values[least]:+.3g} % ({good[least][0]}) to {100 * values[most]:+.3g} % ({good[most][0]}) "
                         "from that of sliders that begin at zero")
    return lines


def _losses(found):
    failed = [record for record in found.samples if record["status"] != 0]
    lines = [f"caution: {len(failed)} of them failed: {failed[0]['reason']}"] if failed else []
    if without := len(found.samples) - len(found.good) - len(failed):
        lines.append(f"caution: {without} of them have no peak inside the sweep and are left out; widen it with --omega")
    return lines


def _first_order(found):
    first = found.first
    missing = [wanted.name for wanted in found.ranges if wanted.name not in first.amplitude]
    lines = [f"first order: none by {', '.join(missing)}, where a run beside the middle has no peak"] if missing else []
    if not first.amplitude:
        return lines
    lines += ["first order from the middle (change of the peak from the middle to the upper end of each range):"]
    for name, slope in first.amplitude.items():
        share, of_omega = np.sum(slope) / found.middle["amplitude"], np.sum(first.omega[name]) / found.middle["omega"]
        lines.append(f"  {name:<24}amplitude {100 * share:+.3g} %, frequency {100 * of_omega:+.3g} %  (by {first.by[name]})")
    lines.append(f"  standard deviation of the amplitude {first.deviation():.3g}, of the frequency {first.deviation('omega'):.3g}")
    lines += [f"caution: first order is meaningless over these ranges: over {name} alone it changes the peak by "
              f"{abs(np.sum(first.amplitude[name])):.3g}, and the second difference of computed peaks adds {first.seconds[name]:.3g}"
              for name in first.bent]
    if unknown := [name for name in first.amplitude if not np.isfinite(first.seconds[name])]:
        lines.append(f"caution: no peak at an end of {', '.join(unknown)}, so that how far first order reaches there is not known")
    if first.flat:
        lines.append("caution: the slope of the peak is 0 in the middle: first order says nothing")
    elif not np.isfinite(first.second):
        lines.append("caution: no peak at the ends along the gradient, so that how far first order reaches is not known")
    else:
        head = "caution: first order is meaningless over these ranges:" if first.second > abs(first.change) else " "
        lines.append(f"{head} along the gradient it changes the peak by {abs(first.change):.3g}, and the second difference of computed "
                     f"peaks adds {first.second:.3g}")
    return lines


def _curves(found):
    lines = []
    for name, points in found.curves.items():
        lines += ["", f"over {name}, the others in the middle:" + _followed(found.tracks.get(name)),
                  f"  {name:>14}{'amplitude':>13}{found.unit.omega:>13}"]
        for number, record in points:
            if record["status"] != 0:
                lines.append(f"  {number:14.6g}  failed: {record['reason']}")
            else:
                lines.append(f"  {number:14.6g}{record['amplitude']:13.6g}{record['omega']:13.6g}"
                             + ("" if record["peak"] else "  at an end of the sweep, no peak"))
    return lines


def _followed(track):
    """How the numbers over one parameter came about, where its peak was to be followed."""
    if track is None:
        return ""
    if not len(track.number):
        return f" by sweeps, as the peak could not be followed: {track.reason}"
    return f" followed in {len(track.number)} points" + (f", by sweeps beyond: {track.reason}" if track.reason else "")


def numbers(found):
    """All of it but curves, for ranges.json."""
    def spread(name):
        values = of_samples(found, name)
        if len(values) < 2:
            return None
        return {"mean": float(np.mean(values)), "deviation": float(np.std(values, ddof=1)), "least": float(values.min()),
                "largest": float(values.max())} | {f"percentile_{p}": float(np.percentile(values, p)) for p in PERCENTILES}

    def short(record):
        return {key: record[key] for key in ("status", "reason", "omega", "amplitude", "rms", "peak") if key in record}

    first = found.first
    return {"case": found.case.path.name, "watched": found.dof, "seed": found.seed, "each_point": found.each_point,
            "ranges": [{"name": wanted.name, "kind": wanted.kind, "low": wanted.low, "high": wanted.high} for wanted in found.ranges],
            "middle": short(found.middle), "samples": len(found.samples), "with_peak": len(found.good),
            "amplitude": spread("amplitude"), "omega": spread("omega"),
            "first_order": {"amplitude": {name: np.asarray(slope).tolist() for name, slope in first.amplitude.items()},
                            "omega": {name: np.asarray(slope).tolist() for name, slope in first.omega.items()}, "by": first.by,
                            "amplitude_deviation": first.deviation(), "omega_deviation": first.deviation("omega"),
                            "change_along_gradient": _or_none(first.change), "second_difference": _or_none(first.second),
                            "second_differences": {name: _or_none(number) for name, number in first.seconds.items()},
                            "meaningless": first.meaningless},
            "curves": {name: [{"number": float(number), **short(record)} for number, record in points]
                       for name, points in found.curves.items()},
            "sliders": [{"name": name, **short(record)} for name, record in found.sliders],
            "tracks": {name: {"reason": track.reason} | {key: getattr(track, key).tolist()
                                                         for key in ("number", "omega", "amplitude", "rms")}
                       for name, track in found.tracks.items()}}


def _or_none(number):
    return float(number) if np.isfinite(number) else None


def _tables(found, path):
    with h5py.File(path, "w") as file:
        file.attrs["format"], file.attrs["case"], file.attrs["watched"] = "dovetail-ranges", found.case.path.name, found.dof
        for wanted in found.ranges:
            table = np.array([wanted.at(np.asarray(places[wanted.name])) for places in found.places])
            file[f"samples/{wanted.name}"] = table
            file[f"samples/{wanted.name}"].attrs["kind"] = wanted.kind
        for name in ("omega", "amplitude", "rms"):
            file[f"samples/{name}"] = np.array([record.get(name, np.nan) for record in found.samples], dtype=float)
        file["samples/peak"] = np.array([record.get("peak", False) for record in found.samples], dtype=np.int8)
        first = [found.first.at(found.middle["amplitude"], places) if len(found.first.amplitude) == len(found.ranges) else np.nan
                 for places in found.places]
        file["samples/first_order_amplitude"] = np.array(first, dtype=float)
        if (values := band(found)) is not None:
            file["band/omega"], file["band/amplitude"] = found.frequencies, values
            file["band/amplitude"].attrs["percentiles"] = (0, *PERCENTILES, 100)
