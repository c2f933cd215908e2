"""A flight of the paper's satellite and what follows from it, made once."""

import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate

from .flights import flown, short


@pytest.fixture(scope="session")
def scenario():
    return short(Scenario.paper(), 1500.0)


@pytest.fixture(scope="session")
def telemetry(scenario):
    return flown(scenario, 2)


@pytest.fixture(scope="session")
def calibration(scenario, telemetry):
    return calibrate(scenario, telemetry)
