"""The recipe for meshes of gmsh on the page about CalculiX, step by step."""

import re
import shutil
import subprocess
import tomllib

import numpy as np
import pytest

from brick_deck import CCX
from dovetail import Model
from dovetail.importers import calculix, convert
from launch import BINARY, ROOT, SECONDS

PAGE = ROOT / "docs" / "how-to" / "import-calculix.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files of the page, meshed and run."""
    if CCX is None or shutil.which("gmsh") is None:
        pytest.skip("CalculiX (ccx) or gmsh is not installed")
    folder = tmp_path_factory.mktemp("gmsh")
    part = PAGE.read_text().split("## A mesh by gmsh\n")[1].split("\n## ")[0]
    blocks = re.findall(r"```\w+\n(.*?)```", part, re.S)
    assert len(blocks) == 4
    for name, block in zip(("bars.geo", "commands", "job.inp", "joints.toml"), blocks):
        (folder / name).write_text(block)
    subprocess.run(["bash", "-e", "commands"], cwd=folder, check=True, capture_output=True, timeout=SECONDS)
    done = subprocess.run([CCX, "job"], cwd=folder, capture_output=True, text=True, timeout=SECONDS)
    assert "Job finished" in done.stdout, done.stdout[-1000:]
    return folder


def test_it_gives_a_model_with_a_closed_joint(folder):
    said = convert("calculix", [str(folder / "job.inp")], str(folder / "model.h5"), setup=str(folder / "joints.toml"))
    model = Model.read(folder / "model.h5")
    np.testing.assert_allclose(model.joint["area"].sum(), 400, rtol=1e-9)
    assert "pairs of matching nodes" in said and "2 bodies, all held" in said and "nothing in the deck holds the mesh" in said
    assert set(model.mesh["cells"]) == {"tetra10"}
    assert f"moving mass r^T M r: {2 * 40 * 10 * 5 * 7.8e-9:.6g} " in said
    assert "model" in tomllib.loads((folder / "case.toml").read_text())


@pytest.mark.slow
def test_steps_of_the_page_lead_to_the_stresses(folder):
    """As a user of CalculiX follows them, at the first attempt."""
    page = PAGE.read_text()
    steps = [re.findall(r"```\w+\n(.*?)```", page.split(step)[1], re.S)[place] for step, place in (("## 3. Import\n", 1), ("## 4. Run", 0))]
    (folder / "case.toml").unlink(missing_ok=True)  # of a test before
    text = "\n".join(steps).replace("scripts/environment", f"{ROOT}/scripts/environment").replace("$ROOT/build/dovetail", str(BINARY))
    done = subprocess.run(["bash", "-ec", text], cwd=folder, capture_output=True, text=True, timeout=SECONDS)
    assert done.returncode == 0, done.stderr
    row = done.stdout.split("utilisation  sets\n")[1].splitlines()[0].split()
    assert float(row[8]) > 0 and "FIXED," in row and (folder / "out/results.png").is_file()


def test_faces_that_were_left_in_are_refused_with_the_recipe(folder):
    (folder / "mesh.inp").write_text((folder / "gmsh.inp").read_text())
    with pytest.raises(ValueError, match="found CPS6, of which CalculiX makes solids; gmsh writes .* a mesh by gmsh"):
        calculix.read([folder / "job.inp"])
