"""What the rows of the atlas say: shares of scenes that a method finishes, where it fails, and which scenes Dovetail does not finish."""

from collections import Counter

import numpy as np
from atlas_methods import DOVETAIL, METHODS, ORIGINAL

ENDS = ("arrived", "no start", "stopped", "turned back", "limit", "crashed")
GOOD = 0.01  # error of an amplitude that is called right
PARTS = (0.01, 0.1, 0.3)  # of a sweep


def outcome(row, method):
    """One word: "arrived", "jumped" (arrived, with a silent jump), or how it ended otherwise; None if not run."""
    part = row[method]
    if part is None:
        return None
    return "jumped" if part["end"] == "arrived" and part["jumps"] else part["end"]


def periodic(row):
    """Whether time integration finds a motion of the forcing period on the curve, or anywhere if there is no curve. None: not asked."""
    if row["truth"] is None:
        return None
    return any(place["settled"] and place.get("stays", True) for place in row["truth"]["places"])


def worst_error(row):
    """Largest error at the places that count, None if there is none."""
    if row["truth"] is None:
        return None
    return max((place["error"] for place in row["truth"]["places"] if place.get("stays")), default=None)


def branch_ends(row):
    """Whether a curve that stopped, stopped where there is no more: integration found nothing periodic in the rest, and had the time."""
    tried = (row["truth"] or {}).get("beyond", [])
    return bool(tried) and not any(place["settled"] or place["why"].startswith("not within") for place in tried)


def errors_at_places(row, method):
    """Errors of a method at the places of a row that count; None where it has no point at that frequency."""
    if method == DOVETAIL:
        return [place["error"] for place in row["truth"]["places"] if place.get("stays")] if row["truth"] else []
    return row.get("errors", {}).get(method, [])


def groups():
    """Dimension by dimension: its name, and its classes as {label: test of a scene}."""
    def ranges(key, bounds):
        edges = [-np.inf, *bounds, np.inf]
        labels = [f"below {bounds[0]:g}"] + [f"{a:g} to {b:g}" for a, b in zip(bounds, bounds[1:])] + [f"from {bounds[-1]:g}"]
        return {label: (lambda s, a=a, b=b: a <= s[key] < b) for label, a, b in zip(labels, edges, edges[1:])}

    def values(key, *names):
        return {str(name): (lambda s, name=name: s[key] == name) for name in names}

    return {
        "k_n / K": ranges("stiffness", (0.1, 1, 10, 100, 1000)),
        "separation": {"open gap": lambda s: s["gap"] > 0, "P/F < 0.1": lambda s: s["gap"] <= 0 and s["press"] < 0.1 * s["force"],
                       "0.1 to 1": lambda s: s["gap"] <= 0 and 0.1 <= s["press"] / s["force"] < 1,
                       "1 to 10": lambda s: s["gap"] <= 0 and 1 <= s["press"] / s["force"] < 10,
                       "from 10": lambda s: s["gap"] <= 0 and s["press"] / s["force"] >= 10},
        "friction": ranges("friction", (1e-9, 0.3, 1.0)),
        "damping": ranges("damping", (1e-3, 1e-2)),
        "contact points": ranges("points", (2, 5, 9)),
        "structure": values("family", "evidence", "chain", "two bodies", "dense", "held by its joint", "hardly held", "near-rigid", "1:3",
                            "symmetric"),
        "first step": values("step", 0.001, 0.1, 1.0, 10.0, 1000.0),
        "units": values("units", "1", "SI", "mm t s N", "small"),
        "force": values("three", False, True),
        "sweep": values("backward", False, True),
    }


def share(rows, method):
    """Of rows that have run: how many, and which part of them arrived without a silent jump."""
    ends = [outcome(row, method) for row in rows if row[method] is not None]
    return len(ends), sum(end == "arrived" for end in ends) / len(ends) if ends else np.nan


def figures(rows):
    """The summary, for JSON and the table."""
    made = {}
    for method in METHODS:
        done = [row[method] for row in rows if row[method] is not None]
        made[method] = {"scenes": len(done), "ends": dict(Counter(part["end"] for part in done)),
                        "silent_jumps": sum(len(part["jumps"]) for part in done),
                        "with_silent_jumps": sum(bool(part["jumps"]) for part in done),
                        "points": sum(part["points"] for part in done), "newton": sum(part["newton"] for part in done),
                        "seconds": sum(part["seconds"] for part in done)}
    counted = [row for row in rows if periodic(row)]
    for method in METHODS:
        made[method]["counted"], made[method]["finished"] = share(counted, method)
        errors = [error for row in counted for error in errors_at_places(row, method)]
        made[method]["places"] = len(errors)
        made[method]["right"] = sum(error is not None and error <= GOOD for error in errors)
    arrived = [row[DOVETAIL].get("left_out", 0) for row in counted if outcome(row, DOVETAIL) == "arrived"]
    made["left_out"] = {str(part): int(sum(left > part for left in arrived)) for part in PARTS}
    made["branch_ends"] = sum(map(branch_ends, counted))
    errors = [worst_error(row) for row in counted if outcome(row, DOVETAIL) == "arrived"]
    errors = [e for e in errors if e is not None]
    made["errors"] = {"scenes": len(errors), "within": {str(bound): int(sum(e <= bound for e in errors)) for bound in (1e-4, 1e-3, GOOD)}}
    return made


def lines(rows):
    """The table as lines of text."""
    made = figures(rows)
    out = [f"{len(rows)} scenes", "", f"{'':22}" + "".join(f"{method:>12}" for method in METHODS)]
    for end in ENDS:
        out.append(f"{end:22}" + "".join(f"{made[method]['ends'].get(end, 0):12}" for method in METHODS))
    for label, key, form in (("with silent jumps", "with_silent_jumps", "12"), ("points", "points", "12"),
                             ("Newton iterations", "newton", "12"),
                             ("seconds", "seconds", "12.0f")):
        out.append(f"{label:22}" + "".join(f"{made[method][key]:{form}}" for method in METHODS))
    out += ["", f"scenes with a periodic motion, by integration: {made[ORIGINAL]['counted']}; of these finished without a silent jump:",
            f"{'':22}" + "".join(f"{100 * made[method]['finished']:11.1f}%" for method in METHODS), ""]
    out.insert(-1, f"{'places within 1 %':22}" + "".join(f"{made[method]['right']:5} of {made[method]['places']:3}" for method in METHODS))
    out.insert(-1, f"of the rest Dovetail stops in {made['branch_ends']} where integration from rest finds nothing periodic beyond")
    out.insert(-1, "of its sweeps that are finished, leaps leave out more than " + ", ".join(
        f"{float(part):.0%} in {count}" for part, count in made["left_out"].items()))
    errors = made["errors"]
    out.append("error of Dovetail's amplitudes against integration, worst of a scene: " + ", ".join(
        f"{count} of {errors['scenes']} within {float(bound):g}" for bound, count in errors["within"].items()))
    out += ["", f"{'arrived, of all scenes':28}{'scenes':>8}" + "".join(f"{method:>12}" for method in METHODS)]
    for dimension, classes in groups().items():
        out.append(dimension)
        for label, test in classes.items():
            chosen = [row for row in rows if test(row["scene"])]
            if chosen:
                out.append(f"  {label:26}{len(chosen):8}" + "".join(f"{100 * share(chosen, method)[1]:11.0f}%" for method in METHODS))
    failing = [row for row in rows if outcome(row, DOVETAIL) not in ("arrived", None)]
    out += ["", f"not finished by Dovetail: {len(failing)}"]
    for row in failing:
        part, truth = row[DOVETAIL], {True: "periodic", False: "nothing periodic", None: ""}[periodic(row)]
        truth = "branch ends" if branch_ends(row) else truth
        out.append(f"  {row['scene']['name']:24}{outcome(row, DOVETAIL):12}{100 * part['reached']:5.0f}%  {truth:17}{part['said'][:150]}")
    return out
