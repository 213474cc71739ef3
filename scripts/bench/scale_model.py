"""Time of a point of the curve on many ranks, by a performance model: give the figures of your machine.

A point in the stuck modes is what `scripts/bench/scale` and `scripts/bench/points` count: evaluations of the residual, iterations of
GMRES, factors of the coarse space, calls of MPI. Each takes the larger of its operations and its bytes; messages come on top. n contact
dofs (modes are few), rows of them on a rank, w = 2H+1:

residual      4 rows n w operations in double precision, 16 rows n bytes of K and M
iteration     4 rows n w in single precision, 4 rows n bytes of Phi_c; Gram-Schmidt reads its vectors twice; products with c motions
coarse space  2 c^2 w^2 rows for its matrix and 2/3 c^3 w^3 for its factors, once a point
contact       by point of the joint, evaluation and harmonic

Where vectors are whole on every rank (src/modal/modal_share.cpp), an iteration waits once, else five times.

A reduction of N dofs to n contact dofs and m modes is counted in operations in double precision, of the blade root with 20 000 to 150 000
dofs (docs/notes/2026-11-30-large-joints.md), shared as if nothing waited: no run takes less.

factors       4.35e5 N (N / 152526)^0.83
modes         6.7e4 N m (N / 152526)^0.1
Psi           2050 N n (N / 152526)^0.24
projections   2 N n^2
"""

import argparse
import math

OTHER_CALLS = 33  # a point, besides those of iterations (docs/notes/2026-11-28-collectives.md)
ITERATIONS_TO_FACTOR, LEAST, BRIEF = 8, 250, 20000  # as in src/modal/modal_share.cpp
MANY = 12000  # as in src/stuck/near_basis.hpp


def coarse_motions(n, w, rows):
    if n < LEAST:
        return 0
    return int(min(math.sqrt(2 * ITERATIONS_TO_FACTOR * n / w), (6 * ITERATIONS_TO_FACTOR * n * rows / w**2) ** (1 / 3)))


def point(n, harmonics, ranks, machine):
    """Seconds of each part of a point: a dict; and whether vectors are whole."""
    w, rows = 2 * harmonics + 1, n / ranks
    motions = coarse_motions(n, w, rows)
    whole = ranks > 1 and n * w < BRIEF
    own = n if whole else rows  # unknowns, by coefficient, that a rank works with in GMRES
    speed, waits = 1e9 * machine.flops, math.ceil(math.log2(ranks))
    memory = 1e9 * min(machine.core_memory, machine.memory / min(ranks, machine.cores))
    network = 1e9 * machine.network

    def work(operations, size, speed=speed):
        return max(operations / speed, size / memory)

    def call(size):
        """A sum over all ranks: its halves travel once each way."""
        return waits * 1e-6 * machine.latency + (2 * size / network if ranks > 1 else 0)

    vectors = machine.linear / machine.solves / 2  # of a solve's basis, on average
    each = {"products": work(4 * rows * n * w, 4 * rows * n),
            "vectors": work(4 * vectors * own * w, 16 * vectors * own * w, speed / 2)
                       + work(4 * motions * own * w, 16 * own * w, speed / 2)}
    message = call(4 * n * w) if whole else 2 * call(4 * n * w) + 3 * call(8 * motions * w)
    parts = {name: machine.linear * seconds for name, seconds in each.items()}
    parts["residuals"] = machine.residuals * work(4 * rows * n * w, 16 * rows * n, speed / 2)
    parts["coarse space"] = (2 * motions**2 * w**2 * rows + 2 / 3 * (motions * w) ** 3) / speed
    parts["contact"] = machine.residuals * 1e-6 * machine.contact * (rows / 3) * harmonics
    parts["messages"] = machine.linear * message + machine.residuals * call(8 * n * w) + OTHER_CALLS * call(64) if ranks > 1 else 0.0
    return parts, whole


def bytes_a_rank(n, ranks):
    """Of K and M, of exact Phi_c where all modes are found, and of its copy in single precision."""
    return (28 if n < MANY else 20) * n * n / ranks


def reduction(dofs, n, modes, ranks, machine):
    """Seconds of each part of a reduction, at least: a dict."""
    size = dofs / 152526
    operations = {"factors": 4.35e5 * dofs * size**0.83, "modes": 6.7e4 * dofs * modes * size**0.1, "Psi": 2050 * dofs * n * size**0.24,
                  "projections": 2.0 * dofs * n**2}
    return {name: count / (0.5e9 * machine.flops * ranks) for name, count in operations.items()}


def table_of_reductions(models, n, modes, ranks, machine):
    lines = [f"{'model':>9}{'dofs':>6}{'modes':>6}{'ranks':>7}{'s':>9}   s: factors, modes, Psi, projections"]
    for dofs in models:
        for p in ranks:
            parts = reduction(dofs, n, modes, p, machine)
            lines.append(f"{dofs:9}{n:6}{modes:6}{p:7}{sum(parts.values()):9.0f}   "
                         + "".join(f"{seconds:9.1f}" for seconds in parts.values()))
    return lines


def table(dofs, harmonics, ranks, machine):
    lines = [f"{'dofs':>6}{'H':>4}{'ranks':>7}{'vectors':>9}{'s/point':>10}{'GiB/rank':>10}   "
             "ms: products, vectors, residuals, coarse space, contact, messages"]
    for n in dofs:
        for p in ranks:
            parts, whole = point(n, harmonics, p, machine)
            each = "".join(f"{1e3 * seconds:9.1f}" for seconds in parts.values())
            lines.append(f"{n:6}{harmonics:4}{p:7}{'whole' if whole else 'shared':>9}{sum(parts.values()):10.4f}"
                         f"{bytes_a_rank(n, p) / 2**30:10.2f}   {each}")
    return lines


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/scale_model", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--dofs", type=int, nargs="+", default=[3000, 30000], metavar="N", help="contact dofs; default %(default)s")
    parser.add_argument("--models", type=int, nargs="+", default=[10**6, 10**7], metavar="N", help="dofs to reduce; default %(default)s")
    parser.add_argument("--modes", type=int, default=50, metavar="M", help="fixed-interface modes; default %(default)s")
    parser.add_argument("--harmonics", type=int, default=5, metavar="H")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 4, 16, 64, 256], metavar="R")
    numbers = {"cores": (64, "cores of a node"), "memory": (400, "of a node [GB/s]"), "core_memory": (12, "of a core at most [GB/s]"),
               "flops": (60, "of a core in single precision, half of it in double [GFLOP/s]"),
               "latency": (10, "of a message, for each doubling of the ranks [us]"), "network": (12, "of a node [GB/s]"),
               "contact": (0.7, "of a contact point, by evaluation and harmonic [us]"), "linear": (27.5, "iterations of GMRES a point"),
               "solves": (5, "linear solves a point"), "residuals": (5, "evaluations a point")}
    for name, (value, words) in numbers.items():
        parser.add_argument(f"--{name.replace('_', '-')}", type=float, default=value, metavar="X", help=f"{words}; default %(default)s")
    machine = parser.parse_args()
    print("\n".join(table(machine.dofs, machine.harmonics, machine.ranks, machine)), end="\n\n")
    print("\n".join(table_of_reductions(machine.models, min(machine.dofs), machine.modes, machine.ranks, machine)))


if __name__ == "__main__":
    main()
