"""Lower bounds of errors that are common to all sensors."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario, compute_lower_bound, evaluate
from mgeo_attitude.lower_bound.common_mode import InertialErrorDynamics, bound_dynamics_information
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from scipy.spatial.transform import Rotation

from .batch import mean_covariance
from .plans import SCENARIOS, coarsen_scenario
from .test_batch import sum_block_variances

MICROSATELLITE = SCENARIOS / "microsatellite.toml"
ANGLE, DECAY, NOISE = 0.4, 0.9, 0.01
DYNAMICS = InertialErrorDynamics(DECAY, NOISE, np.diag([1.0, 2.0, 3.0]))


def cross(v):
    return np.cross(np.eye(3), v)


def draw_rotations(rng, n):
    """Return rotations by up to `ANGLE`, including rotations by `ANGLE` about each axis."""
    vectors = rng.standard_normal((n, 3))
    vectors *= ANGLE * rng.uniform(0.0, 1.0, (n, 1)) / np.linalg.norm(vectors, axis=1)[:, None]
    return Rotation.from_rotvec([*vectors, *(ANGLE * np.eye(3))]).as_matrix()


def test_dynamics_information_equals_information_at_largest_rotation():
    n = 3
    bias = np.diff(bound_dynamics_information(DYNAMICS, ANGLE, None, n))
    rotations = draw_rotations(np.random.default_rng(1), 3000)
    exact = max(np.sum((R - DECAY * np.eye(3)) ** 2) for R in rotations) / NOISE
    np.testing.assert_allclose(bias, exact, rtol=1e-12)
    fixed_vectors = np.tile([0.0, 0.0, 0.7], (n, 1))
    exact = (
        max(np.sum((cross(fixed_vectors[0]) @ (R - DECAY * np.eye(3))) ** 2) for R in rotations)
        / NOISE
    )
    misaligned = np.diff(bound_dynamics_information(DYNAMICS, ANGLE, fixed_vectors, n))
    np.testing.assert_allclose(misaligned, exact, rtol=1e-12)


@pytest.mark.parametrize(("opening", "near"), [(0.02, 0.98), (0.2, 0.8), (3.0, 0.5)])
def test_dynamics_information_is_upper_bound_for_rotating_vector(opening, near):
    v = Rotation.from_rotvec(opening * np.arange(4)[:, None] * [0.0, 1.0, 0.0]).apply([0, 0, 0.7])
    v *= np.array([1.0, 1.1, 0.8, 1.0])[:, None]
    scaled_information = np.diff(bound_dynamics_information(DYNAMICS, ANGLE, v, 4)) * NOISE
    exact = [
        [np.sum((cross(after) @ R - DECAY * cross(before)) ** 2) for before, after in pairwise(v)]
        for R in draw_rotations(np.random.default_rng(2), 1000)
    ]
    ratio = np.max(exact, axis=0) / scaled_information
    assert ratio.max() <= 1.0 + 1e-12
    assert ratio.min() > near


def test_histories_at_maximum_rate_are_above_lower_bound():
    scenario = coarsen_scenario(Scenario.from_toml(MICROSATELLITE), 20.0)
    scenario = dataclasses.replace(scenario, duration=300.0)
    model = FilterModel.from_scenario(scenario)
    bound, rate = (
        compute_lower_bound(scenario, model),
        np.radians(scenario.maneuvers.max_rate_deg_s),
    )
    least = dict.fromkeys(model.suite.blocks, np.inf)
    for attitude in Rotation.random(4, random_state=3).as_matrix():
        turned = dataclasses.replace(model, initial_attitude=attitude)
        for signs in ([1.0, 1.0, 1.0], [1.0, -1.0, 1.0]):
            batch_total = sum_block_variances(
                mean_covariance(turned, rate * np.array(signs), np.eye(3)[None])
            )
            for block, total in zip(model.suite.blocks, batch_total, strict=True):
                least[block] = min(least[block], total / bound.variance_sum[block][-1])
    assert min(least.values()) >= 1.0 - 1e-9
    assert least["mag_a.bias"] < 5.0  # The bound with all other states known is 400 times lower.


@pytest.mark.slow
def test_rotation_at_maximum_rate_approaches_magnetometer_bound():
    scenario = Scenario.from_toml(MICROSATELLITE)
    model = FilterModel.from_scenario(scenario)
    bound, max_rate = compute_lower_bound(scenario, model), scenario.maneuvers.max_rate_deg_s
    rates = max_rate * np.array(
        [[1, 1, 1], [1, -1, 1], [-1, 1, 1], [1, 1, -1], [-1, -1, 1], [1, -1, -1]]
    )
    plan = np.column_stack([rates, np.full(6, 300.0)]).reshape(1, -1)
    variances = evaluate(model.full_duration_model, plan, history=True).variances[0]
    first_state = 3 * model.suite.blocks.index("mag_a.bias")
    ratio = (
        variances[1:, first_state : first_state + 3].sum(axis=1)
        / bound.variance_sum["mag_a.bias"][1:]
    )
    assert ratio.min() >= 1.0
    assert ratio[1800] < 1.2


def test_magnetorquers_do_not_limit_the_rate():
    scenario = Scenario.from_toml(SCENARIOS / "cubesat-1u.toml")
    scenario = dataclasses.replace(scenario, duration=3000.0)
    assert compute_lower_bound(scenario).variance_sum["mag.bias"][-1] > 0.0
    gyro = dataclasses.replace(scenario.gyro, initial_scale_factor=0.01)
    with pytest.raises(
        NoLowerBoundError, match=r"^gyro\.scale_factor: .* rate, which magnetorquers do not"
    ):
        compute_lower_bound(dataclasses.replace(scenario, gyro=gyro))
