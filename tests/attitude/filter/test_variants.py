"""Batches in which designs have different variants of the model."""

import dataclasses
import math

import numpy as np
import pydantic.dataclasses
import pytest
from mgeo_attitude import FilterModel, Gyro, Magnetometer, StarTracker, Suite, SunSensor, evaluate
from mgeo_attitude.scenario import PathConstraint

from .agreement import designs


@pydantic.dataclasses.dataclass(frozen=True)
class NoSunSensor(SunSensor):
    """Sun sensor with infinite noise."""

    def noise_sigmas(self):
        return (math.inf,) * 3


def build_variant(model, suite, weights=None):
    sigma = suite.initial_sigma(math.radians(5.0))
    return dataclasses.replace(
        model,
        suite=suite,
        initial_sigma=sigma,
        weights=model.weights if weights is None else weights,
    )


SIDE = {"boresight": (1.0, 0.2, 0.0), "half_angle_deg": 70.0}


@pytest.fixture(scope="module")
def models(short):
    """Four variants that differ in gyro, noise, field of view, initial 1-sigmas and weights."""
    top = SunSensor(name="b", boresight=(0, 0, 1), half_angle_deg=50.0)
    sensors = SunSensor(name="a", **SIDE), top, Magnetometer()
    requirement = {"attitude_deg": 1.0}
    scenario = dataclasses.replace(short, sensors=sensors, required_sigma=requirement)
    model = FilterModel.from_scenario(scenario)
    better = Gyro(angle_random_walk_deg_per_sqrt_h=0.3, initial_bias_deg_s=0.002, bias_decay=1e-4)
    other = SunSensor(name="a", noise_deg=0.2, initial_bias=0.1, boresight=(0, 1, 0),
                      half_angle_deg=120.0)  # fmt: skip
    return [
        model,
        build_variant(model, Suite(better, sensors)),
        build_variant(model, Suite(Gyro(), (other, *sensors[1:])), np.linspace(0.5, 2.0, 24)),
        build_variant(model, Suite(better, (other, sensors[1], Magnetometer(noise_nt=20.0)))),
    ]


@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("history", [False, True])
def test_variants_in_one_batch_equal_separate_batches(models, threads, history):
    rng = np.random.default_rng(1)
    X = designs(rng, 40, max_duration=300.0)
    X[20:, :8] = X[:20, :8]  # Designs have common maneuvers, also with different variants.
    variant_index = rng.integers(0, 4, 40)
    options = {"threads": threads, "history": history, "covariance": True}
    result = evaluate(models[0], X, variants=models, variant_index=variant_index, **options)
    for k, model in enumerate(models):
        is_variant, separate = variant_index == k, evaluate(model, X[variant_index == k], **options)
        for field in ("t_end", "trace", "covariance", "t_required"):
            assert (
                getattr(result, field)[is_variant].tobytes() == getattr(separate, field).tobytes()
            )
        if history:
            assert result.variances[is_variant].tobytes() == separate.variances.tobytes()
    assert len(set(result.t_end)) > 10


@pytest.mark.parametrize("index", [0, 1])
def test_sensor_with_infinite_noise_equals_absent_sensor(models, short, index):
    full = models[0]
    sensors = list(full.suite.sensors)
    removed = sensors[index]
    remaining = [sensor for sensor in sensors if sensor is not removed]
    reduced_model = FilterModel.from_scenario(dataclasses.replace(short, sensors=tuple(remaining)))
    sensors[index] = NoSunSensor(name=removed.name, **SIDE)
    weights = [0.0 if block.startswith(f"{removed.name}.") else 1.0 for block in full.suite.blocks]
    noisy_model = build_variant(full, Suite(full.suite.gyro, tuple(sensors)), np.repeat(weights, 3))
    X = designs(np.random.default_rng(3), 24, max_duration=300.0)
    expected = evaluate(reduced_model, X, covariance=True)
    result = evaluate(
        full, X, covariance=True, variants=[full, noisy_model], variant_index=np.ones(24)
    )
    assert np.array_equal(result.t_end, expected.t_end)
    assert result.trace == pytest.approx(expected.trace, rel=1e-9)
    is_remaining = np.repeat(weights, 3) > 0
    covariance = result.covariance[:, is_remaining][:, :, is_remaining]
    scale = np.sqrt(np.einsum("nii,njj->nij", expected.covariance, expected.covariance))
    assert np.abs((covariance - expected.covariance) / scale).max() < 1e-9
    assert np.array_equal(
        result.covariance[:, ~is_remaining][:, :, ~is_remaining],
        np.broadcast_to(np.diag(full.initial_sigma[~is_remaining] ** 2), (24, 6, 6)),
    )


@pytest.mark.slow
def test_variants_may_differ_in_star_tracker_and_path_constraint(short):
    tracker = StarTracker(max_rate_deg_s=0.5, sun_exclusion_deg=40.0)
    constraint = PathConstraint(boresight=(1.0, 0.0, 0.0), half_angle_deg=20.0)
    scenario = dataclasses.replace(
        short, sensors=(tracker, Magnetometer()), path_constraints=(constraint,), eclipse=False
    )
    model = FilterModel.from_scenario(scenario)
    other = dataclasses.replace(
        tracker, max_rate_deg_s=1.1, sun_exclusion_deg=60.0, noise_arcsec=30.0
    )
    other_constraint = dataclasses.replace(
        constraint, boresight=(0.0, 0.3, 1.0), attitude_sigmas=1.0
    )
    second = dataclasses.replace(
        build_variant(model, Suite(Gyro(), (other, Magnetometer()))),
        path_constraints=(other_constraint,),
    )
    X, variant_index = designs(np.random.default_rng(5), 16, max_duration=300.0), np.arange(16) % 2
    X[:, np.arange(12) % 4 != 3] *= 0.6
    result = evaluate(model, X, variants=[model, second], variant_index=variant_index)
    for k, each in enumerate((model, second)):
        separate = evaluate(each, X[variant_index == k])
        np.testing.assert_array_equal(result.trace[variant_index == k], separate.trace)
        np.testing.assert_array_equal(result.path_angle[variant_index == k], separate.path_angle)


def test_variants_that_need_another_kernel_are_rejected(models):
    full, X = models[0], designs(np.random.default_rng(3), 2, max_duration=300.0)
    tracker = build_variant(full, Suite(Gyro(), (*full.suite.sensors[:2], StarTracker())))
    with pytest.raises(ValueError, match=r"variants\[1\] differs from the model in states"):
        evaluate(full, X, variants=[full, tracker])
    unlimited_sensors = SunSensor(name="a"), *full.suite.sensors[1:]
    with pytest.raises(ValueError, match=r"variants\[1\] .* directions in view"):
        evaluate(full, X, variants=[full, build_variant(full, Suite(Gyro(), unlimited_sensors))])
    considered_sensor = dataclasses.replace(full.suite.sensors[0], considered=("bias",))
    suite = Suite(Gyro(), (considered_sensor, *full.suite.sensors[1:]))
    with pytest.raises(ValueError, match=r"variants\[1\] .* considered states"):
        evaluate(full, X, variants=[full, build_variant(full, suite)])
