"""Error and price of a point of the curve, Dovetail against other methods, on the chain of scripts/bench/points.

Error: of the tip's first harmonic along t1, relative, the largest of five frequencies from 0.9 to 1.1 of the peak. The truth is Dovetail
with exact contact forces and many harmonics; how far time integration from event to event is from it is told. Price: processor time per
point of the curve on one thread, median of the runs, without start, reduction and compiling.
"""

import argparse
import statistics
import subprocess
import sys

import numpy as np
from field_methods import PEER, PEER_FOLDER, SAMPLES, Chain
from measure import ROOT, keep, surroundings
from points import PEERS

CHAINS = [1, 4, 16, 64]  # contact points
TRUTH, FINE = 60, 1e-9  # harmonics of the truth; tolerance of the integration that checks it
LONG = 10.0  # seconds: what takes longer is run once
ACCURACIES = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3)
METHODS = {  # name: function of Chain, settings, most contact points, marker, line, colour
    "Dovetail": (Chain.dovetail, (1, 3, 5, 7, 10, 15, 20), 64, "o", "-", "#000000"),
    f"Dovetail, N = {SAMPLES}": (Chain.sampled, (1, 3, 5, 10), 64, ".", ":", "#000000"),
    f"dovetail.reference, N = {SAMPLES}": (Chain.numpy, (1, 3, 5, 10), 16, "s", "--", "#c1440e"),
    f"pyHarm, N = {SAMPLES}": (Chain.pyharm, (1, 3, 5, 10), 16, "D", "-.", "#1f6f9f"),
    "Newmark, NumPy": (Chain.newmark, ACCURACIES, 64, "^", (0, (1, 1)), "#6a9a1f"),
    "event to event": (Chain.events, (1e-2, 1e-6), 64, "v", (0, (6, 1, 1, 1)), "#8a4f9e"),
}
ELSEWHERE = dict(zip(PEERS, "x1+"))  # markers
PRICES = (1e-1, 1e-2, 1e-3, 1e-4)


def measured(scene, truth, method, runs):
    """Rows of one method on one chain: setting, error, seconds per point, or why not."""
    function, settings, *_ = METHODS[method]
    for setting in settings:
        times = []
        try:
            for _ in range(runs):
                found, seconds, spent = function(scene, setting)
                times.append(seconds)
                if spent > LONG:
                    break
        except RuntimeError as error:
            yield {"points": scene.points, "method": method, "setting": setting, "why": str(error)}
            continue
        yield {"points": scene.points, "method": method, "setting": setting, "error": float(np.abs(found / truth - 1).max()),
               "seconds": statistics.median(times), "lowest": min(times), "highest": max(times), "runs": len(times)}


def elsewhere(rows, points):
    """The published tools: times of another machine, with the error that their H = 5 and N = 128 have here."""
    same = (points, f"Dovetail, N = {SAMPLES}", 5)
    twin = next((row["error"] for row in rows if (row["points"], row["method"], row["setting"]) == same), None)
    return [{"points": points, "method": name, "setting": 5, "error": twin, "seconds": times[points], "elsewhere": True}
            for name, times in PEERS.items() if twin and points in times]


def install():
    """The peer, into build/bench and nowhere else; the reason if that does not work."""
    run = subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--target", PEER_FOLDER, PEER], text=True, capture_output=True)
    return run.returncode and (run.stderr.strip().splitlines() or ["pip failed"])[-1]


def table(rows):
    lines = ["contact points  method                  setting    error   ms/point      lowest to highest  runs"]
    for row in rows:
        start = f"{row['points']:14d}  {row['method'] + (' *' if 'elsewhere' in row else ''):22}{row['setting']:9g}"
        if "why" in row:
            lines.append(f"{start}   {row['why']}")
            continue
        spread = f"{1e3 * row['lowest']:12.3g} to {1e3 * row['highest']:<8.3g}{row['runs']:4d}" if "runs" in row else ""
        lines.append(f"{start} {row['error']:8.1e} {1e3 * row['seconds']:10.3g} {spread}".rstrip())
    return lines


def cheapest(rows, points, method, error):
    """The row of the least time within an error, or None."""
    own = (row for row in rows if (row["points"], row["method"]) == (points, method) and row.get("error", np.inf) <= error)
    return min(own, key=lambda row: row["seconds"], default=None)


def prices(rows):
    """What an error costs, ms per point and the setting: a line for every chain and method."""
    lines = ["contact points  method                " + "".join(f"{f'within {error:g}':>18}" for error in PRICES)]
    for points, method in dict.fromkeys((row["points"], row["method"]) for row in rows if "elsewhere" not in row):
        best = [cheapest(rows, points, method, error) for error in PRICES]
        words = [f"{1e3 * row['seconds']:.3g} ({row['setting']:g})" if row else "-" for row in best]
        lines.append(f"{points:14d}  {method:22}" + "".join(f"{word:>18}" for word in words))
    return lines


def draw(rows, path):
    """A panel for each number of contact points."""
    import matplotlib.pyplot as plt
    from matplotlib.ticker import LogLocator

    from dovetail.plot import STYLE

    sizes = sorted({row["points"] for row in rows})
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(max(7, 1 + 3.2 * len(sizes)), 6.4), layout="constrained")
        grid = figure.add_gridspec(2, len(sizes), height_ratios=[6, 1])
        first = None
        for column, points in enumerate(sizes):
            axis = figure.add_subplot(grid[0, column], sharey=first)
            first = first or axis
            here = [row for row in rows if row["points"] == points and "error" in row]
            for method, (*_, marker, line, colour) in METHODS.items():
                own = [(row["error"], 1e3 * row["seconds"], row["setting"]) for row in here if row["method"] == method]
                if own:
                    axis.loglog(*zip(*[each[:2] for each in own]), marker=marker, ls=line, color=colour, ms=5)
                for (x, y, setting), after in zip(own, [*own[1:], None]) if marker == "o" else ():
                    beside = (12, -3) if after is None else (3, -13) if y <= after[1] else (3, 6)
                    axis.annotate(f"{setting:g}", (x, y), xytext=beside, textcoords="offset points", fontsize=8, ha="center")
            for row in (row for row in here if "elsewhere" in row):
                axis.loglog(row["error"], 1e3 * row["seconds"], ELSEWHERE[row["method"]], color="0.35", ms=8, mew=1.5, zorder=4)
            axis.set_title(f"{points} contact point{'s' if points > 1 else ''}")
            axis.set_xlim(1, 2e-9)
            axis.set_xlabel("error")
            axis.xaxis.set_major_locator(LogLocator(numticks=5))
            axis.tick_params(labelleft=column == 0)
        first.set_ylabel("processor time per point of the curve [ms]")
        handles = [plt.Line2D([], [], marker=marker, ls=line, color=colour, ms=5, label=name)
                   for name, (*_, marker, line, colour) in METHODS.items() if any(row["method"] == name and "error" in row for row in rows)]
        handles += [plt.Line2D([], [], marker=marker, ls="", color="0.35", ms=8, mew=1.5, label=f"{name}, H = 5 (elsewhere)")
                    for name, marker in ELSEWHERE.items() if any(row["method"] == name for row in rows)]
        below = figure.add_subplot(grid[1, :])
        below.axis("off")
        below.legend(handles=handles, loc="center", ncol=3, fontsize=9)
        figure.savefig(path)


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/field", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--points", type=int, nargs="+", default=CHAINS, metavar="N", help="contact points; default %(default)s")
    parser.add_argument("--methods", nargs="+", choices=list(METHODS), default=list(METHODS), metavar="NAME", help=f"of {list(METHODS)}")
    parser.add_argument("--runs", type=int, default=3, metavar="N",
                        help=f"of which the median time is taken; default %(default)s; one of what takes more than {LONG:g} s")
    parser.add_argument("--install-peer", action="store_true", help=f"first install {PEER} from the package registry into\n"
                        f"{PEER_FOLDER.relative_to(ROOT)} (1.3 GB with what it needs); without it that method is left out")
    parser.add_argument("--picture", metavar="PNG", help="a panel for each number of contact points")
    options = parser.parse_args()
    around, rows, truths, notes = surroundings(), [], {}, []
    if options.install_peer and (reason := install()):
        notes.append(f"{PEER} could not be installed: {reason}")
    if not (PEER_FOLDER / "pyHarm").is_dir():
        notes.append(f"pyHarm is left out: it is not in {PEER_FOLDER.relative_to(ROOT)}, see --install-peer")
        options.methods = [name for name in options.methods if not name.startswith("pyHarm")]
    for points in options.points:
        scene = Chain(points)
        truth = scene.dovetail(TRUTH)[0]
        apart = float(np.abs(scene.events(FINE)[0] / truth - 1).max())
        truths[points] = {"peak": scene.peak, "omegas": scene.omegas, "amplitudes": truth.tolist(), "apart": apart}
        for method in options.methods:
            if points <= METHODS[method][2]:
                rows += measured(scene, truth, method, options.runs)
            print(f"{points} contact points, {method}: done", file=sys.stderr)
        rows += elsewhere(rows, points)
    print("\n".join([*table(rows), "", "ms per point and setting of the cheapest within an error", *prices(rows), ""]))
    for points, told in truths.items():
        print(f"{points} contact points: peak at {told['peak']:g}; truth (H = {TRUTH}) and time integration (tolerance {FINE:g}) are "
              f"{told['apart']:.1e} apart")
    print("\n".join(["setting: number of harmonics, or the accuracy asked of a time integration", "event to event: wall time",
                     f"* measured earlier on another machine, with the error that H = 5, N = {SAMPLES} has here", *notes]))
    keep("field", {**around, "truths": truths, "rows": rows, "notes": notes})
    if options.picture:
        draw(rows, options.picture)


if __name__ == "__main__":
    main()
