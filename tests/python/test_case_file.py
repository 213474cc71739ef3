"""The case file that comes with an import: runs as it stands, around the modes of the stuck structure."""

import re
import tomllib
from types import SimpleNamespace

import brick
import importer_jobs
import numpy as np
import pytest
import scipy.linalg

from dovetail import Joint, Results
from dovetail.importers import case_file, convert, setup_file
from launch import run

SETUP = """[[clamp]]
set = "bottom"
[[force]]
set = "top"
vector = [0, {force}, 0]
[[preload]]
set = "top"
vector = [0, 0, -1e-3]
[[joint]]
between = ["upper", "lower"]
normal_stiffness = 3.0
tangential_stiffness = [2.0, 1.0]
friction = 0.3
"""


def joined(**options):
    structure = brick.pair(poisson=0.3).clamped("bottom").with_force("top", [0, 1e-5, 0])
    return structure.join([Joint.between(structure.surface("upper"), structure.surface("lower"), **options)])


def test_stuck_modes_are_those_with_springs_where_it_touches():
    model = joined(normal_stiffness=3.0, tangential_stiffness=[2.0, 1.0], friction=0.3)
    model.contact["gap"][:2] = 1e-3, -1e-3
    K = model.K.toarray()
    for point, dofs in enumerate(model.contact_dofs):
        if point != 0:  # open
            k_n, k_t = model.contact["normal_stiffness"][point], model.contact["tangential_stiffness"][point]
            K[dofs, dofs] += [*k_t, k_n]
    wanted = np.sqrt(scipy.linalg.eigh(K, model.M.toarray(), eigvals_only=True)[:6])
    omega, shapes = case_file.stuck_modes(model)
    np.testing.assert_allclose(omega, wanted, rtol=1e-8)
    np.testing.assert_allclose(K @ shapes, model.M @ shapes * omega**2, atol=1e-8)


def test_points_without_stiffness_are_held():
    model = joined()
    free = np.setdiff1d(np.arange(model.n), model.contact_dofs)
    wanted = np.sqrt(scipy.linalg.eigh(model.K[free][:, free].toarray(), model.M[free][:, free].toarray(), eigvals_only=True)[:6])
    omega, shapes = case_file.stuck_modes(model)
    np.testing.assert_allclose(omega, wanted, rtol=1e-8)
    assert not shapes[model.contact_dofs].any()
    said = case_file.text(model, "model.h5", omega, 0)
    assert "# normal_stiffness_per_area = 1e11" in said and "contact points held" in said


def test_damping_of_the_deck_and_units_are_in_it():
    model = joined(normal_stiffness=3.0, tangential_stiffness=[2.0, 1.0], friction=0.3)
    model.units, model.damping = "kg, mm, ms", {"mass": 0.5, "stiffness": 2e-3}
    said = case_file.text(model, "model.h5", np.array([0.1, 0.2]), 0)
    assert "mass = 0.5" in said and "stiffness = 0.002" in said and "for want of better" not in said
    assert "0.1 rad/ms  15.9155 Hz" in said and "[rad/ms]" in said


def test_large_matrices_give_the_same_modes(monkeypatch):
    pytest.importorskip("slepc4py")
    model = joined(normal_stiffness=3.0, tangential_stiffness=2.0, friction=0.3)
    small, _ = case_file.stuck_modes(model)
    monkeypatch.setattr(case_file, "LARGE", 10)
    large, shapes = case_file.stuck_modes(model)
    np.testing.assert_allclose(large, small, rtol=1e-8)
    assert np.linalg.matrix_rank(shapes) == 6


def test_the_sweep_is_around_the_lowest_mode_that_the_load_excites():
    """A force along x on a symmetric pair does not move modes along y."""
    model = joined(normal_stiffness=3.0, tangential_stiffness=1.0, friction=0.3)
    omega, shapes = case_file.stuck_modes(model)
    along_y = case_file.excited(model, omega, shapes)
    structure = brick.pair(poisson=0.3).clamped("bottom").with_force("top", [1, 0, 0])
    joint = Joint.between(structure.surface("upper"), structure.surface("lower"), normal_stiffness=3.0, tangential_stiffness=1.0,
                          friction=0.3)
    along_x = case_file.excited(structure.join([joint]), omega, shapes)
    assert along_x != along_y


def test_motions_without_stiffness_are_no_modes():
    model = joined(normal_stiffness=3.0, tangential_stiffness=1.0, friction=0.3)
    model.contact["gap"][1:] = 1.0  # touches at one point, which cannot hold it
    omega, shapes = case_file.stuck_modes(model, 8)
    assert (omega[:3] == 0).all() and omega[3] > 0
    assert case_file.excited(model, omega, shapes) >= 3


def test_without_modes_there_is_no_case_file(tmp_path):
    """A negative stiffness, as of a damaged file."""
    model = joined(normal_stiffness=3.0, tangential_stiffness=1.0, friction=0.3)
    model.K = -model.K
    assert "no case file: the modes of the stuck structure were not found" in case_file.write(model, tmp_path / "model.h5")
    assert not (tmp_path / "case.toml").exists()


def test_where_nothing_touches_the_preload_is_taken_to_close_it():
    model = joined(normal_stiffness=3.0, tangential_stiffness=1.0, friction=0.3)
    closed, _ = case_file.stuck_modes(model)
    model.contact["gap"][:] = 1.0
    np.testing.assert_allclose(case_file.stuck_modes(model)[0], closed, rtol=1e-12)


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """A model written as an import does it, and what was said."""
    folder = tmp_path_factory.mktemp("imported")
    (folder / "joints.toml").write_text(SETUP.format(force=2e-7))
    model = setup_file.apply(brick.pair(poisson=0.3), folder / "joints.toml")
    model.write(folder / "model.h5")
    return folder, case_file.write(model, folder / "model.h5"), model


def test_it_runs_as_it_stands_and_finds_a_peak(imported):
    folder, said, model = imported
    case = tomllib.loads((folder / "case.toml").read_text())
    low, high = case["continuation"]["omega"]
    listed = [float(value) for value in re.findall(r"^#   \d+  (\S+) rad/s", (folder / "case.toml").read_text(), re.M)]
    number = int(re.search(r"around mode (\d+)", said)[1])
    np.testing.assert_allclose([low, high], [0.8 * listed[number - 1], 1.1 * listed[number - 1]], rtol=1e-3)
    results = Results(run(SimpleNamespace(path=folder / "case.toml")).folder / "results.h5")
    tops = [place for place in results.events.of("peak").omega if low < place < high]
    assert tops and min(abs(np.array(tops) / listed[number - 1] - 1)) < 0.02


def test_a_case_file_that_is_there_stays(imported):
    folder, _, model = imported
    before = (folder / "case.toml").read_bytes()
    assert "is there already and stays" in case_file.write(model, folder / "model.h5")
    assert (folder / "case.toml").read_bytes() == before


def test_several_patterns_have_their_courses(tmp_path):
    structure = brick.pair(poisson=0.3).clamped("bottom").with_force("top", [0, 1, 0], phase=0.3)
    model = structure.join([Joint.between(structure.surface("upper"), structure.surface("lower"), normal_stiffness=3.0,
                                          tangential_stiffness=1.0, friction=0.3)])
    case_file.write(model, tmp_path / "model.h5")
    case = tomllib.loads((tmp_path / "case.toml").read_text())
    assert [load["pattern"] for load in case["excitation"]["load"]] == ["force", "force_sin"]


def test_the_command_writes_it(tmp_path):
    (tmp_path / "scratch").mkdir()
    job = importer_jobs.jobs(tmp_path / "scratch")["calculix"]
    importer_jobs.lay_out(job, tmp_path)
    said = convert("calculix", [str(tmp_path / "job.inp")], str(tmp_path / "model.h5"), setup=str(tmp_path / job.setup))
    assert "case.toml: its sweep is around mode 1" in said
    run(SimpleNamespace(path=tmp_path / "case.toml"), "--dry-run")
