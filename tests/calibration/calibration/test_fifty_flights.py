"""Fifty flights of what small satellites have: errors are as large as is claimed."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario

from .flights import PLAN, check_fifty_flights, short

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


CASES = {
    "noise by axis": (noisy_by_axis, PLAN),
    "magnetorquers": (lambda: short(Scenario.cubesat_1u(), 1500.0), COMMANDS),
}


@pytest.mark.parametrize("name", CASES)
def test_errors_are_as_large_as_is_claimed(name):
    scenario, plan = CASES[name]
    check_fifty_flights(scenario(), 3, plan)
