"""Set-up and post-processing: python3 -m dovetail new | import | plot | export | stress | info | peaks | verify | watch | study | range |
fit | wear | wheel."""

import platform
import re
import sys

from . import __version__, blas_kernel
from .arguments import parser

NEGATIVE = re.compile(r"-[\d.]+e[-+]?\d+")  # such as -1e-5, which argparse takes for an option unless a blank stands before it


def versions():
    """The package and what it works with, one in a line."""
    import h5py
    import numpy
    import scipy

    lines = {"dovetail": __version__, "Python": platform.python_version(), "NumPy": numpy.__version__,
             "SciPy": scipy.__version__, "BLAS": blas_kernel.in_words(),
             "HDF5": f"{h5py.version.hdf5_version}, h5py {h5py.__version__}"}
    return "\n".join(f"{name:<10}{text}" for name, text in lines.items())


def main(arguments=None):
    """Returns the exit status: 0 done, 2 the input is wrong, 3 the computation could not go on."""
    words = sys.argv[1:] if arguments is None else arguments
    if {"--version", "-v"} == set(words):
        print(versions())
        return 0
    chosen = parser().parse_args([f" {word}" if NEGATIVE.fullmatch(word) else word for word in map(str, words)])
    try:
        return chosen.run(chosen) or 0
    except (ValueError, KeyError, OSError) as error:
        print(f"dovetail: {_said(error)}", file=sys.stderr)
        return 2


def _said(error):
    """In words; of files without a number of the operating system."""
    if isinstance(error, KeyError):
        return error.args[0]
    if isinstance(error, FileNotFoundError) and error.filename:
        return f"{error.filename}: no such file"
    if isinstance(error, OSError) and error.filename and error.strerror:
        return f"{error.filename}: {error.strerror}"
    return error


if __name__ == "__main__":
    sys.exit(main())
