"""How often ranks wait for each other: collective calls, their bytes and memory, of a run on several numbers of ranks.

Calls are counted by a library between program and MPI (scripts/bench/mpi_calls.cpp), in the stage "5 branch". Two runs, of few and of
more points of the same curve, give by their difference what a point costs: the beginning of the branch is left out. Ranks beyond the
cores are counted as well as others; their time says nothing.
"""

import argparse
import bisect
import re
import subprocess
import sys
from collections import Counter

from measure import BINARY, OUTPUT, ROOT, keep, summary_of, surroundings, weigh
from points import BLADE, CASES

from dovetail import Results

LIBRARY = ROOT / "build/libmpi_calls.so"
COLLECTIVE = {"Allreduce", "Iallreduce", "Reduce", "Scan", "Exscan", "Reduce_scatter", "Reduce_scatter_block", "Bcast", "Ibcast", "Barrier",
              "Ibarrier", "Allgather", "Allgatherv", "Gather", "Gatherv", "Scatter", "Scatterv", "Alltoall", "Alltoallv"}
FEW = 5  # points of the run that is taken off


def counted(path, stage="5 branch"):
    """Calls and bytes of one rank's file in a stage, by call and place (a tuple: who called MPI, addresses in the program)."""
    calls, given = Counter(), Counter()
    for line in path.read_text().splitlines():
        name, call, number, size, *where = line.split("\t")
        if name == stage:
            calls[call, tuple(where)] += int(number)
            given[call, tuple(where)] += float(size)
    return calls, given


def total(counts, collective=True):
    return sum(number for (call, _), number in counts.items() if (call in COLLECTIVE) == collective)


class Symbols:
    """Names of a program's functions, by address."""

    def __init__(self, program):
        lines = subprocess.run(["nm", "-C", "--defined-only", program], capture_output=True, text=True, check=True).stdout.splitlines()
        found = sorted((int(address, 16), name) for address, kind, name in (line.split(" ", 2) for line in lines) if kind in "tTwW")
        self.addresses, self.names = zip(*found)

    def __call__(self, place):
        name = self.names[bisect.bisect_right(self.addresses, int(place, 16) - 1) - 1]
        return re.sub(r"\(.*|dovetail::|\(anonymous namespace\)::", "", name.replace("(anonymous namespace)::", ""))


def run(case, ranks, most):
    """Counts of rank 0 over a run of so many points at most, its results, and its stages."""
    folder = case.parent
    wanted = folder / "counted.toml"
    wanted.write_text(re.sub(r"max_points = \d+", f"max_points = {most}", case.read_text()))
    counting = ["-x", f"LD_PRELOAD={LIBRARY}", "-x", f"MPI_CALLS={folder / 'calls'}"]
    weigh(["mpirun", "-n", ranks, *counting, BINARY, "run", wanted, "--out", folder])
    return counted(folder / "calls.0"), Results(folder / "results.h5"), summary_of(folder)[0]


def measured(scene, points, harmonics, ranks, most):
    """Figures per point, and the places that called, of one setting."""
    case = CASES[scene](OUTPUT / f"scale/{scene.replace(' ', '_')}_{points}_{harmonics}_{ranks}", points, harmonics, "modal")
    (few, few_bytes), begun, start = run(case, ranks, FEW)
    kept = OUTPUT / f"points/blade_{points}/reduced.h5"
    if scene.startswith("blade") and not kept.exists():
        kept.write_bytes((case.parent / "reduced.h5").read_bytes())
    (many, many_bytes), results, summary = run(case, ranks, most)
    each = len(results) - len(begun)
    newton = float(results.points("newton_iterations")[len(begun):].sum())
    linear = summary["linear_iterations"] - start["linear_iterations"]
    many.subtract(few), many_bytes.subtract(few_bytes)
    calls, given = total(many) / each, total(many_bytes) / each
    branch = next(stage for stage in summary["stages"] if stage["name"] == "5 branch")
    row = {"scene": scene, "points": points, "harmonics": harmonics, "ranks": ranks, "curve_points": each, "per_point": calls,
           "per_newton": calls * each / newton, "per_linear": calls * each / linear, "kib": given / 1024,
           "messages": total(many, collective=False) / each, "newton": newton / each, "linear": linear / each,
           "peak_mib": max(branch["peak_mib"])}
    return row, {key: number / each for key, number in many.items() if number}


def places(counts, symbols, most):
    """Lines of the places that call most, by call and the innermost functions of the program."""
    named = Counter()
    for (call, (caller, *where)), number in counts.items():
        named[call, caller, " < ".join(dict.fromkeys(symbols(place) for place in where[:4]))] += number
    return [f"{number:9.2f}  {call:15} {caller:28} {where}" for (call, caller, where), number in named.most_common(most)]


def table(rows):
    lines = [f"{'':11}{'points':>7}{'H':>4}{'ranks':>6}{'Newton':>8}{'linear':>8}{'a point':>10}{'a Newton':>10}{'an iter.':>10}"
             f"{'KiB/point':>11}{'messages':>10}{'MiB/rank':>10}"]
    for row in rows:
        lines.append(f"{row['scene']:11}{row['points']:7}{row['harmonics']:4}{row['ranks']:6}{row['newton']:8.2f}{row['linear']:8.1f}"
                     f"{row['per_point']:10.1f}{row['per_newton']:10.1f}{row['per_linear']:10.2f}{row['kib']:11.1f}{row['messages']:10.1f}"
                     f"{row['peak_mib']:10.0f}")
    return lines


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/scale", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--chain", type=int, nargs="*", default=[16], metavar="N", help="contact points of the chain")
    parser.add_argument("--blade", type=int, nargs="*", default=[102, 506], choices=list(BLADE), metavar="N",
                        help=f"contact points of the blade root, of {list(BLADE)}")
    parser.add_argument("--harmonics", type=int, nargs="*", default=[5], metavar="H")
    parser.add_argument("--ranks", type=int, nargs="*", default=[1, 2, 4], metavar="R")
    parser.add_argument("--most", type=int, default=25, metavar="N", help="points of the longer run; default %(default)s")
    parser.add_argument("--places", type=int, default=0, metavar="N", help="also the places in the program that call most")
    options = parser.parse_args()
    if not LIBRARY.exists():
        sys.exit(f"bench: {LIBRARY} is not there: ninja -C {BINARY.parent} mpi_calls")
    symbols, rows = Symbols(BINARY) if options.places else None, []
    for scene, sizes in (("chain", options.chain), ("blade root", options.blade)):
        for points in sizes:
            for harmonics in options.harmonics:
                for ranks in options.ranks:
                    row, where = measured(scene, points, harmonics, ranks, options.most)
                    rows.append(row)
                    print("\n".join([table([row])[-1], *(places(where, symbols, options.places) if symbols else [])]), file=sys.stderr)
    print("\n".join(table(rows)))
    print("\nNewton, linear: iterations per point; a point, a Newton, an iter.: collective calls per each; KiB/point: bytes that\n"
          "rank 0 gives to them; messages: between two ranks, from rank 0; MiB/rank: memory of the largest")
    keep("scale", {**surroundings(), "rows": rows})


if __name__ == "__main__":
    main()
