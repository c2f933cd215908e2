"""Slopes by the adjoint against differences of the filter itself."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Magnetometer, Suite, SunSensor, evaluate
from mgeo_attitude.filter import has_slopes, slopes
from mgeo_attitude.scenario import PathLimit

from .suites import CHANNELS, SUITES

#: Whose sensors see otherwise than linearly in the attitude, late, or what is not estimated.
WITHOUT = (
    *("considered", "influences", "late", "photodiodes", "oblique star tracker", "two angles"),
    "cubesat_6u_full",
)


def model_of(suite, short, **more):
    channels = CHANNELS if suite.influence_keys else ()
    own = {"gyro": suite.gyro, "sensors": suite.sensors, "world": suite.world}
    scenario = dataclasses.replace(short, channels=channels, **own, **more)
    return FilterModel.from_scenario(scenario)


def plans(model, n, seed):
    """Designs of three rates, and how long each is flown [steps]."""
    rng = np.random.default_rng(seed)
    X = np.concatenate([rng.uniform(-1, 1, (n, 3, 3)), rng.uniform(0, 150, (n, 3, 1))], axis=2)
    return X.reshape(n, -1), rng.integers(60, 200, n)


def by_differences(model, X, stops, small=2e-5):
    """By rates [1/(rad/s)], of fourth order, shape (n, 3, 3)."""
    found = np.empty((len(X), 3, 3))
    for j in range(3):
        for axis in range(3):
            value = []
            for change in (-2.0, -1.0, 1.0, 2.0):
                changed = X.copy()
                changed[:, 4 * j + axis] += np.degrees(change * small)
                value.append(evaluate(model, changed, until=stops).trace)
            found[:, j, axis] = (value[0] - 8 * value[1] + 8 * value[2] - value[3]) / (12 * small)
    return found


@pytest.mark.parametrize(
    "name",
    [
        name if name == "paper" else pytest.param(name, marks=pytest.mark.slow)
        for name in SUITES
        if name not in WITHOUT
    ],
)
def test_slopes_are_those_of_the_filter(name, short):
    model = model_of(SUITES[name], short)
    X, stops = plans(model, 11, seed=3)
    assert has_slopes(model, 200)
    trace, found = slopes(model, model.schedule(X), stops)
    np.testing.assert_array_equal(trace, evaluate(model, X, until=stops).trace)
    # where something comes into view or leaves it differences are of no use
    views = any(sensor.views() for sensor in model.suite.sensors)
    expected = by_differences(model, X, stops, small=1e-7 if views else 2e-5)
    scale = np.abs(expected).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(found / scale, expected / scale, atol=1e-5 if views else 1e-7)


@pytest.mark.parametrize("name", WITHOUT)
def test_there_are_none_for_other_suites(name, short):
    assert not has_slopes(model_of(SUITES[name], short), 200)


def test_there_are_none_where_limits_and_time_matter(short):
    suite = SUITES["paper"]
    assert not has_slopes(model_of(suite, short), 10**6)
    limit = PathLimit(name="camera", reference="sun", boresight=(0.0, 0.0, 1.0), half_angle_deg=4.0)
    assert not has_slopes(model_of(suite, short, path_limits=(limit,)), 200)
    ramps = dataclasses.replace(short.maneuvers, max_acceleration_deg_s2=0.1)
    assert not has_slopes(model_of(suite, short, maneuvers=ramps), 200)


def test_what_is_blind_or_sees_only_forward_has_slopes(short):
    """Of what it sees."""
    suite = Suite(
        SUITES["paper"].gyro,
        (SunSensor(boresight=(1.0, 0.0, 0.0), half_angle_deg=80.0), Magnetometer()),
    )
    model = model_of(suite, short)
    available = model.available.copy()
    available[50:120, 0] = False
    model = dataclasses.replace(model, available=available)
    X, stops = plans(model, 4, seed=5)
    found = slopes(model, model.schedule(X), stops)[1]
    expected = by_differences(model, X, stops, small=1e-7)
    scale = np.abs(expected).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(found / scale, expected / scale, atol=1e-4)


def test_slopes_do_not_depend_on_neighbors_or_threads(paper):
    X, stops = plans(paper, 19, seed=6)
    plan = paper.schedule(X)
    trace, found = slopes(paper, plan, stops, threads=1)
    for threads in (2, 3):
        again = slopes(paper, plan, stops, threads=threads)
        np.testing.assert_array_equal(again[0], trace)
        np.testing.assert_array_equal(again[1], found)
    alone = slopes(paper, paper.schedule(X[[7]]), stops[[7]])
    np.testing.assert_array_equal(alone[1][0], found[7])


def test_what_is_not_flown_has_no_slope(paper):
    X, _ = plans(paper, 2, seed=7)
    X[:, 3] = 90.0
    _, found = slopes(paper, paper.schedule(X), np.array([80, 90]))
    assert (found[:, 0] != 0.0).any(axis=1).all()
    assert not found[:, 1:].any()
