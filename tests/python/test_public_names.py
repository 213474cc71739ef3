"""What `import dovetail` gives: hints of types for editors, and files that pip takes along."""

import inspect
import tomllib
from pathlib import Path

import numpy as np
import pytest

import dovetail
import synthetic_results
from launch import ROOT

PACKAGE = ROOT / "python"
PUBLIC = [getattr(dovetail, name) for name in dovetail.__all__ if not name.startswith("_")]
OPEN = {"self", "cls", "options", "changes", "K", "C", "K_structural"}  # matrices are of SciPy or of PETSc


def functions(thing):
    """Public functions and methods, of classes of the package also those of their bases."""
    if inspect.isfunction(thing):
        return [thing]
    return [member for name, member in inspect.getmembers(thing, inspect.isfunction) if not name.startswith("_")
            and member.__module__.startswith("dovetail")]


@pytest.mark.parametrize("function", [found for thing in PUBLIC for found in functions(thing)], ids=lambda found: found.__qualname__)
def test_public_functions_have_hints(function):
    signature = inspect.signature(function)
    bare = [name for name, parameter in signature.parameters.items() if parameter.annotation is parameter.empty and name not in OPEN]
    assert not bare
    assert function.__name__ == "to_frame" or signature.return_annotation is not signature.empty  # pandas is no dependency


def test_editors_are_told_of_the_hints():
    assert (PACKAGE / "dovetail/py.typed").is_file()


def test_pip_takes_all_files_of_the_package_along():
    patterns = tomllib.loads((PACKAGE / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]["dovetail"]
    taken = {path for pattern in patterns for path in (PACKAGE / "dovetail").glob(pattern)}
    others = {path for path in (PACKAGE / "dovetail").rglob("*") if path.is_file() and path.suffix not in (".py", ".pyc")}
    assert others and others <= taken and all(Path(path).is_file() for path in taken)


def test_a_curve_is_shown_in_a_line(tmp_path):
    contact = {"normal_stiffness": np.ones(1), "tangential_stiffness": np.ones((1, 2)), "friction": np.ones((1, 2)), "gap": np.zeros(1)}
    path = synthetic_results.write(tmp_path / "r.h5", np.arange(1.0, 400.0), np.ones((399, 4, 3)), 1, contact)
    assert repr(dovetail.Results(path).response("x1.t1")) == "Response(name='x1.t1', unit='m')"
