"""The failure atlas: hundreds of scenes, each by three methods and judged by time integration. Where does which method fail?

original   the published algorithm (reference.Original): fixed arc length, memory carried on, finite differences, no second attempt
plain      reference.HarmonicBalance.continuation: adaptive arc length, exact derivatives, line search
dovetail   build/dovetail run with default settings
truth      build/integrate from three points of Dovetail's curve

Every part of a scene is kept in build/bench/atlas/SCENE and made anew only if what it was made with has changed.
docs/notes/2026-11-26-atlas.md says what the scenes are, what counts as a failure, and what was found.
"""

import argparse
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict

import atlas_runs
import atlas_scenes
import atlas_table
from atlas_methods import METHODS
from measure import OUTPUT, keep, surroundings

FOLDER = OUTPUT / "atlas"
PARTS = (*METHODS, "truth")


def one(name, folder, program, parts, patience):
    """In a process of its own: a scene by name, and its parts."""
    scene = atlas_scenes.scenes()[name]
    return {"scene": asdict(scene), **atlas_runs.run_scene(scene, folder / name, program, parts, patience)}


def run(names, folder, parts, jobs, patience=1):
    """Rows of all scenes, in order; says how far it is."""
    program, start, rows = atlas_runs.programs(), time.perf_counter(), {}
    with ProcessPoolExecutor(jobs) as pool:
        waiting = {pool.submit(one, name, folder, program, parts, patience): name for name in names}
        for done, future in enumerate(as_completed(waiting), 1):
            rows[waiting[future]] = row = future.result()
            ends = "  ".join(f"{method} {row[method]['end'] if row[method] else '-':11}" for method in METHODS)
            print(f"{done:4}/{len(names)} {time.perf_counter() - start:6.0f} s  {waiting[future]:24} {ends}", file=sys.stderr, flush=True)
    return [rows[name] for name in names]


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/atlas", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="names of scenes, or beginnings of names; default: all")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS, help="make these only; what is there is shown all the same")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)) + 1, metavar="N",
                        help="scenes at a time; default: one a core, and one while another waits for the disk")
    parser.add_argument("--patience", type=float, default=1, metavar="N",
                        help="N times the usual limit for Dovetail; scenes that met a shorter one are run again")
    parser.add_argument("--fresh", action="store_true", help="forget what was kept")
    parser.add_argument("--map", metavar="PNG", help="draw the map there")
    options = parser.parse_args()
    names = [name for name in atlas_scenes.scenes() if not options.scenes or name.startswith(tuple(options.scenes))]
    if not names:
        parser.error(f"no scene begins with {' or '.join(options.scenes)}")
    if options.fresh:
        for name in names:
            for part in PARTS:
                (FOLDER / name / f"{part}.json").unlink(missing_ok=True)
    around, start = surroundings(), time.perf_counter()
    rows = run(names, FOLDER, options.parts, options.jobs, options.patience)
    around["seconds"] = time.perf_counter() - start
    print("\n".join(atlas_table.lines(rows)))
    if not options.scenes:
        limits = {"limits": atlas_runs.LIMITS, "patience": options.patience}
        keep("atlas", {**around, **limits, "figures": atlas_table.figures(rows), "scenes": rows})
    if options.map:
        import atlas_map
        atlas_map.draw(rows, options.map)


if __name__ == "__main__":
    main()
