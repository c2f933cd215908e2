"""What all tests of the attitude problem share."""

import pytest
from mgeo_attitude.view import Plans


@pytest.fixture(scope="module", autouse=True)
def few_flights():
    """Promises are looked at in 20 flights: figures and reports show those of 200 just alike."""
    kept = Plans._kept

    def of_few(plans, flights=200, *given, **options):
        return kept(plans, 20 if flights == 200 else flights, *given, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Plans, "_kept", of_few)
        yield
