"""What tests of studies share."""

import pytest


@pytest.fixture
def undrawn(monkeypatch):
    """Pages without figures, which take most of a small study's time: for tests of all else."""
    monkeypatch.setattr("mgeo.studies.comparison.Comparison.figures", lambda self: {})
