"""The stand-in plugin of these tests, installed by putting its folder on the path."""

import os
from pathlib import Path

import pytest

STAND_IN = Path(__file__).parent / "stand_in"


@pytest.fixture
def stand_in(monkeypatch):
    """The plugin, for this process."""
    monkeypatch.syspath_prepend(str(STAND_IN))


@pytest.fixture
def stand_in_environment():
    """The plugin, as the environment of another process."""
    return {**os.environ, "PYTHONPATH": str(STAND_IN), "PYTHONWARNINGS": "error"}
