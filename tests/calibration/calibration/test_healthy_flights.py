"""Healthy satellites of all classes: errors are as large as is claimed."""

import pytest

from ...benchmarks.healthy_flights import CLASSES, SIMULATORS, run_flight

#: 1-sigmas that no error of a few hundred exceeds by chance.
WORST = 4.5


@pytest.mark.slow
@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("name", CLASSES)
def test_errors_are_within_their_claimed_sigmas(name, simulator):
    assert run_flight(name, simulator, 0).worst < WORST
