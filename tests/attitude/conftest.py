"""What all tests of the attitude problem share."""

from functools import partialmethod

import pytest
from mgeo_attitude import AttitudeManeuverProblem


@pytest.fixture(scope="module", autouse=True)
def few_flights():
    """Promises are looked at in 20 flights: figures and reports show those of 200 just alike."""
    few = partialmethod(AttitudeManeuverProblem.promises, flights=20)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(AttitudeManeuverProblem, "promises", few)
        yield
