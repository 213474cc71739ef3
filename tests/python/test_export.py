"""Files for ParaView of a sector, of its wheel and of a structure that is none, read by VTK; and the curve as a table."""

import csv
import json
import shutil
import xml.etree.ElementTree as ET

import h5py
import numpy as np
import pytest
import synthetic_results
from ring import N
from ring_results import computed
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from dovetail import Results
from dovetail.__main__ import main
from dovetail.contact_period import LEAST, OPEN, SLIPS, contact_period, samples_of
from dovetail.model_cyclic import read_cyclic
from dovetail.motion import find_joint
from dovetail.shown import chosen_point, chosen_sectors, default_dofs
from dovetail.verify import looked_at

FRAMES = 4


@pytest.fixture(scope="module")
def wave(tmp_path_factory):
    return computed(tmp_path_factory.mktemp("wave"))


@pytest.fixture(scope="module")
def wheel(wave, tmp_path_factory):
    """All frames of the wheel, cells and all, as VTK reads them: of the mesh, and of the contact points."""
    folder = tmp_path_factory.mktemp("wheel") / "wheel"
    assert main(["export", str(wave.path), "--wheel", "--solid", "--frames", str(FRAMES), "-o", str(folder)]) == 0
    return [[read(folder / f"{name}_{i:03d}.vtu") for i in range(FRAMES)] for name in ("motion", "contact")]


def read(path):
    """The grid, and its point data by name."""
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0
    grid = reader.GetOutput()
    data = grid.GetPointData()
    return grid, {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


def places(grid):
    return vtk_to_numpy(grid.GetPoints().GetData())


def shown(results):
    """The point that is written where none is named."""
    return chosen_point(results, dofs=default_dofs(results))


def test_the_scene_rubs_and_opens(wave):
    """Else the tests below would compare little."""
    point = shown(wave)
    assert wave.points("slip")[point] + wave.points("open")[point] > 0


def test_a_wheel_is_all_sectors_in_their_places(wave, wheel):
    """Displacements are those that results give; where neighbours are joined, both have the same place before and after."""
    point = shown(wave)
    for i, (grid, data) in enumerate(wheel[0]):
        X, u = places(grid).reshape(N, -1, 3), data["displacement"].reshape(N, -1, 3)
        time = [2 * np.pi * i / FRAMES / wave.omega[point]]
        for j in range(N):
            wanted = wave.displacement(point, times=time, sector=j, axes="global")[0]
            np.testing.assert_allclose(u[j], wanted, rtol=0, atol=1e-6 * np.abs(wanted).max())
        left, right = (data[f"set {side}"].reshape(N, -1)[0] == 1 for side in ("left", "right"))
        for values in (X, X + 50 * u):
            here, there = values[:, right], np.roll(values[:, left], -1, axis=0)
            order = [np.lexsort((X[0][side][:, 2], np.hypot(*X[0][side][:, :2].T).round(4))) for side in (right, left)]
            np.testing.assert_allclose(here[:, order[0]], there[:, order[1]], atol=2e-5)
        assert data["sector"].reshape(N, -1)[:, 0].tolist() == list(range(N))
        vibration = data["vibration"].reshape(N, -1, 3)
        assert np.linalg.norm(vibration, axis=2).max() <= data["amplitude"].max() * (1 + 1e-3)
        still = data["displacement"].reshape(N, -1, 3) - vibration
        np.testing.assert_allclose(still[0], wave.displacement(point, n=16).mean(axis=0), rtol=0, atol=1e-6 * np.abs(still).max())


def test_cells_are_whole(wave, wheel):
    """All of positive volume, as many as the sectors have, and as large in every sector."""
    grid = wheel[0][0][0]
    quality = vtkMeshQuality()
    quality.SetInputData(grid)
    quality.SetHexQualityMeasureToVolume()
    quality.Update()
    volume = vtk_to_numpy(quality.GetOutput().GetCellData().GetArray("Quality")).reshape(N, -1)
    assert volume.min() > 0 and volume.shape[1] == 16
    np.testing.assert_allclose(volume, np.tile(volume[0], (N, 1)), rtol=1e-5)


def test_contact_points_of_a_wheel(wave, wheel):
    """Forces and states of every sector at that instant, by the time shift of results; friction along the turned axes."""
    point, joint = shown(wave), find_joint(wave)
    with h5py.File(wave.path.with_name("model.h5")) as file:
        cyclic = read_cyclic(file)
    samples, points = samples_of(FRAMES, wave.wave), wave.contact_points
    assert samples % (FRAMES * N) == 0
    of = {(j, contact): (*wave.contact_force(point, contact + 1, samples, sector=j),
                         [wave.hysteresis(point, contact + 1, d, samples, sector=j)[0] for d in (0, 1)])
          for j in range(N) for contact in range(points)}
    for i, (grid, data) in enumerate(wheel[1]):
        at = i * samples // FRAMES
        for j in range(N):
            mine = slice(j * points, (j + 1) * points)
            angle = 2 * np.pi * j / N
            R = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
            np.testing.assert_allclose(places(grid)[mine], joint["position"] @ R.T, atol=1e-6)
            for contact in range(points):
                force, state, loop = of[j, contact]
                largest, row = np.abs(force).max(), j * points + contact
                assert data["normal_force"][row] == pytest.approx(force[at, 2], abs=1e-5 * largest)
                friction = R @ joint["axes"][contact][:2].T @ force[at, :2]
                np.testing.assert_allclose(data["friction_force"][row], friction, rtol=0, atol=1e-5 * largest)
                assert (data["state"][row] == OPEN) == (state[at, 0] == 2)
                x = [values[at] for values in loop]
                along = joint["axes"][contact][:2] @ R.T @ data["relative_displacement"][row]
                np.testing.assert_allclose(along, x, rtol=0, atol=1e-5 * np.abs(x).max() + 1e-12)
        np.testing.assert_allclose(data["pressure"], data["normal_force"] / data["area"], rtol=1e-5)
        np.testing.assert_allclose(data["friction_energy"][:points], wave.contact_activity(point).dissipation, rtol=1e-5, atol=1e-12)
        mesh, row = wheel[0][i][1], np.flatnonzero(np.isin(wheel[0][i][1]["node"], cyclic["nodes"][:, 0]))
        order = np.argsort(np.argsort(cyclic["nodes"][:, 0]))
        for name in ("displacement", "vibration"):
            np.testing.assert_array_equal(data[name].reshape(N, -1, 3), mesh[name][row].reshape(N, -1, 3)[:, order])
        shut = data["gap"] < 0
        np.testing.assert_array_equal(shut, data["state"] != OPEN)


def test_collections_name_the_files_and_their_times(wave, tmp_path):
    assert main(["export", str(wave.path), "--frames", "3", "--point", "1", "-o", str(tmp_path / "one")]) == 0
    for name in ("motion", "contact"):
        sets = ET.parse(tmp_path / f"one/{name}.pvd").getroot().findall("Collection/DataSet")
        assert [entry.get("file") for entry in sets] == [f"{name}_{i:03d}.vtu" for i in range(3)]
        times = [float(entry.get("timestep")) for entry in sets]
        np.testing.assert_allclose(times, 2 * np.pi / wave.omega[1] * np.arange(3) / 3, rtol=1e-8)
        assert all((tmp_path / "one" / entry.get("file")).is_file() for entry in sets)


def test_another_sector_and_its_outer_faces(wave, tmp_path):
    assert main(["export", str(wave.path), "--sector", "3", "--surface", "--frames", "1", "-o", str(tmp_path / "s")]) == 0
    grid, data = read(tmp_path / "s/motion_000.vtu")
    kinds = {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}
    assert kinds == {9} and set(data["sector"]) == {3}  # quadrangles
    wanted = wave.displacement(shown(wave), data["node"], n=1, sector=3, axes="global")[0]
    np.testing.assert_allclose(data["displacement"], wanted, rtol=0, atol=1e-6 * np.abs(wanted).max())


def test_a_structure_that_is_no_sector(tmp_path):
    results = computed(tmp_path, cyclic=False)
    assert main(["export", str(results.path), "--frames", "2"]) == 0
    grid, data = read(tmp_path / "results_paraview/motion_001.vtu")
    point = shown(results)
    wanted = results.displacement(point, n=2)[1]
    np.testing.assert_allclose(data["displacement"], wanted, rtol=0, atol=1e-6 * np.abs(wanted).max())
    assert "sector" not in data and grid.GetNumberOfCells() == 16
    _, contact = read(tmp_path / "results_paraview/contact_001.vtu")
    assert "displacement" in contact and len(contact["state"]) == results.contact_points
    for option in ("--wheel", "--sector=0"):
        assert main(["export", str(results.path), option]) == 2


def test_points_along_the_curve_at_their_largest_motion(wave, tmp_path, capsys):
    folder = tmp_path / "along"
    assert main(["export", str(wave.path), "--along", "4", "--solid", "-o", str(folder)]) == 0
    assert "4 points, at their largest motion" in capsys.readouterr().out
    points = looked_at(wave, 4)
    assert len(points) == 4 and points[0] == 0 and points[-1] == len(wave) - 1 and wave.largest_point(wave.watched) in points
    for name in ("motion", "contact"):
        steps = ET.parse(folder / f"{name}.pvd").getroot().findall(".//DataSet")
        assert [float(step.get("timestep")) for step in steps] == points
        for point, step in zip(points, steps):
            _, data = read(folder / step.get("file"))
            assert set(data["point"]) == {point} and np.allclose(data["frequency"], wave.frequency[point], rtol=1e-6)
            if name == "motion":
                size = np.linalg.norm(data["vibration"], axis=1)
                np.testing.assert_allclose(size.max(), data["amplitude"].max(), rtol=1e-5)
            else:
                np.testing.assert_allclose(data["slip_share"], wave.contact_activity(point).slip, atol=1e-6)


def test_without_motion_of_the_mesh(tmp_path, capsys):
    results = computed(tmp_path, motion='["over_left"]')
    assert main(["export", str(results.path), "--frames", "2"]) == 0
    assert "note: no motion of the mesh: " in capsys.readouterr().out
    assert {path.name for path in (tmp_path / "results_paraview").iterdir()} == {
        "contact.pvd", "contact_000.vtu", "contact_001.vtu", "curve.csv", "export.json"}
    assert main(["export", str(results.path), "--wheel", "-o", str(tmp_path / "other")]) == 2
    assert "output.motion says which are kept" in capsys.readouterr().err and not (tmp_path / "other").exists()
    assert main(["export", str(results.path), "--solid", "-o", str(tmp_path / "other")]) == 2
    assert "dovetail: --solid: " in capsys.readouterr().err and not (tmp_path / "other").exists()


def without(results, folder, name, file):
    """A copy of the folder of results, without one dataset or group of a file."""
    shutil.copytree(results.path.parent, folder)
    with h5py.File(folder / file, "r+") as changed:
        del changed[name]
    return folder / "results.h5"


@pytest.mark.parametrize("file, name, words", [
    ("model.h5", "contact/position", "has no /contact/position"), ("results.h5", "points/contact", "an older version wrote the run")])
def test_without_what_contact_points_need(wave, tmp_path, capsys, file, name, words):
    """The mesh and the curve are written all the same."""
    path = without(wave, tmp_path / "run", name, file)
    assert main(["export", str(path), "--model", str(path.with_name("model.h5")), "--frames", "1", "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "note: no contact points: " in said and words in said and {entry.name for entry in (tmp_path / "out").iterdir()} == {
        "motion.pvd", "motion_000.vtu", "curve.csv", "export.json"}


def test_names_with_dots_and_new_folders(wave, tmp_path, capsys):
    path = tmp_path / "run.v2.h5"
    shutil.copytree(wave.path.parent, tmp_path, dirs_exist_ok=True)
    (tmp_path / "results.h5").rename(path)
    for options, made in (([], "run.v2_paraview"), (["-o", str(tmp_path / "deep/v1.2")], "deep/v1.2")):
        assert main(["export", str(path), "--frames", "1", *options]) == 0 and (tmp_path / made / "curve.csv").is_file()
    assert main(["export", str(path), "-o", str(tmp_path / "new/deep/curve.csv")]) == 0
    assert (tmp_path / "new/deep/curve.csv").is_file()
    (tmp_path / "dir.csv").mkdir()
    capsys.readouterr()
    for words, said in (([str(path), "-o", str(tmp_path / "dir.csv"), "--replace"], "dir.csv: is there already and is a folder"),
                        ([str(tmp_path / "deep")], "deep: is a folder; a results file is wanted")):
        assert main(["export", *words]) == 2
        assert said in capsys.readouterr().err


def test_the_table(wave, tmp_path):
    path = tmp_path / "c.csv"
    assert main(["export", str(wave.path), "--dof", "x1.t1", "a1", "-o", str(path)]) == 0
    with open(path) as file:
        rows = list(csv.DictReader(file))
    path.write_text("mine\n")
    assert main(["export", str(wave.path), "-o", str(path)]) == 2 and path.read_text() == "mine\n"
    for options in (["--replace"], []):  # then it is its own
        assert main(["export", str(wave.path), "-o", str(path), *options]) == 0
    assert len(rows) == len(wave) and not (tmp_path / "results_paraview").exists()
    columns = {"omega [rad/s]": wave.omega, "frequency [Hz]": wave.frequency, "amplitude of x1.t1 [m]": wave.amplitude("x1.t1"),
               "slip points": wave.points("slip"), "friction energy per period and sector [J]":
               [wave.contact_activity(i).dissipation.sum() for i in range(len(wave))]}
    for name, wanted in columns.items():
        np.testing.assert_allclose([float(row[name]) for row in rows], wanted, rtol=1e-8)


def test_files_of_others_stay(wave, tmp_path, capsys):
    """An export replaces what an export has written, and takes away what it does not write again."""
    folder = tmp_path / "out"
    words = ["export", str(wave.path), "-o", str(folder), "--frames"]
    assert main([*words, "3"]) == 0 and main([*words, "2"]) == 0
    assert not (folder / "motion_002.vtu").exists() and (folder / "motion_001.vtu").exists()
    (folder / "mine.txt").write_text("mine")
    (folder / "motion_002.vtu").write_text("mine")
    assert main([*words, "3"]) == 2
    assert "motion_002.vtu: is there already; name another with -o, or say --replace" in capsys.readouterr().err
    assert (folder / "motion_002.vtu").read_text() == "mine" and len(json.loads((folder / "export.json").read_text())["files"]) == 7
    assert main([*words, "3", "--replace"]) == 0 and (folder / "mine.txt").read_text() == "mine"
    (folder / "export.json").write_text("[]")
    assert main([*words, "3"]) == 2 and "is no list of an export" in capsys.readouterr().err


@pytest.mark.parametrize("options, words", [
    (["--frames", "0"], "--frames: 1 to 999 are wanted, found 0"), (["--point", "4000"], "point must be a whole number from -"),
    (["--along", "0"], "--along: 1 to 999"),
    (["--along", "3", "--at", "1"], "--along is of points all over the curve, --at of one"),
    (["--point", "0", "--at", "1"], "--point and --at both say which point is meant"),
    (["--sector", "5"], "sector must be a whole number from 0 to 4, found 5"),
    (["--wheel", "--sector", "1"], "--wheel is all sectors, --sector one of them"),
    (["-o", "x.vtu"], "a table is written as FILE.csv, and all else into a folder, whose name does not end with .vtu")])
def test_refusals(wave, capsys, options, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["export", str(wave.path), *options]) == 2
    assert words in capsys.readouterr().err and not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", ["export", "plot"])
def test_a_place_is_a_finite_number(wave, capsys, command):
    with pytest.raises(SystemExit):
        main([command, str(wave.path), "--at", "nan"])
    assert "argument --at: a finite number is wanted, found nan" in capsys.readouterr().err


def test_way_of_a_slider(tmp_path):
    """Under a constant normal force it is four times what the amplitude exceeds the reach of the spring by; energy is mu N times it."""
    kn, kt, mu, xn, A = 2.0, 3.0, 0.5, 0.4, 0.9
    contact = {"normal_stiffness": np.array([kn]), "tangential_stiffness": np.array([[kt, kt]]), "friction": np.array([[mu, mu]]),
               "gap": np.array([0.0])}
    coefficients = np.zeros((1, 3, 3))
    coefficients[0, 0, 1] = A
    path = synthetic_results.write(tmp_path / "r.h5", [1.0], coefficients, 0, contact, xp=np.array([0, 0, xn]))
    period = contact_period(Results(path), 0, 4096)
    way = 4 * (A - mu * kn * xn / kt)
    assert period.slip_path[0] == pytest.approx(way, rel=1e-3)
    assert period.energy[0] == pytest.approx(mu * kn * xn * way, rel=1e-2)
    assert np.mean(period.state == SLIPS) == pytest.approx(period.slip[0], abs=0.01)
    assert chosen_sectors(Results(path)) == [0]


def test_samples_hit_every_sector():
    from dovetail.travelling_wave import TravellingWave

    for sectors, order, frames in ((36, 4, 24), (7, 3, 10), (12, 0, 5), (10, -4, 24)):
        samples = samples_of(frames, TravellingWave(sectors, order, np.zeros(1)))
        assert samples >= LEAST and samples % frames == 0 and samples * order % sectors == 0
