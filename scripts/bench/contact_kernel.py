"""Speed and accuracy of the contact forces: exact and sampled, beside the arithmetic limit and a naive program, on one thread.

Random motions in five kinds: clearly stuck; stuck, but so near the bound that instants have to be looked for; simple slip with 4 to
8 events per period; slip with 8 to 20, evenly spread; contacts that open in every period. Harmonics decay as k^-1.5. Times are CPU time.
"""

import argparse
import json
import os

from measure import BINARY, OUTPUT, ROOT, keep, surroundings, weigh

PROGRAM = BINARY.parent / "contact_kernel"
PICTURE = ROOT / "docs/notes/contact_kernel.png"
DRAWN = {"slip": "slip, always closed", "separation": "opens in every period"}
MICRO = 1e6


def operations(kind, harmonics, samples, events, runs):
    """Floating-point operations that one point takes at least: for the forces, for forces and Jacobian, for Jacobian times vector.

    n = 2H+1 coefficients a row, E events, R stick intervals that an event began (a rank-one term each); `samples` 0 is exact.
    Sampled: two transforms of three rows at a quarter of their plain cost 2 n N; 22 operations of the law at every sample, once round.
    Exact: value and slope of three rows in max(64, 8H) cells, 8 each and harmonic; at every event two polynomials of its cell (38 H
    each), 500 for the zero, 12 n for the powers of exp(i theta) and the integrals; a Toeplitz plus Hankel product, 4 n^2, for every
    mask there is. Jacobian, both: 2 n^2 for every block, 4 n^2 and 10 n for every rank-one term; sampled, integrals too, 6 n per event.
    """
    n = 2 * harmonics + 1
    product, blocks, rank_one = 4 * n * n, 10 * n * n, 4 * n * n
    masks = {"stuck": 0, "nearly slips": 3}.get(kind, 5)
    if samples:
        forces = 3 * n * samples + 22 * samples
    elif kind == "stuck":
        forces = 6 * n  # springs
    else:
        forces = 24 * harmonics * max(64, 8 * harmonics) + events * (76 * harmonics + 500 + 12 * n) + masks * product
    if kind == "stuck" or (samples and kind == "nearly slips"):
        return forces, forces, 3 * n
    return forces, forces + blocks + runs * (rank_one + 10 * n) + bool(samples) * 6 * n * events, masks * product + 6 * n * runs


def measured_rows(options):
    """Build and run the program: its rows, each with limits beside the times [s], and the peak of multiply-adds [1/s]."""
    weigh(["cmake", "--build", PROGRAM.parent, "--target", PROGRAM.name])
    said, cost = weigh([PROGRAM, "--seed", options.seed, "--motions", options.motions, "--repetitions", options.runs,
                        "--naive", options.naive, "--milliseconds", options.milliseconds,
                        "--harmonics", ",".join(map(str, options.harmonics)), "--samples", ",".join(map(str, options.samples))])
    told = json.loads(said)
    peak = max(told["peak_flops"].values())
    for row in told["measured"]:
        counts = operations(*(row[key] for key in ("kind", "harmonics", "samples", "events", "runs")))
        row["operations"] = dict(zip(("residual", "jacobian", "product"), counts))
        row["limit"] = {name: count / peak for name, count in row["operations"].items()}
    return told["measured"], told["peak_flops"], told["cpu"], cost


def table(rows):
    """Lines of text, a block for every H and kind."""
    lines = [f"{'':12}thousand points per second    limit  naive           error of forces    error of Jacobian",
             f"{'':12}  forces +Jacobian  J times v         us  slower    median    worst    median    worst"]
    for row in rows:
        if row["samples"] == 0:
            about = f"{row['events']:.1f} events per period" if row["events"] else "no events"
            lines += ["", f"H = {row['harmonics']}, {row['kind']}: {about}"]
        speeds = "".join(f"{1e-3 / row[name]:{wide}.1f}" for name, wide in (("residual", 8), ("jacobian", 10), ("product", 11)))
        reached = row["limit"]["jacobian"] / row["jacobian"] if row["samples"] or row["kind"] != "stuck" else 0
        line = f"{samples_of(row):12}{speeds}" + (f"{reached:9.0%}" if reached else f"{'-':>9}")
        if naive := row.get("naive"):
            line += f"{MICRO * naive['jacobian']:9.0f}{naive['jacobian'] / row['jacobian']:7.0f}x"
        else:
            line += " " * 17
        for name in ("force_error", "jacobian_error"):
            error = row.get(name)
            line += f"{error['median']:10.0e}{error['worst']:9.0e}" if error else ""
        lines.append(line)
    return lines


def samples_of(row):
    return f"  N = {row['samples']}" if row["samples"] else "  exact"


def draw(path, rows):
    """Error against time per point: a row of panels for each kind, a column for each H. Told apart by marker and line style."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    every = sorted({row["harmonics"] for row in rows})
    with plt.rc_context({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.axisbelow": True}):
        figure, panels = plt.subplots(len(DRAWN), len(every), figsize=(1.2 + 2.5 * len(every), 6.4), layout="constrained", dpi=160,
                                      sharey=True, sharex="col", squeeze=False)
        for line, (kind, title) in zip(panels, DRAWN.items()):
            for axis, harmonics in zip(line, every):
                some = [row for row in rows if (row["kind"], row["harmonics"]) == (kind, harmonics)]
                draw_panel(axis, some)
                axis.set_title(f"H = {harmonics}: {title},\n{some[0]['events']:.0f} events per period", loc="left", fontsize=8.5)
            line[0].set_ylabel("relative error (median)")
        for axis in panels[-1]:
            axis.set_xlabel("CPU time per point, forces\nand Jacobian [µs]")
        figure.legend(*panels[0, 0].get_legend_handles_labels(), frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1), ncol=4,
                      handlelength=3.5)
        figure.savefig(path, bbox_inches="tight")
    print(f"picture: {path.relative_to(ROOT)}")


def draw_panel(axis, rows):
    exact, sampled = rows[0], rows[1:]
    times = [MICRO * row["jacobian"] for row in sampled]
    naive = [MICRO * row["naive"]["jacobian"] for row in sampled]
    errors = {name: [row[name]["median"] for row in sampled] for name in ("force_error", "jacobian_error")}
    axis.loglog(times, errors["jacobian_error"], "s--", color="black", markerfacecolor="white", markersize=5, linewidth=1,
                label="sampled: Jacobian")
    axis.loglog(times, errors["force_error"], "o-", color="black", markersize=5, linewidth=1, label="sampled: forces")
    axis.loglog(naive, errors["force_error"], "x:", color="#777777", markersize=6, linewidth=1, label="naive program: forces")
    for row, time, error in zip(sampled, times, errors["force_error"]):
        axis.annotate(f"N = {row['samples']}", (time, error), xytext=(-6, 0), textcoords="offset points", ha="right",
                      va="center", fontsize=7, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5})
    time = MICRO * exact["jacobian"]
    axis.set_ylim(2e-9, 0.5)
    axis.set_xlim(0.15 * min(times), 2 * max(naive))
    axis.axvline(time, color="black", linestyle=(0, (7, 2, 1, 2)), linewidth=1.2, label="exact", marker="*", markersize=11,
                 markevery=[0], clip_on=False)
    axis.annotate(f"exact: {time:.3g} µs,\nerror {exact['force_error']['median']:.0e}", (time, 4e-9), xytext=(6, 0),
                  textcoords="offset points", fontsize=7)
    axis.grid(color="#e3e3e3", linewidth=0.7)


def positive(text):
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} given, a number from 1 on wanted")
    return value


def settings(arguments=None):
    parser = argparse.ArgumentParser(prog="scripts/bench/contact_kernel", description=__doc__.splitlines()[0])
    parser.add_argument("--harmonics", type=positive, nargs="+", metavar="H", help="default 5 10 20 40")
    parser.add_argument("--samples", type=positive, nargs="+", metavar="N", help="default 64 256 1024 4096")
    parser.add_argument("--motions", type=positive, metavar="N", help="of each kind and H; default 256")
    parser.add_argument("--runs", type=positive, metavar="N", help="median of so many; default 7")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="of the motions; default %(default)s")
    parser.add_argument("--quick", action="store_true", help="few motions, measured once: figures to look at, not to quote")
    parser.add_argument("--picture", action="store_true", help=f"draw to {PICTURE.relative_to(ROOT)} instead of build/bench")
    options = parser.parse_args(arguments)
    full = {"harmonics": [5, 10, 20, 40], "samples": [64, 256, 1024, 4096], "motions": 256, "runs": 7}
    quick = {"harmonics": [5, 10], "samples": [64, 256], "motions": 16, "runs": 1}
    for name, value in (quick if options.quick else full).items():
        if getattr(options, name) is None:
            setattr(options, name, value)
    options.harmonics, options.samples = sorted(set(options.harmonics)), sorted(set(options.samples))
    if options.samples[-1] <= 2 * options.harmonics[-1]:
        parser.error(f"{options.harmonics[-1]} harmonics need at least {2 * options.harmonics[-1] + 1} samples")
    options.naive, options.milliseconds = (2, 0) if options.quick else (8, 5)  # points of the naive program, shortest measurement
    return options


def main():
    options = settings()
    around = surroundings()
    rows, peak, cpu, cost = measured_rows(options)
    load = os.getloadavg()[0]
    print(f"contact forces of random motions, {options.motions} of each kind: one thread, CPU time, median of {options.runs} "
          f"run{'s' * (options.runs > 1)}; {around['cores']} cores, load {around['load_at_start']:.1f} before, {load:.1f} after")
    print(f"multiply-adds, one thread: {1e-9 * peak['before']:.1f} GFLOP/s before, {1e-9 * peak['after']:.1f} after; "
          f"\"limit\": share of that speed which forces and Jacobian reach\n")
    print("\n".join(table(rows)))
    difference = max(row["naive"]["difference"] for row in rows if "naive" in row)
    print(f"\nsampled and naive differ by {difference:.0e} at most; the error of the exact forces is what a later beginning of the period "
          f"changes in them\nwhole bench: {cost.wall:.0f} s, CPU {cost.cpu:.0f} s")
    keep("contact_kernel" + "_quick" * options.quick,
         {**around, "load_at_end": load, "cpu": cpu, "seed": options.seed, "motions": options.motions, "runs": options.runs,
          "peak_flops": peak, "measured": rows})
    draw(PICTURE if options.picture else OUTPUT / PICTURE.name, rows)


if __name__ == "__main__":
    main()
