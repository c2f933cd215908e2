"""Star tracker: availability, and noise about any boresight."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    AttitudeManeuverProblem,
    FilterModel,
    Gyro,
    Scenario,
    StarTracker,
    Suite,
)
from mgeo_attitude.filter.history import can_measure
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.scenario import Convergence

from .agreement import assert_agrees

TRACKER = StarTracker(
    boresight=(0.0, 1.0, -1.0),
    max_rate_deg_s=0.5,
    sun_exclusion_deg=40.0,
    earth_exclusion_deg=20.0,
    moon_exclusion_deg=15.0,
)


def scenario(tracker=TRACKER, **changes):
    return dataclasses.replace(
        Scenario.cubesat_6u(),
        duration=3000.0,
        step=2.0,
        convergence=Convergence(window=60.0, relative_decrease=1e-6),
        sensors=(tracker, *Scenario.cubesat_6u().sensors),
        **changes,
    )


@pytest.fixture(scope="module")
def model():
    return FilterModel.from_scenario(scenario())


def angle(axis, vectors):
    """Return the angle in degrees, from the chord of the unit sphere."""
    return np.degrees(2.0 * np.arcsin(0.5 * np.linalg.norm(vectors - axis, axis=1)))


def test_availability_follows_from_exclusion_angles(model):
    """The body is at rest in GCRS."""
    environment = AttitudeManeuverProblem(scenario()).environment
    axis = np.array([0.0, 1.0, -1.0]) / np.sqrt(2.0)
    distance = np.linalg.norm(environment.position, axis=1)
    nadir = -environment.position / distance[:, None]
    limb = np.degrees(np.arcsin(6378136.3 / distance))
    outside_sun_cone = (angle(axis, environment.sun) > 40.0) | ~environment.sunlit
    outside_earth_cone = angle(axis, nadir) - limb > 20.0
    attitude = np.broadcast_to(np.eye(3), (model.n_steps + 1, 3, 3))
    is_measured = can_measure(model, 0, attitude, np.zeros((model.n_steps, 3)))
    moon, _ = model.select_direction("moon")
    np.testing.assert_array_equal(
        is_measured, outside_sun_cone & outside_earth_cone & (angle(axis, moon) > 15.0)
    )
    assert is_measured.any()
    assert not is_measured.all()


@pytest.mark.slow
def test_star_tracker_measures_up_to_maximum_rate(model):
    """A sample belongs to the step before it."""
    tracker = dataclasses.replace(TRACKER, sun_exclusion_deg=None, earth_exclusion_deg=None)
    bare = dataclasses.replace(tracker, moon_exclusion_deg=None)
    model = FilterModel.from_scenario(scenario(bare))
    slow, fast = [0.3, 0.0, 0.4], [0.3, 0.01, 0.4]  # deg/s, with norms of 0.5 and slightly more
    design = np.array([*slow, 100.0, *fast, 60.0, *slow, 500.0])
    motion = Motion.from_design(model, design, model.n_steps)
    actual = can_measure(model, 0, motion.attitude, motion.rates)
    times = model.times
    np.testing.assert_array_equal(actual, (times <= 100.0) | (times > 160.0))
    assert_agrees(model, design[None])


@pytest.mark.parametrize("boresight", [(0.0, 0.0, 1.0), (0.0, 0.0, -2.0), (1.0, -2.0, 0.5)])
def test_information_is_isotropic_across_the_boresight(boresight):
    """Hᵀ R⁻¹ H = (I - b bᵀ) / σc² + b bᵀ / σr² for the boresight b."""
    tracker = StarTracker(boresight=boresight)
    H = Suite(Gyro(), (tracker,)).measurement_matrix(tracker, np.zeros(3))[:, :3]
    b = np.array(boresight) / np.linalg.norm(boresight)
    cross, roll = np.radians([10.0 / 3600.0, 60.0 / 3600.0])
    along = np.outer(b, b)
    expected = (np.eye(3) - along) / cross**2 + along / roll**2
    actual = H.T @ np.diag(np.array(tracker.noise_sigmas()) ** -2.0) @ H
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-9 * expected.max())
