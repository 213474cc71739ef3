"""The commands new, import, plot and info."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest
import synthetic_results

from dovetail import Model, Results, __version__, plot
from dovetail.__main__ import main
from dovetail.importers import FORMATS
from launch import BINARY, ROOT, SECONDS

CONTACT = {"normal_stiffness": np.full(2, 1e3), "tangential_stiffness": np.full((2, 2), 5e2), "friction": np.full((2, 2), 0.3),
           "gap": np.zeros(2)}


@pytest.fixture
def results(tmp_path):
    omega = np.linspace(1, 3, 41)
    coefficients = np.zeros((41, 8, 7))
    response = 1 / (4 - omega**2 + 0.2j * omega)
    for row, size in ((0, 3.0), (1, 0.1), (2, 0.5), (5, 1.0), (6, 0.4), (7, 0.001)):
        coefficients[:, row, 1], coefficients[:, row, 2] = size * response.real, -size * response.imag
    slip = np.abs(response) > 1
    return synthetic_results.write(tmp_path / "r.h5", omega, coefficients, 2, CONTACT, xp=np.tile([0, 0, 0.5], 2), slip=slip, stick=~slip)


def python(*arguments, **environment):
    return subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, timeout=SECONDS,
                          env={**os.environ, "OMP_NUM_THREADS": "1", **environment})


def test_new_folder_runs_as_it_stands(tmp_path, capsys):
    folder = tmp_path / "joint"
    assert main(["new", str(folder)]) == 0
    assert sorted(path.name for path in folder.iterdir()) == ["README.md", "case-file.schema.json", "case.toml", "model.py"]
    done = python(folder / "model.py", PYTHONPATH=str(ROOT / "python"))
    assert done.returncode == 0, done.stderr
    assert "area       0.0006 m^2" in done.stdout
    assert done.stdout.endswith("model.h5: 648 degrees of freedom, 12 contact points\n")
    model = Model.read(folder / "model.h5")
    K, M = model.K.toarray(), model.M.toarray()
    assert np.linalg.eigvalsh(K)[0] > 0 and np.linalg.eigvalsh(M)[0] > 0
    pressed = model.preload.copy()
    assert pressed[model.contact_dofs[:, 2]].sum() == pytest.approx(900)  # closes for positive n
    pressed[model.contact_dofs[:, 2]] = 0
    np.testing.assert_allclose(pressed, 0, atol=1e-12)  # equal and opposite on the two beams
    if BINARY.exists():
        done = subprocess.run([BINARY, "run", "case.toml", "--dry-run"], cwd=folder, capture_output=True, text=True, timeout=SECONDS)
        assert done.returncode == 0, done.stderr

    capsys.readouterr()
    assert main(["new", str(folder)]) == 2
    assert "is there already" in capsys.readouterr().err


def test_template_model_says_how_to_find_the_package(tmp_path):
    main(["new", str(tmp_path / "joint")])
    done = python(tmp_path / "joint" / "model.py", PYTHONPATH="")
    assert done.returncode == 1 and "export PYTHONPATH=FOLDER_OF_DOVETAIL/python" in done.stderr and "Traceback" not in done.stderr


def test_template_case_explains_every_key():
    tomllib = pytest.importorskip("tomllib")
    text = (ROOT / "python/dovetail/template/case.toml").read_text()
    case = tomllib.loads(re.sub(r"^# (\w+ = )", r"\1", text, flags=re.MULTILINE))
    assert {section: set(keys) for section, keys in case.items() if isinstance(keys, dict)} == {
        "reduction": {"modes", "kind", "interior_modes", "exact_modes", "check_modes", "memory"},
        "damping": {"stiffness", "mass", "structural", "ratios", "of", "matrix", "contact"},
        "excitation": {"fourier", "engine_order"},
        "contact": {"law", "normal_stiffness", "tangential_stiffness", "normal_stiffness_per_area", "tangential_stiffness_per_area",
                    "friction", "gap"}, "preload": {"initial"},
        "accuracy": {"tolerance", "estimates", "between"}, "harmonic_balance": {"harmonics", "samples"},
        "newton": {"step_tolerance", "residual_tolerance", "max_iterations"},
        "scaling": {"kind", "frequency", "modal", "contact"},
        "continuation": {"unit", "omega", "step", "adaptive", "max_points", "at", "start", "watch", "stop_after_peaks",
                             "stop_at_amplitude"},
        "path": {"parameter", "joint", "points", "range", "omega", "peak", "at"}, "sensitivity": {"of"},
        "mode": {"number", "near", "amplitude", "at", "to_force"},
        "recovery": {"strategies", "allow_branch_change", "work"}, "stability": {"enabled"}, "output": {"directory", "motion"}}
    assert {"title", "model", "reduced"} <= set(case)


def test_five_dof_example_is_the_published_one(tmp_path):
    (tmp_path / "model.py").write_text((ROOT / "inputs/dof5/model.py").read_text())
    assert python(tmp_path / "model.py", PYTHONPATH=str(ROOT / "python")).returncode == 0
    model = Model.read(tmp_path / "model.h5")
    chain = np.diag([10.0, 20, 20, 20, 20]) - 10 * (np.eye(5, k=1) + np.eye(5, k=-1))
    np.testing.assert_array_equal(model.K.toarray(), chain)
    np.testing.assert_array_equal(model.M.toarray(), np.eye(5))
    np.testing.assert_array_equal(model.force, [1, 1, 0, 0, 0])
    np.testing.assert_array_equal(model.preload, [1, 0.1, 0.1, 0.1, 0.1])


def test_import_command(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("Name: Kex\n1\n")
    assert main(["import", "csv", str(tmp_path / "a.csv"), "-o", str(tmp_path / "m.h5")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    rows = {"omega_a2": "4", "Max": "0,0,0", "Mxx": "1,0,0\n0,1,0\n0,0,1", "Kxx": "2,0,0\n0,2,0\n0,0,2", "fa": "1", "fx": "0,0,0",
            "Rx": "0,0,-1"}
    (tmp_path / "a.csv").write_text("".join(f"Name: {name}\n{values}\n\n" for name, values in rows.items()))
    assert main(["import", "csv", str(tmp_path / "a.csv"), "-o", str(tmp_path / "m.h5")]) == 0
    assert main(["info", str(tmp_path / "m.h5")]) == 0
    said = capsys.readouterr().out
    assert "m.h5: reduced model: 1 modes, 1 contact points" in said and "recovery" in said and "2 rad/s" in said


def test_import_help_gives_every_format_a_line(capsys):
    with pytest.raises(SystemExit):
        main(["import", "--help"])
    said = capsys.readouterr().out
    for name, files in FORMATS.items():
        assert re.search(rf"^  {name} +{re.escape(files)}$", said, re.MULTILINE)


@pytest.mark.parametrize("kind, name", [("response", "r.png"), ("history", "r_history.png"), ("hysteresis", "r_hysteresis.png")])
def test_plot_command_writes_a_picture(results, kind, name, capsys):
    assert main(["plot", str(results), "--kind", kind]) == 0
    assert capsys.readouterr().out == f"{results.with_name(name)}\n"
    picture = plot.plt.imread(results.with_name(name))
    assert min(picture.shape[:2]) > 500 and picture[..., :3].std() > 0.05
    assert main(["plot", str(results), "--kind", kind, "--dof", "x1.t1", "--at", "2.1", "-o", str(results.with_name("own.png"))]) == 0
    assert results.with_name("own.png").stat().st_size > 5000


@pytest.mark.parametrize("options, words", [
    (["--at", "1e9"], "--at 1e+09: {} has frequencies from 1 to 3 rad/s"),
    (["--kind", "map", "--at", "0.5"], "--at 0.5: {} has frequencies from 1 to 3 rad/s"),
    (["--at", "2", "--hz"], "--at 2: {} has frequencies from 0.159155 to 0.477465 Hz"),
    (["--harmonic", "3"], "--harmonic: changes nothing in a picture of kind response"),
    (["--kind", "pressure", "--at", "2"], "--at: changes nothing in a picture of kind pressure"),
    (["--kind", "pressure", "--dof", "x1.n"], "--dof: changes nothing in a picture of kind pressure"),
    (["--kind", "mode", "--at", "2"], "--at: changes nothing in a picture of kind mode"),
    (["--labels", "a", "--harmonic", "3"], "--harmonic: changes nothing in a picture of several files")])
def test_options_that_a_picture_has_no_use_for_are_refused(results, options, words, capsys):
    assert main(["plot", str(results), *options]) == 2
    assert words.format(results) in capsys.readouterr().err and not list(results.parent.glob("*.png"))


def test_response_shows_amplitude_over_frequency(results):
    data = Results(results)
    figure = plot.response(data, hz=True)
    curves = {line.get_label().split()[0]: line for line in figure.axes[0].lines if "peak" in line.get_label()}
    assert set(curves) == {"x2.t1", "x2.t2"}  # the contact point that moves most, without the direction that hardly does
    np.testing.assert_allclose(curves["x2.t2"].get_xdata(), data.omega / (2 * np.pi))
    np.testing.assert_allclose(curves["x2.t2"].get_ydata(), 0.4 / np.abs(4 - data.omega**2 + 0.2j * data.omega), rtol=1e-12)
    slip = next(line for line in figure.axes[-1].lines if line.get_label() == "slip")
    np.testing.assert_array_equal(slip.get_ydata(), 100 * data.points("slip"))
    assert len(plot.response(data, ["a1", "x1.t1"]).axes) == 3  # modal and contact unknowns have different units


def test_response_is_dashed_where_it_is_unstable_and_dotted_where_that_is_uncertain(results, monkeypatch):
    data, drawn = Results(results), {}
    data.stable = np.full(len(data), plot.STABLE)
    data.stable[5:9], data.stable[12] = plot.UNSTABLE, plot.UNCERTAIN
    line = plot.plt.Axes.plot

    def watched(axis, x, y, *rest, **style):
        if np.size(x) >= len(data) and style.get("linestyle") in plot.DASHES.values():
            drawn.setdefault(style["linestyle"], np.unique(x[np.isfinite(y)]))  # the amplitude comes first
        return line(axis, x, y, *rest, **style)

    monkeypatch.setattr(plot.plt.Axes, "plot", watched)
    axis = plot.response(data, ["x2.t2"]).axes[0]
    assert {"unstable", "stability uncertain"} <= {text.get_text() for text in axis.get_legend().get_texts()}
    for verdict, pieces in ((plot.UNSTABLE, [slice(4, 10)]), (plot.UNCERTAIN, [slice(11, 14)]),
                            (plot.STABLE, [slice(0, 5), slice(9, 12), slice(13, None)])):
        seen = np.unique(np.concatenate([data.omega[piece] for piece in pieces]))
        np.testing.assert_array_equal(drawn[plot.DASHES[verdict]], seen)


@pytest.mark.parametrize("arguments, message", [
    (["--dof", "x9.t1"], "no degree of freedom 'x9.t1'; there are a1 to a2"),
    (["--kind", "hysteresis", "--dof", "x1.n"], "a friction loop needs a tangential direction such as x1.t1, found 'x1.n'"),
    (["--kind", "hysteresis", "--dof", "a1"], "a friction loop needs a tangential direction"),
    (["-o", "/dev/null/folder/a.png"], "/dev/null/folder/a.png: its folder is not there and cannot be made: Not a directory"),
])
def test_wrong_plot_is_one_line_and_status_2(results, arguments, message, capsys):
    assert main(["plot", str(results), *arguments]) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1


def test_info(results, tmp_path, capsys):
    Model(np.eye(5), np.eye(5), [[2, 3, 4]], force=[0, -7.0, 0, 0, 0], contact={"friction": [0.1, 0.3]}).write(tmp_path / "m.h5")
    assert main(["info", str(tmp_path / "m.h5"), str(results)]) == 0
    said = re.sub(r" +", " ", capsys.readouterr().out)
    for line in ("degrees of freedom 5 (2 elastic)", "force 1 entries, largest 7", "friction 0.1 to 0.3", "points 41",
                 "omega 1 to 3 rad/s (0.159155 to 0.477465 Hz)", "peak of x2.t1 2.5"):
        assert line in said
    (tmp_path / "text.h5").write_text("no")
    for name in ("text.h5", "none.h5"):
        assert main(["info", str(tmp_path / name)]) == 2
        assert name in capsys.readouterr().err


@pytest.mark.slow
def test_help_version_and_wrong_command(capsys):
    assert python("-m", "dovetail", "--help", PYTHONPATH=str(ROOT / "python")).stdout.startswith("usage: python3 -m dovetail")
    done = python("-m", "dovetail", "plto", PYTHONPATH=str(ROOT / "python"))
    assert done.returncode == 2 and "plto" in done.stderr
    project = re.search(r"project\(dovetail VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())
    assert project[1] == __version__


def test_options_are_not_abbreviated(results, capsys):
    with pytest.raises(SystemExit):
        main(["verify", str(results), "--point", "3"])
    assert "unrecognized arguments: --point 3" in capsys.readouterr().err


def test_a_folder_in_place_of_a_file_is_named(tmp_path, capsys):
    for command in ("info", "plot"):
        assert main([command, str(tmp_path)]) == 2
        assert f"{tmp_path}: is a folder; a file of Dovetail in it is wanted" in capsys.readouterr().err


@pytest.mark.parametrize("command", [["study"], ["wear", "--cycles", "1", "--archard", "1", "1/Pa"], ["range", "--friction", "0.1", "0.2"]])
def test_a_file_that_is_not_there_is_named(tmp_path, command, capsys):
    missing = str(tmp_path / "no such.toml")
    assert main([command[0], missing, *command[1:]]) == 2
    assert capsys.readouterr().err == f"dovetail: {missing}: no such file\n"
