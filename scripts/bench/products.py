"""Speed of the products with the array of modes, with each instruction set, beside the BLAS.

An array of single precision times few columns, and its transpose times the result, 24 rows at a time as in the program; sgemm on the
same array, both ways; sgemm of large squares. All in turn on one thread, CPU time, medians. The kernel of OpenBLAS is that of the
instruction set: OPENBLAS_CORETYPE.
"""

import argparse
import json
import os

from measure import BINARY, keep, surroundings, weigh

PROGRAM = BINARY.parent / "products"
KERNELS = {"AVX-512": "SkylakeX", "AVX2": "Haswell", "portable": "Nehalem"}


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench/products", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--size", type=int, default=1530, metavar="N", help="rows and columns of the array; default %(default)s")
    parser.add_argument("--widths", type=int, nargs="+", default=[11, 21, 41], metavar="W", help="columns, 2H+1; default 11 21 41")
    parser.add_argument("--runs", type=int, default=9, metavar="N", help="median of so many; default %(default)s")
    options = parser.parse_args()
    around = surroundings()
    weigh(["cmake", "--build", PROGRAM.parent, "--target", PROGRAM.name])
    rows = []
    for form, kernel in KERNELS.items():
        os.environ["OPENBLAS_CORETYPE"] = kernel
        rows += json.loads(weigh([PROGRAM, form, options.size, options.runs, *options.widths])[0])
    print(f"GFLOP/s of products with {options.size} x {options.size} numbers, median of {options.runs}; {around['cores']} cores, "
          f"load {around['load_at_start']:.1f} before, {os.getloadavg()[0]:.1f} after\n")
    print(f"{'':10}{'width':>6}{'both':>8}{'product':>9}{'transpose':>11}{'sgemm':>8}{'square':>8}{'both/square':>13}")
    for row in rows:
        print(f"{row['form']:10}{row['width']:6}{row['both']:8.1f}{row['product']:9.1f}{row['transpose']:11.1f}{row['sgemm']:8.1f}"
              f"{row['square']:8.1f}{row['both'] / row['square']:13.0%}")
    print("\nboth: product and transpose, 24 rows at a time; product, transpose: of the same 24 rows, which stay in the cache")
    keep("products", {**around, "runs": options.runs, "size": options.size, "rows": rows})


if __name__ == "__main__":
    main()
