"""The command range: against sampled peaks of another program, closed forms, and itself when it was broken off."""

import json

import h5py
import numpy as np
import pytest

import cases
from dovetail import Model, Results, case_runs
from dovetail.__main__ import main
from dovetail.case_runs import CaseRuns, CurveCase, largest_peak
from dovetail.study_runs import Program
from launch import BINARY, run
from test_sensitivity import DATA, given

CHAIN = ["--omega", "1.25", "1.75", "--watch", "x4.t1", "--binary", str(BINARY)]


@pytest.fixture(autouse=True)
def undrawn(monkeypatch):
    """Drawing takes longer than the runs."""
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda *_, **__: None)


def found(out):
    return json.loads((out / "ranges.json").read_text())


@pytest.mark.parametrize("name", ["mc_mu_i", "mc_common_mu"])
def test_given_samples(tmp_path, name):
    """Peaks of the chain with sampled friction, of each point by itself and of all together; by a dense program with its own law."""
    case, _ = given(tmp_path, "chain")
    data = np.load(DATA / f"{name}.npz")
    chosen = [0, int(np.argmax(data["amp"])), int(np.argmin(data["amp"]))]
    runs = CaseRuns(CurveCase(case.path, omega=(1.25, 1.75), watch="x4.t1"), Program(BINARY), tmp_path / "out")
    runs.begin()
    records = runs.each([{"friction": ("factor", data["factor"][i])} for i in chosen],
                        lambda results: largest_peak(results, runs.dof), "samples")
    for i, record in zip(chosen, records):  # the peak of rms lies beside that of the largest displacement
        assert record["rms"] == pytest.approx(data["amp"][i], rel=1e-4) and record["omega"] == pytest.approx(data["om"][i], rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("options, name, tolerance", [(["--each-point"], "mc_mu_i", 0.015), ([], "mc_common_mu", 0.03)])
def test_mean_and_deviation_of_samples(tmp_path, options, name, tolerance):
    """mu from 0.25 to 0.75. Against 200 and 60 random samples, whose own error of the mean is a tenth or so of the deviation."""
    case, _ = given(tmp_path, "chain")
    assert main(["range", str(case.path), "--friction", "0.25", "0.75", "--samples", "32", "--along", "0", *options, *CHAIN]) == 0
    with h5py.File(tmp_path / "case_range/ranges.h5") as file:
        rms, factor = file["samples/rms"][()], file["samples/friction"][()] / 0.5
    data = np.load(DATA / f"{name}.npz")
    error = data["amp"].std() / np.sqrt(len(data["amp"]))
    assert abs(rms.mean() - data["amp"].mean()) < 3 * error
    assert rms.std(ddof=1) == pytest.approx(data["amp"].std(ddof=1), rel=0.25)
    assert factor.min() > 0.5 and factor.max() < 1.5
    first = found(tmp_path / "case_range")["first_order"]  # of half the peak-to-peak; in rms it is 0.063 and 0.098
    wanted = {"mc_mu_i": 0.063, "mc_common_mu": 0.098}[name]
    middle = found(tmp_path / "case_range")["middle"]
    assert first["amplitude_deviation"] / middle["amplitude"] * 0.576 == pytest.approx(wanted, rel=tolerance)


def test_closed_form_of_a_stuck_mass(tmp_path):
    """A = F / (c w sqrt(1 - z^2)), w^2 = (k + k_t)/m, c = 2 z w m, at w sqrt(1 - 2 z^2)."""
    case = cases.stuck_mass(tmp_path)
    k, c, kt = 40.0, 40.0 * 0.01, 60.0
    assert main(["range", str(case.path), "--tangential_stiffness", "0.5x", "2x", "--watch", "x1.t1", "--samples", "3", "--along", "3",
                 "--binary", str(BINARY)]) == 0
    numbers = found(tmp_path / "case_range")

    def closed(kt):
        w = np.sqrt(k + kt)
        z = c / (2 * w)
        return 1 / (c * w * np.sqrt(1 - z**2)), w * np.sqrt(1 - 2 * z**2)

    for entry, factor in zip(numbers["curves"]["tangential_stiffness"], (0.5, 1, 2)):
        assert entry["number"] == pytest.approx(factor)
        assert (entry["amplitude"], entry["omega"]) == pytest.approx(closed(factor * kt), rel=1e-6)
    h = 1e-4
    (up, over), (down, under) = closed(kt * np.exp(h)), closed(kt * np.exp(-h))
    slope = numbers["first_order"]
    assert slope["by"] == {"tangential_stiffness": "sensitivity"} and not slope["meaningless"]
    assert slope["amplitude"]["tangential_stiffness"] == pytest.approx((up - down) / (2 * h) * np.log(2), rel=1e-5)
    assert slope["omega"]["tangential_stiffness"] == pytest.approx((over - under) / (2 * h) * np.log(2), rel=1e-5)
    ends = closed(kt / 2)[0], closed(kt)[0], closed(2 * kt)[0]
    assert slope["second_difference"] == pytest.approx(abs(ends[0] - 2 * ends[1] + ends[2]) / 2, rel=1e-4)
    with h5py.File(tmp_path / "case_range/ranges.h5") as file:
        for factor, amplitude in zip(file["samples/tangential_stiffness"], file["samples/amplitude"]):
            assert amplitude == pytest.approx(closed(factor * kt)[0], rel=1e-6)
        band, omega = file["band/amplitude"][()], file["band/omega"][()]
    assert np.all(np.diff(band, axis=0) >= 0) and omega[0] == 7 and omega[-1] == 13.5


def test_the_peak_followed_over_a_parameter(tmp_path):
    """The same closed form between the numbers of the table as well, and one run in place of many."""
    case = cases.stuck_mass(tmp_path)
    k, c, kt = 40.0, 40.0 * 0.01, 60.0
    assert main(["range", str(case.path), "--tangential_stiffness", "0.5x", "2x", "--watch", "x1.t1", "--samples", "0", "--along", "5",
                 "--track", "--binary", str(BINARY)]) == 0
    track = found(tmp_path / "case_range")["tracks"]["tangential_stiffness"]
    assert track["reason"] == "" and len(track["number"]) > 5
    w = np.sqrt(k + kt * np.array(track["number"]))
    z = c / (2 * w)
    np.testing.assert_allclose(track["amplitude"], 1 / (c * w * np.sqrt(1 - z**2)), rtol=1e-6)
    np.testing.assert_allclose(track["omega"], w * np.sqrt(1 - 2 * z**2), rtol=1e-6)
    table = found(tmp_path / "case_range")["curves"]["tangential_stiffness"]
    np.testing.assert_allclose([entry["number"] for entry in table], np.geomspace(0.5, 2, 5))
    here = [int(np.argmin(np.abs(np.array(track["number"]) - entry["number"]))) for entry in table]
    np.testing.assert_allclose([entry["amplitude"] for entry in table], np.array(track["amplitude"])[here])
    runs = [json.loads(line) for line in (tmp_path / "case_range/runs.jsonl").read_text().splitlines()]
    assert len(runs) == 4 and sum("rms" in run and isinstance(run["rms"], list) for run in runs) == 1  # middle, track, both ends


@pytest.mark.slow
def test_bands_over_a_mode(tmp_path):
    """One Jenkins element with H = 1, whose frequency and damping ratio are known: at every amplitude the bands of the samples are those of
    the closed form at their frictions."""
    case = cases.single_mass(tmp_path, 2, friction=8.0, tangential_stiffness=30.0, omega=None, step=None, harmonics=1, samples="exact",
                             solver="assembled", kind="auto", stiffness=None)
    with h5py.File(tmp_path / "reduced.h5", "r+") as file:
        file["Fx"][...] = [1.0, 0, 0]
    k, kt, N = 40.0, 30.0, 120 * 800 / (40.0 + 120)
    case.path.write_text(case.path.read_text() + "\n[mode]\nnear = 8.4\namplitude = [1, 400]\n")
    assert main(["range", str(case.path), "--friction", "0.05", "0.2", "--samples", "4", "--along", "2", "--binary", str(BINARY)]) == 0

    def closed(a, mu):
        slips = a > (us := mu * N / kt)
        T = np.arccos(1 - 2 * np.minimum(us / a, 1))
        square = np.where(slips, k + kt / np.pi * (T - np.sin(2 * T) / 2), k + kt)
        return np.sqrt(square), np.where(slips, 2 * mu * N * (a - us) / (np.pi * square * a**2), 0)

    numbers = found(tmp_path / "case_range")
    alpha = np.array(numbers["modal_amplitude"])
    for entry, mu in zip(numbers["curves"]["friction"], (0.05, 0.2)):
        omega, zeta = closed(alpha, mu)
        np.testing.assert_allclose(entry["omega"], omega, rtol=3e-3)
        np.testing.assert_allclose(entry["damping_ratio"], zeta, atol=3e-3)
    with h5py.File(tmp_path / "case_range/ranges.h5") as file:
        band, samples = file["band/omega"][()], file["samples/omega"][()]
    assert samples.shape == (4, len(alpha)) and numbers["failed"] == 0
    np.testing.assert_allclose(band[0], samples.min(axis=0))
    np.testing.assert_allclose(band[-1], samples.max(axis=0))
    low, high = closed(alpha, 0.05)[0], closed(alpha, 0.2)[0]
    assert np.all(band[0] > low * (1 - 3e-3)) and np.all(band[-1] < high * (1 + 3e-3)) and (band[-1] - band[0]).max() > 0.1


@pytest.mark.slow
def test_offsets_and_values_of_tracks_are_those_of_sweeps(tmp_path):
    """Five degrees of freedom: the middle of the ranges is not the case, and of the gap an offset is added."""
    case = cases.dof5(tmp_path, harmonics=3, samples="exact", kind="auto", omega=[0.9, 1.2], **cases.TIGHT)
    tables = []
    for more in ([], ["--track"]):
        assert main(["range", str(case.path), "--friction", "0.3", "1.1", "--gap", "-0.4", "0.6", "--force", "0.8x", "1.1x",
                     "--watch", "a1", "--samples", "0", "--along", "3", "--binary", str(BINARY), *more]) == 0
        tables.append(found(tmp_path / "case_range")["curves"])
    for name, swept in tables[0].items():
        for one, other in zip(swept, tables[1][name], strict=True):
            assert one["number"] == pytest.approx(other["number"])
            assert 1 - 3e-3 < other["amplitude"] / one["amplitude"] < 1 + 1e-6  # each is largest in its own place
            assert 1 - 1e-6 < other["rms"] / one["rms"] < 1 + 3e-3
            assert one["omega"] == pytest.approx(other["omega"], rel=5e-3)


@pytest.mark.parametrize("damping", [{"ratios": [[1, 0.02]]}, {"damped_springs": True}], ids=lambda damping: next(iter(damping)))
def test_damping_that_is_made_of_the_joint_has_slopes_by_differences(tmp_path, damping):
    """The program has no sensitivities there: the range was refused, as if the case had asked for some."""
    case = cases.dof5(tmp_path, harmonics=3, samples="exact", kind="auto", omega=[0.95, 1.1], **damping)
    assert main(["range", str(case.path), "--friction", "0.9x", "1.1x", "--watch", "a1", "--samples", "0", "--along", "0",
                 "--binary", str(BINARY)]) == 0
    assert found(tmp_path / "case_range")["first_order"]["by"] == {"friction": "differences"}


@pytest.mark.slow
def test_slopes_by_damping(tmp_path, caplog):
    """The amplitude goes with 1/c but for z^2. Of a picture without curves nothing is said."""
    case = cases.stuck_mass(tmp_path)
    assert main(["range", str(case.path), "--damping", "0.8x", "1.25x", "--watch", "x1.t1", "--samples", "0", "--along", "0",
                 "--until-peak", "1", "--binary", str(BINARY)]) == 0
    numbers = found(tmp_path / "case_range")
    share = numbers["first_order"]["amplitude"]["damping"] / numbers["middle"]["amplitude"]
    assert not caplog.records
    assert numbers["first_order"]["by"] == {"damping": "sensitivity"} and share == pytest.approx(-np.log(1.25), rel=2e-3)


@pytest.mark.slow
def test_preload_is_that_of_models_with_another(tmp_path):
    """Five degrees of freedom whose gap gives no force: peaks, and the slope at the middle, are those of models made with that preload."""
    settings = {"kind": "auto", "harmonics": 3, "samples": "exact", "omega": [0.85, 1.15], "gap": 0.0, **cases.TIGHT}

    def peak(name, factor):
        (folder := tmp_path / name).mkdir()
        case = cases.dof5(folder, **settings)
        model = Model.read(folder / "model.h5")
        model.with_loads(model.force, np.array([5, 0.1, 5, 0.1, 20]) * factor, None).write(folder / "model.h5")
        case.path.write_text(case.path.read_text().replace("[continuation]", '[continuation]\nwatch = "x1.t1"'))
        return case, largest_peak(Results(run(case).folder / "results.h5"), "x1.t1")

    case, _ = peak("case", 1.0)
    assert main(["range", str(case.path), "--preload", "0.8x", "1.25x", "--samples", "0", "--along", "3", "--binary", str(BINARY)]) == 0
    numbers = found(case.path.parent / "case_range")
    for entry, name, factor in zip(numbers["curves"]["preload"], "abc", (0.8, 1.0, 1.25)):
        _, direct = peak(name, factor)
        assert (entry["amplitude"], entry["omega"]) == pytest.approx((direct["amplitude"], direct["omega"]), rel=1e-5)
    assert len({entry["amplitude"] for entry in numbers["curves"]["preload"]}) == 3
    assert numbers["first_order"]["by"] == {"preload": "sensitivity"}
    (_, up), (_, down) = peak("up", 1.005), peak("down", 1 / 1.005)
    slope = np.log(up["rms"] / down["rms"]) / (2 * np.log(1.005)) * np.log(1.25)  # sensitivities are of the rms amplitude
    assert numbers["first_order"]["amplitude"]["preload"] / numbers["middle"]["amplitude"] == pytest.approx(slope, rel=5e-3)


def test_broken_off_and_taken_up_again(tmp_path, capsys, monkeypatch):
    case = cases.stuck_mass(tmp_path)
    command = ["range", str(case.path), "--tangential_stiffness", "0.9x", "1.2x", "--watch", "x1.t1", "--samples", "2", "--along", "0",
               "--until-peak", "1", "--binary", str(BINARY)]
    kept = tmp_path / "case_range/runs.jsonl"
    with monkeypatch.context() as patched:
        patched.setattr(case_runs.Progress, "tell", lambda self, _: (_ for _ in ()).throw(KeyboardInterrupt))
        assert main(command) == 3
    assert "the same command goes on" in capsys.readouterr().err
    lines = kept.read_text().splitlines()
    assert len(lines) == 1
    kept.write_text(kept.read_text() + '{"fingerprint": "cut')  # by a kill
    assert main(command) == 0
    after = [line for line in kept.read_text().splitlines() if line.endswith("}")]
    assert "middle of the ranges: 1 of 1 are there" in capsys.readouterr().err
    assert after[0] == lines[0] and len(after) == 5  # middle, two along the gradient, two samples
    text = (tmp_path / "case_range/ranges.json").read_text()
    capsys.readouterr()
    assert main(command) == 0
    said = capsys.readouterr().err
    assert (tmp_path / "case_range/ranges.json").read_text() == text and "samples: 2 of 2 are there" in said and " s  " not in said
    assert not (tmp_path / "case_range/under_way").exists()


@pytest.mark.slow
def test_samples_that_fail_or_have_no_peak_are_told(tmp_path, capsys):
    """Ranges reach so far that some peaks lie outside of the sweep, and the program fails where k_t is large."""
    case = cases.stuck_mass(tmp_path)
    program = tmp_path / "program"
    program.write_text(f"""#!/bin/sh
if grep -q '^tangential_stiffness = 1[0-9][0-9]' "$2"; then echo "dovetail: the sweep could not go on" >&2; exit 3; fi
exec "{BINARY}" "$@"
""")
    program.chmod(0o755)
    assert main(["range", str(case.path), "--tangential_stiffness", "30", "120", "--omega", "9", "13.5", "--watch", "x1.t1",
                 "--samples", "8", "--along", "0", "--binary", str(program)]) == 0
    numbers, said = found(tmp_path / "case_range"), capsys.readouterr().out
    assert "of them failed: the sweep could not go on" in said and "have no peak inside the sweep" in said
    with h5py.File(tmp_path / "case_range/ranges.h5") as file:
        kt, peak, amplitude = (file[f"samples/{name}"][()] for name in ("tangential_stiffness", "peak", "amplitude"))
    inside = (40 + kt > 9.0**2 + 0.1) & (kt < 100)
    np.testing.assert_array_equal(peak, inside)
    assert np.isnan(amplitude[kt >= 100]).all() and numbers["with_peak"] == inside.sum() and 0 < inside.sum() < 8
