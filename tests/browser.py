"""Pages in headless Chromium, for tests of reports and of the explorer."""

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
_TIMEOUT = 60.0  # s; enough for a busy machine


def find_browser():
    """Return the path of an installed browser, or skip the test if there is none."""
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        pytest.skip(f"none of {', '.join(BROWSERS)} is installed")
    return path


class Page:
    """Open page of a browser.

    Attributes
    ----------
    driver : selenium.webdriver.Chrome
    """

    def __init__(self, driver):
        self.driver = driver

    def evaluate(self, expression):
        """Return the value of a JavaScript expression, after waiting for a promise."""
        return self.driver.execute_script(f"return ({expression})")

    def run(self, script):
        """Run JavaScript statements."""
        self.driver.execute_script(script)

    def until(self, condition):
        """Wait until a JavaScript expression is true, and return its value."""
        end = time.monotonic() + _TIMEOUT
        while not (value := self.evaluate(condition)):
            assert time.monotonic() < end, f"never true: {condition}"
            time.sleep(0.05)
        return value

    def until_close(self, expression, expected, atol):
        """Wait until the values of a JavaScript expression are close to the expected ones."""
        end = time.monotonic() + _TIMEOUT
        while not np.allclose(values := self.evaluate(expression), expected, rtol=0.0, atol=atol):
            if time.monotonic() > end:
                np.testing.assert_allclose(values, expected, rtol=0.0, atol=atol)
            time.sleep(0.05)

    def set(self, selector, value):
        """Set the value of the range input that a CSS selector identifies."""
        element = f"document.querySelector({json.dumps(selector)})"
        self.run(f"{element}.value = {value}; {element}.dispatchEvent(new Event('input'))")

    def print(self):
        """Switch the page to its print layout."""
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        self.run("dispatchEvent(new Event('beforeprint'))")

    def picture(self, path):
        """Write the whole page as a PNG file."""
        width, height = self.evaluate("[innerWidth, document.documentElement.scrollHeight]")
        clip = {"x": 0, "y": 0, "width": width, "height": height, "scale": 1}
        options = {"format": "png", "captureBeyondViewport": True, "clip": clip}
        result = self.driver.execute_cdp_cmd("Page.captureScreenshot", options)
        path.write_bytes(b64decode(result["data"]))

    def errors(self):
        """Return the error messages on the JavaScript console of the browser."""
        return [e["message"] for e in self.driver.get_log("browser") if e["level"] == "SEVERE"]


@contextmanager
def opened(address, width=1200, **features):
    """Context manager that opens a file or URL in a browser, and yields its `Page`.

    Parameters
    ----------
    address : path or str
        File or URL.
    width : int
        Width of the window [px].
    **features
        CSS media features, such as ``color_scheme="dark"``.
    """
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
            page.until("document.body.dataset.shown")  # It is set when all figures are drawn.
        yield page
    finally:
        driver.quit()
