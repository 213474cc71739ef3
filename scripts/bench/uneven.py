"""What differs between the contact points of the blade root, and what could be saved by it: from one run per size, at H = 10.

moving     parts of the points that do not stick all through the period: on average over the curve, and at least once
ranks      the most that one rank has to do for its points' contact law, over the mean of all: events of a period, and one for each point
harmonics  which points the high harmonics of the contact forces come from: what is left of their effect on the motion, if the
           points that have most of it keep them and the others do not; at the point of the curve that moves most, by the stuck structure
"""

import argparse

import h5py
import numpy as np
import points
from measure import OUTPUT, keep, surroundings
from scipy.linalg import eigh

from dovetail import Results
from dovetail.reference import analysis

HARMONICS, LOWEST = 10, 5  # of the run; those that all points keep
RANKS = 2, 4, 8, 16, 32
PARTS = 0.1, 0.2, 0.3, 0.4, 0.5  # of the points
SAMPLES = 512


def worst_share(costs, ranks):
    """Largest sum of a rank over the mean of all, where each has neighbouring points; mean over the curve.

    costs : (points of the curve, contact points)
    """
    sums = np.array([costs[:, own].sum(axis=1) for own in np.array_split(np.arange(costs.shape[1]), ranks)])
    return float((sums.max(axis=0) / sums.mean(axis=0)).mean())


def matrices(path):
    """K and M (n, n) of a reduced model, modes first."""
    with h5py.File(path) as file:
        kaa, kxx, max_, mxx = (file[name][()] for name in ("Kaa", "Kxx", "Max", "Mxx"))
    coupling = np.zeros((len(kaa), len(kxx)))
    return np.block([[np.diag(kaa), coupling], [coupling.T, kxx]]), np.block([[np.eye(len(kaa)), max_], [max_.T, mxx]])


def effects(K, M, omega, forces, lowest):
    """Undamped motion (contact points, n, columns) that the harmonics above `lowest` of each point's forces make by themselves.

    K, M : (n, n), the contact dofs last; forces : (3 contact points, 2H+1)
    """
    squares, shapes = eigh(K, M)
    contact = shapes[-len(forces):].reshape(-1, 3, len(K))
    made = []
    for k in range(lowest + 1, forces.shape[1] // 2 + 1):
        pushed = np.einsum("pdm,pdc->mpc", contact, forces[:, 2 * k - 1:2 * k + 1].reshape(-1, 3, 2))
        modal = pushed.reshape(len(K), -1) / (squares - (k * omega) ** 2)[:, None]
        made.append((shapes @ modal).reshape(pushed.shape).transpose(1, 0, 2))
    return np.concatenate(made, axis=2)


def left(made, part):
    """What is left of the whole effect if that part of the points, those with most of it, keep all harmonics."""
    order = np.argsort([-np.linalg.norm(one) for one in made])
    return float(np.linalg.norm(made[order[int(part * len(made)):]].sum(axis=0)) / np.linalg.norm(made.sum(axis=0)))


def beyond_springs(results, point):
    """Coefficients (3 contact points, 2H+1) of the contact forces without those of the springs that a stuck point is."""
    count = len(results.contact["gap"])
    forces = np.concatenate([analysis(results.contact_force(point, j + 1, SAMPLES)[0].T, results.harmonics) for j in range(count)])
    return forces - springs(results)[:, None] * results.coefficients[point][-3 * count:]


def springs(results):
    return np.column_stack([results.contact["tangential_stiffness"], results.contact["normal_stiffness"]]).ravel()


def measured(count):
    row = points.measured("blade root", count, HARMONICS, "modal", 1, 1)
    folder = OUTPUT / f"points/blade_root_{count}_{HARMONICS}_modal_1"
    results = Results(folder / "results.h5")
    activity = [results.contact_activity(i) for i in range(len(results))]
    moving, events = (np.array(values) for values in ([a.stick < 1 - 1e-12 for a in activity], [a.events for a in activity]))
    top = int(np.argmax([np.linalg.norm(results.coefficients[i][:, 1:]) for i in range(len(results))]))
    K, M = matrices(folder / "reduced.h5")
    own = np.arange(len(K) - 3 * count, len(K))
    K[own, own] += springs(results)
    made = effects(K, M, results.omega[top], beyond_springs(results, top), LOWEST)
    return {"points": count, "law": row["shares"]["contact laws"], "moving": float(moving.mean()), "ever": float(moving.any(axis=0).mean()),
            "worst": {ranks: worst_share(1.0 + events, ranks) for ranks in RANKS},
            "effect": float(np.linalg.norm(made.sum(axis=0)) / np.linalg.norm(results.coefficients[top][:, 1:])),
            "left": {part: left(made, part) for part in PARTS}}


def table(rows):
    lines = []
    for row in rows:
        lines += [f"{row['points']} contact points: {100 * row['moving']:.0f} % move on average, "
                  f"{100 * row['ever']:.0f} % at some point of the curve",
                  f"  ranks, most / mean of the contact law, {100 * row['law']:.0f} % of the time on one rank: "
                  + ", ".join(f"{ranks}: {worst:.2f}" for ranks, worst in row["worst"].items()),
                  f"  harmonics above {LOWEST} of all points' forces: {row['effect']:.1e} of the motion; left if so many points keep them: "
                  + ", ".join(f"{100 * part:.0f} %: {rest:.2f}" for part, rest in row["left"].items())]
    return lines


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/uneven", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--blade", type=int, nargs="*", default=[102, 506], choices=list(points.BLADE), metavar="N",
                        help=f"contact points, of {list(points.BLADE)}")
    options = parser.parse_args()
    around = surroundings()
    rows = [measured(count) for count in options.blade]
    print("\n".join(table(rows)))
    keep("uneven", {**around, "rows": rows})


if __name__ == "__main__":
    main()
