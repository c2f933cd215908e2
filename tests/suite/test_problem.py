"""Suites compared with the attitude problem with the same sensors, and with explicit sums."""

import dataclasses
import itertools
import pickle

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, FilterModel, evaluate
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.scenario import Convergence
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_suite import SensorSuiteProblem
from mgeo_suite.catalog import FaceSunSensor
from pymoo.optimize import minimize

from mgeo import MGEODirected
from mgeo.algorithms.variables import convert_numbers_to_designs
from mgeo.testing import check_problem

from ..three import three


def test_problem_follows_the_plugin_protocol(problem):
    check_problem(problem, n_points=6)


def build_scenario(problem, choice):
    """Return the scenario with the gyro and the sensors of a choice only."""
    gyro, *sensors = (p.instruments[i] for p, i in zip(problem.suites.places, choice, strict=True))
    present = tuple(sensor for sensor in sensors if sensor is not None)
    return dataclasses.replace(problem.scenario, gyro=gyro, sensors=present)


CHOICES = [(0, 0, 0, 0, 0), (1, 1, 1, 2, 1), (0, 1, 0, 0, 2), (1, 0, 1, 0, 0)]


@pytest.mark.parametrize("choice", CHOICES)
def test_objectives_equal_those_of_the_attitude_problem(problem, points, choice):
    """The attitude problem uses a filter kernel that is compiled for the sensors of the suite."""
    X = points.copy()
    X[:, :5] = choice
    plans = X[:, 5:]
    F = problem.evaluate(X)
    attitude_problem = AttitudeManeuverProblem(build_scenario(problem, choice))
    expected = attitude_problem.evaluate(plans)
    assert np.array_equal(F[:, 4], expected[:, 0])
    assert F[:, 5] == pytest.approx(expected[:, 1], rel=1e-9)
    covariance = evaluate(attitude_problem.model, plans, covariance=True).covariance
    assert F[:, 3] == pytest.approx(attitude_accuracy_deg(covariance), rel=1e-9)


def test_resources_are_sums_over_the_instruments(problem, table, points):
    sections = ["gyros", "magnetometers", "star_trackers", "sun_sensors", "sun_sensors"]
    keys = ["price_keur", "mass_g", "power_mw"]
    sizes = [range(len(place.options)) for place in problem.suites.places]
    for choice in itertools.product(*sizes):
        total = np.zeros(3)
        for section, place, number in zip(sections, problem.suites.places, choice, strict=True):
            index = number - (place.options[0] == "none")
            if index >= 0:
                total += [table[section][index][key] for key in keys]
        assert problem.suites.compute_resources(np.array([choice]))[0] == pytest.approx(total)
    X = points[:3]
    assert problem.evaluate(X)[:, :3] == pytest.approx(
        problem.suites.compute_resources(X[:, :5].astype(int))
    )


def test_designs_as_numbers_and_as_dicts_are_equivalent(problem, points):
    designs = convert_numbers_to_designs(problem, points)
    assert designs[0]["gyro"] in ("poor", "good")
    assert np.array_equal(problem.evaluate(designs), problem.evaluate(points))
    assert np.array_equal(problem.encode_designs(designs), points)
    assert np.array_equal(problem.encode_designs([dict(designs[0])]), points[:1])


def test_objectives_do_not_depend_on_batch_or_threads(problem, points):
    copied = pickle.loads(pickle.dumps(problem))
    expected = problem.evaluate(points)
    for threads in (1, 3):
        copied.threads = threads
        for rows in np.array_split(np.arange(len(points))[::-1], 7):
            assert np.array_equal(copied.evaluate(points[rows]), expected[rows])
    rebuilt = SensorSuiteProblem.from_options(problem.to_options())
    assert np.array_equal(rebuilt.evaluate(points), expected)


@pytest.mark.slow
def test_bias_states_of_a_sun_sensor_are_optional():
    with_bias = FaceSunSensor(name="a", initial_bias=0.02, half_angle_deg=60.0)
    without_bias = dataclasses.replace(with_bias, initial_bias=0.0)
    assert list(with_bias.states()) == ["misalignment", "bias"]
    assert list(without_bias.states()) == ["misalignment"]
    scenario = dataclasses.replace(
        three("cubesat_6u"), duration=600.0, step=10.0, sensors=(without_bias,)
    )
    small_bias = dataclasses.replace(
        scenario, sensors=(dataclasses.replace(with_bias, initial_bias=1e-9),)
    )
    X = np.array([[0.3, 0.2, -0.4, 200.0] * 3])
    a, b = (
        evaluate(FilterModel.from_scenario(s), X, covariance=True) for s in (scenario, small_bias)
    )
    assert a.covariance[0, :3, :3] == pytest.approx(b.covariance[0, :3, :3], rel=1e-9)


@pytest.mark.slow
def test_search_finds_cheapest_and_most_accurate_suites(problem):
    """The reference is the best of 40 random plans of each suite, for the median of three runs."""
    suite_problem = SensorSuiteProblem(problem.scenario, problem.catalog, ("price", "attitude"))
    sizes = [range(len(place.options)) for place in suite_problem.suites.places]
    rng, best = np.random.default_rng(2), {}
    for choice in itertools.product(*sizes):
        X = np.tile([*choice, *np.zeros(12)], (40, 1))
        X[:, 5:] = rng.uniform(-1.0, 1.0, (40, 12))
        X[:, 8::4] = rng.uniform(0.0, 300.0, (40, 3))
        price, accuracy = suite_problem.evaluate(X).T
        best[price[0]] = min(best.get(price[0], np.inf), accuracy.min())
    ratios = []
    for seed in (1, 2, 3):
        F = minimize(suite_problem, MGEODirected(), ("n_eval", 4000), seed=seed).F
        assert F[:, 0].min() == min(best)
        ratios.append(max(F[F[:, 0] <= price, 1].min() / best[price] for price in best))
    assert np.median(ratios) <= 1.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"objectives": ["prize"]}, r"objectives\[0\] = 'prize': unknown objective; did you mean"),
        ({"objectives": ["t_required"]}, "the scenario has no required_sigma"),
        ({"scenario": 3}, "scenario = 3: expected a table"),
        ({"scenario": {"preset": "paper", "step": -1.0}}, r"scenario\.step = -1\.0: expected"),
        (
            {"scenario": {"preset": "paper", "required_sigma": {"sun.bias": 1.0}}},
            r"required_sigma.sun.bias = 1.0: expected a state of the attitude, the gyro",
        ),
        (
            {"scenario": {"preset": "paper", "monte_carlo": {"n_runs": 3}}},
            "monte_carlo = .*nominal run",
        ),
    ],
)
def test_error_names_the_invalid_option(changes, message):
    with pytest.raises(InvalidValue, match=message):
        SensorSuiteProblem.from_options(changes)


def test_invalid_designs_are_refused(problem, points):
    X = points[:2].copy()
    X[1, 0] = 2.0
    with pytest.raises(
        ValueError, match=r"gyro = 2\.0: expected an integer from 0 to 1, which selects one of poor"
    ):
        problem.view(X).describe()
    with pytest.raises(ValueError, match=r"X of shape \(2, 5\): expected \(n, 17\)"):
        problem.view(X[:, :5]).describe()
    X[1, 0] = np.nan
    with pytest.raises(ValueError, match=r"gyro = nan: expected an integer"):
        problem.split_designs(X)
    (design,) = convert_numbers_to_designs(problem, points[:1])
    for wrong, message in (
        ({**design, "gyro": "none"}, "gyro = 'none': unknown option"),
        ({**design, "gyro": ["poor"]}, r"gyro = \['poor'\]: unknown option"),
        ({"gyro": "poor"}, r"\{'gyro': 'poor'\}: expected a dict of \['gyro', 'magnetometer'"),
        (3, r"3: expected a dict of"),
    ):
        with pytest.raises(ValueError, match=message):
            problem.split_designs(np.array([wrong], dtype=object))


def test_overview_lists_maneuvers_until_the_end_of_the_plan(problem, points):
    """The duration of the scenario bounds the plan, and required 1-sigmas have a time."""
    scenario = dataclasses.replace(
        problem.scenario, convergence=Convergence(rule="end"), required_sigma={"attitude_deg": 50.0}
    )
    suites = SensorSuiteProblem(scenario, problem.suites.catalog, ["price", "t_required"])
    x = points[0].copy()
    durations = x[suites.n_var - 4 * scenario.maneuvers.count :][3::4]
    durations[:] = 800.0
    view = suites.view([x])
    shown = view.overview()["maneuvers"].table
    assert shown["duration [s]"].tolist() == [800.0, 400.0]
    front = view.front_table()
    assert front["ends after [s]"].tolist() == [scenario.duration]
    assert front["requirement met after [s]"].tolist() == view.evaluation.t_required.tolist()
