"""The commands of python3 -m dovetail. What each of them needs is imported when it runs."""

import shutil
import sys
from pathlib import Path

TEMPLATE = Path(__file__).with_name("template")


def new(arguments):
    """Copy the template folder."""
    target = Path(arguments.name)
    if target.exists():
        raise ValueError(f"{target}: is there already; choose another name")
    shutil.copytree(TEMPLATE, target, ignore=shutil.ignore_patterns("__pycache__"))
    print(f"{target}: model.py, case.toml, its schema for editors, and README.md, which says how to go on")


def import_(arguments):
    """Convert foreign files to a model or reduced file."""
    from .importers import convert

    try:
        print(f"{arguments.output}: {convert(arguments.format, arguments.files, arguments.output, arguments.setup)}")
    except ValueError as error:
        if notes := getattr(error, "notes", None):
            print("\n  ".join([f"{arguments.output}: not written; what was read until then:", *notes]))
        raise


def plot(arguments):
    """Draw a picture of a results file, or of the mesh of a model file."""
    from .plot_command import plot as command

    command(arguments)


def export(arguments):
    """Write files for ParaView, and the curve as a table."""
    from .export import export as command

    command(arguments)


def stress(arguments):
    """Say where a part is stressed most, and how much of its strength that uses."""
    from .stress import stress as command

    command(arguments)


def info(arguments):
    """Say what is in a file."""
    from .info import describe

    for path in arguments.files:
        print(describe(path))


def peaks(arguments):
    """Tabulate the peaks that a nonlinear mode gives over the force."""
    from .peaks_table import peaks as command

    command(arguments)


def verify(arguments):
    """Compute points of results again, independently of the program."""
    from .verify import verify as command

    return _with_runs(command, arguments)


def watch(arguments):
    """Show a run while it goes on."""
    from .watch import watch as command

    command(arguments)


def study(arguments):
    """Run a grid of settings on a case, and say what each buys."""
    from .study import study as command

    return _with_runs(command, arguments)


def ranges(arguments):
    """Say what ranges of parameters make of a peak."""
    from .ranges import ranges as command

    return _with_runs(command, arguments)


def fit(arguments):
    """Find parameters of a joint from a measured curve."""
    from .fit import fit as command

    return _with_runs(command, arguments)


def wear(arguments):
    """Let friction wear a joint, and say what that makes of it."""
    from .wear import wear as command

    return _with_runs(command, arguments)


def wheel(arguments):
    """Say whether a travelling wave is stable."""
    from .wheel import wheel as command

    return _with_runs(command, arguments)


def _with_runs(command, arguments):
    """Status of a command that runs cases."""
    from .study_runs import RunFailed

    try:
        command(arguments)
    except RunFailed as error:
        print(f"dovetail: {error}", file=sys.stderr)
        return 3
