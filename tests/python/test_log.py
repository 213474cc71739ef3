"""--log json: what the program says, as an object a line; of points and events what results.h5 has."""

import json
import subprocess

import h5py
import numpy as np
import pytest

import cases
from launch import BINARY, SURROUNDINGS, refuse_constant, run

SHORT = {"harmonics": 3, "samples": 32, "omega": [0.9, 1.1]}


def lines(text):
    """The objects; each has time, kind and text."""
    found = [json.loads(one, parse_constant=refuse_constant) for one in text.splitlines()]
    assert all(one["time"].endswith("Z") and one["kind"] and one["text"] for one in found)
    return found


def of(kind, found):
    return [one for one in found if one["kind"] == kind]


@pytest.mark.parametrize("ranks", [None, 2])
def test_points_and_events_are_those_of_the_results(tmp_path, ranks):
    done = run(cases.dof5(tmp_path, **SHORT), "--log", "json", "-hb_snes_monitor", ranks=ranks)
    found = lines(done.out)
    points, events = of("point", found), of("event", found)
    assert "SNES Function norm" in done.err
    with h5py.File(done.folder / "results.h5") as file:
        assert [one["point"] for one in points] == list(range(len(file["points/omega"])))
        for name in ("omega", "harmonics", "located", "newton_iterations", "linear_iterations", "residual", "stick", "slip", "open"):
            np.testing.assert_array_equal([one[name] for one in points], file["points"][name][()], name)
        kinds = file["events/kind"].attrs["names"].decode().split()
        assert [one["event"] for one in events] == [kinds[kind] for kind in file["events/kind"][()]]
        np.testing.assert_array_equal([one["omega"] for one in events], file["events/omega"][()])
    assert [one["end"] for one in of("end", found)] == ["arrived"] and not of("error", found)
    assert {"over": "frequency", "from": 0.9, "to": 1.1}.items() <= of("curve", found)[0].items()
    assert "5 branch" in [one["text"] for one in of("stage", found)]


def test_amplitudes_are_those_of_the_peaks(tmp_path):
    done = run(cases.dof5(tmp_path, **SHORT), "--log", "json")
    points, peaks = of("point", lines(done.out)), [one for one in of("event", lines(done.out)) if one["event"] == "peak"]
    assert peaks and all(points[one["point"]]["amplitude"] == pytest.approx(one["amplitude"], rel=1e-12) for one in peaks)


def test_warnings_notes_and_the_closing_error_are_lines(tmp_path):
    case = cases.dof5(tmp_path, **SHORT)
    found = lines(run(case, "--log", "json", "-no_such_option", "1").out)
    assert "-no_such_option was not used" in of("note", found)[-1]["text"]
    again = run(cases.dof5(tmp_path, harmonics=3, samples=32, omega=[0.2, 0.3]), "--log", "json")
    assert of("warning", lines(again.out)) and of("warning", lines(again.out))[0]["warning"]
    case.path.write_text(case.path.read_text().replace("harmonics", "harmonisc"))
    refused = run(case, "--log", "json", ranks=2, status=2)
    last = lines(refused.out)[-1]
    assert last["kind"] == "error" and last["status"] == 2 and "harmonisc" in last["text"] and last["text"] in refused.err


@pytest.mark.parametrize("command", ["reduce", "modes", "check"])
def test_other_commands_speak_json_too(tmp_path, command):
    assert lines(run(cases.dof5(tmp_path, **SHORT), "--log", "json", command=command).out)


def test_text_that_is_no_utf8_is_json_all_the_same(tmp_path):
    done = run(cases.dof5(tmp_path, **SHORT), "--dry-run", "--log", "json")
    assert "modes" in lines(done.out)[0]["text"]
    missing = subprocess.run([BINARY, "run", tmp_path / "\udcff\"\t.toml", "--log", "json"], env=SURROUNDINGS, capture_output=True)
    assert missing.returncode == 2
    assert "?\"?.toml: there is no such case file" in lines(missing.stdout.decode())[-1]["text"].replace("\t", "?")


@pytest.mark.parametrize("words", [["xml"], []])
def test_other_forms_are_refused_in_words(tmp_path, words):
    assert "--log wants text or json behind it" in run(cases.dof5(tmp_path, **SHORT), "--log", *words, status=2).err


def test_text_is_the_default(tmp_path):
    said = [run(cases.dof5(tmp_path, **SHORT), *options, out=f"out{len(options)}").out for options in ([], ["--log", "text"])]
    assert said[0].splitlines()[:3] == said[1].splitlines()[:3] and "  step " in said[0] and "{" not in said[0]
