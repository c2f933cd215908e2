"""Fixtures that install the plugin for the tests by adding its folder to the module path."""

import os
from pathlib import Path

import pytest

STAND_IN = Path(__file__).parent / "stand_in"


@pytest.fixture
def stand_in(monkeypatch):
    """Install the plugin in this process."""
    monkeypatch.syspath_prepend(str(STAND_IN))


@pytest.fixture
def stand_in_environment():
    """Environment variables of another process in which the plugin is installed."""
    path = os.pathsep.join(filter(None, [str(STAND_IN), os.environ.get("PYTHONPATH")]))
    return {**os.environ, "PYTHONPATH": path, "PYTHONWARNINGS": "error"}
