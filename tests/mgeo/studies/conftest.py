"""What tests of studies share."""

from functools import cache

import pytest

from mgeo.studies import plan

packages_distributions = cache(plan.packages_distributions)


@pytest.fixture
def quick(monkeypatch):
    """Studies without what takes most of a small one's time: figures, and a list of all packages.

    The list is made once.
    """
    monkeypatch.setattr("mgeo.studies.comparison.Comparison.figures", lambda self: {})
    monkeypatch.setattr(plan, "packages_distributions", packages_distributions)
