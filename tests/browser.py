"""The browser in which pages are looked at."""

import shutil

import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


def find_browser():
    """Path of an installed browser; without one the test is skipped with a message."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip(f"no browser to look at the pages: none of {', '.join(BROWSERS)} is installed")
    return found
