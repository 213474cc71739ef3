"""What recovery is worth: the scenes of the atlas with all of it, and with `recovery.strategies = []`, by this program and by others.

With `--ablate` also with all strategies but one, each in turn, by the first program. Where it makes the same run with all and without any,
no strategy was tried: the others are that run, too. Where it does not arrive with all, none is left out: only losses are looked for.
Nothing is judged here: a scene is finished when the sweep arrives. `scripts/bench/atlas` says whether its curve is right.
"""

import argparse
import json
import os
import re
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

import atlas_methods
import atlas_runs
import atlas_scenes
from measure import BINARY, OUTPUT, ROOT, keep, surroundings

FOLDER = OUTPUT / "recovery"
STRATEGIES = re.findall(r'{"(\w+)", (?:true|false)', (ROOT / "src/recovery/strategies.hpp").read_text())  # all that the program has
COUNTS = ("newton_iterations", "step_cuts", "corners", "inexact_linear_solves")


def kinds_of(programs, ablated):
    """What is run: {words: (program, strategies)}, None for all of them."""
    kinds = {}
    for number, program in enumerate(programs, 1):
        kinds |= {f"{number} without": (program, []), f"{number} with": (program, None)}
    return kinds | {f"no {name}": (programs[0], [other for other in STRATEGIES if other != name]) for name in ablated}


def one(name, kinds, patience):
    """A scene in all these ways: {words: figures}."""
    scene = atlas_scenes.scenes()[name]
    built = atlas_scenes.build(scene)
    longer = atlas_runs.FACTOR if scene.points > atlas_runs.MANY or scene.family == "evidence" else 1
    rows = {}
    for words, (program, strategies) in kinds.items():
        if words.startswith("no ") and (rows["1 with"]["end"] != "arrived" or same(rows["1 without"], rows["1 with"])):
            rows[words] = rows["1 with"]
            continue
        folder = FOLDER / words.replace(" ", "_") / name
        folder.mkdir(parents=True, exist_ok=True)
        case = atlas_scenes.write(built, folder)
        if strategies is not None:
            case.write_text(case.read_text() + f"[recovery]\nstrategies = {json.dumps(strategies)}\n")
        run, about = atlas_methods.dovetail(case, built.omega, folder, patience * longer * atlas_runs.LIMITS["dovetail"], program)
        rows[words] = {"end": run.end, "seconds": run.seconds, "reached": run.figures()["reached"],
                       **{count: about.get(count, 0) for count in COUNTS}}
    return name, rows


def same(run, other):
    """Whether two runs arrived by the same work."""
    return all(run[key] == other[key] for key in ("end", *COUNTS)) and run["end"] == "arrived"


def table(rows, kinds):
    """Lines, one for each way."""
    ends = ("arrived", "no start", "stopped", "turned back", "limit", "crashed")
    heads = "".join(f"{name.split('_')[0]:>10}" for name in (*COUNTS, "seconds"))
    out = [f"{'':20}" + "".join(f"{end:>12}" for end in ends) + heads]
    for words in kinds:
        counted = Counter(row[words]["end"] for row in rows.values())
        sums = [sum(row[words][key] for row in rows.values()) for key in (*COUNTS, "seconds")]
        out.append(f"{words:20}" + "".join(f"{counted[end]:12}" for end in ends) + "".join(f"{total:10.0f}" for total in sums))
    return out


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/recovery", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="names of scenes, or beginnings of names; default: all")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="every Nth of these scenes only")
    parser.add_argument("--program", nargs="*", default=[BINARY], metavar="FILE", help="programs to compare; default: build/dovetail")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), metavar="N", help="scenes at a time; default: cores")
    parser.add_argument("--patience", type=float, default=1, metavar="N", help="N times the limit of the atlas")
    parser.add_argument("--ablate", nargs="*", metavar="NAME", choices=STRATEGIES, help="leave out each of these in turn; default: all")
    options = parser.parse_args()
    names = [name for name in atlas_scenes.scenes() if not options.scenes or name.startswith(tuple(options.scenes))][::options.every]
    ablated = [] if options.ablate is None else options.ablate or STRATEGIES
    around, rows, kinds = surroundings(), {}, kinds_of(options.program, ablated)
    with ProcessPoolExecutor(options.jobs) as pool:
        works = [pool.submit(one, name, kinds, options.patience) for name in names]
        for done, work in enumerate(works, 1):
            name, row = work.result()
            rows[name] = row
            ends = "  ".join(f"{kind['end']:11}" for kind in row.values())
            print(f"{done:4}/{len(names)} {name:24} {ends}", file=sys.stderr, flush=True)
    for number, program in enumerate(options.program, 1):
        print(f"{number}: {program}")
    print("\n".join(table(rows, kinds)))
    keep("recovery", {**around, "programs": [str(program) for program in options.program], "scenes": rows})


if __name__ == "__main__":
    main()
