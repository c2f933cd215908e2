"""Errors that all sensors share: what a turn tells of them, and what no turn can."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario, compute_lower_bound, evaluate
from mgeo_attitude.lower_bound.common_mode import Carrier, compute_following_cost
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from scipy.spatial.transform import Rotation

from .batch import mean_covariance
from .plans import SCENARIOS, coarse
from .test_batch import totals

MICROSATELLITE = SCENARIOS / "microsatellite.toml"
ANGLE, DECAY, NOISE = 0.4, 0.9, 0.01
CARRIER = Carrier(DECAY, NOISE, np.diag([1.0, 2.0, 3.0]))


def cross(v):
    return np.cross(np.eye(3), v)


def turns(rng, n):
    """Rotations of up to the angle, among them some of all of it about each axis."""
    vectors = rng.standard_normal((n, 3))
    vectors *= ANGLE * rng.uniform(0.0, 1.0, (n, 1)) / np.linalg.norm(vectors, axis=1)[:, None]
    return Rotation.from_rotvec([*vectors, *(ANGLE * np.eye(3))]).as_matrix()


def test_a_step_costs_what_the_farthest_turn_does():
    n = 3
    bias = np.diff(compute_following_cost(CARRIER, ANGLE, None, n))
    rotations = turns(np.random.default_rng(1), 3000)
    exact = max(np.sum((R - DECAY * np.eye(3)) ** 2) for R in rotations) / NOISE
    np.testing.assert_allclose(bias, exact, rtol=1e-12)
    still = np.tile([0.0, 0.0, 0.7], (n, 1))
    exact = max(np.sum((cross(still[0]) @ (R - DECAY * np.eye(3))) ** 2) for R in rotations) / NOISE
    misaligned = np.diff(compute_following_cost(CARRIER, ANGLE, still, n))
    np.testing.assert_allclose(misaligned, exact, rtol=1e-12)


@pytest.mark.parametrize(("opening", "near"), [(0.02, 0.98), (0.2, 0.8), (3.0, 0.5)])
def test_no_turn_costs_more_while_the_vector_turns_too(opening, near):
    v = Rotation.from_rotvec(opening * np.arange(4)[:, None] * [0.0, 1.0, 0.0]).apply([0, 0, 0.7])
    v *= np.array([1.0, 1.1, 0.8, 1.0])[:, None]
    told = np.diff(compute_following_cost(CARRIER, ANGLE, v, 4)) * NOISE
    exact = [
        [np.sum((cross(after) @ R - DECAY * cross(before)) ** 2) for before, after in pairwise(v)]
        for R in turns(np.random.default_rng(2), 1000)
    ]
    ratio = np.max(exact, axis=0) / told
    assert ratio.max() <= 1.0 + 1e-12
    assert ratio.min() > near


def test_no_history_at_the_greatest_rate_is_below():
    """By the information of a whole history at once, which shares nothing with the limit."""
    scenario = coarse(Scenario.from_toml(MICROSATELLITE), 20.0)
    scenario = dataclasses.replace(scenario, duration=300.0)
    model = FilterModel.from_scenario(scenario)
    found, rate = (
        compute_lower_bound(scenario, model),
        np.radians(scenario.maneuvers.max_rate_deg_s),
    )
    least = dict.fromkeys(model.suite.blocks, np.inf)
    for attitude in Rotation.random(4, random_state=3).as_matrix():
        turned = dataclasses.replace(model, initial_attitude=attitude)
        for signs in ([1.0, 1.0, 1.0], [1.0, -1.0, 1.0]):
            slow = totals(mean_covariance(turned, rate * np.array(signs), np.eye(3)[None]))
            for block, total in zip(model.suite.blocks, slow, strict=True):
                least[block] = min(least[block], total / found.variance_sum[block][-1])
    assert min(least.values()) >= 1.0 - 1e-9
    assert least["mag_a.bias"] < 5.0  # about one axis; two thousand times if all else is known


@pytest.mark.slow
def test_turns_at_the_greatest_rate_come_near_what_the_field_lets_magnetometers_know():
    scenario = Scenario.from_toml(MICROSATELLITE)
    model = FilterModel.from_scenario(scenario)
    found, most = compute_lower_bound(scenario, model), scenario.maneuvers.max_rate_deg_s
    rates = most * np.array(
        [[1, 1, 1], [1, -1, 1], [-1, 1, 1], [1, 1, -1], [-1, -1, 1], [1, -1, -1]]
    )
    plan = np.column_stack([rates, np.full(6, 300.0)]).reshape(1, -1)
    ran = evaluate(model.full_duration_model, plan, history=True).variances[0]
    own = 3 * model.suite.blocks.index("mag_a.bias")
    ratio = ran[1:, own : own + 3].sum(axis=1) / found.variance_sum["mag_a.bias"][1:]
    assert ratio.min() >= 1.0
    assert ratio[1800] < 1.2


def test_coils_leave_the_rate_free():
    scenario = Scenario.from_toml(SCENARIOS / "cubesat-1u.toml")
    scenario = dataclasses.replace(scenario, duration=3000.0)
    assert compute_lower_bound(scenario).variance_sum["mag.bias"][-1] > 0.0
    gyro = dataclasses.replace(scenario.gyro, initial_scale_factor=0.01)
    with pytest.raises(
        NoLowerBoundError, match=r"^gyro\.scale_factor: .* rate, which magnetorquers do not"
    ):
        compute_lower_bound(dataclasses.replace(scenario, gyro=gyro))
