"""Programs in turn on the same scenes: processor time of a curve and what it took, medians, and the ratio to the first program.

Each scene is reduced once, by the first program. In each round every program follows the curve once, so that what else the machine does
meets all of them. `build/dovetail` of the commit before beside that of this one shows what a change costs.
"""

import argparse
import os
import shutil
import statistics
import sys
from functools import partial

import points
from measure import BINARY, OUTPUT, ROOT, keep, summary_of, surroundings, weigh

sys.path.insert(0, str(ROOT / "tests/verification"))
import free_beams

FOLDER = OUTPUT / "turns"
COUNTS = ("points", "newton_iterations", "linear_iterations", "step_cuts", "corners", "leaps", "inexact_linear_solves")


def shipped(name, folder):
    """The case of inputs/NAME."""
    folder.mkdir(parents=True, exist_ok=True)
    model = ROOT / "inputs" / name / "model.h5"
    if not model.exists():
        weigh([sys.executable, model.with_name("model.py")])
    path = folder / "case.toml"
    path.write_text(model.with_name("case.toml").read_text().replace('"model.h5"', f'"{model}"'))
    return path


def chain(count, folder):
    return points.chain_case(folder, count, 5, "modal")


def blade(count, force, folder):
    return points.blade_case(folder, count, 10, "modal", force)


SCENES = {"two posts": partial(shipped, "two_solids"), "dof5": partial(shipped, "dof5"), "chain 16": partial(chain, 16),
          "chain 64": partial(chain, 64), "lap joint": free_beams.write, "blade 102": partial(blade, 102, 1),
          "blade 506": partial(blade, 506, 1), "blade 1026": partial(blade, 1026, 1), "blade 102 opens": partial(blade, 102, 30),
          "blade 506 opens": partial(blade, 506, 30), "blade 1026 opens": partial(blade, 1026, 30)}


def one(program, case, folder, reduced):
    """Figures of one run from that reduced model, which the first run makes."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    if reduced.exists():
        shutil.copy(reduced, folder)
    weigh([program, "run", case, "--out", folder])
    if not reduced.exists() and (folder / "reduced.h5").exists():
        shutil.copy(folder / "reduced.h5", reduced)
    summary, _ = summary_of(folder)
    branch = next(stage for stage in summary["stages"] if stage["name"] == "5 branch")
    return {"cpu": sum(branch["cpu"])} | {name: summary.get(name, 0) for name in COUNTS}


def scene(name, programs, runs):
    """Rows of a scene, one for each program."""
    place = FOLDER / name.replace(" ", "_")
    shutil.rmtree(place, ignore_errors=True)
    case = SCENES[name](place)
    each = [[] for _ in programs]
    for _ in range(runs):
        for program, figures in zip(programs, each):
            figures.append(one(program, case, place / "out", place / "reduced_once.h5"))
    rows = [{key: statistics.median(run[key] for run in figures) for key in figures[0]} for figures in each]
    for row in rows:
        row["ratio"] = row["cpu"] / rows[0]["cpu"]
    return rows


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/turns", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("programs", nargs="*", default=[BINARY], metavar="PROGRAM", help="default: build/dovetail")
    parser.add_argument("--scenes", nargs="*", default=list(SCENES)[:-1], choices=list(SCENES), metavar="NAME", help=f"of {list(SCENES)}")
    parser.add_argument("--runs", type=int, default=5, metavar="N", help="of which the median is taken; default %(default)s")
    options = parser.parse_args()
    around, rows = surroundings(), {}
    for number, program in enumerate(options.programs, 1):
        print(f"{number}: {program}")
    print(f"{'':18}{'program':>8}{'cpu [s]':>10}{'ratio':>8}" + "".join(f"{name.split('_')[0]:>9}" for name in COUNTS))
    for name in options.scenes:
        rows[name] = scene(name, options.programs, options.runs)
        for number, row in enumerate(rows[name], 1):
            counted = "".join(f"{row[count]:9.0f}" for count in COUNTS)
            print(f"{name:18}{number:8}{row['cpu']:10.3f}{row['ratio']:8.3f}{counted}", flush=True)
    print(f"load {around['load_at_start']:.1f} before, {os.getloadavg()[0]:.1f} after")
    keep("turns", {**around, "programs": [str(program) for program in options.programs], "runs": options.runs, "scenes": rows})


if __name__ == "__main__":
    main()
