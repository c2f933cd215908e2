"""Whatever attitude and rate a flight starts with, and whoever flies it."""

import dataclasses
import importlib.util

import numpy as np
import pytest
from mgeo_attitude import Environment, FilterModel, Scenario
from mgeo_attitude.scenario import InitialConditions
from mgeo_calibration import calibrate, fly

from .flights import PLAN, check_claimed, normalized

STARTS = {
    "GCRS": {},
    "turned": {"quaternion": [0.5, -0.1, 0.7, 0.5], "rate_deg_s": [0.4, -0.7, 0.3]},
    "nadir": {"pointing": "nadir"},
    "Sun": {"pointing": "sun", "axis": [1.0, 0.0, 0.0]},
}


def starting(start, preset="cubesat_6u"):
    """A preset that starts so; with `nadir` at the orbital rate."""
    return Scenario.from_dict(
        {"preset": preset, "duration": 1500.0, "initial": {"attitude_deg": 10.0, **STARTS[start]}}
    )


def simulator(name):
    """Of flights: a function as `fly`."""
    if name == "own":
        return fly
    if importlib.util.find_spec("Basilisk") is None:
        pytest.skip('flights by Basilisk: pip install "./problems/calibration[basilisk]"')
    from mgeo_calibration.flight.basilisk.fly import fly as by_basilisk

    return by_basilisk


@pytest.mark.slow
@pytest.mark.parametrize("name", ["own", pytest.param("basilisk", marks=pytest.mark.basilisk)])
def test_flights_from_nadir_are_calibrated_as_claimed(name):
    """NEES of six flights, and the largest of their errors, within bounds of chi-square."""
    scenario, flights = starting("nadir"), 6
    environment = Environment.from_scenario(scenario)
    found = []
    for seed in range(flights):
        telemetry = simulator(name)(scenario, PLAN, seed, environment=environment)
        off = telemetry.truth.attitude[0] @ FilterModel.from_scenario(scenario).initial_attitude.T
        assert np.arccos((np.trace(off) - 1.0) / 2.0) < np.radians(40.0)
        found.append(normalized(calibrate(scenario, telemetry), telemetry))
    check_claimed(found, 0.998, 4.2)


@pytest.mark.cases(2)
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("preset", ["paper", "cubesat_6u"])
def test_every_start_is_found(start, preset):
    scenario = starting(start, preset)
    telemetry = fly(scenario, PLAN, 11)
    check_claimed([normalized(calibrate(scenario, telemetry), telemetry)], 0.998)


def test_telemetry_does_not_ask_what_start_was_planned():
    """The same samples under another [initial] give the same numbers, bit by bit."""
    scenario = starting("nadir")
    telemetry = fly(scenario, PLAN, 3)
    plain = dataclasses.replace(scenario, initial=InitialConditions(attitude_deg=10.0))
    one, other = calibrate(scenario, telemetry), calibrate(plain, telemetry)
    np.testing.assert_array_equal(one.states, other.states)
    np.testing.assert_array_equal(one.covariance, other.covariance)
    np.testing.assert_array_equal(one.quaternion, other.quaternion)
