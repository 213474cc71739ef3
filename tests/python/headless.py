"""A browser without a window for tests of pages: Chromium, driven by Selenium. Both are optional; scripts/setup installs them."""

import importlib.util
import shutil
from contextlib import contextmanager

import pytest

from launch import SECONDS

ARGUMENTS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--window-size=1000,900")
needs_browser = pytest.mark.skipif(not (shutil.which("chromedriver") and importlib.util.find_spec("selenium")),
                                   reason="no chromium-driver and selenium: scripts/setup installs them where the distribution has them")


@contextmanager
def browser():
    """A driver of its own."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    for argument in ARGUMENTS:
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
    try:
        yield driver
    finally:
        driver.quit()


def until(driver, condition, what):
    """What condition() gives as soon as that is true. Looks now and then, so that the browser has time for its page."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(driver, SECONDS, poll_frequency=0.3).until(lambda _: condition(), f"waited in vain for {what}")


def complaints(driver):
    """What the console has said since it was asked last."""
    return [entry["message"] for entry in driver.get_log("browser")]
