"""Estimated against true errors, and runs by tolerance against fixed harmonics, on scenes that differ in kind.

The true error of a point is its distance from the curve of a reference with many more harmonics, in the measure of the estimates
(docs/theory/error-estimates.md), at frequencies that all runs pass. Fixed harmonics are timed without estimates, and run once more with
them. All runs of a scene are repeated in turn, so that what else the machine does meets all of them.
"""

import argparse
import json
import shutil
import statistics
import sys

import h5py
import numpy as np
from accuracy_scenes import SCENES
from measure import BINARY, OUTPUT, keep, surroundings, weigh

from dovetail import Results
from dovetail.study_errors import distances
from dovetail.study_runs import toml

TOLERANCES = (1e-2, 1e-3, 1e-4)
RUNS = ((0.3, 15), (5, 5), (1e9, 1))  # so many, of which the median time is taken, where one takes less [s]
FREQUENCIES = 40
WITH_MODES = 3  # harmonics, where modes are what differs
OFFSET = 3e-6  # of the sweep: of the reference's points beside each frequency
CHOSEN = "chosen"  # modes, by the tolerance
SOME = 1e-7  # true errors below are none
LEAST = 1e-9  # and those below are drawn here


class Bench:
    """One scene: its reference, and runs compared with it."""

    def __init__(self, name):
        self.name, self.scene = name, SCENES[name]
        self.folder = OUTPUT / "accuracy" / name.replace(" ", "_")
        self.folder.mkdir(parents=True, exist_ok=True)
        self.times = {}  # folder: processor times per point [s]
        self.runs = {}  # folder: how often it runs
        self.content = self.scene.make(self.folder)
        begin, end = self.content["continuation"]["omega"]
        self.sweep, self.down = abs(end - begin), end < begin
        self.frequencies = np.linspace(begin, end, FREQUENCIES + 2)[1:-1]
        self.content["continuation"].pop("max_points", None)
        self.reference = self.finest("reference", self.scene.reference)

    def finest(self, name, harmonics, modes=None):
        offsets = [f + shift * OFFSET * self.sweep for f in self.frequencies for shift in (-1, 0, 1)]
        folder, _ = self.run(name, {"harmonics": harmonics}, {"estimates": False}, offsets, modes=modes)
        return Results(folder / "results.h5")

    def run(self, name, balance, accuracy, at, modes=None):
        """The folder, and figures."""
        folder = self.folder / name
        folder.mkdir(exist_ok=True)
        content = {**self.content, "stability": {"enabled": False}, "accuracy": accuracy,
                   "harmonic_balance": {**{key: value for key, value in self.content.get("harmonic_balance", {}).items()
                                           if key == "solver"}, **balance},
                   "continuation": {**self.content["continuation"], "at": sorted(map(float, at), reverse=self.down)}}
        content["output"] = {"motion": []} if "model" in content else {}
        if self.scene.one_of_several and name != "reference":
            content["continuation"]["start"] = str(self.folder / "reference/results.h5")
        if modes is not None:
            content["reduction"] = {key: value for key, value in content["reduction"].items() if key != "modes"}
            content["reduction"] |= {} if modes == CHOSEN else {"modes": modes}
        (folder / "case.toml").write_text(toml(content))
        # reduced once for every run
        if modes is None and (made := self.folder / "reference/reduced.h5").exists() and folder.name != "reference":
            shutil.copy(made, folder)
        return folder, self.once(folder)

    def once(self, folder):
        weigh([BINARY, "run", folder / "case.toml", "--out", folder])
        summary = json.loads((folder / "summary.json").read_text())
        cpu = {stage["name"]: sum(stage["cpu"]) for stage in summary["stages"]}["5 branch"]
        self.times.setdefault(folder, []).append(cpu / summary["points"])
        self.runs.setdefault(folder, next(runs for limit, runs in RUNS if cpu < limit))
        return {"points": summary["points"], "end": summary["end"]}

    def timed(self, rows):
        """Repeats in turn what the rows time, and gives them the medians [s per point]."""
        folders = {row[key] for row in rows for key in ("folder", "estimated") if key in row}
        for again in range(1, max(runs for _, runs in RUNS)):
            for folder in sorted(folder for folder in folders if again < self.runs[folder]):
                self.once(folder)
        for row in rows:
            row["seconds"] = statistics.median(self.times[row.pop("folder")])
            if "estimated" in row:
                row["with_estimates"] = statistics.median(self.times[row.pop("estimated")])
        return rows

    def true_errors(self, folder, reference=None, contacts_alone=False):
        results = Results(folder / "results.h5")
        with h5py.File(folder / "state.h5") as state:
            scales = state["scales"][()]
        if contacts_alone:
            scales[1] = np.inf
        at, true = distances(results, reference or self.reference, scales, self.sweep, self.frequencies, OFFSET * self.sweep)
        return results, at, true

    def fixed(self, harmonics):
        bare, plain = self.run(f"H{harmonics}", {"harmonics": harmonics}, {"estimates": False}, self.frequencies)
        if 2 * harmonics > self.scene.reference:  # which says nothing of an estimate by twice the harmonics
            return {"scene": self.name, "harmonics": harmonics, "folder": bare, **plain, **spread(self.true_errors(bare)[2])}
        folder, _ = self.run(f"H{harmonics}_estimated", {"harmonics": harmonics}, {"estimates": True}, self.frequencies)
        results, at, true = self.true_errors(folder)
        return {"scene": self.name, "harmonics": harmonics, "folder": bare, "estimated": folder, **plain, **spread(true),
                **judged(true, of_balance(results)[at])}

    def by_modes(self):
        """Rows for all numbers of modes but the last, which is the reference."""
        *counts, most = self.scene.modes
        reference, rows = self.finest("most_modes", WITH_MODES, most), []
        for count in counts:
            folder, figures = self.run(f"modes{count}", {"harmonics": WITH_MODES}, {}, self.frequencies, modes=count)
            results, at, true = self.true_errors(folder, reference)
            rows.append({"scene": self.name, "modes": count, **figures, **spread(true), **judged(true, results.points("error_modes")[at])})
        return rows

    def by_tolerance(self, tolerance):
        folder, figures = self.run(f"tolerance{tolerance:g}", {}, {"tolerance": tolerance}, self.frequencies)
        return {"scene": self.name, "tolerance": tolerance, "folder": folder, **figures, **self.kept(folder, tolerance)}

    def kept(self, folder, tolerance, reference=None):
        results, _, true = self.true_errors(folder, reference, contacts_alone=reference is not None)
        used = results.points("harmonics")
        return {**spread(true), "within": float(np.mean(true <= tolerance)), "fewest": int(used.min()), "most": int(used.max()),
                "told_above": int(np.sum(of_balance(results) > tolerance))}

    def modes_by_tolerance(self):
        """Rows for tolerances that choose modes as well, against the most modes and harmonics: by the motion of the contacts, since half of
        the modes are other ones (reduction.kind = "residual")."""
        reference, rows = self.finest("most", self.scene.reference, self.scene.modes[-1]), []
        for tolerance in TOLERANCES:
            folder, figures = self.run(f"modes_by_tolerance{tolerance:g}", {}, {"tolerance": tolerance}, self.frequencies, modes=CHOSEN)
            rows.append({"scene": self.name, "both": tolerance, "chosen": Results(folder / "results.h5").modes, **figures,
                         **self.kept(folder, tolerance, reference)})
        return rows


def of_balance(results):
    """Estimated errors by harmonics and samples: references have the same modes."""
    return results.points("error_harmonics") + results.points("error_sampling")


def judged(true, estimated):
    """Quantiles of true by estimated error, and how many are within a factor of 5, where there is any error."""
    some = true > SOME
    if not some.any():
        return {}
    ratio = true[some] / estimated[some]
    return {"ratios": [float(q) for q in np.quantile(ratio, (0.05, 0.5, 0.95))], "judged": int(some.sum()),
            "within_5": float(np.mean((ratio > 0.2) & (ratio < 5)))}


def spread(true):
    return {"compared": len(true), "error": float(np.quantile(true, 0.95)), "largest": float(true.max())}


def compare(rows):
    """Adds to every run by tolerance the cheapest fixed harmonics that are as good at 95 % of the points."""
    for row in rows:
        if "tolerance" in row:
            good = [other for other in rows if other["scene"] == row["scene"] and "harmonics" in other
                    and other["error"] <= max(row["tolerance"], row["error"])]
            best = min(good, key=lambda other: other["seconds"], default=None)
            row["rival"] = best and best["harmonics"]
            row["times_rival"] = best and row["seconds"] / best["seconds"]


def in_words(row):
    ratios = " ".join(f"{q:6.2f}" for q in row.get("ratios", ())) or "     none"
    return f"{ratios:27} " + (f"{100 * row['within_5']:3.0f} % of {row['judged']}" if "ratios" in row else "")


def table(rows):
    """Lines of text."""
    lines = ["scene            harmonics  points  ms/point  with estimates  error: 95 %  largest   true/estimate 5, 50, 95 %   within 5"]
    for row in (row for row in rows if "harmonics" in row):
        lines.append(f"{row['scene']:16} {row['harmonics']:9d} {row['points']:7d} {1e3 * row['seconds']:9.3g}"
                     f"{1e3 * row.get('with_estimates', float('nan')):16.3g} {row['error']:12.1e} {row['largest']:8.1e}   {in_words(row)}")
    lines += ["", f"scene (H = {WITH_MODES})        modes  points  error: 95 %  largest   true/estimate 5, 50, 95 %   within 5"]
    for row in (row for row in rows if "modes" in row):
        lines.append(f"{row['scene']:16} {row['modes']:9d} {row['points']:7d} {row['error']:12.1e} {row['largest']:8.1e}   {in_words(row)}")
    lines += ["", "scene            tolerance  points  ms/point  harmonics  error: 95 %  largest   kept at   against"]
    for row in rows:
        if "tolerance" in row:
            rival = f"{row['times_rival']:.2f} times H = {row['rival']}" if row["rival"] else "none as good"
            lines.append(f"{row['scene']:16} {row['tolerance']:9.0e} {row['points']:7d} {1e3 * row['seconds']:9.3g}"
                         f"{row['fewest']:7d}-{row['most']:<3d} {row['error']:12.1e} {row['largest']:8.1e}   {100 * row['within']:5.0f} %"
                         f"   {rival}" + (f"; told above at {row['told_above']} points" if row["told_above"] else ""))
    lines += ["", "scene            tolerance  modes  harmonics  error: 95 %  largest   kept at   (modes by tolerance too)"]
    for row in (row for row in rows if "both" in row):
        lines.append(f"{row['scene']:16} {row['both']:9.0e} {row['chosen']:6d} {row['fewest']:6d}-{row['most']:<3d} {row['error']:12.1e} "
                     f"{row['largest']:8.1e}   {100 * row['within']:5.0f} %")
    return lines


def draw(rows, path):
    """A panel per scene: what harmonics buy, and the runs by tolerance as stars."""
    import matplotlib.pyplot as plt
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

    from dovetail.plot import STYLE

    names = list(dict.fromkeys(row["scene"] for row in rows))
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(2, 4, figsize=(13, 6.4), layout="constrained")
        for axis, name in zip(axes.flat, names):
            for key, marker, fill in (("harmonics", "o", "black"), ("tolerance", "*", "white")):
                for row in (row for row in rows if row["scene"] == name and key in row):
                    x, y = 1e3 * row["seconds"], max(row["error"], LEAST)
                    axis.loglog(x, y, marker, color="black", mfc=fill, ms=5 if key == "harmonics" else 11)
                    axis.annotate(f"{row[key]:g}", (x, y), xytext=(5, 4), textcoords="offset points", fontsize=8)
            fixed = [row for row in rows if row["scene"] == name and "harmonics" in row]
            axis.loglog([1e3 * row["seconds"] for row in fixed], [max(row["error"], LEAST) for row in fixed], color="0.6", lw=1, zorder=0)
            axis.set_title(f"{name}\n{SCENES[name].kind}", fontsize=9)
            axis.margins(0.18)
            axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.xaxis.set_major_formatter(FormatStrFormatter("%g"))
            axis.xaxis.set_minor_formatter(NullFormatter())
            if max(row["error"] for row in fixed) < LEAST:
                axis.set_ylim(LEAST / 10, 1e3 * LEAST)
                axis.text(0.05, 0.9, f"all below {LEAST:g}", transform=axis.transAxes)
        for axis in axes.flat[len(names):]:
            axis.axis("off")
        axes.flat[-1].plot([], [], "o", color="black", label="fixed harmonics, their number")
        axes.flat[-1].plot([], [], "*", color="black", mfc="white", ms=11, label="by tolerance")
        axes.flat[-1].legend(loc="center")
        figure.supxlabel("processor time per point [ms]")
        figure.supylabel("true error, 95 % of the points below")
        figure.savefig(path)


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/accuracy", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES), metavar="NAME", help=f"of {list(SCENES)}")
    parser.add_argument("--picture", metavar="PNG", help="a panel per scene")
    options = parser.parse_args()
    around, rows = surroundings(), []
    for name in options.scenes:
        bench = Bench(name)
        rows += bench.timed([bench.fixed(harmonics) for harmonics in bench.scene.harmonics]
                            + [bench.by_tolerance(tolerance) for tolerance in TOLERANCES])
        if bench.scene.modes:
            rows += bench.by_modes()
        if bench.scene.choose_modes:
            rows += bench.modes_by_tolerance()
        print(f"{name}: done", file=sys.stderr)
    compare(rows)
    print("\n".join(table(rows)))
    keep("accuracy", {**around, "runs": RUNS, "rows": rows})
    if options.picture:
        draw(rows, options.picture)


if __name__ == "__main__":
    main()
