#!/usr/bin/env python3
"""Two programs on the same scenes: every dataset that they store, bit for bit, but for times. The net under a change of structure.

    tests/equal_bits/compare.py BEFORE AFTER [SCENE ...]     names, or beginnings of names; default: all of SCENES

Models are reduced once, by the first program, and both follow the curve from the stored reduced.h5. `--parts N`: the second program stops
after N points and goes on from its own state, so that what it saves and restores is compared as well. `--ranks R`: both under mpirun.
Exit status 1 where anything differs; and, of all scenes, where a strategy of recovery is used by none.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "tests/verification"), str(ROOT / "scripts/bench")]
import atlas_scenes

FOLDER = ROOT / "build/equal_bits"
TIMES = {"seconds", "parts"}  # datasets and entries of summary.json that are no result
ABOUT = {"program", "stages", "reduction", "branch_seconds", "blas_kernel", *TIMES}
LIMIT = 120  # seconds of the processor for one run
STRATEGIES = ["fewer_harmonics", "jump", "integration", "elsewhere"]  # as in src/recovery/strategies.hpp
ALONE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def scene_names():
    """Shipped inputs, and scenes of the atlas that between them use every recovery: see scenes.txt."""
    lines = (Path(__file__).with_name("scenes.txt")).read_text().splitlines()
    return [line.split()[0] for line in lines if line and not line.startswith("#")]


def write(name, folder):
    """Case of a scene in a folder; its path."""
    if (ROOT / "inputs" / name).is_dir():
        model = ROOT / "inputs" / name / "model.h5"
        if not model.exists():
            subprocess.run([sys.executable, model.with_name("model.py")], check=True, stdout=subprocess.DEVNULL,
                           env={**os.environ, "PYTHONPATH": str(ROOT / "python")})
        text = model.with_name("case.toml").read_text()
        (folder / "case.toml").write_text(text.replace('"model.h5"', f'"{model}"'))
        return folder / "case.toml"
    return atlas_scenes.write(atlas_scenes.build(atlas_scenes.scenes()[name]), folder)


def run(program, case, folder, ranks, *options):
    """Exit status of a run, whose files are in `folder`, with what it said in run.log."""
    mpirun = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    command = ["prlimit", f"--cpu={LIMIT}", *mpirun, str(program), "run", str(case), "--out", str(folder), *options]
    with open(folder / "run.log", "a") as log:
        return subprocess.run(command, stdout=log, stderr=subprocess.DEVNULL, env={**os.environ, **ALONE}).returncode


def in_parts(program, case, folder, ranks, points):
    """The same with a stop after so many points."""
    text = case.read_text()
    limited = "\n".join(line for line in text.splitlines() if not line.startswith("max_points"))
    short = case.with_name(f"{folder.name}.toml")
    short.write_text(limited.replace("[continuation]", f"[continuation]\nmax_points = {points}"))
    status = run(program, short, folder, ranks)
    if status != 0 or json.loads((folder / "summary.json").read_text())["end"] != "max_points":
        return status
    short.write_text(limited)
    return run(program, short, folder, ranks, "--restart")


def contents(folder):
    """Every dataset of results.h5 but times, and the counts of summary.json."""
    found = {}
    with h5py.File(folder / "results.h5", "r") as file:
        file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    summary = json.loads((folder / "summary.json").read_text())
    return {name: value for name, value in found.items() if name.split("/")[-1] not in TIMES}, \
           {name: value for name, value in summary.items() if name not in ABOUT}


def differences(one, other):
    """Names of what two runs do not have alike, with how much."""
    (data, counts), (data_2, counts_2) = contents(one), contents(other)
    found = [f"{name}: only in one" for name in sorted(data.keys() ^ data_2.keys())]
    for name in sorted(data.keys() & data_2.keys()):
        a, b = data[name], data_2[name]
        if a.shape != b.shape:
            found.append(f"{name}: shape {a.shape} and {b.shape}")
        elif a.tobytes() != b.tobytes():
            change = np.nanmax(abs(a.astype(float) - b)) if a.dtype.kind in "fiu" and a.size else "other"
            found.append(f"{name}: differs by {change}")
    return found + [f"summary {name}: {counts.get(name)} and {counts_2.get(name)}" for name in sorted(counts.keys() | counts_2.keys())
                    if counts.get(name) != counts_2.get(name)]


def strategies_used(folder):
    """Strategies of recovery that a run has used."""
    said, counts = (folder / "run.log").read_text(), {}
    if (folder / "summary.json").exists():
        counts = json.loads((folder / "summary.json").read_text())
    used = {"jump": counts.get("leaps"), "integration": counts.get("integrations") or "comes from time integration" in said,
            "fewer_harmonics": "comes from fewer harmonics" in said, "elsewhere": "begun at this one" in said}
    return {name for name, yes in used.items() if yes}


def compared(name, before, after, ranks, parts):
    """A scene by both programs: name, exit statuses and differences."""
    folder = FOLDER / name
    shutil.rmtree(folder, ignore_errors=True)
    for part in ("before", "after"):
        (folder / part).mkdir(parents=True)
    case = write(name, folder)
    statuses = [run(before, case, folder / "before", ranks)]
    if (reduced := folder / "before/reduced.h5").exists():
        shutil.copy(reduced, folder / "after")
    statuses.append(in_parts(after, case, folder / "after", ranks, parts) if parts else run(after, case, folder / "after", ranks))
    ended = [(folder / part / "summary.json").exists() for part in ("before", "after")]
    used = strategies_used(folder / "after")
    if not all(ended):
        return name, statuses, used, [] if statuses[0] == statuses[1] else ["one of them did not end"]
    return name, statuses, used, differences(folder / "before", folder / "after")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--parts", type=int, default=0, metavar="N")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    options = parser.parse_args()
    names = [name for name in scene_names() if not options.scenes or name.startswith(tuple(options.scenes))]
    if not names:
        parser.error("no scene begins like that")
    unlike, users = 0, {name: [] for name in STRATEGIES}
    with ProcessPoolExecutor(options.jobs) as pool:
        programs = options.before.resolve(), options.after.resolve()
        works = [pool.submit(compared, name, *programs, options.ranks, options.parts) for name in names]
        for work in works:
            name, statuses, used, found = work.result()
            unlike += bool(found)
            for strategy in used:
                users[strategy].append(name)
            verdict = "DIFFERS" if found else "equal"
            print(f"{name:28} {verdict:8} status {statuses[0]} {statuses[1]}  {'; '.join(found[:3])}", flush=True)
    print(f"{len(names) - unlike} of {len(names)} scenes equal bit for bit")
    for strategy, scenes in users.items():
        print(f"{strategy:16} used by {', '.join(scenes) or 'none'}")
    sys.exit(unlike > 0 or (names == scene_names() and not all(users.values())))


if __name__ == "__main__":
    main()
