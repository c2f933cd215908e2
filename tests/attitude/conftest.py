"""Fixtures for all tests of the attitude problem."""

import pytest
from mgeo_attitude.view.plans import Plans


@pytest.fixture(scope="module", autouse=True)
def few_flights():
    """Evaluate plans in 20 instead of 200 Monte Carlo runs, which is sufficient for tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Plans, "n_monte_carlo_runs", 20)
        yield
