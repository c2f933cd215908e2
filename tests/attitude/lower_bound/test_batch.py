"""Lower bound compared with the mean information of 300 s over attitudes."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario, evaluate
from mgeo_attitude.lower_bound.assembly import compute_lower_bound
from scipy.spatial.transform import Rotation

from ..filter.suites import SUITES
from .batch import mean_covariance

#: Suites with a lower bound: without measurement latency and without sensitivities of the gyro
#: bias.
BOUNDED_SUITES = [
    name
    for name, suite in SUITES.items()
    if not any(s.latency_states() for s in suite.sensors) and not suite.gyro.bias_sensitivities
]
#: Rotations of a cube, whose mean of a vector is zero and of a matrix a third of its trace.
CUBE = Rotation.create_group("O").as_matrix()
RATE = np.radians([0.31, -0.24, 0.17])


def build_model(name):
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
def attitude_independent_bound(monkeypatch):
    """Disable the bounds that depend on the rate of a single history."""
    monkeypatch.setattr("mgeo_attitude.lower_bound.assembly._bound_common_modes", lambda *_: ())


def sum_block_variances(covariance):
    return np.diag(covariance).reshape(-1, 3).sum(axis=1)


def compute_ratios(name, rotations):
    """Return the ratio of the lower bound to the mean-information bound by block, and the bound.

    Considered blocks are omitted. Gyro errors are omitted because a mean over attitudes separates
    them from the attitude, so that their mean-information bound is far too low.
    """
    scenario, model = build_model(name)
    actual = compute_lower_bound(scenario, model)
    slow = sum_block_variances(mean_covariance(model, RATE, rotations))
    left_out = {model.suite.blocks[state // 3] for state in model.suite.considered_indices}
    return {
        block: actual.variance_sum[block][-1] / total
        for block, total in zip(model.suite.blocks, slow, strict=True)
        if block not in left_out and not block.startswith("gyro")
    }, actual


@pytest.mark.slow
@pytest.mark.usefixtures("attitude_independent_bound")
@pytest.mark.parametrize("name", BOUNDED_SUITES)
def test_lower_bound_equals_mean_information_over_cube_rotations(name):
    ratios, actual = compute_ratios(name, CUBE)
    varies = SUITES[name].processes
    for block, ratio in ratios.items():
        assert ratio <= 1.0 + 1e-9, block
        if block == "attitude" or block.endswith(("albedo", "error")):
            # The lower bound assumes a bias that is known at all times.
            assert ratio > 0.95 or actual.relaxations, block
        elif any(each.startswith(block.split(".")[0]) for each in actual.relaxations):
            continue  # Anisotropic noise is relaxed to the noise of the best axis.
        elif not (varies and block.endswith(("scale_factor", "nonorthogonality"))):
            # A common scale factor has the same effect as a field error at any attitude.
            assert ratio == pytest.approx(1.0, rel=1e-9), block


@pytest.mark.slow
@pytest.mark.usefixtures("attitude_independent_bound")
@pytest.mark.parametrize("name", ["paper", "considered"])
def test_lower_bound_is_below_mean_information_over_random_rotations(name):
    rotations = Rotation.random(1000, random_state=1).as_matrix()
    ratios, actual = compute_ratios(name, rotations)
    for block, ratio in ratios.items():
        assert ratio <= 1.0 + 1e-9, block
        assert ratio > 0.9 or actual.relaxations or SUITES[name].processes, block


@pytest.mark.parametrize("name", ["full gyro"])
def test_batch_covariance_equals_filter_covariance(name):
    _, model = build_model(name)
    plan = np.degrees(np.append(RATE, np.radians(300.0)))[None]
    kernel = evaluate(model.full_duration_model, plan, covariance=True).covariance[0]
    slow = mean_covariance(model, RATE, np.eye(3)[None])
    np.testing.assert_allclose(sum_block_variances(slow), sum_block_variances(kernel), rtol=1e-6)
