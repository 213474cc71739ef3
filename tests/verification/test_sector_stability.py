"""Stability of travelling waves, `python3 -m dovetail wheel`: by the sector, by the program on the whole wheel, and by time integration.

A load of engine order 3 on six sectors has waves of nodal diameters 0 and 3 alone. At the second frequency motions of nodal diameters 1
and 2 grow in the wave, which no computation of one sector sees; at the first all die out.
"""

import re
from dataclasses import replace

import h5py
import numpy as np
import pytest

import cases
import cyclic_sector
import in_time
import launch
from dovetail import Results, wave_contacts, wave_exponents
from dovetail.__main__ import main
from dovetail.reduced_system import equations
from dovetail.wheel_runs import WholeWheel

SWEEP = 2730.0, 2541.5
STABLE, UNSTABLE = ("stable", 2730.0), ("unstable", 2541.5)


def response(folder, name="eo3_aliased", omega=SWEEP, factor=2.0, harmonics=9, start=None, others=None):
    """Results of a sweep with loads that many times those of the case, and numbers of other keys that many times theirs."""
    path, models = cyclic_sector.write(folder, name, omega[0], samples='"exact"', modes=20, further="accuracy.estimates = false\n")
    if start is not None:
        cyclic_sector.write_start(folder, name, omega[0], models, 1.001 * start.reshape(-1, 15))

    def loads(found):
        return f"fourier = {[factor * float(number) for number in found[1].split(',')][:2 * harmonics + 1]}"
    text = re.sub(r"fourier = \[(.*)\]", loads, path.read_text()).replace("harmonics = 7", f"harmonics = {harmonics}")
    for key, times in (others or {}).items():
        text = re.sub(rf"(?<={key} = ).*", lambda found: re.sub(r"[\d.]+(e-?\d+)?", lambda n: f"{times * float(n[0])}", found[0]), text)
    path.write_text(re.sub(r"omega = \[.*\]", f"omega = {list(omega)}", text).replace("1e-6", "1e-8"))
    return Results(launch.run(cases.Case(path, None, None, {})).folder / "results.h5")


@pytest.fixture(scope="module")
def curve(tmp_path_factory):
    return response(tmp_path_factory.mktemp("curve"))


def table(said):
    """Rows: frequency, point, verdict, multiplier, and of the whole wheel verdict, multiplier, moved."""
    shares = r"((?:\d+ \(\d+ %\)(?:, )?)+)"
    return re.findall(rf"^ +([\d.]+) +(\d+)  (\w+) +([\d.]+)  {shares}(?: +(\w+) +([\d.]+)  (\S+))?", said, re.M)


def largest(results, point):
    return wave_exponents.largest(equations(results), results.coefficients_at(point), results.omega[point], results.wave)


def test_the_command_says_which_wave_is_stable_and_what_grows_in_the_other(curve, capsys):
    assert main(["wheel", str(curve.path), "--at", "2730", "2541.5"]) == 0
    first, second = table(capsys.readouterr().out)
    assert [first[2], second[2]] == ["stable", "unstable"] and float(first[0]) == 2730 and float(second[0]) == 2541.5
    assert first[4] == "3 (76 %), 0 (24 %)" and {*re.findall(r"(\d) \(", second[4])} == {"1", "2"}
    assert 0.95 < float(first[3]) < 0.97 and 1.08 < float(second[3]) < 1.14
    assert not (curve.path.parent / "results_wheel").exists()


def test_the_peak_is_taken_by_itself_and_frequencies_in_hertz(curve, capsys):
    assert main(["wheel", str(curve.path)]) == 0
    (one,) = table(capsys.readouterr().out)  # no peak: the largest point, where the sweep ends
    assert float(one[0]) == 2541.5 and one[2] == "unstable"
    assert main(["wheel", str(curve.path), "--at", "434.5", "--hz"]) == 0
    assert table(capsys.readouterr().out)[0][:2] == ("434.493", "0")


@pytest.mark.parametrize("name, frequency", [STABLE, UNSTABLE])
def test_the_program_says_the_same_of_all_sectors(curve, capsys, tmp_path, name, frequency):
    """The wave is a motion of the wheel. The sector samples since when a slider sticks: multipliers are off by 2e-4."""
    assert main(["wheel", str(curve.path), "--at", str(frequency), "--whole", "--out", str(tmp_path / "all"), "--binary",
                 str(launch.BINARY)]) == 0
    (row,) = table(capsys.readouterr().out)
    assert row[2] == row[5] == name and float(row[7]) < 1e-10
    assert float(row[3]) == pytest.approx(float(row[6]), abs=3e-4)
    whole = Results(tmp_path / f"all/point_{row[1]}/results.h5")
    assert (whole.stable[0], whole.contact_points, whole.modes) == (name == "stable", 48, 120)


@pytest.mark.parametrize("harmonics, multiplier", [(9, 1.0978), (20, 1.1149)])
def test_what_sliders_remember_makes_the_wave_more_unstable(tmp_path, harmonics, multiplier):
    """Without it the multiplier would be 1.04."""
    assert largest(response(tmp_path, harmonics=harmonics), -1).multiplier == pytest.approx(multiplier, abs=2e-4)


def test_an_exponent_that_is_far_less_without_memory_is_found(tmp_path):
    """Behind a fold, motions of nodal diameters 1 and 2 grow by 5 per cent in a period; without memory they would shrink by 30."""
    results = response(tmp_path, omega=(2260.0, 2210.0), factor=2.08, harmonics=6,
                       others={"friction": 0.29, "tangential_stiffness": 0.48, "damping.stiffness": 0.8})
    point = int(np.argmax(np.diff(results.omega) > 0)) + 2
    told, found = WholeWheel(results, [point], tmp_path / "wheel", launch.BINARY).run(point), largest(results, point)
    assert told.moved < 1e-5 and found.multiplier == pytest.approx(told.multiplier, abs=5e-4)
    assert 1.02 < found.multiplier < 1.1 and found.share[[1, 2]].sum() > 0.99


@pytest.mark.parametrize("name, point", [("eo2_separation", 1), ("eo-1_two_loads", 1), ("eo1_root", 1),
                                         pytest.param("eo3_aliased", 2, marks=pytest.mark.slow)])
def test_the_wave_of_a_sector_is_one_of_the_program_on_all_sectors(tmp_path, capsys, name, point):
    omega = float(cyclic_sector.DATA[f"{name}/omega"][point])
    results = response(tmp_path, name, (omega, omega), 1.0, 7, cyclic_sector.FEW[f"{name}/X_modes20"][point])
    assert main(["wheel", str(results.path), "--whole", "--binary", str(launch.BINARY)]) == 0
    (row,) = table(capsys.readouterr().out)
    assert float(row[7]) < 1e-10 and float(row[3]) == pytest.approx(float(row[6]), abs=3e-4)
    points = results.contact_points
    whole = Results(tmp_path / "results_wheel/point_0/results.h5").coefficients_at(0)[-18 * points:].reshape(6, 3 * points, -1)
    for j in range(6):
        expected = results.coefficients_at(0, sector=j)[-3 * points:]
        np.testing.assert_allclose(whole[j], expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.slow
@pytest.mark.parametrize("name, frequency", [STABLE, UNSTABLE])
def test_integrated_in_time_a_push_of_other_diameters_dies_out_or_grows(curve, capsys, tmp_path, name, frequency):
    """Modes of nodal diameters 1 and 2 are at rest in the wave. By how much they grow is known to a tenth in the logarithm: steps."""
    main(["wheel", str(curve.path), "--at", str(frequency), "--whole", "--out", str(tmp_path), "--binary", str(launch.BINARY)])
    point = curve.at(frequency)
    whole = Results(tmp_path / f"point_{point}/results.h5")
    system, q = equations(whole), whole.coefficients_at(0)
    diameter = np.repeat([0, 1, 2, 3], [20, 40, 40, 20])
    others = np.isin(diameter, [1, 2])
    size = np.abs(q[:120, 1:]).max()
    assert np.abs(q[:120][others]).max() < 1e-9 * size
    push = np.zeros(len(q))
    push[:120] = 1e-4 * size * np.random.default_rng(3).normal(size=120)
    found = in_time.periods(system, q, whole.omega[0], 24, 5000, push)[:, :120] / size
    norm = np.linalg.norm(found[:, others], axis=1)
    rate = np.polyfit(np.arange(12), np.log(norm[12:]), 1)[0]
    expected = np.log(largest(curve, point).multiplier)
    if name == "unstable":
        assert rate == pytest.approx(expected, rel=0.15) and norm[-1] > 2 * norm[6]
    else:
        assert -0.09 < rate < -0.03 and norm[-1] < 0.4 * norm[2]


def test_points_of_law_cone_are_left_to_the_program_where_they_slip(curve, monkeypatch):
    monkeypatch.setitem(curve.contact, "law", np.ones(8, int))
    with pytest.raises(ValueError, match='contact point 5 of law "cone" slips, or opens and closes: .* ask with --whole'):
        largest(curve, -1)


def test_what_the_sector_cannot_tell_the_program_does(curve, capsys, tmp_path, monkeypatch):
    """--whole was refused with the words to ask with --whole."""
    monkeypatch.setattr(wave_contacts.ContactWaves, "__init__", lambda *_: (_ for _ in ()).throw(wave_contacts.KnownToTheProgram("cone")))
    command = ["wheel", str(curve.path), "--at", "2730"]
    assert main(command) == 2
    assert main([*command, "--whole", "--out", str(tmp_path / "all"), "--binary", str(launch.BINARY)]) == 0
    assert re.search(r" see whole +stable +0\.9\d+ ", capsys.readouterr().out)


def test_a_pattern_that_rests_in_the_case_rests_in_the_wheel(curve, tmp_path):
    whole = WholeWheel(curve, [0], tmp_path / "all", launch.BINARY)
    loads = whole.case(0, 19)["excitation"]["load"]
    whole.wheel = replace(whole.wheel, loads=[("at rest", 0), *whole.wheel.loads, ("at rest", 1)])
    assert whole.case(0, 19)["excitation"]["load"] == loads and len(loads) == 6


def test_what_is_no_wave_in_time_is_refused(curve, tmp_path, capsys, monkeypatch):
    def refused(words, results, *options):
        assert main(["wheel", str(results), *map(str, options)]) == 2
        assert words in capsys.readouterr().err

    refused("--at 3000: ", curve.path, "--at", 2600, 3000)
    refused("has frequencies from 404.492 to 434.493 Hz", curve.path, "--at", 2600, "--hz")
    refused("--out and --binary are of the whole wheel", curve.path, "--out", tmp_path)
    refused("is no program", curve.path, "--whole", "--binary", tmp_path / "none")
    plain = tmp_path / "plain.h5"
    with h5py.File(curve.path) as old, h5py.File(plain, "w") as new:
        for name in old:
            old.copy(name, new)
        new.attrs.update(old.attrs)
        new.attrs["case"] = curve.case.replace("damping.stiffness", "damping.structural = 0.01\ndamping.stiffness")
    refused("damping.structural of its case has no motion in time", plain)
    with h5py.File(plain, "r+") as file:
        file.attrs["case"], file.attrs["parameter"] = curve.case, "friction"
        file["points/parameter"], file["events/parameter"] = file["points/omega"][()], file["events/omega"][()]
    refused("is over friction; wanted is a response over the frequency", plain)
    with h5py.File(plain, "r+") as file:
        del file.attrs["sectors"], file.attrs["parameter"]
    refused("is not of a sector of a cyclic structure", plain)
    monkeypatch.setattr(wave_exponents, "MEMORY", 2**20)
    refused("GiB of dense matrices for their stability", curve.path)
    monkeypatch.setattr("dovetail.wheel_runs.CONTACT_DOFS", 140)
    refused("--whole: 6 sectors with 8 contact points have 144 contact dofs, 140 are the limit", curve.path, "--whole", "--binary",
            launch.BINARY)
    assert not (curve.path.parent / "results_wheel").exists()
    (tmp_path / "mine/point_0").mkdir(parents=True)
    (tmp_path / "mine/point_0/case.toml").write_text("mine")
    monkeypatch.undo()
    refused("was not written here", curve.path, "--at", 2730, "--whole", "--out", tmp_path / "mine", "--binary", launch.BINARY)
