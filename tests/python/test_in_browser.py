"""The page of `watch --page`, as a browser shows it while a run goes on."""

import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest

import cases
from headless import browser, complaints, needs_browser, until
from launch import SECONDS, SURROUNDINGS, kill, line, run, wait_for

pytestmark = [needs_browser, pytest.mark.slow]
SLOWLY = {"adaptive": False, "step": 0.0002, "max_points": 10**6, "harmonics": 3, "samples": 2**13}
SIZES = "const c = document.getElementById('curve'); return [c.complete && c.naturalWidth, c.getBoundingClientRect().bottom, innerHeight]"


@pytest.fixture
def driver():
    with browser() as driver:
        yield driver


@contextmanager
def watched(folder):
    """The command at work, as a user starts it: its process and the page's address."""
    command = [sys.executable, "-m", "dovetail", "watch", folder, "--page"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=SURROUNDINGS)
    try:
        yield process, process.stdout.readline().split()[0]
    finally:
        process.kill()
        process.communicate()


def shown(driver, name):
    return driver.find_element("id", name).text


def curve(driver):
    """Where the picture at hand comes from, "" while there is none."""
    element = driver.find_element("id", "curve")
    return element.get_attribute("src") if element.is_displayed() else ""


def test_the_page_follows_a_run_to_its_end(tmp_path, driver):
    command, folder = line(cases.dof5(tmp_path, **SLOWLY), out="out")
    process = subprocess.Popen(command, env=SURROUNDINGS, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        wait_for((folder / "results.h5").exists, "results")
        with watched(folder) as (_, address):
            driver.get(address)
            until(driver, lambda: curve(driver), "a curve")
            first, said = curve(driver), shown(driver, "state")
            assert "following" in said and "%" in said and "#" not in said and driver.find_element("id", "done").is_displayed()
            assert driver.title == shown(driver, "title") == "five degrees of freedom" and "stick" in shown(driver, "shares")
            until(driver, lambda: curve(driver) != first and shown(driver, "state") != said, "a new picture and what is said of it")
            process.send_signal(signal.SIGTERM)
            process.wait(SECONDS)
            until(driver, lambda: shown(driver, "state").startswith("ended (interrupted), "), "the end")
            until(driver, lambda: curve(driver).endswith("False") and driver.execute_script(SIZES)[0], "the whole curve")
            assert not driver.find_element("id", "done").is_displayed()
            _, bottom, height = driver.execute_script(SIZES)
            assert bottom <= height  # all of the picture is to be seen
            assert not complaints(driver)
    finally:
        kill(process)


def test_the_page_says_why_there_is_no_curve(tmp_path, driver):
    case = cases.dof5(tmp_path, harmonics=3, samples=32, omega=[1.02, 1.03], max_iterations=1)
    why = run(case, out="out", status=3).summary["why"]
    with watched(tmp_path / "out") as (process, address):
        driver.get(address)
        until(driver, lambda: shown(driver, "state").startswith("ended (no_start), 0 points"), "the end")
        assert why in shown(driver, "state") and shown(driver, "shares") == "no point yet" and not curve(driver)
        assert not complaints(driver)
        (tmp_path / "out/results.h5").write_bytes(b"of something else")
        until(driver, lambda: "results.h5" in shown(driver, "state"), "what is wrong with the file")
        process.kill()
        until(driver, lambda: shown(driver, "state") == "dovetail watch has ended", "that nobody answers")
