import pytest


@pytest.fixture
def without_figures(monkeypatch):
    """Skip the drawing of figures, which takes most of the time of a small study."""
    monkeypatch.setattr("mgeo.studies.comparison.Comparison.draw_figures", lambda self: {})
