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
    path = os.pathsep.join(filter(None, [str(STAND_IN), os.environ.get("PYTHONPATH")]))
    return {**os.environ, "PYTHONPATH": path, "PYTHONWARNINGS": "error"}
