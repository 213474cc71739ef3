"""What a run watches: nodes by name, amplitudes as in Python, peaks with their unknown, units of the model."""

import shutil
import sys
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from launch import ROOT, line, run, words_of

from dovetail import Model, Results
from dovetail.info import describe

TEMPLATE = ROOT / "python/dovetail/template"


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """The model of the template."""
    folder = tmp_path_factory.mktemp("model")
    shutil.copy(TEMPLATE / "model.py", folder)
    words_of([sys.executable, str(folder / "model.py")])
    return folder / "model.h5"


def case(folder, model, units=None, **continuation):
    """The template's case with keys of [continuation], its model labelled with other units."""
    folder.mkdir(exist_ok=True)
    shutil.copy(model, folder / "model.h5")
    if units is not None:
        with h5py.File(folder / "model.h5", "r+") as file:
            file.attrs["units"] = units
    text = (TEMPLATE / "case.toml").read_text()
    keys = "".join(f"{key} = {value}\n" for key, value in continuation.items() if key != "omega")
    text = text.replace("omega = [11000.0, 12600.0] ", f"omega = {continuation.get('omega', [11000.0, 12600.0])}\n{keys}")
    (folder / "case.toml").write_text(text)
    return SimpleNamespace(path=folder / "case.toml")


@pytest.mark.parametrize("name, ranks", [
    pytest.param("shaken.y", 2, marks=pytest.mark.slow), ("lower face of A.x", None),
    pytest.param("200.y", None, marks=pytest.mark.slow)])
def test_peaks_of_a_node_are_those_of_its_recovered_motion(tmp_path, model, name, ranks):
    with h5py.File(model) as file:
        sets = {key: values[()] for key, values in file["mesh/sets"].items()}
    done = run(case(tmp_path / "run", model, omega=[11500.0, 12000.0], watch=f'"{name}"'), ranks=ranks)
    results = Results(done.folder / "results.h5")
    peaks = results.events.of("peak")
    assert results.watched == results.watch == name and len(peaks) > 0 and (peaks.unknown == -1).all()
    np.testing.assert_allclose(peaks.amplitude, results.amplitude(name)[peaks.point], rtol=1e-10)
    assert list(results.located_peaks(name)) == list(peaks.point)
    assert f"peak of {name}: {peaks.amplitude[0]:.7g} m at {peaks.omega[0]:.9g} rad/s" in done.out
    assert done.summary["located"]["peaks"][0]["unknown"] == name
    where = name.rsplit(".", 1)[0]
    nodes = sets[where] if where in sets else [int(where)]
    motion = results.displacement(int(peaks.point[0]), nodes, n=4096)[:, :, "xyz".index(name[-1])].mean(axis=1)
    assert np.ptp(motion) / 2 == pytest.approx(peaks.amplitude[0], rel=1e-5)


def test_amplitudes_of_the_log_are_those_of_python(tmp_path, model):
    """Also where the motion has even harmonics, whose largest |q - mean| is another number."""
    done = run(case(tmp_path / "run", model, omega=[11500.0, 12000.0]))
    results = Results(done.folder / "results.h5")
    peaks = results.events.of("peak")
    assert len(peaks) > 0
    for point, amplitude, unknown in zip(peaks.point, peaks.amplitude, peaks.unknown):
        name = results.dof_names()[unknown]
        everywhere = [results.amplitude(dof)[point] for dof in results.dof_names()[results.modes:]]
        assert amplitude == pytest.approx(max(everywhere), rel=1e-10) == pytest.approx(results.amplitude(name)[point], rel=1e-10)
        assert f"peak of {name}: {amplitude:.7g} m" in done.out and f"located peak of {name}" in describe(results.path)
        _, q = results.time_history(int(point), name, 4096)
        assert np.abs(q - q.mean()).max() > amplitude * (1 + 1e-6)
    first = next(words for words in done.out.splitlines() if words.startswith("     1 "))
    assert float(first.split()[2]) == pytest.approx(max(results.amplitude(dof)[0] for dof in results.dof_names()[results.modes:]), rel=1e-4)


@pytest.mark.slow
def test_watched_motion_is_kept_where_motion_is_not(tmp_path, model):
    folder = tmp_path / "run"
    path = case(folder, model, omega=[11800.0, 11860.0], watch='"shaken.y"').path
    path.write_text(path.read_text() + "\n[output]\nmotion = []\n" if "[output]" not in path.read_text()
                    else path.read_text().replace("[output]", "[output]\nmotion = []"))
    done = run(SimpleNamespace(path=path))
    results = Results(done.folder / "results.h5")
    with h5py.File(results.reduced) as file:
        assert len(file["recovery/elastic_dofs"]) == 1
    peaks = results.events.of("peak")
    assert len(peaks) > 0
    np.testing.assert_allclose(peaks.amplitude, results.amplitude("shaken.y")[peaks.point], rtol=1e-10)
    again = run(SimpleNamespace(path=path))
    assert "still fits the model, reused" in again.out
    np.testing.assert_array_equal(Results(done.folder / "results.h5").events.of("peak").amplitude, peaks.amplitude)


def test_nodes_that_cannot_be_watched_are_refused(tmp_path, model):
    for name, words in (("shak.y", 'there is no node set or node "shak"'), ("99999.y", 'there is no node set or node "99999"'),
                        ("shaken.q", 'must be "tip.y"')):
        err = run(case(tmp_path / "run", model, watch=f'"{name}"'), status=2).err
        assert f'continuation.watch = "{name}"' in err and words in err
    run(case(tmp_path / "run", model), command="reduce")
    path = case(tmp_path / "run", model, watch='"shaken.y"').path
    path.write_text(path.read_text().replace('model = "model.h5"', 'reduced = "reduced.h5"').replace("modes = 10", ""))
    err = run(SimpleNamespace(path=path), status=2).err
    assert "names a node, whose motion the reduced model alone does not say; give  model =" in err
    made = case(tmp_path / "run", model, watch='"shaken.y"')
    Model(np.eye(4), np.eye(4), [[1, 2, 3]], force=[1.0, 0, 0, 0]).write(tmp_path / "run/model.h5")
    assert "has no mesh" in run(made, status=2).err


@pytest.mark.slow
def test_a_sweep_that_begins_within_the_peak_keeps_its_tolerance(tmp_path, model):
    """There the first point with few harmonics is far from the one with enough, and no branch is left by taking more."""
    accuracy = run(case(tmp_path / "run", model, omega=[11500.0, 11600.0])).summary["accuracy"]
    assert accuracy["above"] == 0 and accuracy["largest"] < accuracy["tolerance"]


def test_an_end_of_the_sweep_is_no_peak_in_the_log(tmp_path, model):
    done = run(case(tmp_path / "run", model, omega=[11000.0, 11300.0]))
    assert done.summary["peaks"] == 0 and "  peak of" not in done.out
    results = Results(done.folder / "results.h5")
    last = results.amplitude(results.watched)[-1]
    assert f"no peak, still rising at the end of the curve: {results.watched}: {last:.7g} m at 11300 rad/s" in done.out
    assert f"no peak: {results.watched}" in describe(results.path)
    done = run(case(tmp_path / "back", model, omega=[11300.0, 11000.0]))
    assert "no peak, falling from the beginning of the curve" in done.out and "still rising" not in done.out


@pytest.mark.parametrize("units, length, omega, stiffness", [("t, mm, s, N", "mm", "rad/s", "N/mm"),
                                                            *(pytest.param(*other, marks=pytest.mark.slow) for other in
                                                              [("kg, mm, ms", "mm", "rad/ms", "kN/mm"), ("bushels", "", "rad/s", "")])])
def test_the_log_is_in_the_units_of_the_model(tmp_path, model, units, length, omega, stiffness):
    made = case(tmp_path / "run", model, units, omega=[11500.0, 12000.0])
    done = run(made)
    results = Results(done.folder / "results.h5")
    peaks = results.events.of("peak")
    whose = results.dof_names()[peaks.unknown[0]]
    assert f"peak of {whose}: {peaks.amplitude[0]:.7g}{' ' * bool(length)}{length} at {peaks.omega[0]:.9g} {omega}\n" in done.out
    assert f"Omega [{omega}]" in done.out and ("motion [mm]" in done.out) == bool(length)
    assert " m " not in done.out.replace("memory", "") and ("rad/s" in done.out) == (omega == "rad/s")
    assert f"{peaks.amplitude[0]:.9g} {length}".strip() in describe(results.path)
    command, _ = line(made, "--dry-run")
    told, _ = words_of(command)
    row = next(words for words in told.splitlines() if words.startswith("contact.normal_stiffness"))
    assert (f"[{stiffness}]" in row) if stiffness else ("[" not in row)
    hertz = next(words for words in told.splitlines() if "[Hz]" in words)
    assert f"{11500 / (2 * np.pi) * (1000 if 'ms' in units else 1):.4f}"[:7] in hertz
