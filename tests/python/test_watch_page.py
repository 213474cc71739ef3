"""The page of `watch --page`: what is served, to whom, and what its script makes of it."""

import http.client
import json
import re
import shutil
import subprocess
import sys
import threading
from contextlib import contextmanager
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest

import cases
import synthetic_results
from dovetail import watch_page
from dovetail.__main__ import main
from launch import SECONDS, SURROUNDINGS, going, wait_for

CONTACT = {"normal_stiffness": np.ones(1), "tangential_stiffness": np.ones((1, 2)), "friction": np.ones((1, 2)), "gap": np.zeros(1)}
SCRIPT = """
const parts = {}, page = { title: "", getElementById: (name) => (parts[name] ??= { hidden: true }) };
const done = () => { console.log(JSON.stringify({ ...parts, page: page.title })); process.exit(); };
(function (document, fetch, setTimeout) { BODY })(page, (name) => fetch("ADDRESS" + name), done);
"""


@contextmanager
def served(path, **options):
    with watch_page.server_of(watch_page.Page(path, **options)) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server.server_port
        finally:
            server.shutdown()
            thread.join()


def asked(port, target, host="127.0.0.1"):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=SECONDS)
    connection.request("GET", target, headers={"Host": f"{host}:{port}"})
    answer = connection.getresponse()
    return answer.status, answer.read(), answer.headers


@pytest.fixture
def path(tmp_path):
    omega = np.linspace(1, 3, 21)
    coefficients = np.zeros((21, 4, 3))
    coefficients[:, 1, 1] = 1 / np.hypot(1 - omega / 2, 0.1)
    return synthetic_results.write(tmp_path / "results.h5", omega, coefficients, 1, CONTACT, title="<b>Füße & $x$</b>")


def test_page_state_and_curve_are_served(path):
    with served(path) as port:
        status, page, headers = asked(port, "/")
        assert status == 200 and headers["Content-Type"].startswith("text/html") and b"curve.svg" in page
        found = json.loads(asked(port, "/state.json")[1])
        assert found["title"] == "<b>Füße & $x$</b>" and found["points"] == 21 and not found["running"]
        assert found["state"] == "ended (broken off), 21 points" and "stick 100 %" in found["shares"]
        status, curve, headers = asked(port, "/curve.svg?21")
        assert status == 200 and headers["Content-Type"] == "image/svg+xml"
        assert ElementTree.fromstring(curve).tag == "{http://www.w3.org/2000/svg}svg"
        assert asked(port, "/../results.h5")[0] == 404 and asked(port, "/results.h5")[0] == 404


def test_pages_of_strangers_get_nothing(path):
    with served(path) as port:
        assert asked(port, "/state.json", host="evil.example")[0] == 403
        assert asked(port, "/state.json", host="localhost")[0] == 200


def test_what_is_not_there_yet_ends_nothing(tmp_path, path):
    with served(tmp_path / "later" / "results.h5") as port:
        assert json.loads(asked(port, "/state.json")[1])["points"] == 0 and asked(port, "/curve.svg")[0] == 503
        assert asked(port, "/")[0] == 200
    with h5py.File(path, "a") as file:
        for name in list(file["points"]):
            if name != "contact":
                values = file[f"points/{name}"][:0]
                del file[f"points/{name}"]
                file[f"points/{name}"] = values
    with served(path) as port:
        assert json.loads(asked(port, "/state.json")[1])["shares"] == "no point yet" and asked(port, "/curve.svg")[0] == 503


def test_the_curve_follows_a_run_that_goes_on(tmp_path):
    case = cases.dof5(tmp_path, adaptive=False, step=0.0002, max_points=10**6, harmonics=3, samples=256)
    with going(case, out="out") as (_, folder), served(folder / "results.h5") as port:
        def state():
            return json.loads(asked(port, "/state.json")[1])

        wait_for(lambda: state()["points"] > 2, "points")
        first, before = state(), asked(port, "/curve.svg")[1]
        assert first["running"] and 0 <= first["done"] < 1 and "following" in first["state"]
        assert asked(port, "/curve.svg")[1] == before  # no new one at once, as drawing takes longer than a point
        wait_for(lambda: state()["drawn"] != first["drawn"], "a new picture")
        assert state()["points"] > first["points"]


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed: scripts/setup installs it where the distribution has it")
def test_the_script_fills_the_page(path, tmp_path):
    with served(path) as port:
        script = re.search(r"<script>(.*)</script>", watch_page.PAGE, re.DOTALL)[1]
        (tmp_path / "page.js").write_text(SCRIPT.replace("ADDRESS", f"http://127.0.0.1:{port}/").replace("BODY", script))
        said = subprocess.run(["node", tmp_path / "page.js"], capture_output=True, text=True, timeout=SECONDS, check=True).stdout
    shown = json.loads(said)
    assert shown["title"]["textContent"] == shown["page"] == "<b>Füße & $x$</b>"
    assert shown["state"]["textContent"].startswith("ended") and shown["done"]["hidden"] is True
    assert shown["curve"]["src"].startswith("curve.svg?21")
    assert all(f'id="{name}"' in watch_page.PAGE for name in shown if name != "page")


def test_the_command_says_where_it_is(path):
    command = [sys.executable, "-m", "dovetail", "watch", str(path.parent), "--page"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=SURROUNDINGS) as process:
        try:
            port = int(re.match(r"http://127\.0\.0\.1:(\d+)/ shows ", process.stdout.readline())[1])
            assert asked(port, "/")[0] == 200
        finally:
            process.kill()


def test_wrong_ports_are_refused(path, capsys):
    for port in ("-1", "70000"):
        assert main(["watch", str(path), "--page", port]) == 2 and f"--page {port}" in capsys.readouterr().err
