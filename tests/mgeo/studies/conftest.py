"""What tests of studies share."""

from functools import cache

import pytest

from mgeo.studies import plan

packages_distributions = cache(plan.packages_distributions)


@pytest.fixture
def quick(monkeypatch):
    """Draw no figures: they take most of the time of a small study."""
    monkeypatch.setattr("mgeo.studies.comparison.Comparison.figures", lambda self: {})
