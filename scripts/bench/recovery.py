"""What recovery is worth: the scenes of the atlas with all of it, and with `recovery.strategies = []`, by this program and by others.

Nothing is judged here: a scene is finished when the sweep arrives. `scripts/bench/atlas` says whether its curve is right.
"""

import argparse
import os
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

import atlas_methods
import atlas_runs
import atlas_scenes
from measure import BINARY, OUTPUT, keep, surroundings

FOLDER = OUTPUT / "recovery"
COUNTS = ("newton_iterations", "step_cuts", "corners", "inexact_linear_solves")


def one(name, programs, patience):
    """A scene by all programs, with and without recovery: {(program, recovery): figures}."""
    scene = atlas_scenes.scenes()[name]
    built = atlas_scenes.build(scene)
    longer = atlas_runs.FACTOR if scene.points > atlas_runs.MANY or scene.family == "evidence" else 1
    rows = {}
    for number, program in enumerate(programs):
        for recovery in (False, True):
            folder = FOLDER / f"{number}{'_with' if recovery else '_without'}" / name
            folder.mkdir(parents=True, exist_ok=True)
            case = atlas_scenes.write(built, folder)
            if not recovery:
                case.write_text(case.read_text() + "[recovery]\nstrategies = []\n")
            run, about = atlas_methods.dovetail(case, built.omega, folder, patience * longer * atlas_runs.LIMITS["dovetail"], program)
            rows[number, recovery] = {"end": run.end, "seconds": run.seconds, "reached": run.figures()["reached"],
                                      **{count: about.get(count, 0) for count in COUNTS}}
    return name, rows


def table(rows, programs):
    """Lines, a column for each program without and with recovery."""
    kinds = [(number, recovery) for number in range(len(programs)) for recovery in (False, True)]
    out = [f"{'':24}" + "".join(f"{f'{number + 1} with' if recovery else f'{number + 1} without':>12}" for number, recovery in kinds)]
    ends = {kind: Counter(row[kind]["end"] for row in rows.values()) for kind in kinds}
    for end in ("arrived", "no start", "stopped", "turned back", "limit", "crashed"):
        out.append(f"{end:24}" + "".join(f"{ends[kind][end]:12}" for kind in kinds))
    for key in (*COUNTS, "seconds"):
        out.append(f"{key:24}" + "".join(f"{sum(row[kind][key] for row in rows.values()):12.0f}" for kind in kinds))
    return out


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/recovery", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="names of scenes, or beginnings of names; default: all")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="every Nth of these scenes only")
    parser.add_argument("--program", nargs="*", default=[BINARY], metavar="FILE", help="programs to compare; default: build/dovetail")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), metavar="N", help="scenes at a time; default: cores")
    parser.add_argument("--patience", type=float, default=1, metavar="N", help="N times the limit of the atlas")
    options = parser.parse_args()
    names = [name for name in atlas_scenes.scenes() if not options.scenes or name.startswith(tuple(options.scenes))][::options.every]
    around, rows = surroundings(), {}
    with ProcessPoolExecutor(options.jobs) as pool:
        works = [pool.submit(one, name, options.program, options.patience) for name in names]
        for done, work in enumerate(works, 1):
            name, row = work.result()
            rows[name] = row
            ends = "  ".join(f"{kind['end']:11}" for kind in row.values())
            print(f"{done:4}/{len(names)} {name:24} {ends}", file=sys.stderr, flush=True)
    for number, program in enumerate(options.program, 1):
        print(f"{number}: {program}")
    print("\n".join(table(rows, options.program)))
    keep("recovery", {**around, "programs": [str(program) for program in options.program],
                      "scenes": {name: {f"{number} {recovery}": figures for (number, recovery), figures in row.items()}
                                 for name, row in rows.items()}})


if __name__ == "__main__":
    main()
