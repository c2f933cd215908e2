"""What all tests of the attitude problem share."""

import pytest
from mgeo_attitude.view.plans import Plans


@pytest.fixture(scope="module", autouse=True)
def few_flights():
    """Promises are looked at in 20 flights: figures and reports show those of 200 just alike."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Plans, "n_monte_carlo_runs", 20)
        yield
