"""What newcomers wish for first, each by one command or a few lines, on the folder that `dovetail new` makes.

Three more have tests of their own: pip (test_installation.py), what is told before the first point (test_watching.py), and surfaces
that overlap in part (test_gmsh_recipe.py, the page about CalculiX).
"""

import re
import subprocess

import pytest

from launch import BINARY, ROOT, SECONDS, SURROUNDINGS

PYTHON = "$PYTHON -m dovetail"
WISHES = {  # (the lines, what they print, the file they leave)
    "response of a node": (f"{PYTHON} plot out/results.h5 --dof shaken.y --hz", "out/results.png", "out/results.png"),
    "resonances": ("$RUN modes case.toml", r"2 +1917\.7\d +12049", None),
    "units": ("mkdir mm && sed 's/\"SI\"/\"t, mm, s, N\"/' model.py >mm/model.py && $PYTHON mm/model.py >log\n"
              f"{PYTHON} info mm/model.h5", r"units +t, mm, s, N", None),
    "levels of force in one picture": ("sed 's/^fourier = .*/fourier = [0, 2]/' case.toml >low.toml\n"
                                       "$RUN run low.toml --out low >log\n"
                                       f"{PYTHON} plot low/results.h5 out/results.h5 --labels 2N 20N -o levels.png", "", "levels.png"),
    "csv": (f"{PYTHON} export out/results.h5 -o curve.csv", "", "curve.csv"),
    "ParaView": (f"{PYTHON} export out/results.h5 -o paraview", "", "paraview/contact.pvd"),
    "animation": (f"{PYTHON} plot out/results.h5 --kind motion -o motion.gif", "", "motion.gif"),
    "stress": (f"{PYTHON} stress out/results.h5 --fatigue-strength 60e6 --tensile 400e6 --worst 1", r"utilisation.*\n +\d+ ", None),
    "backbone": ("sed -e 's/^omega = .*//; s/^tolerance = .*//; s/^\\[mode\\].*/[mode]\\nnumber = 2\\namplitude = [1e-8, 1e-6]/' \\\n"
                 "  -e 's/^\\[reduction\\]/[reduction]\\nmodes = 10/; s/^\\[harm.*/&\\nharmonics = 3/' case.toml >mode.toml\n"
                 f"$RUN run mode.toml --out mode >log && {PYTHON} plot mode/results.h5 --kind mode -o mode.png", "", "mode.png"),
    "from Python": ("$PYTHON -c 'import dovetail; print(len(dovetail.run(\"case.toml\", out=\"py\")), \"points\")'", r"^\d+ points", None),
    "a folder in use": ("flock out/dovetail.lock $RUN run case.toml 2>&1 || echo refused", r"dovetail: .*another(.|\n)*refused", None),
    "versions to report": ("$RUN --version -v", r"PETSc.*\d", None),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("new")
    said(folder, f"{PYTHON} new joint && cd joint && $PYTHON model.py && $RUN run case.toml")
    return folder / "joint"


def said(folder, lines):
    text = f"source {ROOT}/scripts/environment; RUN={BINARY}\n{lines}"
    done = subprocess.run(["bash", "-ec", text], cwd=folder, env=SURROUNDINGS, capture_output=True, text=True,
                          timeout=SECONDS)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("wish", WISHES)
def test_a_few_lines_do_it(wish, folder):
    lines, words, file = WISHES[wish]
    assert len(lines.splitlines()) <= 5 and re.search(words, said(folder, lines), re.MULTILINE)
    assert file is None or (folder / file).stat().st_size > 0
