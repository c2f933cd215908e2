"""Simulated run of the paper's satellite and its calibration, computed once per session."""

import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate

from .runs import short, simulate_from_any_attitude


@pytest.fixture(scope="session")
def scenario():
    return short(Scenario.paper(), 1500.0)


@pytest.fixture(scope="session")
def telemetry(scenario):
    return simulate_from_any_attitude(scenario, 2)


@pytest.fixture(scope="session")
def calibration(scenario, telemetry):
    return calibrate(scenario, telemetry)
