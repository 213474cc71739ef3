"""Where the time and memory of a reduction go: the blade root, by size and ranks, its factorisation beside the machine's dgemm."""

import argparse
import re
import shutil
import statistics
import sys
import time

import numpy as np
from measure import BINARY, OUTPUT, ROOT, keep, summary_of, surroundings, weigh

EXAMPLE = ROOT / "inputs/blade_root"
PICTURE = ROOT / "docs/notes/reduction.png"
ASSEMBLY_RANKS = 2
FACTORISATION = "factorisation"
STAGES = {"1 model": "read and distribute", "2a analysis": "ordering, analysis", "2c factorisation": FACTORISATION, "2d modes": "modes",
          "2e constraint modes": "Psi", "2f projections": "projections", "2h writing": "writing"}  # none contains another
REST = "between these"
CASE = """model = "model.h5"
reduction = {{ modes = {modes} }}
excitation = {{ fourier = [0, 0, 1] }}    # required, as are the next two; a reduction looks at none of them
harmonic_balance = {{ harmonics = 3 }}
continuation = {{ omega = [2102, 2138] }}
"""


def dgemm(n=2000, times=5):
    """GFLOP/s of a product of two n x n matrices on one thread, best of so many."""
    a, b = np.random.default_rng(0).standard_normal((2, n, n))
    product = np.empty_like(a)
    seconds = []
    for _ in range(times):
        start = time.perf_counter()
        np.matmul(a, b, out=product)
        seconds.append(time.perf_counter() - start)
    return 2e-9 * n**3 / min(seconds)


def assemble(dofs, flank, modes, folder):
    """Write model.h5 and case.toml into an empty folder: dofs and contact points of the model, what making it cost."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    said, cost = weigh(["mpirun", "-n", ASSEMBLY_RANKS, sys.executable, EXAMPLE / "model.py", "--dofs", dofs,
                        "--flank", "x".join(map(str, flank)), "-o", folder / "model.h5"])
    (folder / "case.toml").write_text(CASE.format(modes=modes))
    found = re.search(r"(\d+) dofs, (\d+) contact points, ([\d.]+) s on", said)
    return {"dofs": int(found[1]), "points": int(found[2]), "seconds": float(found[3]), "wall": cost.wall, "cpu": cost.cpu,
            "peak_mib": cost.peak_mib, "ranks": ASSEMBLY_RANKS}


def one_run(folder, ranks):
    """Figures of one reduction on so many ranks, from scratch."""
    out = folder / f"ranks_{ranks}"
    shutil.rmtree(out, ignore_errors=True)  # a reduced.h5 that is there would be used again
    _, cost = weigh(["mpirun", "-n", ranks, BINARY, "reduce", folder / "case.toml", "--out", out])
    return {**figures(*summary_of(out)), "wall": cost.wall}


def figures(summary, stages):
    """Seconds of every stage in order, the total, CPU time and memory of a run, from what `summary_of` returns.

    Memory is that of the rank which took most: "peak_mib" and what had been forecast for that same rank.
    """
    records = {stage["name"]: stage for stage in summary["stages"]}
    total = stages["1 model"] + stages["2 reduction"]
    seconds = {label: stages[name] for name, label in STAGES.items()}
    seconds[REST] = total - sum(seconds.values())
    peaks, about = records["2 reduction"]["peak_mib"], summary["reduction"]
    fullest = int(np.argmax(peaks))
    return {"seconds": seconds, "total": total, "cpu": sum(records["1 model"]["cpu"] + records["2 reduction"]["cpu"]),
            "gflops": 1e-9 * about["flops"] / seconds[FACTORISATION], "flops": about["flops"],
            "peak_mib": peaks[fullest], "forecast_mib": about["forecast_mib"][fullest],
            "forecast_over_peak": about["forecast_mib"][fullest] / peaks[fullest], "backward_error": about["backward_error"],
            "ordering": about["ordering"], "psi": "kept" if about["kept_psi"] else "in blocks"}


def middle_run(runs):
    """Median of every number over the runs; words that differ are all named. Lowest and highest total beside it."""
    middle = {"seconds": {name: statistics.median(run["seconds"][name] for run in runs) for name in runs[0]["seconds"]}}
    for key in runs[0].keys() - {"seconds"}:
        values = [run[key] for run in runs]
        middle[key] = "/".join(sorted(set(values))) if isinstance(values[0], str) else statistics.median(values)
    totals = [run["total"] for run in runs]
    middle["lowest"], middle["highest"] = min(totals), max(totals)
    return middle


def table(measured, machine):
    """Lines of text: a column for every entry of `measured`, {"model": of assemble, "ranks", "run": of middle_run}.

    machine: GFLOP/s of dgemm on one thread.
    """
    rows = [("dofs", lambda m, ranks, r: f"{m['dofs']}"),
            ("contact points", lambda m, ranks, r: f"{m['points']}"),
            ("ranks", lambda m, ranks, r: f"{ranks}"),
            ("ordering", lambda m, ranks, r: r["ordering"]),
            (f"mesh, assembly ({ASSEMBLY_RANKS} ranks) [s]", lambda m, ranks, r: f"{m['seconds']:.1f}"),
            ("  largest rank [MiB]", lambda m, ranks, r: f"{m['peak_mib']:.0f}")]
    for name in (*STAGES.values(), REST):
        rows.append((f"{name} [s]", lambda m, ranks, r, name=name: f"{r['seconds'][name]:.2f}"))
        if name == FACTORISATION:
            rows += [("  GFLOP/s", lambda m, ranks, r: f"{r['gflops']:.1f}"),
                     ("  of dgemm, per rank", lambda m, ranks, r: f"{r['gflops'] / (ranks * machine):.0%}")]
        if name == "Psi":
            rows.append(("  Psi", lambda m, ranks, r: r["psi"]))
    rows += [("total [s]", lambda m, ranks, r: f"{r['total']:.2f}"),
             ("  lowest run", lambda m, ranks, r: f"{r['lowest']:.2f}"),
             ("  highest run", lambda m, ranks, r: f"{r['highest']:.2f}"),
             ("CPU time, all ranks [s]", lambda m, ranks, r: f"{r['cpu']:.2f}"),
             ("peak memory, largest rank [MiB]", lambda m, ranks, r: f"{r['peak_mib']:.0f}"),
             ("  forecast for it [MiB]", lambda m, ranks, r: f"{r['forecast_mib']:.0f}"),
             ("  forecast / peak", lambda m, ranks, r: f"{r['forecast_over_peak']:.2f}"),
             ("backward error", lambda m, ranks, r: f"{r['backward_error']:.0e}")]
    return [f"{label:34}" + "".join(f"{show(one['model'], one['ranks'], one['run']):>11}" for one in measured) for label, show in rows]


def draw(path, measured):
    """A panel for every size, a stacked bar for every number of ranks; parts told apart by hatching as well as by grey."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    looks = [("black", ""), ("white", ""), ("#777777", ""), ("white", "////"), ("#d5d5d5", ""), ("white", "xxxx"), ("#444444", ""),
             ("white", "....")]
    models = list({one["model"]["dofs"]: one["model"] for one in measured}.values())
    bars = [[one for one in measured if one["model"]["dofs"] == model["dofs"]] for model in models]
    with plt.rc_context({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.axisbelow": True,
                         "hatch.linewidth": 0.6}):
        heights = [0.5, *(0.5 + 0.38 * len(some) for some in bars)]
        figure, axes = plt.subplots(len(heights), figsize=(7.5, 0.5 + sum(heights)), layout="constrained", dpi=160, height_ratios=heights)
        for axis, model, some in zip(axes[1:], models, bars):
            widest = max(one["run"]["total"] for one in some)
            begin = np.zeros(len(some))
            for name, (face, hatch) in zip((*STAGES.values(), REST), looks):
                seconds = np.array([max(0.0, one["run"]["seconds"][name]) for one in some])
                axis.barh(range(len(some)), seconds, 0.7, begin, label=name, facecolor=face, hatch=hatch, edgecolor="black", linewidth=0.6)
                for i in np.flatnonzero(seconds > 0.07 * widest):
                    axis.text(begin[i] + seconds[i] / 2, i, f"{seconds[i]:.3g}", ha="center", va="center", fontsize=7,
                              bbox={"facecolor": "white", "edgecolor": "none", "pad": 1})
                begin += seconds
            for i, one in enumerate(some):
                axis.annotate(f"{one['run']['total']:.3g} s, {one['run']['peak_mib']:.0f} MiB{' per rank' * (one['ranks'] > 1)}",
                              (begin[i], i), xytext=(4, 0), textcoords="offset points", va="center", fontsize=7)
            axis.set_yticks(range(len(some)), [f"{one['ranks']} rank{'s' * (one['ranks'] > 1)}" for one in some])
            axis.set_xlim(0, 1.25 * widest)
            axis.invert_yaxis()
            axis.tick_params(axis="y", length=0)
            axis.grid(axis="x", color="#e3e3e3", linewidth=0.7)
            axis.set_title(f"{model['dofs']} dofs, {model['points']} contact points", loc="left", fontsize=9)
        axes[-1].set_xlabel("wall time [s]")
        axes[0].axis("off")
        axes[0].legend(*axes[1].get_legend_handles_labels(), frameon=False, loc="center", ncol=4, handlelength=2.2, handleheight=1.2)
        figure.savefig(path)
    print(f"picture: {path.relative_to(ROOT)}")


def positive(text):
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} given, a number from 1 on wanted")
    return value


def pair(text):
    parts = text.split("x")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"{text} given, NxM wanted")
    return tuple(positive(part) for part in parts)


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/reduction", description=__doc__)
    parser.add_argument("--dofs", type=positive, nargs="+", default=[20_000, 60_000, 150_000], metavar="N",
                        help="about as many unknowns; default 20000 60000 150000")
    parser.add_argument("--ranks", type=positive, nargs="+", default=[1, 2], metavar="R", help="default 1 2")
    parser.add_argument("--flank", type=pair, default=(4, 13), metavar="NxM",
                        help="pairs of triangles down a flank and along the axis: 2 (2N+1) (2M+1) contact points; default 4x13, 486 points")
    parser.add_argument("--modes", type=positive, default=50, metavar="N", help="default %(default)s")
    parser.add_argument("--runs", type=positive, default=3, metavar="N", help="median of so many; default %(default)s")
    parser.add_argument("--picture", action="store_true", help=f"draw to {PICTURE.relative_to(ROOT)} instead of build/bench")
    options = parser.parse_args()
    around = surroundings()
    start = dgemm()
    sizes, every = sorted(set(options.dofs)), sorted(set(options.ranks))
    folders = {dofs: OUTPUT / f"reduction_{dofs}" for dofs in sizes}
    models = {dofs: assemble(dofs, options.flank, options.modes, folders[dofs]) for dofs in sizes}
    runs = {(dofs, ranks): [] for dofs in sizes for ranks in every}
    for i in range(options.runs):
        for (dofs, ranks), done in runs.items():  # all in turn, so that a slow minute hits all alike
            done.append(one_run(folders[dofs], ranks))
            print(f"run {i + 1} of {options.runs}, {dofs} dofs, ranks {ranks}: {done[-1]['total']:.1f} s", file=sys.stderr)
    end = dgemm()
    machine = max(start, end)
    measured = [{"model": models[dofs], "ranks": ranks, "run": middle_run(done), "runs": done} for (dofs, ranks), done in runs.items()]

    print(f"reduction of the blade root to {options.modes} modes: wall time on the slowest rank, median of {options.runs} "
          f"run{'s' * (options.runs > 1)}; {around['cores']} cores, load {around['load_at_start']:.1f}")
    print(f"dgemm, one thread: {start:.1f} GFLOP/s before, {end:.1f} after\n")
    print("\n".join(table(measured, machine)))
    keep("reduction", {**around, "modes": options.modes, "dgemm_gflops": {"before": start, "after": end}, "measured": measured})
    draw(PICTURE if options.picture else OUTPUT / PICTURE.name, measured)


if __name__ == "__main__":
    main()
