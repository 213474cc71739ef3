"""The picture of the structure in motion, of a wheel, of one sector and of a structure that is none."""

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.collections import PolyCollection
from PIL import Image
from ring import N
from ring_results import ORDER, computed

from dovetail.__main__ import main
from dovetail.motion_picture import enlargement, largest_at, motion_picture, view
from dovetail.moving_mesh import moving_mesh
from dovetail.shown import chosen_point, default_dofs


@pytest.fixture(scope="module")
def wave(tmp_path_factory):
    return computed(tmp_path_factory.mktemp("wave"))


def drawn(figure):
    """(triangles, 3, 2) of the picture."""
    [polygons] = [artist for artist in figure.axes[0].collections if isinstance(artist, PolyCollection)]
    return np.array([path.vertices[:3] for path in polygons.get_paths()])


def test_a_wheel_is_drawn_whole(wave):
    """Its outline holds the places of all sectors, each moved as results say, at the instant of the largest motion."""
    point = wave.largest_point(wave.watched)
    mesh = moving_mesh(wave, point, surface=True)
    theta, (_, right, above) = largest_at(mesh), view(mesh.axis, 2)
    vibration = [mesh.displacement(theta, j, mean=False) for j in range(N)]
    factor = enlargement(np.concatenate([mesh.places(j) for j in range(N)]), np.concatenate(vibration))
    figure = motion_picture(wave, point)
    triangles = drawn(figure)
    assert f"{N} sectors, engine order {ORDER}; motion {factor:g} times as large" in figure._suptitle.get_text()
    for j in range(N):
        u = wave.displacement(point, mesh.rows, times=[theta / wave.omega[point]], sector=j, axes="global")[0]
        mean = wave.displacement(point, mesh.rows, n=16, sector=j, axes="global").mean(axis=0)
        places = mesh.places(j) + factor * (u - mean)
        flat = np.column_stack([places @ right, places @ above])
        distance = np.abs(flat[:, None] - triangles.reshape(1, -1, 2)).max(axis=2).min(axis=1)
        assert np.mean(distance < 1e-9) > 0.4  # nodes on faces that look at the eye
    assert len(triangles) > len(drawn(motion_picture(wave, point, 1))) * N / 2
    plt.close("all")


def test_the_instant_is_that_of_the_largest_motion(wave):
    mesh = moving_mesh(wave, wave.largest_point(wave.watched))
    size = np.linalg.norm(mesh.displacement(largest_at(mesh), mean=False), axis=1).max()
    others = [np.linalg.norm(mesh.displacement(theta, mean=False), axis=1).max() for theta in np.linspace(0, 2 * np.pi, 100)]
    assert size >= 0.99 * max(others) and size == pytest.approx(mesh.amplitude().max(), rel=1e-12)


def test_the_eye_looks_along_the_axis_and_up_stays_up():
    for axis, up in (((0, 0, 1), 2), ((-1, 0, 0), 2), ((0, 1, 0), 0), (None, 1)):
        eye, right, above = view(None if axis is None else np.array(axis, float), up)
        np.testing.assert_allclose(np.array([right, above, eye]) @ np.array([right, above, eye]).T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(np.cross(right, above), eye, atol=1e-12)
        assert axis is None or eye @ axis > 0.8
        assert axis == (0, 0, 1) or above[up] > 0.8  # of a wheel about z nothing is


def test_enlargement_is_a_round_number():
    places = np.array([[0.0, 0, 0], [1, 0, 0]])
    for largest in (3e-7, 2e-3, 0.06, 4.0):
        factor = enlargement(places, np.array([[largest, 0, 0]]))
        assert 0.4 * 0.06 <= factor * largest <= 0.06 * (1 + 1e-9) and f"{factor:.0e}"[0] in "125"
    assert enlargement(places, np.zeros((1, 3))) == 1


def test_the_command(wave, tmp_path, capsys):
    for options, ending in ((["--kind", "motion"], "motion"), (["--kind", "motion", "--sector", "2"], "motion"),
                            (["--kind", "history", "--sector", "2"], "history")):
        path = tmp_path / f"{ending}.png"
        assert main(["plot", str(wave.path), *options, "-o", str(path)]) == 0 and path.stat().st_size > 5000
    assert main(["plot", str(wave.path), "--kind", "motion", "-o", str(tmp_path / "new/deep.png")]) == 0
    capsys.readouterr()
    for options, words in ((["--kind", "map", "--sector", "1"], "--sector: is for motion and history"),
                           (["--kind", "motion", "--sector", "9"], "sector must be a whole number from 0 to 4, found 9")):
        assert main(["plot", str(wave.path), *options]) == 2
        assert words in capsys.readouterr().err


def test_picture_film_and_export_show_one_point(wave, tmp_path, monkeypatch):
    """By default the peak of the loaded node, not that of a contact point."""
    wanted = chosen_point(wave, dofs=default_dofs(wave))
    assert wanted != chosen_point(wave)  # else nothing is tested
    found = []
    monkeypatch.setattr("dovetail.motion_picture.motion_film", lambda results, point, *_: found.append(point))
    monkeypatch.setattr("dovetail.motion_picture.motion_picture", lambda results, point, *_: found.append(point) or plt.figure())
    for name in ("a.gif", "a.png"):
        assert main(["plot", str(wave.path), "--kind", "motion", "-o", str(tmp_path / name)]) == 0
    plt.close("all")
    assert found == [wanted, wanted]


def test_a_film_is_one_period(wave, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("dovetail.motion_picture.FRAMES", 6)
    path = tmp_path / "new/wheel.gif"
    assert main(["plot", str(wave.path), "--kind", "motion", "-o", str(path)]) == 0
    with Image.open(path) as film:
        pictures = []
        for i in range(film.n_frames):
            film.seek(i)
            pictures.append(np.asarray(film.convert("L"), dtype=float))
    assert len(pictures) == 6
    steps = [np.abs(a - b).mean() for a, b in zip(pictures, pictures[1:] + pictures[:1])]
    assert min(steps) > 0 and steps[-1] < 2 * max(steps[:-1])  # it moves, and the end leads to the beginning
    for options, words in ((["--kind", "map"], "a film is of --kind motion"), ([], "a film is of --kind motion")):
        assert main(["plot", str(wave.path), *options, "-o", str(path)]) == 2
        assert words in capsys.readouterr().err


def test_the_command_keeps_no_figure(wave, tmp_path, capsys):
    before = plt.get_fignums()
    assert main(["plot", str(wave.path), "--kind", "motion", "-o", str(tmp_path / "a.png")]) == 0 and plt.get_fignums() == before
    assert main(["plot", str(wave.path), "-o", str(tmp_path)]) == 2
    assert f"{tmp_path}: is there already and is a folder; name another with -o" in capsys.readouterr().err


def test_a_structure_that_is_no_sector(tmp_path):
    results = computed(tmp_path, cyclic=False)
    figure = motion_picture(results, 0)
    assert figure._suptitle.get_text().splitlines()[1].startswith("motion ") and len(drawn(figure)) > 10
    assert main(["plot", str(results.path), "--kind", "motion", "--sector", "0"]) == 2
    plt.close(figure)


def test_history_of_another_sector(wave):
    from dovetail.plot import history

    figure = history(wave, 0, ["x1.t1"], sector=3)
    wanted = wave.time_history(0, "x1.t1", 512, sector=3)[1]
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata()[:-1], wanted)
    assert figure.axes[0].get_title().endswith(", sector 3")
    plt.close(figure)
