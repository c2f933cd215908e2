"""Biases that follow channels: what a channel is along a plan, and what the filter makes of it."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    AttitudeManeuverProblem,
    Environment,
    FilterModel,
    Gyro,
    Influence,
    Magnetometer,
    NoLimit,
    Photodiode,
    Scenario,
    SunSensor,
    agreement,
    evaluate,
    limit,
    reference_run,
)
from mgeo_attitude.filter.error_budget import error_budget
from mgeo_attitude.scenario import Channel
from mgeo_attitude.settings.errors import InvalidValue
from scipy.integrate import solve_ivp

TEMP = Channel(name="temp", in_sunlight=40.0, in_shadow=-20.0, time_constant=700.0, initial=5.0)
CURRENT = Channel(name="current", times=(100.0, 300.0, 900.0), values=(0.1, 0.5, -0.2))
DESIGN = np.array([0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0])


def scenario(gyro=(), mag=(), duration=1500.0, **changes):
    base = Scenario.paper()
    sun, field = base.sensors
    return dataclasses.replace(
        base,
        duration=duration,
        step=5.0,
        eclipse=True,
        channels=(TEMP, CURRENT),
        gyro=dataclasses.replace(base.gyro, influences=gyro),
        sensors=(sun, dataclasses.replace(field, influences=mag)),
        **changes,
    )


def test_a_temperature_follows_the_eclipse_with_its_time_constant():
    """Against SciPy's integrator."""
    of = scenario(duration=12000.0)
    environment = Environment.from_scenario(of)
    assert 0 < environment.sunlit.sum() < len(environment.sunlit)
    values = TEMP.at(environment.times, environment.sunlit)
    assert values[0] == 5.0
    goal = np.where(environment.sunlit, 40.0, -20.0)
    y = 5.0
    for k in range(1, 400):
        found = solve_ivp(
            lambda t, u, k=k: (goal[k] - u) / 700.0, (0.0, 5.0), [y], rtol=1e-10, atol=1e-12
        )
        y = found.y[0, -1]
        assert values[k] == pytest.approx(y, abs=1e-7)
    free = dataclasses.replace(TEMP, initial=None).at(environment.times, environment.sunlit)
    assert free[0] == goal[0]


def test_a_table_is_read_by_lines_and_held_beyond_its_ends():
    found = CURRENT.at(np.array([0.0, 200.0, 600.0, 2000.0]), np.ones(4, dtype=bool))
    np.testing.assert_allclose(found, [0.1, 0.3, 0.15, -0.2])


def test_the_gyro_counts_the_mean_of_a_step_and_a_sensor_its_sample():
    of = scenario((Influence("current", 0.01, "A", 0.1),), (Influence("current", 300.0, "A", 0.1),))
    model = FilterModel.from_scenario(of)
    u = model.channels["current"] - 0.1
    np.testing.assert_array_equal(model.influences[:, 1], u)
    np.testing.assert_allclose(model.influences[1:, 0], 0.5 * (u[1:] + u[:-1]), atol=1e-15)


@pytest.mark.slow
def test_kernel_and_filterpy_agree_and_the_budget_adds_up():
    of = scenario(
        (Influence("temp", 1e-3, "degC", 20.0),),
        (Influence("current", 2000.0, "A"), Influence("temp", 20.0, "degC", 20.0)),
    )
    model = FilterModel.from_scenario(of)
    found = agreement(model, DESIGN)
    assert found.same_end
    assert found.difference < 1e-9
    run = reference_run(model, DESIGN)
    total = error_budget(model, DESIGN, run.t_end).variances.sum(axis=0)
    np.testing.assert_allclose(total, run.sigma[-1] ** 2, rtol=1e-9)


@pytest.mark.slow
def test_a_channel_that_rests_cannot_be_told_from_the_bias():
    """At one unit above its reference: the bias then is the sum of both."""
    still = Channel(name="temp", times=(0.0,), values=(21.0,))
    sigma = Magnetometer().initial_bias_nt
    of = dataclasses.replace(
        scenario(mag=(Influence("temp", sigma, "degC", 20.0),)), channels=(still,)
    )
    model = FilterModel.from_scenario(of)
    P = evaluate(model.endless, DESIGN, covariance=True).covariance[0]
    bias, per = (3 * model.suite.blocks.index(f"mag.{b}") for b in ("bias", "bias_per_temp"))
    half = model.initial_sigma[bias] ** 2 / 2.0
    both = P[bias, bias] + 2.0 * P[bias, per] + P[per, per]
    assert P[bias, bias] == pytest.approx(half, rel=0.01)
    assert P[per, per] == pytest.approx(half, rel=0.01)
    assert both < 1e-3 * half


def test_a_sensors_influence_has_a_limit_and_the_gyros_says_why_not():
    of = scenario(mag=(Influence("current", 2000.0, "A"),))
    bound = limit(of)
    X = np.random.default_rng(2).uniform(-1.0, 1.0, (10, 12))
    X[:, 3::4] = 300.0
    found = evaluate(FilterModel.from_scenario(of), X)
    assert (found.trace > np.interp(found.t_end, bound.times, bound.trace)).all()
    with pytest.raises(NoLimit, match=r"gyro\.influences: how temp turns the attitude"):
        limit(scenario((Influence("temp", 1e-3),)))


def test_a_file_says_it_and_its_units_follow():
    of = scenario((Influence("temp", 1e-3, "degC", 20.0),), (Influence("current", 500.0, "A"),))
    assert Scenario.from_toml(of.to_toml()) == of
    assert Scenario.from_dict(of.to_dict()) == of
    units = {block: unit.text for block, unit in of.suite.units.items()}
    assert units["gyro.bias_per_temp"] == "deg/h per degC"
    assert units["mag.bias_per_current"] == "nT per A"
    sigma = of.suite.initial_sigma(0.1)
    blocks = of.suite.blocks
    assert sigma[3 * blocks.index("gyro.bias_per_temp")] == pytest.approx(np.radians(1e-3))
    assert sigma[3 * blocks.index("mag.bias_per_current")] == pytest.approx(500.0 / 50_000.0)


def test_an_influence_of_no_channel_is_refused_with_the_way_out():
    of = scenario(mag=(Influence("tmp", 1.0),))
    message = (
        r"sensors\[1\]\.influences\[0\]\.channel = 'tmp': unknown channel; did you mean 'temp'\?.*"
        r"give its values along the plan in \[\[channels\]\], or take the influence out"
    )
    with pytest.raises(InvalidValue, match=message):
        FilterModel.from_scenario(of)
    with pytest.raises(InvalidValue, match=message):  # before anything is computed
        AttitudeManeuverProblem(of)
    with pytest.raises(InvalidValue, match=r"gyro\.influences\[0\].*there are no \[\[channels"):
        FilterModel.from_scenario(
            dataclasses.replace(scenario((Influence("tmp", 1.0),)), channels=())
        )


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({}, "in_sunlight = None: expected a number, or a table"),
        ({"in_sunlight": 1.0, "in_shadow": 0.0}, "time_constant = None"),
        ({"times": (0.0, 1.0), "values": (1.0,)}, "values = .*expected as many as times: 2"),
        ({"times": (1.0, 1.0), "values": (1.0, 2.0)}, "times = .*expected times that increase"),
        (
            {"times": (0.0,), "values": (1.0,), "in_shadow": 2.0},
            "in_shadow = 2.0: expected nothing",
        ),
        ({"times": (0.0,), "values": (1.0,), "initial": 2.0}, "initial = 2.0: expected nothing"),
        (
            {"name": "a b", "times": (0.0,), "values": (1.0,)},
            "name = 'a b': expected a string that matches",
        ),
    ],
)
def test_what_a_channel_cannot_be(keys, message):
    with pytest.raises(InvalidValue, match=message):
        Channel(**{"name": "temp", **keys})


def test_two_channels_of_a_name_are_refused():
    with pytest.raises(InvalidValue, match=r"channels\[1\]\.name = 'temp'"):
        dataclasses.replace(scenario(), channels=(TEMP, TEMP))


@pytest.mark.parametrize("owner", [Gyro, SunSensor])
def test_an_influence_twice_is_refused(owner):
    twice = (Influence("temp", 1.0), Influence("temp", 2.0))
    with pytest.raises(InvalidValue, match=r"influences\[1\]\.channel = 'temp': expected each one"):
        owner(influences=twice)


def test_what_has_no_bias_has_nothing_that_follows():
    with pytest.raises(InvalidValue, match=r"influences\[0\].*photodiode has no bias that follows"):
        Photodiode(influences=(Influence("temp", 1.0),))
    with pytest.raises(InvalidValue, match=r"initial_sigma = 0.0: expected a number > 0"):
        Influence("temp", 0.0)
