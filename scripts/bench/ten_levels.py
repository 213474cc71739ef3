"""The peak at ten force levels: what it costs, and how far it is off, by four ways and a peer.

The amplitude is sqrt(sum of a_k^2 + b_k^2, k >= 1) of one unknown, largest over the frequency. Ways: a sweep for each level, ended
behind its peak; the peak followed over the force; synthesis from one nonlinear mode; the true equations solved near each
synthesised peak; and sweeps by pyHarm, for three of the levels, whose time is multiplied accordingly. Errors are the largest of the
levels, relative to peaks followed with many harmonics. Times are of the processor, without starts of programs and reduction: stage
"5 branch" of Dovetail, process time in Python.
"""

import argparse
import json
import os
import subprocess
import sys
import time
import tomllib

import numpy as np
from field import install
from field_methods import PEER, PEER_FOLDER, SAMPLES, SINGLE, XI
from measure import BINARY, OUTPUT, ROOT, keep, summary_of, surroundings, weigh

from dovetail import Results, reference
from dovetail.case_runs import largest_peak
from dovetail.modes import Backbone
from dovetail.peaks_table import solved_peak
from dovetail.study_runs import toml

sys.path.insert(0, str(ROOT / "tests/verification"))
import chain

LEVELS = 10
BEYOND = 1.03  # of the largest force, how far the mode is followed
LARGEST_SOLVED = 5  # harmonics: dense NumPy takes minutes with more
ASKED = (0, 5, 9)  # levels that the peer computes
WALK, SIDES = 27, (0.92, 1.06)  # of a sweep of the peer: frequencies, and where around the true peak
WAYS = {"ten sweeps": ("o", "#20639b", "-"), "peak track": ("s", "black", "-"), "synthesis": ("^", "#b5502c", "-"),
        "synthesis, solved": ("v", "#b5502c", "--"), "pyHarm, sweeps": ("D", "0.45", ":")}


class Chain:
    """The chain with some contact points, of scripts/bench/points; the last contact point is watched."""

    forces, harmonics, many, by_peer = np.geomspace(0.15, 2.5, LEVELS), (1, 3, 5, 7), 15, (3,)

    def __init__(self, points):
        self.points, self.name, self.watch = points, f"chain_{points}", f"x{points}.t1"
        self.title = f"chain, {points} contact points"
        self.model = chain.model(points)

    def case(self, harmonics):
        folder = OUTPUT / f"ten_levels/{self.name}"
        case = tomllib.loads(chain.write(folder, self.points, harmonics, solver="assembled", omega=(1.2, 1.9)).read_text())
        return folder, case | {"continuation": {"omega": case["continuation"]["omega"]}}

    def pyharm(self, harmonics, peaks):
        """Peaks of the levels ASKED by field_pyharm.py, NaN for the others: a parabola through the three highest points of each sweep. Also
        seconds, in proportion to all levels: each of its sweeps compiles for longer than it computes."""
        K, M = (A.toarray() for A in (self.model.K, self.model.M))
        reduced = reference.craig_bampton(K, M, self.model.contact_dofs, self.model.force, self.model.preload, 3)
        preload = reference.contact_preload(reduced, reference.Contact.uniform(self.points, 2 / self.points, 1 / self.points, 0.5))
        found, spent = np.full(LEVELS, np.nan), 0.0
        for i in ASKED:
            force, peak = self.forces[i], peaks[i]
            omegas = np.linspace(*(side * peak for side in SIDES), WALK)
            asked = {"K": K.tolist(), "M": M.tolist(), "force": (force * self.model.force).tolist(), "xi": XI, "mu": 0.5,
                     "kn": 2 / self.points, "kt": 1 / self.points, "N0": preload.g[:, 2].tolist(), "samples": SAMPLES,
                     "omegas": omegas.tolist(), "harmonics": harmonics, "node": self.points - 1}
            folder = OUTPUT / "ten_levels/peer"
            folder.mkdir(parents=True, exist_ok=True)
            run = subprocess.run([sys.executable, ROOT / "scripts/bench/field_pyharm.py"], input=json.dumps(asked), text=True, cwd=folder,
                                 capture_output=True, env=os.environ | SINGLE | {"PYTHONPATH": str(PEER_FOLDER), "HOME": str(folder)})
            if run.returncode:
                raise RuntimeError(f"force {force:.3g}: {(run.stderr.strip().splitlines() or ['no answer'])[-1]}")
            answer = json.loads(run.stdout.splitlines()[-1])
            spent += answer["seconds"]
            found[i] = top(omegas, np.array(answer["amplitudes"]))
        return found, spent * LEVELS / len(ASKED)


def top(omegas, amplitudes):
    """The vertex of the parabola through the highest point and its neighbours."""
    i = int(np.argmax(amplitudes))
    if not 0 < i < len(omegas) - 1:
        raise RuntimeError("no peak between the ends of the sweep")
    bend, slope, height = np.polyfit(omegas[i - 1:i + 2] - omegas[i], amplitudes[i - 1:i + 2], 2)
    return height - slope**2 / (4 * bend)


def run(scene, harmonics, kind, changes):
    """Results of the case with other sections, and processor seconds of its curve. All runs of a scene share one reduction."""
    folder, case = scene.case(harmonics)
    folder.mkdir(parents=True, exist_ok=True)
    case["continuation"] |= {"watch": scene.watch}
    for section, content in changes.items():
        case[section] = content
    if "mode" in changes:
        case["continuation"] = {"watch": scene.watch}
    for section in ("stability", "accuracy") if "mode" in changes or "path" in changes else ():
        case.pop(section, None)
    path = folder / f"{kind}.toml"
    path.write_text(toml(case))
    weigh([BINARY, "run", path, "--out", folder])
    summary, _ = summary_of(folder)
    return Results(folder / "results.h5"), next(sum(stage["cpu"]) for stage in summary["stages"] if stage["name"] == "5 branch")


def sweeps(scene, harmonics):
    found, seconds, points = [], 0.0, 0
    load = scene.case(harmonics)[1]["excitation"]["fourier"]
    for force in scene.forces:
        scaled = {"excitation": {"fourier": [float(force * number) for number in load]}}
        sweep = scene.case(harmonics)[1]["continuation"] | {"watch": scene.watch, "stop_after_peaks": 1}
        results, spent = run(scene, harmonics, "sweep", scaled | {"continuation": sweep})
        peak = largest_peak(results, scene.watch)
        if not peak["peak"]:
            raise RuntimeError(f"force {force:.3g}: no peak in the sweep")
        found.append(peak["rms"])
        seconds, points = seconds + spent, points + len(results)
    return np.array(found), seconds, points


def track(scene, harmonics):
    """Amplitudes, frequencies, seconds, points; from the least force up."""
    results, seconds = run(scene, harmonics, "track", {"path": {
        "parameter": "force", "range": [float(scene.forces[0]), float(scene.forces[-1])], "peak": "amplitude",
        "at": [float(force) for force in scene.forces[1:-1]]}})
    here = [results.at(force) for force in scene.forces]
    if not np.allclose(results.parameter[here], scene.forces, rtol=1e-9):
        raise RuntimeError(f"the track ended at force {results.parameter[-1]:.3g}")
    return results.tracked_amplitude[here], results.omega[here], seconds, len(results)


def modes(scene, harmonics):
    """Rows of synthesis, and of the equations solved from there where they are small enough."""
    results, seconds = run(scene, harmonics, "mode", {"mode": {"number": 1, "amplitude": [1e-8, 1e8],
                                                               "to_force": float(BEYOND * scene.forces[-1])}})
    began = time.process_time()
    backbone, row = Backbone.read(results), results.dof_index(scene.watch)
    tops = [backbone.highest(row, force) for force in scene.forces]
    seconds += time.process_time() - began
    yield "synthesis", np.array([rms(motion, row) for motion in tops]), seconds, len(results)
    if backbone.judges and harmonics <= LARGEST_SOLVED:
        began = time.process_time()
        solved = [solved_peak(backbone, motion, row) for motion in tops]
        seconds += time.process_time() - began
        yield "synthesis, solved", np.array([rms(motion, row) for motion in solved]), seconds, len(results)


def rms(motion, row):
    return float(np.linalg.norm(motion.coefficients[row, 1:]))


def compared(scene, peer):
    """Rows: way, harmonics, error, seconds, points; or why there is none."""
    truth, omegas, *_ = track(scene, scene.many)
    yield {"scene": scene.title, "truth": truth.tolist(), "omegas": omegas.tolist(), "forces": scene.forces.tolist()}

    def row(way, harmonics, found, seconds, points):
        return {"scene": scene.title, "way": way, "harmonics": harmonics, "error": float(np.nanmax(np.abs(found / truth - 1))),
                "seconds": seconds, "points": points, "errors": (found / truth - 1).tolist()}

    def ways(harmonics):
        yield "ten sweeps", lambda: [("ten sweeps", *sweeps(scene, harmonics))]
        yield "peak track", lambda: [("peak track", *np.delete(np.array(track(scene, harmonics), dtype=object), 1))]
        yield "synthesis", lambda: modes(scene, harmonics)
        if peer and harmonics in scene.by_peer:
            yield "pyHarm, sweeps", lambda: [("pyHarm, sweeps", *scene.pyharm(harmonics, omegas), LEVELS * WALK)]

    for harmonics in scene.harmonics:
        for way, compute in ways(harmonics):
            try:
                for name, found, seconds, points in compute():
                    yield row(name, harmonics, np.asarray(found, dtype=float), seconds, points)
            except (RuntimeError, ValueError) as error:
                yield {"scene": scene.title, "way": way, "harmonics": harmonics, "why": str(error)}


def line(row):
    """A line of the table."""
    start = f"{row['scene']:32}{row['way']:20}{row['harmonics']:4d}"
    return start + (f"   {row['why']}" if "why" in row else f"{row['error']:11.1e}{row['seconds']:10.3g}{row['points']:8d}")


def draw(rows, path):
    """Error over processor time, a panel for each scene."""
    import matplotlib.pyplot as plt

    from dovetail.plot import STYLE

    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(1, len(scenes), figsize=(5.2 * len(scenes), 4.6), layout="constrained", squeeze=False)
        for axis, scene in zip(panels[0], scenes):
            for way, (marker, colour, dashes) in WAYS.items():
                own = [row for row in rows if row["scene"] == scene and row.get("way") == way and "error" in row]
                if own:
                    axis.loglog([row["seconds"] for row in own], [row["error"] for row in own], marker=marker, color=colour, ls=dashes,
                                ms=5, label=way)
                for row in own:
                    axis.annotate(f"{row['harmonics']}", (row["seconds"], row["error"]), xytext=(5, 4), textcoords="offset points",
                                  fontsize=7, color=colour)
            axis.set(title=scene, xlabel="processor time of ten peaks [s]", ylabel="largest relative error of the ten")
            axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncol=3)
        figure.savefig(path)


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/ten_levels", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--chain", type=int, nargs="+", default=[4], metavar="N", help="contact points of the chain; default %(default)s")
    parser.add_argument("--install-peer", action="store_true", help=f"first install {PEER} from the package registry into\n"
                        f"{PEER_FOLDER.relative_to(ROOT)} (1.3 GB with what it needs); without it that way is left out")
    parser.add_argument("--picture", metavar="PNG", help="error over time, numbers are harmonics")
    options = parser.parse_args()
    if options.install_peer and (reason := install()):
        print(f"{PEER} could not be installed: {reason}")
    peer = (PEER_FOLDER / "pyHarm").is_dir()
    around, rows = surroundings(), []
    if not peer:
        print(f"{PEER} is left out: it is not in {PEER_FOLDER.relative_to(ROOT)}; --install-peer brings it")
    print(f"{'scene':32}{'way':20}{'H':>4}{'error':>11}{'cpu [s]':>10}{'points':>8}")
    for scene in map(Chain, options.chain):
        for row in compared(scene, peer):
            rows.append(row)
            if "way" in row:
                print(line(row), flush=True)
    keep("ten_levels", {**around, "load_at_end": os.getloadavg()[0], "rows": rows})
    if options.picture:
        draw([row for row in rows if "way" in row], options.picture)


if __name__ == "__main__":
    main()
