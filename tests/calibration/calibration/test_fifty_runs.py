"""Filter and calibrations of fifty runs with typical small satellites: errors agree with the
covariances.
"""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario

from .runs import PLAN, check_fifty_runs, short

pytestmark = pytest.mark.slow

#: Spin up about z, spin about x, despin. With magnetorquers the motion differs from run to run.
COMMANDS = np.array([0.1, -0.2, 1.5, 500.0, 1.0, 0.0, 0.2, 500.0, 0.0, 0.0, 0.0, 500.0])


def build_scenario_with_noise_per_axis():
    """Return a scenario with a small initial attitude error, so that nonlinear effects do not
    matter.
    """
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
    "noise by axis": (build_scenario_with_noise_per_axis, PLAN),
    "magnetorquers": (lambda: short(Scenario.cubesat_1u(), 1500.0), COMMANDS),
}


@pytest.mark.parametrize("name", CASES)
def test_errors_agree_with_covariance(name):
    scenario, plan = CASES[name]
    check_fifty_runs(scenario(), 3, plan)
