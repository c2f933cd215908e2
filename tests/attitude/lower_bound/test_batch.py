"""The limit beside a slow independent one: the mean information of 300 s over attitudes."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario, evaluate
from mgeo_attitude.lower_bound.assembly import compute_lower_bound
from scipy.spatial.transform import Rotation

from ..filter.suites import SUITES
from .batch import mean_covariance

#: What a sample tells of a delay depends on the rate: there is no limit with one, nor with what
#: the gyro's bias follows.
LIMITED = [
    name
    for name, suite in SUITES.items()
    if not any(s.latency_states() for s in suite.sensors) and not suite.gyro.bias_sensitivities
]
#: Rotations of a cube: their mean of a vector is zero, and of a matrix the share of its trace.
CUBE = Rotation.create_group("O").as_matrix()
RATE = np.radians([0.31, -0.24, 0.17])


def of_suite(name):
    suite = SUITES[name]
    sensors = [dataclasses.replace(each, sample_interval=None) for each in suite.sensors]
    scenario = dataclasses.replace(
        Scenario.paper(),
        gyro=suite.gyro,
        sensors=tuple(sensors),
        environment_errors=suite.environment_errors,
        duration=300.0,
        step=20.0,
        trace_weights={},
    )
    return scenario, FilterModel.from_scenario(scenario)


@pytest.fixture
def any_attitude(monkeypatch):
    """Without what is known of one history's rates: a mean over attitudes belongs to none."""
    monkeypatch.setattr("mgeo_attitude.lower_bound.assembly._bound_common_modes", lambda *_: ())


def totals(covariance):
    return np.diag(covariance).reshape(-1, 3).sum(axis=1)


def compare(name, rotations):
    """The limit over the slow one, by blocks; not of those that are considered.

    Nor of the gyro: a mean over attitudes parts its errors from the attitude's, by which alone
    they are seen, and is far below the limit.
    """
    scenario, model = of_suite(name)
    found = compute_lower_bound(scenario, model)
    slow = totals(mean_covariance(model, RATE, rotations))
    left_out = {model.suite.blocks[state // 3] for state in model.suite.considered_indices}
    return {
        block: found.variance_sum[block][-1] / total
        for block, total in zip(model.suite.blocks, slow, strict=True)
        if block not in left_out and not block.startswith("gyro")
    }, found


@pytest.mark.slow
@pytest.mark.usefixtures("any_attitude")
@pytest.mark.parametrize("name", LIMITED)
def test_the_limit_is_the_mean_information_over_a_cube(name):
    ratios, found = compare(name, CUBE)
    varies = SUITES[name].processes
    for block, ratio in ratios.items():
        assert ratio <= 1.0 + 1e-9, block
        if block == "attitude" or block.endswith(("albedo", "error")):
            # it knows the bias all the way, the slow one at the steps
            assert ratio > 0.95 or found.relaxations, block
        elif any(each.startswith(block.split(".")[0]) for each in found.relaxations):
            continue  # noise that differs by axes counts as nowhere more than on its best
        elif not (varies and block.endswith(("scale_factor", "nonorthogonality"))):
            # a scale common to all axes is as an error of the field is, whatever the attitude
            assert ratio == pytest.approx(1.0, rel=1e-9), block


@pytest.mark.slow
@pytest.mark.usefixtures("any_attitude")
@pytest.mark.parametrize("name", ["paper", "considered"])
def test_the_limit_is_not_above_the_mean_information_over_random_rotations(name):
    rotations = Rotation.random(1000, random_state=1).as_matrix()
    ratios, found = compare(name, rotations)
    for block, ratio in ratios.items():
        assert ratio <= 1.0 + 1e-9, block
        assert ratio > 0.9 or found.relaxations or SUITES[name].processes, block


@pytest.mark.parametrize("name", ["full gyro"])
def test_the_slow_one_has_the_covariance_of_the_kernel(name):
    _, model = of_suite(name)
    plan = np.degrees(np.append(RATE, np.radians(300.0)))[None]
    kernel = evaluate(model.full_duration_model, plan, covariance=True).covariance[0]
    slow = mean_covariance(model, RATE, np.eye(3)[None])
    np.testing.assert_allclose(totals(slow), totals(kernel), rtol=1e-6)
