"""What `cmake --install` and `pip install ./python` put in place works on its own: without this tree, from an empty environment."""

import re
import shutil
import subprocess
import sys
import tomllib

import pytest

from dovetail import __version__
from launch import ROOT, SECONDS

BUILD = ROOT / "build"


def output(*command, folder=None, **environment):
    """What a command prints, with nothing in the environment but what is given."""
    done = subprocess.run([str(word) for word in command], cwd=folder, env=environment, capture_output=True, text=True, timeout=SECONDS)
    assert done.returncode == 0, f"{' '.join(map(str, command))} ended with {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    """An installation that has been moved since."""
    if not (BUILD / "cmake_install.cmake").is_file():
        pytest.skip("no build/ to install from")
    first, moved = (tmp_path_factory.mktemp("prefix") / name for name in ("first", "moved"))
    subprocess.run(["cmake", "--install", BUILD, "--prefix", first], check=True, stdout=subprocess.DEVNULL, timeout=SECONDS)
    first.rename(moved)
    return moved


@pytest.fixture(scope="module")
def joint(prefix, tmp_path_factory):
    """The folder that the installed template makes."""
    folder = tmp_path_factory.mktemp("installed")
    output(prefix / "bin/dovetail-python", "-m", "dovetail", "new", "joint", folder=folder)
    output(prefix / "bin/dovetail-python", "model.py", folder=folder / "joint")
    return folder / "joint"


@pytest.mark.slow
def test_program_runs_from_an_empty_environment(prefix, joint):
    assert output(prefix / "bin/dovetail", "--version").startswith(f"dovetail {__version__} ")
    told = output(prefix / "bin/dovetail", "run", "case.toml", "--dry-run", folder=joint)
    assert "harmonic_balance.harmonics" in told and "reduction" in told


@pytest.mark.slow
def test_a_run_and_its_results(prefix, joint):
    """From the installed program to the installed package, by way of a link to both."""
    links = joint.parent / "links"
    links.mkdir()
    for name in ("dovetail", "dovetail-python"):
        (links / name).symlink_to(prefix / "bin" / name)
    case = (joint / "case.toml").read_text()
    (joint / "point.toml").write_text(case.replace("omega = [11000.0, 12600.0]", "omega = [11800.0, 11800.0]"))
    output(links / "dovetail", "run", "point.toml", folder=joint)
    assert "points                1\n" in output(links / "dovetail-python", "-m", "dovetail", "info", "out/results.h5", folder=joint)
    where = output(links / "dovetail-python", "-c", "import dovetail, shutil; print(dovetail.__file__, shutil.which('dovetail'))")
    assert where.split() == [str(prefix / "share/dovetail/python/dovetail/__init__.py"), str(prefix / "bin/dovetail")]


def test_documents_are_there(prefix):
    documents = prefix / "share/doc/dovetail"
    for name in ("README.md", "LICENSE", "CITATION.cff", "CHANGELOG.md", "CONTRIBUTING.md", "docs", "inputs/two_solids/case.toml"):
        assert (documents / name).exists(), name
    assert not [path for path in prefix.rglob("*") if path.name in ("__pycache__", "out") and path.is_relative_to(documents)]


def test_readers_of_foreign_files_are_pinned_alike():
    """In scripts/setup and in the extras of the package; and the version is one in program, package and citation."""
    project = tomllib.loads((ROOT / "python/pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    pinned = re.search(r'^extras="(.*)"$', (ROOT / "scripts/setup").read_text(), re.MULTILINE)[1].split()
    assert sorted(extras["ansys"] + extras["nastran"]) == sorted(pinned)
    assert f"\nversion: {__version__}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"project(dovetail VERSION {__version__} " in (ROOT / "CMakeLists.txt").read_text()


@pytest.mark.slow
def test_pip_installs_the_package(tmp_path):
    """Into an environment that sees the distribution's packages, without the network."""
    source, environment = tmp_path / "python", tmp_path / "venv"
    shutil.copytree(ROOT / "python", source, ignore=shutil.ignore_patterns("__pycache__", "build", "*.egg-info"))
    output(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", environment)  # pip is the distribution's
    python = environment / "bin/python"
    if subprocess.run([python, "-c", "import setuptools"], env={}, capture_output=True, timeout=SECONDS).returncode:
        pytest.skip("no setuptools to build with, and the network is not asked")
    output(python, "-m", "pip", "install", "--quiet", "--no-index", "--no-build-isolation", source, HOME=str(tmp_path))
    assert str(environment) in output(python, "-c", "import dovetail; print(dovetail.__file__)")
    for module in ("importers.calculix", "reference.newton", "hdf5_parts"):
        output(python, "-c", f"import dovetail.{module}")
    assert output(python, "-m", "dovetail", "--version") == f"dovetail {__version__}\n"
    output(python, "-m", "dovetail", "new", "joint", folder=tmp_path)
    assert "12 contact points" in output(python, "model.py", folder=tmp_path / "joint")
