"""Time per point of a response curve against the number of contact points: a chain, and the blade root in slip.

The chain is the one on which published tools were timed (N = 128 samples), over its first resonance, 1.2 to 1.9 rad/s; a point there
slips and opens. The blade root is followed through its resonance, where most points slip, and once more under thirty times the load,
where three quarters of them open. A point is Newton's method and a tangent; the median of the runs, of one above 1000 points, is given,
and the share of each kind of work in the last by PETSc's -log_view.
"""

import argparse
import json
import os
import re
import shutil
import statistics
import sys
import time
from functools import partial

import numpy as np
from measure import BINARY, OUTPUT, ROOT, keep, summary_of, surroundings, weigh

from dovetail import Results

sys.path.insert(0, str(ROOT / "tests/verification"))
import chain

CHAIN, BLADE = [1, 4, 16, 64, 256, 1024], {102: "1x8", 506: "5x11", 1026: "9x13"}  # contact points; triangles on a flank
PEERS = {"tmdsimpy": {1: 0.027, 4: 0.064, 16: 0.34, 64: 13.4}, "pyHarm 1.2.2": {1: 0.047, 4: 0.15, 16: 0.80, 64: 11},
         "NLvib": {1: 0.064, 4: 0.39, 16: 2.6, 64: 60}}  # seconds per point at H = 5, measured on another machine like this one
LARGEST_ASSEMBLED = {"chain": 16, "blade root": 0, "blade opens": 0}  # contact points
WORK = {"HbContact": "contact laws", "HbMatrices": "K q, M q", "HbModes": "products with Phi", "HbExchange": "between ranks",
        "KSPGMRESOrthog": "orthogonalising"}
BLADE_CASE = """model = "{model}"
reduction = {{ modes = 12 }}
damping = {{ stiffness = 1e-6 }}
excitation = {{ fourier = [0, 0, {force}] }}
harmonic_balance = {{ harmonics = {harmonics}, solver = "{solver}" }}
continuation = {{ omega = [2118.5, 2125.5], max_points = {most} }}
stability = {{ enabled = false }}
accuracy = {{ estimates = false }}
output = {{ motion = [] }}
"""


def chain_case(folder, points, harmonics, solver):
    return chain.write(folder, points, harmonics, 128, solver, omega=(1.2, 1.9))


def blade_case(folder, points, harmonics, solver, force=1):
    """The model is made once, with a mesh that is just fine enough."""
    model = OUTPUT / f"points/blade_{points}/model.h5"
    if not model.exists():
        model.parent.mkdir(parents=True, exist_ok=True)
        weigh([sys.executable, ROOT / "inputs/blade_root/model.py", "--dofs", 60000, "--flank", BLADE[points], "-o", model])
    reduced = model.with_name("reduced.h5")
    folder.mkdir(parents=True, exist_ok=True)
    if reduced.exists():  # the same for every run
        shutil.copy(reduced, folder)
    path = folder / "case.toml"
    path.write_text(BLADE_CASE.format(model=model, harmonics=harmonics, solver=solver, force=force, most=40 if points < 1000 else 20))
    return path


CASES = {"chain": chain_case, "blade root": blade_case, "blade opens": partial(blade_case, force=30)}


def measured(scene, points, harmonics, solver, ranks, runs):
    """Figures of one setting: medians over the runs."""
    folder = OUTPUT / f"points/{scene.replace(' ', '_')}_{points}_{harmonics}_{solver}_{ranks}"
    case = CASES[scene](folder, points, harmonics, solver)
    command = [*(["mpirun", "-n", ranks] if ranks > 1 else []), BINARY, "run", case, "--out", folder, "-log_view"]
    each = []
    for _ in range(runs):
        text, _ = weigh(command)
        if scene.startswith("blade") and not (kept := OUTPUT / f"points/blade_{points}/reduced.h5").exists():
            shutil.copy(folder / "reduced.h5", kept)
        each.append(figures(folder))
    middle = {key: statistics.median(run[key] for run in each) for key in each[0]}
    row = {"scene": scene, "points": points, "harmonics": harmonics, "solver": solver, "ranks": ranks, **middle,
           "shares": shares(text, folder)}
    return row | rates(row, Results(folder / "results.h5").modes)


def rates(row, modes):
    """Operations and bytes per second of the products with Phi: two per linear iteration, in single precision."""
    contact = 3 * row["points"]
    seconds = row["shares"][WORK["HbModes"]] * row["mean"] * row["curve_points"]
    entries = 2 * row["iterations"] * contact * (contact + modes)
    if row["solver"] != "modal" or seconds < 1e-2:
        return {"gflops": float("nan"), "gbytes": float("nan")}
    return {"gflops": 2e-9 * entries * (2 * row["harmonics"] + 1) / seconds, "gbytes": 4e-9 * entries / seconds}


def machine():
    """What one thread does at its best, in single precision: a matrix product [GFLOP/s], a product of long vectors [GB/s]."""
    A, (v, w), best = np.ones((2000, 2000), np.float32), np.ones((2, 50_000_000), np.float32), [np.inf, np.inf]
    for _ in range(5):
        for which, work in enumerate((lambda: A @ A, lambda: v @ w)):
            start = time.perf_counter()
            work()
            best[which] = min(best[which], time.perf_counter() - start)
    return {"gflops": 2e-9 * 2000**3 / best[0], "gbytes": 2e-9 * v.nbytes / best[1]}


def figures(folder):
    """Of one run. The first point, whose start is far away, is left out of the time of a point."""
    results = Results(folder / "results.h5")
    summary, _ = summary_of(folder)
    branch = next(stage for stage in summary["stages"] if stage["name"] == "5 branch")
    seconds, newton, linear = (results.points(name) for name in ("seconds", "newton_iterations", "linear_iterations"))
    steps, solves = len(seconds), summary.get("linear_iterations", 0)  # those of tangents and located places as well
    return {"curve_points": steps, "wall": float(np.median(seconds[1:])), "mean": max(branch["seconds"]) / steps,
            "cpu": sum(branch["cpu"]) / steps, "newton": float(newton.mean()), "linear": float(linear.sum() / newton.sum()),
            "tangent": (summary["linear_iterations"] - linear.sum()) / steps if "linear_iterations" in summary else float("nan"),
            "iterations": solves, "cuts": summary["step_cuts"], "slip": float(results.points("slip")[-1]),
            "open": float(results.points("open").max()), "peak_mib": max(branch["peak_mib"])}


def shares(text, folder):
    """Parts of the stage's time on the first rank, of the kinds of work that -log_view tells."""
    stage = text[text.index("Event Stage", text.index("5 branch", text.index("Summary of Stages"))):]
    last = next(part for part in re.split(r"--- Event Stage \d+: ", stage) if part.startswith("5 branch"))
    whole = max(next(s for s in summary_of(folder)[0]["stages"] if s["name"] == "5 branch")["seconds"])
    found = {name: 0.0 for name in WORK.values()}
    for line in last.splitlines():
        fields = line.split()
        if fields and fields[0] in WORK:
            found[WORK[fields[0]]] = float(fields[3]) / whole
    return found


def table(rows):
    lines = [f"{'':11}{'points':>7}{'H':>4}{'solver':>11}{'ranks':>6}{'ms/point':>10}{'mean':>9}{'cpu':>9}{'Newton':>8}"
             f"{'linear':>8}{'slip':>6}{'open':>6}{'MiB':>7}{'GFLOP/s':>9}{'GB/s':>6}   "
             "shares: contact, matrices, Phi, ranks, orthog."]
    for row in rows:
        parts = "  ".join(f"{100 * part:3.0f}" for part in row["shares"].values())
        lines.append(f"{row['scene']:11}{row['points']:7}{row['harmonics']:4}{row['solver']:>11}{row['ranks']:6}{1e3 * row['wall']:10.2f}"
                     f"{1e3 * row['mean']:9.2f}{1e3 * row['cpu']:9.2f}{row['newton']:8.2f}{row['linear']:8.2f}{row['slip']:6.2f}"
                     f"{row['open']:6.2f}{row['peak_mib']:7.0f}{row['gflops']:9.1f}{row['gbytes']:6.1f}   {parts} %")
    return lines


def draw(rows, path):
    import matplotlib.pyplot as plt

    from dovetail.plot import LINES, STYLE

    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(7, 4.6))
        for (name, times), (colour, _) in zip(PEERS.items(), LINES[3:]):
            axes.loglog(list(times), [1e3 * t for t in times.values()], color=colour, ls=":", marker=".", label=f"{name}, chain, H = 5 *")
        kinds = [("chain", 5, "assembled"), ("chain", 5, "modal"), ("chain", 10, "modal"), ("blade root", 5, "modal"),
                 ("blade root", 10, "modal")]
        for (scene, harmonics, solver), marker in zip(kinds, "sovD^"):
            own = [row for row in rows if (row["scene"], row["harmonics"], row["solver"], row["ranks"]) == (scene, harmonics, solver, 1)]
            if own:
                axes.loglog([row["points"] for row in own], [1e3 * row["cpu"] for row in own], marker=marker, ms=4,
                            color=LINES[0][0] if scene == "chain" else LINES[1][0], ls="-" if harmonics == 5 else "--",
                            label=f"{scene}, H = {harmonics}, {solver}")
        axes.set_xlabel("contact points")
        axes.set_ylabel("processor time per point of the curve [ms]")
        axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1))
        figure.savefig(path, bbox_inches="tight")


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/points", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=3, metavar="N", help="of which the median is taken; default %(default)s")
    parser.add_argument("--chain", type=int, nargs="*", default=CHAIN, metavar="N", help="contact points of the chain")
    parser.add_argument("--blade", type=int, nargs="*", default=list(BLADE), choices=list(BLADE), metavar="N",
                        help=f"contact points of the blade root, of {list(BLADE)}")
    parser.add_argument("--harmonics", type=int, nargs="*", default=[5, 10], metavar="H")
    parser.add_argument("--ranks", type=int, nargs="*", default=[1, 2], metavar="R")
    parser.add_argument("--add", action="store_true", help="to the figures in build/bench/points.json, in table and chart as well")
    parser.add_argument("--picture", metavar="PNG", help="chart of processor time per point on one rank")
    options = parser.parse_args()
    around, best = surroundings(), machine()
    rows = json.loads((OUTPUT / "points.json").read_text())["rows"] if options.add else []
    opened = [points for points in options.blade if points < 1000]  # the first point of more takes minutes
    for scene, sizes in (("chain", options.chain), ("blade root", options.blade), ("blade opens", opened)):
        for harmonics in options.harmonics:
            for solver in ("assembled", "modal"):
                for ranks in options.ranks if solver == "modal" and scene != "blade opens" else [1]:
                    for points in sizes:
                        if solver == "assembled" and (points > LARGEST_ASSEMBLED[scene] or harmonics > 5):
                            continue
                        rows.append(measured(scene, points, harmonics, solver, ranks, 1 if points > 1000 else options.runs))
                        print(table(rows[-1:])[-1], file=sys.stderr)
    print(f"time per point, median of {options.runs} runs; {around['cores']} cores, load {around['load_at_start']:.1f} before, "
          f"{os.getloadavg()[0]:.1f} after\n")
    print("\n".join(table(rows)))
    print("\nms/point: median of the points of a curve, wall; mean, cpu: of the whole curve with its failed steps, CPU of all ranks;\n"
          "Newton: iterations per point; linear: per Newton iteration; slip: points that slip at the last point; open: most that open;\n"
          "GFLOP/s, GB/s: of the products with Phi; one thread at its best, a matrix product and a product of long vectors: "
          f"{best['gflops']:.0f} GFLOP/s, {best['gbytes']:.1f} GB/s")
    print("published tools on the chain, H = 5, N = 128, ms per point (not run here): " + "; ".join(
        f"{name} " + ", ".join(f"{points}: {1e3 * t:g}" for points, t in times.items()) for name, times in PEERS.items()))
    keep("points", {**around, "machine": best, "runs": options.runs, "rows": rows, "peers_measured_elsewhere": PEERS})
    if options.picture:
        draw(rows, options.picture)


if __name__ == "__main__":
    main()
