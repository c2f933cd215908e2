"""Where maneuvers arrive: beside the schedule of their steps, turned by scipy."""

import numpy as np
import pytest
from mgeo_attitude.maneuvers.drives import SlewLimits
from mgeo_attitude.maneuvers.schedule import schedule
from mgeo_attitude.trajectory.arrival import arrival, missing
from scipy.spatial.transform import Rotation

STEP = 2.0


@pytest.mark.slow
@pytest.mark.parametrize("lengths", [(60, 40), (3, 97), (100, 2)])  # ramps take 1 to 20 steps
def test_it_is_what_the_schedule_of_all_steps_makes(lengths):
    rng = np.random.default_rng(sum(lengths))
    rate, attitude = rng.uniform(-0.01, 0.01, 3), Rotation.random(rng=rng)
    rates = rng.uniform(-0.01, 0.01, (2, 3))
    inertia, share = np.diag([0.1, 0.2, 0.3]), rng.uniform(-1.0, 1.0, (4, 3))
    limits = SlewLimits(5e-4, 1e-4, inertia, share, rate)
    design = np.column_stack([np.degrees(rates), STEP * np.array(lengths)]).ravel()
    plan = schedule(design, STEP, limits, sum(lengths))
    expected = attitude
    for turned, steps in zip(plan.rates[0], plan.lasting(sum(lengths))[0], strict=True):
        expected = Rotation.from_rotvec(-turned * steps * STEP) * expected
    bounds = limits.max_acceleration, limits.max_torque, limits.allocation @ limits.inertia
    found = arrival(attitude.as_matrix(), rate, rates, np.array(lengths), STEP, bounds)
    np.testing.assert_allclose(found, expected.as_matrix(), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 0.1, 3.0, np.pi - 1e-9])
def test_what_is_missing_is_the_rotation_between(angle):
    rng = np.random.default_rng(5)
    for _ in range(50):
        reached, axis = Rotation.random(rng=rng), rng.normal(size=3)
        turn = angle * axis / np.linalg.norm(axis)
        target = Rotation.from_rotvec(turn) * reached
        found = missing(target.as_matrix(), reached.as_matrix())
        np.testing.assert_allclose(found, turn, rtol=0.0, atol=1e-8 if angle > 3.1 else 1e-14)
