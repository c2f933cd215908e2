"""Designs of one batch that are flown by satellites of other instruments, by one kernel."""

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
    """One that knows nothing."""

    def noise_sigmas(self):
        return (math.inf,) * 3


def variant(model, suite, weights=None):
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
    """Four of one form: gyros, noises, fields of view, initial 1-sigmas and weights differ."""
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
        variant(model, Suite(better, sensors)),
        variant(model, Suite(Gyro(), (other, *sensors[1:])), np.linspace(0.5, 2.0, 24)),
        variant(model, Suite(better, (other, sensors[1], Magnetometer(noise_nt=20.0)))),
    ]


@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("history", [False, True])
def test_each_design_is_as_if_its_variant_was_alone(models, threads, history):
    rng = np.random.default_rng(1)
    X = designs(rng, 40, max_duration=300.0)
    X[20:, :8] = X[:20, :8]  # much in common, also between variants
    which = rng.integers(0, 4, 40)
    options = {"threads": threads, "history": history, "covariance": True}
    found = evaluate(models[0], X, variants=models, variant_index=which, **options)
    for k, model in enumerate(models):
        mine, alone = which == k, evaluate(model, X[which == k], **options)
        for field in ("t_end", "trace", "covariance", "t_required"):
            assert getattr(found, field)[mine].tobytes() == getattr(alone, field).tobytes()
        if history:
            assert found.variances[mine].tobytes() == alone.variances.tobytes()
    assert len(set(found.t_end)) > 10


@pytest.mark.parametrize("index", [0, 1])
def test_a_sensor_of_infinite_noise_is_as_good_as_absent(models, short, index):
    full = models[0]
    sensors = list(full.suite.sensors)
    gone = sensors[index]
    without = [sensor for sensor in sensors if sensor is not gone]
    plain = FilterModel.from_scenario(dataclasses.replace(short, sensors=tuple(without)))
    sensors[index] = NoSunSensor(name=gone.name, **SIDE)
    weights = [0.0 if block.startswith(f"{gone.name}.") else 1.0 for block in full.suite.blocks]
    blind = variant(full, Suite(full.suite.gyro, tuple(sensors)), np.repeat(weights, 3))
    X = designs(np.random.default_rng(3), 24, max_duration=300.0)
    expected = evaluate(plain, X, covariance=True)
    found = evaluate(full, X, covariance=True, variants=[full, blind], variant_index=np.ones(24))
    assert np.array_equal(found.t_end, expected.t_end)
    assert found.trace == pytest.approx(expected.trace, rel=1e-9)
    kept = np.repeat(weights, 3) > 0
    covariance = found.covariance[:, kept][:, :, kept]
    scale = np.sqrt(np.einsum("nii,njj->nij", expected.covariance, expected.covariance))
    assert np.abs((covariance - expected.covariance) / scale).max() < 1e-9
    assert np.array_equal(
        found.covariance[:, ~kept][:, :, ~kept],
        np.broadcast_to(np.diag(full.initial_sigma[~kept] ** 2), (24, 6, 6)),
    )


@pytest.mark.slow
def test_trackers_and_path_limits_may_differ_in_numbers_but_not_in_what_they_look_at(short):
    tracker = StarTracker(max_rate_deg_s=0.5, sun_exclusion_deg=40.0)
    limit = PathConstraint(boresight=(1.0, 0.0, 0.0), half_angle_deg=20.0)
    scenario = dataclasses.replace(
        short, sensors=(tracker, Magnetometer()), path_constraints=(limit,), eclipse=False
    )
    model = FilterModel.from_scenario(scenario)
    other = dataclasses.replace(
        tracker, max_rate_deg_s=1.1, sun_exclusion_deg=60.0, noise_arcsec=30.0
    )
    aside = dataclasses.replace(limit, boresight=(0.0, 0.3, 1.0), attitude_sigmas=1.0)
    second = dataclasses.replace(
        variant(model, Suite(Gyro(), (other, Magnetometer()))), path_constraints=(aside,)
    )
    X, which = designs(np.random.default_rng(5), 16, max_duration=300.0), np.arange(16) % 2
    X[:, np.arange(12) % 4 != 3] *= 0.6
    found = evaluate(model, X, variants=[model, second], variant_index=which)
    for k, each in enumerate((model, second)):
        alone = evaluate(each, X[which == k])
        np.testing.assert_array_equal(found.trace[which == k], alone.trace)
        np.testing.assert_array_equal(found.path_angle[which == k], alone.path_angle)


def test_variants_of_another_form_are_refused(models):
    full, X = models[0], designs(np.random.default_rng(3), 2, max_duration=300.0)
    tracker = variant(full, Suite(Gyro(), (*full.suite.sensors[:2], StarTracker())))
    with pytest.raises(ValueError, match=r"variants\[1\] differs from the model in states"):
        evaluate(full, X, variants=[full, tracker])
    everywhere = SunSensor(name="a"), *full.suite.sensors[1:]
    with pytest.raises(ValueError, match=r"variants\[1\] .* directions in view"):
        evaluate(full, X, variants=[full, variant(full, Suite(Gyro(), everywhere))])
    unsure = dataclasses.replace(full.suite.sensors[0], considered=("bias",))
    suite = Suite(Gyro(), (unsure, *full.suite.sensors[1:]))
    with pytest.raises(ValueError, match=r"variants\[1\] .* considered states"):
        evaluate(full, X, variants=[full, variant(full, suite)])
