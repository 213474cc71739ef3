"""Time per point of the five-degree-of-freedom example as delivered: Dovetail on one rank, and dovetail.reference.

The reference starts from one of Dovetail's own points and follows the curve with the same arc length, so both must find the
same frequencies; the bench stops if they do not.
"""

import argparse
import statistics
import sys
import time

import numpy as np
from measure import BINARY, OUTPUT, ROOT, keep, summary_of, surroundings, weigh

from dovetail import Model, Results, reference

CASE = ROOT / "inputs/dof5"
MODES, XI, FOURIER, INITIAL, STEP = 2, 0.05, [0, 0, 1], 1e-5, 0.05  # of case.toml; the rest is in results.h5
REFERENCE_START = 1.0  # [rad/s], both directions slip there
SAME_FREQUENCY = 1e-6  # [rad/s]; the two differ by rounding only
ORIGINAL = {"points": 436, "newton": 1300, "mean": 31.0}  # compiled kernel; published code, measured on another machine


def dovetail_run(folder):
    """One run: points, Newton iterations, milliseconds per point, wall and CPU time of the whole process."""
    _, cost = weigh([BINARY, "run", CASE / "case.toml", "--out", folder])
    summary, seconds = summary_of(folder)
    per_point = 1e3 * Results(folder / "results.h5").points("seconds")
    return {"points": summary["points"], "newton": summary["newton_iterations"],
            "mean": 1e3 * seconds["5 branch"] / summary["points"], "median": float(np.median(per_point)),
            "slowest": float(per_point.max()), "wall": cost.wall, "cpu": cost.cpu}


def reference_run(results, points):
    """`points` steps of dovetail.reference from a point of `results`: milliseconds per point, wall and CPU, and the deviation."""
    model, contact = Model.read(CASE / "model.h5"), reference.Contact(*(results.contact[name] for name in (
        "normal_stiffness", "tangential_stiffness", "friction", "gap")))
    reduced = reference.craig_bampton(model.K, model.M, model.contact_dofs, model.force, model.preload, MODES)
    system = reference.HarmonicBalance(reduced, contact, reference.contact_preload(reduced, contact, INITIAL), XI, FOURIER,
                                       results.harmonics, results.samples)
    first = results.at(REFERENCE_START)
    wall, cpu = time.perf_counter(), time.process_time()
    omega, _ = system.continuation(results.omega[first], results.omega[-1], STEP, largest=STEP, points=points + 1,
                                   q0=results.coefficients[first])
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    deviation = float(np.abs(omega - results.omega[first:first + points + 1]).max())
    if deviation > SAME_FREQUENCY:
        raise SystemExit(f"bench: reference and Dovetail find frequencies {deviation:g} rad/s apart: not the same computation")
    return {"points": points + 1, "mean": 1e3 * wall / (points + 1), "cpu": 1e3 * cpu / (points + 1), "deviation": deviation}


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/five_dof", description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5, metavar="N", help="default %(default)s")
    parser.add_argument("--reference-points", type=int, default=10, metavar="N", help="default %(default)s")
    options = parser.parse_args()
    around = surroundings()
    weigh([sys.executable, CASE / "model.py"])
    folder = OUTPUT / "five_dof"
    runs = [dovetail_run(folder) for _ in range(options.runs)]
    middle = {key: statistics.median(run[key] for run in runs) for key in runs[0]}
    means = [run["mean"] for run in runs]
    twin = reference_run(Results(folder / "results.h5"), options.reference_points)

    print(f"five-dof example as delivered (H = 10, N = 64, fixed step), 1 rank, median of {options.runs} runs; "
          f"{around['cores']} cores, load {around['load_at_start']:.1f}\n")
    print(f"{'':34}{'points':>7}{'Newton':>8}{'ms per point':>14}")
    print(f"{'Dovetail':34}{middle['points']:7.0f}{middle['newton']:8.0f}{middle['mean']:14.2f}")
    print(f"{'  lowest to highest run':34}{'':15}{min(means):9.2f} to {max(means):.2f}")
    print(f"{'  typical point (median)':34}{'':15}{middle['median']:14.2f}")
    print(f"{'  slowest point':34}{'':15}{middle['slowest']:14.2f}")
    print(f"{'dovetail.reference, dense NumPy':34}{twin['points']:7}{'':8}{twin['mean']:14.1f}")
    print(f"{'the original, compiled kernel *':34}{ORIGINAL['points']:7}{ORIGINAL['newton']:8}{ORIGINAL['mean']:14.1f}")
    print(f"\nwhole process, start and reduction included: wall {middle['wall']:.2f} s, CPU {middle['cpu']:.2f} s; dovetail.reference: "
          f"CPU {twin['cpu']:.1f} ms per point")
    print(f"dovetail.reference iterates to 1e-11 instead of 1e-5; its frequencies agree with Dovetail's to {twin['deviation']:.0e} rad/s")
    print("* not run here: measured elsewhere, on a similar machine")
    keep("five_dof", {**around, "dovetail": middle, "runs": runs, "reference": twin, "original_measured_elsewhere": ORIGINAL})


if __name__ == "__main__":
    main()
