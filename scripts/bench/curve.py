"""Time and error of whole curves: what a user waits for, at the accuracy he asks for.

Each scene is followed once a round by every program, and by the last of them with each --between as well, so that what else the machine
does meets all of them. Medians are given, and the ratio to the first program. `build/dovetail` of an older commit beside that of this
one shows what changes cost. Each program reduces a scene once.

With --finest the last program draws each curve once more with that little error between its points; error is the largest distance of
those points from the curve that is drawn, in parts of its height and of the sweep.
"""

import argparse
import os
import re
import shutil
import statistics
import sys
from functools import partial
from pathlib import Path

import h5py
import numpy as np
import points
from measure import BINARY, OUTPUT, ROOT, keep, summary_of, surroundings, weigh
from scipy.spatial import cKDTree

from dovetail import Results

sys.path.insert(0, str(ROOT / "tests/verification"))
import chain
import free_beams

FOLDER = OUTPUT / "curve"
COUNTS = ("points", "newton_iterations", "linear_iterations", "step_cuts", "corners", "leaps", "inexact_linear_solves")
DRAWN = 2000  # values between two points, where distances are measured


def shipped(name, folder):
    """The case of inputs/NAME."""
    folder.mkdir(parents=True, exist_ok=True)
    model = ROOT / "inputs" / name / "model.h5"
    if not model.exists():
        weigh([sys.executable, model.with_name("model.py")])
    path = folder / "case.toml"
    path.write_text(model.with_name("case.toml").read_text().replace('"model.h5"', f'"{model}"'))
    return path


def blade(count, force, folder):
    """The whole sweep of the bench of points."""
    path = points.blade_case(folder, count, 10, "modal", force)
    path.write_text(re.sub(r", max_points = \d+", "", path.read_text()))
    return path


def a_chain(count, folder):
    return chain.write(folder, count)


SCENES = {"two posts": partial(shipped, "two_solids"), "dof5": partial(shipped, "dof5"), "blisk": partial(shipped, "blisk"),
          **{f"chain {count}": partial(a_chain, count) for count in points.CHAIN}, "lap joint": free_beams.write,
          **{f"blade {count}": partial(blade, count, 1) for count in points.BLADE},
          **{f"blade {count} opens": partial(blade, count, 30) for count in points.BLADE}}
USUAL = ["two posts", "dof5", "chain 4", "chain 16", "chain 64", "lap joint", "blade 102", "blade 506", "blade 102 opens"]


def with_between(case, between):
    """That case, with the curve drawn that well; as it is where `between` is None."""
    if between is None:
        return case
    text = case.read_text()
    given = re.search(r"accuracy = \{(.*)\}", text)
    text = text.replace(given[0], f"accuracy = {{{given[1]}, between = {between} }}") if given else \
        f"{text}\n[accuracy]\nbetween = {between}\n"
    path = case.with_name(f"between_{between}.toml")
    path.write_text(text)
    return path


def one(program, case, folder, reduced):
    """Figures of one run from that reduced model, which the first run makes."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    if reduced.exists():
        shutil.copy(reduced, folder)
    text, _ = weigh([program, "run", case, "--out", folder, "-log_view"])
    if not reduced.exists() and (folder / "reduced.h5").exists():
        shutil.copy(folder / "reduced.h5", reduced)
    summary, _ = summary_of(folder)
    branch = next(stage for stage in summary["stages"] if stage["name"] == "5 branch")
    with h5py.File(folder / "results.h5") as file:
        seconds, of = file["points/seconds"][:], dict(file.attrs)
    row = {"cpu": sum(branch["cpu"]), "first": seconds[0] / np.median(seconds[1:])} | {name: summary.get(name, 0) for name in COUNTS}
    whole = {"points": int(of["contact_points"]), "harmonics": int(of["harmonics"]), "solver": "modal", "mean": row["cpu"] / row["points"],
             "curve_points": row["points"], "iterations": row["linear_iterations"], "shares": points.shares(text, folder)}
    return row | {"products": 2 * row["linear_iterations"] / row["points"], "gflops": points.rates(whole, int(of["modes"]))["gflops"]}


def distance(folder, finest):
    """Of the finest run's points from the curve that another run's results draw."""
    fine = Results(finest / "results.h5")
    try:
        along, amplitude = Results(folder / "results.h5").curve(fine.watched, n=DRAWN)
    except ValueError:  # results of an older program
        return float("nan")
    there = np.isfinite(along)
    reach, top = np.ptp(fine.along), fine.amplitude(fine.watched).max()
    drawn = np.c_[along[there] / reach, amplitude[there] / top]
    return float(cKDTree(drawn).query(np.c_[fine.along / reach, fine.amplitude(fine.watched) / top])[0].max())


def scene(name, entries, runs, finest):
    """Rows of a scene, one for each (program, between)."""
    place = FOLDER / name.replace(" ", "_")
    shutil.rmtree(place, ignore_errors=True)
    case = SCENES[name](place)
    programs = list(dict.fromkeys(program for program, _ in entries))
    reduced = {program: place / f"reduced_{number}.h5" for number, program in enumerate(programs)}
    each = [[] for _ in entries]
    for _ in range(runs):
        for number, (program, between) in enumerate(entries):
            each[number].append(one(program, with_between(case, between), place / f"out_{number}", reduced[program]))
    rows = [{key: statistics.median(run[key] for run in figures) for key in figures[0]} for figures in each]
    if finest:
        one(programs[-1], with_between(case, finest), place / "finest", reduced[programs[-1]])
    for number, row in enumerate(rows):
        row["ratio"] = row["cpu"] / rows[0]["cpu"]
        row["error"] = distance(place / f"out_{number}", place / "finest") if finest else float("nan")
    return rows


def line(name, number, between, row):
    setting = "default" if between is None else f"{between:g}"
    counted = "".join(f"{row[count]:9.0f}" for count in COUNTS)
    return (f"{name:18}{number:8}{setting:>9}{row['cpu']:10.3f}{row['ratio']:8.3f}{row['error']:10.1e}{row['first']:7.1f}"
            f"{row['products']:10.1f}{row['gflops']:9.1f}{counted}")


def draw(rows, entries, path):
    import matplotlib.pyplot as plt
    from matplotlib.ticker import LogLocator

    from dovetail.plot import LINES, STYLE

    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(7, 4.6))
        for (name, own), (colour, style), marker in zip(rows.items(), LINES * 3, "osD^vP*X<>hd" * 3):
            known = [(row["cpu"], row["error"]) for (program, _), row in zip(entries, own)
                     if program == entries[-1][0] and row["error"] > 0]
            if known:
                axes.loglog(*zip(*sorted(known)), marker=marker, ms=4, color=colour, ls=style, label=name)
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter("")
        axes.set_xlabel("processor time of the curve [s]")
        axes.set_ylabel("distance from the curve, of its size")
        axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1))
        figure.savefig(path, bbox_inches="tight")


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/curve", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("programs", nargs="*", type=Path, default=[BINARY], metavar="PROGRAM", help="default: build/dovetail")
    parser.add_argument("--scenes", nargs="*", default=USUAL, choices=list(SCENES), metavar="NAME", help=f"of {list(SCENES)}")
    parser.add_argument("--runs", type=int, default=5, metavar="N", help="of which the median is taken; default %(default)s")
    parser.add_argument("--between", type=float, nargs="*", default=[], metavar="E", help="accuracy.between of further runs")
    parser.add_argument("--finest", type=float, metavar="E", help="accuracy.between of the curve that errors are measured from")
    parser.add_argument("--picture", metavar="PNG", help="chart of error over time")
    options = parser.parse_args()
    around, best, rows = surroundings(), points.machine(), {}
    programs = [program.resolve() for program in options.programs]
    entries = [(program, None) for program in programs] + [(programs[-1], between) for between in options.between]
    for number, program in enumerate(programs, 1):
        print(f"{number}: {program}")
    print(f"{'':18}{'program':>8}{'between':>9}{'cpu [s]':>10}{'ratio':>8}{'error':>10}{'first':>7}{'products':>10}{'GFLOP/s':>9}"
          + "".join(f"{name.split('_')[0]:>9}" for name in COUNTS))
    for name in options.scenes:
        rows[name] = scene(name, entries, options.runs, options.finest)
        for (program, between), row in zip(entries, rows[name]):
            print(line(name, programs.index(program) + 1, between, row), flush=True)
    print(f"first: point, in following ones; products: with Phi and its transpose, a point; square products of matrices make "
          f"{best['gflops']:.0f} GFLOP/s here\nload {around['load_at_start']:.1f} before, {os.getloadavg()[0]:.1f} after")
    keep("curve", {**around, "machine": best, "programs": [str(program) for program in programs], "runs": options.runs,
                   "entries": [[str(program), between] for program, between in entries], "scenes": rows})
    if options.picture:
        draw(rows, entries, options.picture)


if __name__ == "__main__":
    main()
