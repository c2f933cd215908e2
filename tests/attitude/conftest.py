"""Fixtures of all tests of the attitude problem."""

import pytest
from mgeo_attitude.view.plans import Plans


@pytest.fixture(scope="module", autouse=True)
def few_flights():
    """Use 20 instead of 200 Monte Carlo runs, which figures and reports display in the same way."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Plans, "n_monte_carlo_runs", 20)
        yield
