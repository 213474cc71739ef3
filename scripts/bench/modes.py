"""The two kinds of reduction side by side: error of the response, and cost, over the number of modes.

Errors are those of the contacts' motion at given frequencies, against a reduction with many modes and residuals.
"""

import argparse
import json
import shutil
import sys
import tomllib

import numpy as np
from measure import BINARY, OUTPUT, ROOT, keep, surroundings, weigh

from dovetail import Results
from dovetail.study_runs import toml

KINDS = ("craig-bampton", "residual")
HARMONICS = 3
# inputs/NAME -> numbers of modes, those of the reference, frequencies
SCENES = {"two_solids": ((2, 5, 10, 20, 40), 120, 10), "blade_root": ((4, 12, 20, 40), 80, 4)}


def run(name, kind, modes, frequencies):
    """Results of one reduction, made anew, and processor seconds of the modes and of all of it."""
    source = ROOT / "inputs" / name
    if not (source / "model.h5").exists():
        weigh([sys.executable, source / "model.py"])
    content = tomllib.loads((source / "case.toml").read_text())
    folder = OUTPUT / f"modes/{name}_{kind}_{modes}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    content |= {"model": str(source / "model.h5"), "reduction": {"modes": modes, "kind": kind}, "stability": {"enabled": False},
                "output": {"motion": []}, "harmonic_balance": {"harmonics": HARMONICS},
                "continuation": {"omega": content["continuation"]["omega"], "at": [float(omega) for omega in frequencies]}}
    (folder / "case.toml").write_text(toml(content))
    weigh([BINARY, "run", folder / "case.toml", "--out", folder])
    stages = {stage["name"]: sum(stage["cpu"]) for stage in json.loads((folder / "summary.json").read_text())["stages"]}
    return Results(folder / "results.h5"), stages["2d modes"], stages["2 reduction"]


def contacts(results, frequencies):
    """(m, 3 N_x, 2H) coefficients of the contacts' motion at each frequency, without means."""
    points = [int(np.argmin(np.abs(results.omega - omega))) for omega in frequencies]
    return results.coefficients[points, results.modes:, 1:]


def compared(name):
    """Rows of the table."""
    counts, most, frequencies = SCENES[name]
    begin, end = tomllib.loads((ROOT / f"inputs/{name}/case.toml").read_text())["continuation"]["omega"]
    frequencies = np.linspace(begin, end, frequencies + 2)[1:-1]
    truth = contacts(run(name, "residual", most, frequencies)[0], frequencies)
    for modes in counts:
        for kind in KINDS:
            results, seconds, all_of_it = run(name, kind, modes, frequencies)
            error = np.linalg.norm(contacts(results, frequencies) - truth, axis=(1, 2)) / np.linalg.norm(truth, axis=(1, 2))
            yield {"scene": name, "modes": modes, "kind": kind, "error": float(error.max()), "modes_seconds": seconds,
                   "estimate": float(np.nanmax(results.points("error_modes"))), "reduction_seconds": all_of_it}


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/modes", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES), metavar="NAME", help=f"of {list(SCENES)}")
    options = parser.parse_args()
    around, rows = surroundings(), []
    print("scene        modes  kind            error   estimate along the curve   modes [s]   reduction [s]")
    for name in options.scenes:
        for row in compared(name):
            rows.append(row)
            print(f"{name:12} {row['modes']:5d}  {row['kind']:13} {row['error']:8.1e} {row['estimate']:16.1e} {row['modes_seconds']:19.2f} "
                  f"{row['reduction_seconds']:13.1f}", flush=True)
    keep("modes", {**around, "rows": rows})


if __name__ == "__main__":
    main()
