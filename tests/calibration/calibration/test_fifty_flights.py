"""Fifty flights of what small satellites have: errors are as large as is claimed."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import HorizonSensor, Scenario
from mgeo_calibration import calibrate

from . import independent
from .flights import PLAN, check_claimed, check_fifty_flights, normalized, short
from .test_influences import scenario as following
from .test_photodiodes import SCENARIO as FACES

pytestmark = pytest.mark.slow

#: Spin up about z, spin about x, despin: what the coils of a 1U make of it is another in each.
COMMANDS = np.array([0.1, -0.2, 1.5, 500.0, 1.0, 0.0, 0.2, 500.0, 0.0, 0.0, 0.0, 500.0])


def noisy_by_axis():
    """From a start that is known well: what is not linear about a large error is another's test."""
    base = Scenario.cubesat_6u()
    sun, mag = base.sensors
    return short(
        base,
        1500.0,
        initial=dataclasses.replace(base.initial, attitude_deg=1.0),
        gyro=dataclasses.replace(
            base.gyro,
            angle_random_walk_deg_per_sqrt_h=(0.05, 0.15, 1.5),
            rate_random_walk=(1e-8, 8e-8, 2e-6),
        ),
        sensors=(
            dataclasses.replace(sun, noise_deg=(0.25, 0.5, 2.0)),
            dataclasses.replace(mag, noise_nt=(50.0, 100.0, 400.0)),
        ),
    )


def with_horizon_sensor():
    horizon = HorizonSensor(boresight=(0.0, 0.0, 1.0), half_angle_deg=80.0)
    base = Scenario.cubesat_6u()
    return short(base, 1500.0, sensors=(horizon, base.sensors[1]))


def with_faces():
    """From a start that is known as well as faces need it: see the last test."""
    return short(FACES, 2000.0, initial=dataclasses.replace(FACES.initial, attitude_deg=5.0))


CASES = {
    "noise by axis": (noisy_by_axis, PLAN),
    "horizon sensor": (with_horizon_sensor, PLAN),
    "influences": (lambda: following(1500.0), PLAN),
    "photodiodes": (with_faces, PLAN),
    "coils": (lambda: short(Scenario.cubesat_1u(), 1500.0), COMMANDS),
}


@pytest.mark.cases(0, 1)
@pytest.mark.parametrize("name", CASES)
def test_errors_are_as_large_as_is_claimed(name):
    scenario, plan = CASES[name]
    check_fifty_flights(scenario(), 3, plan)


@pytest.mark.campaign
def test_a_gyro_that_is_noisier_about_one_axis_is_calibrated_as_claimed():
    """Flights of an independent simulator."""
    uneven = {
        "angle_random_walk_deg_per_sqrt_h": (0.02, 0.1, 1.0),
        "rate_random_walk": (1e-8, 1e-7, 2e-6),
    }
    paper = Scenario.paper()
    scenario = short(paper, 3000.0, gyro=dataclasses.replace(paper.gyro, **uneven))
    found, alike = [], dataclasses.replace(scenario, gyro=paper.gyro)
    for seed in range(10):
        telemetry = independent.fly(scenario, independent.steady(PLAN), seed)
        found.append(normalized(calibrate(scenario, telemetry), telemetry))
    check_claimed(found, worst=np.inf)
    assert not calibrate(alike, telemetry).supported
