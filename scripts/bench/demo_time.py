"""Where the time of scripts/demo goes: each of its steps, and the parts of the longest one from PETSc's own log."""

import argparse
import csv
import re
import shutil
import statistics
import sys

from measure import BINARY, OUTPUT, ROOT, keep, summary_of, surroundings, weigh

CASE = ROOT / "inputs/two_solids"
PICTURE = ROOT / "docs/notes/demo_time.png"
STAGES = {"1 model": "read and distribute the model", "2 reduction": "reduction", "3 preload": "contact preload", "4 scaling": "scaling"}
EVENTS = {"KSPSolve": "branch: linear solves", "SNESJacobianEval": "branch: Jacobian",
          "SNESFunctionEval": "branch: residual with contact"}  # none contains another
REST = "branch: writing, step control"
BRANCH = [*EVENTS.values(), REST]


def event_seconds(log, stage):
    """Seconds of every PETSc event of a stage, mean over ranks: the waiting of one rank is the work of another."""
    seconds = {}
    with open(log, newline="") as file:
        for row in csv.reader(file):
            if row[0].strip() == stage:
                seconds.setdefault(row[1].strip(), []).append(float(row[4]))
    return {name: statistics.mean(values) for name, values in seconds.items()}


def one_run(ranks, folder):
    """Seconds of every step of the demo on so many ranks, in order, and the CPU time of all of it."""
    shutil.rmtree(folder, ignore_errors=True)  # a reduced.h5 that is there would be used again
    folder.mkdir(parents=True)
    mpirun = ["mpirun", "-n", ranks]
    said, mesh = weigh([*mpirun, sys.executable, CASE / "model.py"])
    inside = float(re.search(r"([\d.]+) s on \d+ rank", said)[1])
    log = folder / "log.csv"
    _, run = weigh([*mpirun, BINARY, "run", CASE / "case.toml", "--out", folder, "-log_view", f":{log}:ascii_csv"])
    pictures = [weigh([sys.executable, "-m", "dovetail", "plot", folder / "results.h5", "--hz", *more])[1]
                for more in (["--dof", "x4.t2"], ["--kind", "hysteresis", "--dof", "x4.t2", "x5.t2"], ["--kind", "map", "--dof", "x4.t2"])]
    summary, stages = summary_of(folder)

    seconds = {"meshing, assembly, model file": inside, "  its start: Python, libraries": mesh.wall - inside}
    seconds["dovetail: start and end"] = run.wall - sum(stages[name] for name in (*STAGES, "5 branch"))  # those in between are parts
    seconds.update({label: stages[name] for name, label in STAGES.items()})
    events = event_seconds(log, "5 branch")
    parts = {label: events[name] for name, label in EVENTS.items()}
    seconds.update(parts)
    seconds[REST] = stages["5 branch"] - sum(parts.values())
    seconds["three pictures"] = sum(cost.wall for cost in pictures)
    cpu = mesh.cpu + run.cpu + sum(cost.cpu for cost in pictures)
    return {"seconds": seconds, "cpu": cpu, "points": summary["points"], "newton": summary["newton_iterations"],
            "ms_per_point": 1e3 * stages["5 branch"] / summary["points"]}


def middle_run(runs):
    """Median of every number over the runs."""
    middle = {key: statistics.median(run[key] for run in runs) for key in runs[0] if key != "seconds"}
    branches = [sum(run["seconds"][name] for name in BRANCH) for run in runs]
    middle["branch_lowest"], middle["branch_highest"] = min(branches), max(branches)
    middle["seconds"] = {name: statistics.median(run["seconds"][name] for run in runs) for name in runs[0]["seconds"]}
    return middle


def draw(path, measured):
    """Horizontal bars, one pair per step; told apart by hatching as well as by grey."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    names = list(next(iter(measured.values()))["seconds"])
    looks = [{"color": "#404040"}, {"facecolor": "white", "edgecolor": "black", "hatch": "////", "linewidth": 0.8}]
    height = 0.8 / len(measured)
    with plt.rc_context({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.axisbelow": True}):
        figure, axis = plt.subplots(figsize=(7.5, 4.6), layout="constrained", dpi=160)
        for i, (ranks, run) in enumerate(measured.items()):
            seconds = [run["seconds"][name] for name in names]
            places = [j + (i - (len(measured) - 1) / 2) * height for j in range(len(names))]
            axis.barh(places, seconds, 0.9 * height, label=f"{ranks} rank{'s' * (ranks > 1)}: {sum(seconds):.1f} s in all",
                      **looks[i % 2])
            for place, value in zip(places, seconds):
                axis.annotate(f"{value:.3f}" if value < 0.1 else f"{value:.2f}", (value, place), xytext=(3, 0),
                              textcoords="offset points", va="center", fontsize=7)
        axis.set_yticks(range(len(names)), [name.strip() for name in names])
        axis.invert_yaxis()
        axis.tick_params(axis="y", length=0)
        axis.grid(axis="x", color="#e3e3e3", linewidth=0.7)
        axis.set_xlabel("wall time [s]")
        axis.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=2, borderaxespad=0.2)
        figure.suptitle(f"demo: two posts, {next(iter(measured.values()))['points']:.0f} points of the response")
        figure.savefig(path)
    print(f"picture: {path.relative_to(ROOT)}")


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/demo_time", description=__doc__)
    parser.add_argument("--ranks", type=int, default=2, metavar="R", help="beside one rank; default %(default)s")
    parser.add_argument("--runs", type=int, default=3, metavar="N", help="median of so many; default %(default)s")
    parser.add_argument("--picture", action="store_true", help=f"draw to {PICTURE.relative_to(ROOT)} instead of build/bench")
    options = parser.parse_args()
    around = surroundings()
    every = sorted({1, options.ranks})
    rounds = [{ranks: one_run(ranks, OUTPUT / f"demo_time_{ranks}") for ranks in every} for _ in range(options.runs)]
    measured = {ranks: middle_run([one[ranks] for one in rounds]) for ranks in every}

    print(f"the demo, everything installed and built: wall time [s], median of {options.runs} runs; {around['cores']} cores, "
          f"load {around['load_at_start']:.1f}\n")
    print(f"{'':34}" + "".join(f"{f'{ranks} rank' + 's' * (ranks > 1):>10}" for ranks in every))
    for name in measured[1]["seconds"]:
        print(f"{name:34}" + "".join(f"{run['seconds'][name]:10.3f}" for run in measured.values()))
    totals = {"all of it": [sum(run["seconds"].values()) for run in measured.values()],
              "CPU time, all ranks": [run["cpu"] for run in measured.values()],
              "the branch": [sum(run["seconds"][name] for name in BRANCH) for run in measured.values()],
              "  lowest run": [run["branch_lowest"] for run in measured.values()],
              "  highest run": [run["branch_highest"] for run in measured.values()]}
    for name, values in totals.items():
        print(f"{name:34}" + "".join(f"{value:10.2f}" for value in values))
    print(f"{'ms per point':34}" + "".join(f"{run['ms_per_point']:10.1f}" for run in measured.values()))
    print(f"{'points, Newton iterations':34}" + "".join(f"{run['points']:5.0f}{run['newton']:5.0f}" for run in measured.values()))
    keep("demo_time", {**around, "ranks": measured})
    draw(PICTURE if options.picture else OUTPUT / PICTURE.name, measured)


if __name__ == "__main__":
    main()
