"""One scene by all methods: each part kept as JSON (and its curve as npz) beside the case, under a key of what it was made with."""

import hashlib
import json
from dataclasses import replace
from itertools import islice
from pathlib import Path

import atlas_jumps
import atlas_methods
import atlas_scenes
import atlas_truth
import h5py
import numpy as np
from atlas_methods import DOVETAIL, ORIGINAL, PLAIN, Run
from measure import BINARY, ROOT

HERE = Path(__file__).resolve().parent
# Seconds of the processor; truth and beyond: for all places; again: for a suspect step of Dovetail's, and of the others.
LIMITS = {ORIGINAL: 1.5, PLAIN: 2, DOVETAIL: 48, "truth": 4, "beyond": 60, "again": 3, "again plain": 1.5}
MANY = 8  # contact points beyond which all of them get FACTOR times as long, as do the scenes with names
FACTOR = 2
MORE = ("folds", "corners", "harmonics", "integrations", "leaps", "step_cuts", "left_out")  # of Dovetail's summary
PASSED = 1.4  # lengths of a step after which a curve followed again has mostly come by its end, and need not go on
STARTS = 3  # points from which a suspect step of Dovetail's is followed again


def digest(*paths):
    """Short hash of files."""
    made = hashlib.sha256()
    for path in paths:
        made.update(Path(path).read_bytes())
    return made.hexdigest()[:16]


def programs():
    """Hash of what makes each part, apart from the scene itself."""
    python = digest(*sorted((ROOT / "python/dovetail/reference").glob("*.py")), HERE / "atlas_methods.py")
    core = digest(BINARY)
    judge = digest(atlas_truth.PROGRAM) if atlas_truth.PROGRAM.exists() else "none"
    return {ORIGINAL: python, PLAIN: python, DOVETAIL: f"{core} {judge}", "truth": f"{core} {judge}"}  # the judge looks for jumps


def kept(path, key, limit):
    """A part from the run before, if it was made with the same things and has not met a limit below this one."""
    if path.exists():
        part = json.loads(path.read_text())
        if part.get("key") == key and not (part.get("end") == "limit" and part.get("allowed", limit) < limit):
            return part
    return None


def keep(path, key, part):
    path.write_text(json.dumps({"key": key, **part}, indent=1, allow_nan=True) + "\n")
    return part


def run_scene(scene, folder, program, parts, patience=1):
    """Every part in `parts` of a scene that is not there yet; a dict with all parts there are. program : as `programs` has it;
    patience : so many times the usual limit for Dovetail"""
    folder.mkdir(parents=True, exist_ok=True)
    longer = FACTOR if scene.points > MANY or scene.family == "evidence" else 1
    limits = {name: limit * longer for name, limit in LIMITS.items()}
    limits[DOVETAIL] *= patience
    built = atlas_scenes.build(scene)
    key = {part: f"{built.fingerprint()} {program}" for part, program in program.items()}
    made, anew = {}, set()
    for part in (ORIGINAL, PLAIN, DOVETAIL, "truth"):
        path = folder / f"{part}.json"
        made[part] = None if part == "truth" and DOVETAIL in anew else kept(path, key[part], limits[part])
        if made[part] is not None or part not in parts:
            continue
        case = folder / "case.toml"
        if part == "truth":
            if not atlas_truth.PROGRAM.exists() or made[DOVETAIL] is None:
                continue
            run = curve(folder, made[DOVETAIL], DOVETAIL, built)
            judged = {"places": atlas_truth.judge(case, folder, run, built.modes, limits["truth"])}
            if run.end in ("stopped", "turned back"):
                judged["beyond"] = atlas_truth.beyond(case, run, limits["beyond"])
            made[part] = keep(path, key[part], judged)
            continue
        if part == DOVETAIL:
            atlas_scenes.write(built, folder)
            run, about = atlas_methods.dovetail(case, built.omega, folder, limits[part])
            more = {name: about[name] for name in (*MORE, "places") if name in about}
        else:
            run, more = getattr(atlas_methods, part)(built, limits[part]), {}
        np.savez(folder / f"{part}.npz", omega=run.omega, coefficients=run.coefficients, announced=np.array(run.announced, int))
        follow = follower(part, built, folder, run, limits["again" if part == DOVETAIL else "again plain"])
        jumps, doubts = atlas_jumps.silent_jumps(run.omega, run.coefficients, built.modes, abs(built.omega[1] - built.omega[0]),
                                                 run.announced, follow, part == DOVETAIL, more.pop("places", ()))
        made[part] = keep(path, key[part], {**run.figures(), **more, "allowed": limits[part], "jumps": jumps, "doubts": doubts})
        anew.add(part)
    if made["truth"] is not None:
        made["errors"] = errors_of_the_others(folder, made, built)
    return made


def errors_of_the_others(folder, made, built):
    """Error of original and plain at the places where Dovetail's curve was judged; None where they have no point at that frequency."""
    errors = {}
    for method in (ORIGINAL, PLAIN):
        if made[method] is None:
            continue
        run, errors[method] = curve(folder, made[method], method, built), []
        for place in made["truth"]["places"]:
            if place.get("stays"):
                found = atlas_truth.at(place["omega"], run, built.modes, np.array(place["true"])) if run.points > 1 else None
                errors[method].append(None if found is None else atlas_truth.error(found, np.array(place["true"]), built.modes))
    return errors


def curve(folder, part, method, built):
    """The curve of a part from the run before, as a Run."""
    stored = np.load(folder / f"{method}.npz")
    return Run(part["end"], built.omega, part["newton"], part["seconds"], part["said"], stored["omega"], stored["coefficients"],
               tuple(stored["announced"]))


def only(results, point, path):
    """A results file with a single point of another, to start from: by its frequency alone a point is not known where the curve folds."""
    with h5py.File(results) as old, h5py.File(path, "w") as new:
        new.attrs.update(old.attrs)

        def copy(name, item):
            if isinstance(item, h5py.Dataset):
                new[name] = item[point:point + 1] if name.startswith("points/") else item[()]

        old.visititems(copy)


def starts(run, i, n, least):
    """Points before the step from point i to point n, from which a sweep in the curve's own sense may come by both. Turning points are no
    places to begin at a frequency, and where the frequency changes by less than `least` the sense is not known."""
    for j in range(i, -1, -1):
        if j < i and j + 1 in run.announced:
            return
        onwards = run.omega[j + 1] - run.omega[j]
        turns = j > 0 and j not in run.announced and (run.omega[j] - run.omega[j - 1]) * onwards < 0
        if abs(onwards) > least and not turns and min((run.omega[i:n + 1] - run.omega[j]) * np.sign(onwards)) >= 0:
            yield j


def follower(method, built, folder, run, limit):
    """The function that `atlas_jumps.silent_jumps` wants: by Dovetail itself for its own curve, by plain continuation for the others."""
    def again_plain(i, n):
        system = atlas_methods.Plain(*atlas_methods.arguments(built))
        whole = np.append(run.coefficients[n] - run.coefficients[i], run.omega[n] - run.omega[i])
        try:
            q = system.solve(run.omega[i], run.coefficients[i])
            up = system.tangent(np.append(q, run.omega[i]), np.eye(len(whole))[-1])
        except (RuntimeError, np.linalg.LinAlgError):
            return
        step, sense = np.linalg.norm(whole) / atlas_jumps.FINER, 1 if up @ whole >= 0 else -1
        beyond = run.omega[i], run.omega[i] * (1 + 100 * sense)
        branch = ((*point, 0) for point in system.branch(*beyond, step, step, step / 1e3, q))
        omega, coefficients, left = run.omega[:0], run.coefficients[:0], limit
        for points in (PASSED * atlas_jumps.FINER, (4 - PASSED) * atlas_jumps.FINER):
            done = atlas_methods.collect(lambda: islice(branch, int(points)), replace(built, omega=beyond), left)
            left -= done.seconds
            if done.points:
                omega, coefficients = np.r_[omega, done.omega], np.concatenate([coefficients, done.coefficients])
            yield omega, coefficients
            if done.end != "arrived" or left < 0:
                return

    def again_dovetail(i, n):
        """From points before: in time where the curve is followed in time there, else by a short sweep."""
        fine, width = folder / "again", abs(built.omega[1] - built.omega[0])
        fine.mkdir(exist_ok=True)
        with h5py.File(folder / "results.h5") as results:  # the highest coefficients do not tell: zero where the contact is still open
            harmonics = results["points/harmonics"][:].tolist()
        for j in islice(starts(run, i, n, atlas_jumps.SHORTEST * width), STARTS):
            only(folder / "results.h5", j, fine / "start.h5")
            yield from by_harmonics(j, i, n, fine, harmonics[j], width)

    def case_from(j, span, fine, **more):
        """Case of a sweep that begins at point j, in the curve's sense."""
        first, sense = float(run.omega[j]), np.sign(run.omega[j + 1] - run.omega[j])
        return atlas_scenes.write(replace(built, omega=(first, float(first + sense * min(span, first / 2))), **more), fine)

    def by_harmonics(j, i, n, fine, harmonics, width):
        """Steps are a hundredth of the sweep at most, and then FINER of them for the one in question, all alike."""
        span = max(10 * np.abs(run.omega[j:n + 1] - run.omega[j]).max(), 1e-4 * width)
        with h5py.File(folder / "results.h5") as results:
            arc = np.ptp(results["points/arclength"][i:n + 1])
        for span, step, alike in ((span, 1e-4, "true"), (width, arc / atlas_jumps.FINER, "false")):
            case = case_from(j, span, fine, step=float(step), harmonics=harmonics)
            case.write_text(case.read_text() + f'start = "start.h5"\nmax_points = 500\nadaptive = {alike}\n')
            done, _ = atlas_methods.dovetail(case, built.omega, fine, limit)
            end = done.announced[0] if done.announced else done.points
            if end and abs(done.omega[0] - run.omega[j]) <= 1e-12 * run.omega[j]:
                yield done.omega[:end], done.coefficients[:end]

    return again_dovetail if method == DOVETAIL else again_plain
