"""Biases that follow channels, in Basilisk's flights."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Environment, FilterModel
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_calibration.flight.basilisk.vehicle import Vehicle

from ...calibration.test_influences import scenario as following
from .flights import PLAN, check_calibrated, errorless, seen

pytestmark = pytest.mark.basilisk


def test_what_is_reported_is_more_by_what_follows_alone():
    scenario = following(60.0)
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    motion, drawn = Motion.of(model, PLAN, model.n_steps), errorless(model)
    more = np.random.default_rng(1).standard_normal((61, 3))
    other = dataclasses.replace(drawn, follows={"mag": more})
    one, two = (
        seen(scenario, motion, each, Vehicle.cubesat_6u(), environment) for each in (drawn, other)
    )
    np.testing.assert_array_equal(two.sensors[0], one.sensors[0])
    off = (two.sensors[1] - one.sensors[1])[1:, 0]
    np.testing.assert_allclose(off, more[1:], rtol=0, atol=1e-12)


@pytest.mark.slow
def test_flights_are_calibrated_within_bounds():
    """Three, of a gyro that follows a temperature and a magnetometer that does and a current."""
    check_calibrated(following(1500.0), PLAN, 3)
