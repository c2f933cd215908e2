"""Healthy satellites of all classes: errors agree with the covariances."""

import pytest

from ...benchmarks.healthy_flights import CLASSES, SIMULATORS, run_flight

#: Bound in 1-sigmas that none of a few hundred errors exceeds by chance.
WORST = 4.5


@pytest.mark.slow
@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("name", CLASSES)
def test_errors_agree_with_covariance(name, simulator):
    assert run_flight(name, simulator, 0).worst < WORST
