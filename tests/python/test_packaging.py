"""packaging/: the recipe for Spack, played with a stand-in for Spack, names what the build asks for; the container file what is there."""

import re
import runpy
import sys
import tomllib
from contextlib import nullcontext
from types import ModuleType, SimpleNamespace

import pytest

from launch import ROOT

RECIPE = ROOT / "packaging/spack/spack_repo/dovetail/packages/dovetail/package.py"
NAMES = {"PETSC": "petsc", "SLEPC": "slepc", "FFTW": "fftw", "MPI": "mpi", "toml11": "toml11", "LAPACK": "lapack", "METIS": "metis",
         "HDF5": "hdf5", "MUMPS": "mumps", "SCALAPACK": "scalapack", "PkgConfig": "pkgconfig"}  # in CMakeLists.txt -> in Spack


@pytest.fixture
def recipe(monkeypatch):
    """Its class, and what it depends on by name."""
    asked = {}
    spack = ModuleType("spack.package")
    for word in ("license", "version", "generator"):
        setattr(spack, word, lambda *words, **options: None)
    spack.depends_on = lambda spec, **options: asked.__setitem__(re.match(r"[a-z0-9-]+", spec)[0], spec)
    spack.default_args = lambda **options: nullcontext()
    cmake = ModuleType("cmake")
    cmake.CMakePackage = type("CMakePackage", (), {"define": staticmethod(lambda name, value: f"-D{name}={value}")})
    names = ("spack", "spack_repo", "spack_repo.builtin", "spack_repo.builtin.build_systems")
    for name, module in {**{name: ModuleType(name) for name in names}, "spack.package": spack,
                         "spack_repo.builtin.build_systems.cmake": cmake}.items():
        monkeypatch.setitem(sys.modules, name, module)
    return SimpleNamespace(package=runpy.run_path(str(RECIPE))["Dovetail"], asked=asked)


def test_spack_is_asked_for_all_that_the_build_looks_for(recipe):
    text = (ROOT / "CMakeLists.txt").read_text()
    wanted = set(re.findall(r"(?:find_package|pkg_check_modules|find_library)\((\w+)", text)) - {"MUMPS_SCOTCH", "MUMPS_SCOTCH_COMMON"}
    assert wanted <= NAMES.keys()
    assert {NAMES[name] for name in wanted} <= recipe.asked.keys()
    assert "mpi" in recipe.asked["hdf5"] and "mumps" in recipe.asked["petsc"]


def test_spack_is_asked_for_what_the_python_package_imports(recipe):
    needed = tomllib.loads((ROOT / "python/pyproject.toml").read_text())["project"]["dependencies"]
    assert {f"py-{name}" for name in [*needed, "h5py", "mpi4py", "petsc4py", "slepc4py"]} <= recipe.asked.keys()


def test_spack_builds_the_clone_that_the_recipe_is_in(recipe):
    assert recipe.package.git == f"file://{ROOT}"
    python = SimpleNamespace(command=SimpleNamespace(path="/python3"))
    arguments = recipe.package.cmake_args(SimpleNamespace(define=recipe.package.define, spec={"python": python}))
    text = (ROOT / "CMakeLists.txt").read_text() + (ROOT / "cmake/install.cmake").read_text()
    assert all(re.match(r"-D(\w+)=", argument)[1] in text for argument in arguments)


def test_the_container_is_set_up_by_the_script_and_its_options():
    text = (ROOT / "packaging/Containerfile").read_text()
    scripts = set(re.findall(r"/tmp/dovetail/(scripts/\w+)", text))
    assert scripts and all((ROOT / script).is_file() for script in scripts)
    assert set(re.findall(r"(DOVETAIL_\w+)=", text)) <= set(re.findall(r"DOVETAIL_\w+", (ROOT / "scripts/setup").read_text()))
