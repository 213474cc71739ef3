"""Two sweeps with lift-off, contact forces exact and sampled: points, Newton iterations and folds that sampling puts on the curve.

(a) A mass of 1 kg on a spring of 40 N/m, pressed onto a contact of 120 N/m and excited so that it lifts off (check 1 of the single
    mass in tests/verification), 5 to 16 rad/s.
(b) A chain of two masses, K = [[1, -1], [-1, 2]], C = 0.03 K, 0.1 cos on the second, the first against a stop of 100 N/m at 1 m,
    0.8 to 0.5 rad/s. It touches the stop for a small part of the period only.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import time

import numpy as np
from measure import BINARY, OUTPUT, ROOT, keep, surroundings

from dovetail import Model, Results

sys.path.insert(0, str(ROOT / "tests/verification"))
import cases

SAMPLES = ["exact", 128, 256, 1024, 4096]
FAR = 1e4  # [N/m] stiffness of directions that nothing excites, far above every harmonic of interest
CHAIN = """title = "chain of two masses against a stop"
model = "model.h5"
reduction = {{ modes = 1 }}
damping = {{ stiffness = 0.03 }}
excitation = {{ fourier = [0, 1] }}
contact = {{ law = "unilateral", normal_stiffness = 100.0, gap = 1.0 }}
harmonic_balance = {{ harmonics = {harmonics}, samples = {samples} }}
continuation = {{ omega = [0.8, 0.5] }}
"""


def single_mass(folder, harmonics, samples):
    return cases.single_mass(folder, 1, harmonics=harmonics, samples=samples).path


def chain(folder, harmonics, samples):
    """The chain as a model: dofs x1 (normal direction of the contact), x2, and t1, t2 of the contact, which nothing couples."""
    K = np.diag([1.0, 2, FAR, FAR])
    K[0, 1] = K[1, 0] = -1
    Model(K, np.eye(4), np.array([[2, 3, 0]]), np.array([0, 0.1, 0, 0]), np.zeros(4)).write(folder / "model.h5")
    path = folder / "case.toml"
    path.write_text(CHAIN.format(harmonics=harmonics, samples=json.dumps(samples)))
    return path


SWEEPS = {"single mass": single_mass, "chain": chain}
RUNS = [("single mass", 5), ("single mass", 10), ("chain", 25)]


def one_sweep(name, harmonics, samples, limit):
    """Figures of one run that ends by itself or after `limit` seconds; in that case of the points until then."""
    folder = OUTPUT / f"sweep_{name.replace(' ', '_')}_{harmonics}_{samples}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    case = SWEEPS[name](folder, harmonics, samples)
    start = time.perf_counter()
    try:
        done = subprocess.run([BINARY, "run", case, "--out", folder], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, timeout=limit)
        said = done.stdout
    except subprocess.TimeoutExpired as stopped:
        said = (stopped.stdout or b"").decode()
    seconds = time.perf_counter() - start
    if not (folder / "results.h5").exists():
        sys.exit(f"{said}\nbench: no results of {case}")
    return {"sweep": name, "harmonics": harmonics, "samples": samples, "seconds": seconds, **figures(folder)}


def figures(folder):
    """What became of the sweep in a folder, from its results and, if it ended by itself, its summary.json."""
    results = Results(folder / "results.h5")
    omega = results.omega
    summary = folder / "summary.json"
    about = json.loads(summary.read_text()) if summary.exists() else {"end": "time limit"}
    peak, steps = results.amplitude("x1.n"), np.diff(results.points("arclength"))
    return {"end": about["end"], "points": len(omega), "last_omega": float(omega[-1]),
            "newton": about.get("newton_iterations", int(results.points("newton_iterations").sum())),
            "cuts": about.get("step_cuts"), "leaps": about.get("leaps"), "folds": turning_points(omega),
            "smallest_step": float(steps[steps > 0].min(initial=np.inf)),  # a leap has no arc length
            "peak": float(peak.max()), "peak_omega": float(omega[peak.argmax()])}


def turning_points(omega):
    """How often the frequency changes between rising and falling along the branch."""
    senses = np.sign(np.diff(omega))
    senses = senses[senses != 0]
    return int(np.count_nonzero(senses[1:] != senses[:-1]))


def table(rows):
    """Lines of text, a block for every sweep and H."""
    lines = [f"{'':12}{'end':>12}{'at':>8}{'points':>8}{'Newton':>8}{'cuts':>7}{'folds':>7}{'leaps':>7}{'least step':>12}"
             f"{'peak':>10}{'at':>8}{'s':>8}"]
    last = None
    for row in rows:
        if (block := (row["sweep"], row["harmonics"])) != last:
            lines += ["", f"{row['sweep']}, H = {row['harmonics']}"]
            last = block
        known = {name: "?" if row[name] is None else row[name] for name in ("cuts", "leaps")}
        evaluation = "  exact" if row["samples"] == "exact" else f"  N = {row['samples']}"
        lines.append(f"{evaluation:12}{row['end']:>12}{row['last_omega']:8.3f}{row['points']:8}{row['newton']:8}{known['cuts']:>7}"
                     f"{row['folds']:7}{known['leaps']:>7}{row['smallest_step']:12.1e}{row['peak']:10.4f}{row['peak_omega']:8.4f}"
                     f"{row['seconds']:8.1f}")
    return lines


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/sweeps", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--limit", type=float, default=60, metavar="S", help="a sweep that takes longer is stopped; default %(default)s s")
    options = parser.parse_args()
    around = surroundings()
    rows = []
    for name, harmonics in RUNS:
        for samples in SAMPLES:
            rows.append(one_sweep(name, harmonics, samples, options.limit))
            print(f"{name}, H = {harmonics}, {samples}: {rows[-1]['end']} after {rows[-1]['seconds']:.1f} s", file=sys.stderr)
    print(f"sweeps with lift-off, 1 rank, one run each, stopped after {options.limit:g} s; {around['cores']} cores, load "
          f"{around['load_at_start']:.1f} before, {os.getloadavg()[0]:.1f} after\n")
    print("\n".join(table(rows)))
    print("\nfolds: changes between rising and falling frequency; least step: arc length in scaled variables; peak: largest normal\n"
          "displacement of the contact [m]; of a sweep that was stopped, Newton iterations of accepted points only")
    keep("sweeps", {**around, "limit": options.limit, "sweeps": rows})


if __name__ == "__main__":
    main()
