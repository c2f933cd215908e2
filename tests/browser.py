"""Pages in headless Chromium."""

import json
import shutil
import time
from base64 import b64decode
from contextlib import contextmanager

import numpy as np
import pytest
from selenium import webdriver

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
FLAGS = (
    *("headless", "no-sandbox", "disable-gpu", "disable-quic", "no-first-run"),
    *("disable-background-networking", "disable-component-update", "disable-sync"),
    "enable-unsafe-swiftshader",  # WebGL without a graphics card
)
_PATIENCE = 60.0  # seconds, on a busy machine


def find_browser():
    """Return the path of an installed browser; skip the test if there is none."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip(f"none of {', '.join(BROWSERS)} is installed")
    return found


class Page:
    """An open page.

    Attributes
    ----------
    driver : selenium.webdriver.Chrome
    """

    def __init__(self, driver):
        self.driver = driver

    def evaluate(self, expression):
        """Return the value of a JavaScript expression; a promise is awaited."""
        return self.driver.execute_script(f"return ({expression})")

    def run(self, script):
        """Run JavaScript statements."""
        self.driver.execute_script(script)

    def until(self, condition):
        """Wait until a JavaScript expression is true, and return its value."""
        end = time.monotonic() + _PATIENCE
        while not (value := self.evaluate(condition)):
            assert time.monotonic() < end, f"never true: {condition}"
            time.sleep(0.05)
        return value

    def until_close(self, expression, expected, atol):
        """Wait until numbers are as expected."""
        end = time.monotonic() + _PATIENCE
        while not np.allclose(found := self.evaluate(expression), expected, rtol=0.0, atol=atol):
            if time.monotonic() > end:
                np.testing.assert_allclose(found, expected, rtol=0.0, atol=atol)
            time.sleep(0.05)

    def set(self, selector, value):
        """Move a range input."""
        found = f"document.querySelector({json.dumps(selector)})"
        self.run(f"{found}.value = {value}; {found}.dispatchEvent(new Event('input'))")

    def print(self):
        """Show the page as it is printed."""
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        self.run("dispatchEvent(new Event('beforeprint'))")

    def picture(self, path):
        """Write the whole page as a PNG file."""
        width, height = self.evaluate("[innerWidth, document.documentElement.scrollHeight]")
        clip = {"x": 0, "y": 0, "width": width, "height": height, "scale": 1}
        options = {"format": "png", "captureBeyondViewport": True, "clip": clip}
        found = self.driver.execute_cdp_cmd("Page.captureScreenshot", options)
        path.write_bytes(b64decode(found["data"]))

    def errors(self):
        """Return messages of errors on the console."""
        return [e["message"] for e in self.driver.get_log("browser") if e["level"] == "SEVERE"]


@contextmanager
def opened(address, width=1200, **features):
    """Open a file or an address in a window of a width, such as with ``color_scheme="dark"``."""
    options = webdriver.ChromeOptions()
    options.binary_location = find_browser()
    for flag in FLAGS:
        options.add_argument(f"--{flag}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    program = shutil.which("chromedriver") or pytest.skip("chromedriver is not installed")
    driver = webdriver.Chrome(options, webdriver.ChromeService(program))
    try:
        size = {"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": width < 600}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        media = [
            {"name": f"prefers-{k.replace('_', '-')}", "value": v} for k, v in features.items()
        ]
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": media})
        page, is_file = Page(driver), not str(address).startswith("http://")
        driver.get(f"file://{address}" if is_file else address)
        if is_file:
            page.until("document.body.dataset.shown")  # all figures are drawn
        yield page
    finally:
        driver.quit()
