"""Fixtures of the tests of studies."""

import pytest


@pytest.fixture
def quick(monkeypatch):
    """Draw no figures: they take most of the time of a small study."""
    monkeypatch.setattr("mgeo.studies.comparison.Comparison.draw_figures", lambda self: {})
