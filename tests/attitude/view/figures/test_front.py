"""The picture of the front against the objectives that it shows."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, evaluate
from mgeo_attitude.criteria.objectives import attitude_sigma_deg
from mgeo_attitude.criteria.robustness import draw_runs
from mgeo_attitude.scenario import MonteCarloSettings, PathConstraint
from mgeo_attitude.view.plans import select_sample_rows

from mgeo.evaluation.dominance import find_front_rows
from mgeo.figures.style import escape_markup


@pytest.fixture(scope="module")
def figure(problem, X):
    return problem.view(X).figures()["front"]


def named(figure, name):
    (found,) = (trace for trace in figure.data if trace.name == name)
    return found


def by_trace(figure, name):
    """Return points of a trace of the figure, shape (k, 2), once its button shows the trace."""
    place = [trace.name for trace in figure.data].index(name)
    attitude, trace = figure.layout.updatemenus[0].buttons
    assert (attitude.label, trace.label) == ("attitude", "trace")
    changes, layout = trace.args
    assert layout["yaxis.title.text"].startswith("trace")
    return np.column_stack([changes[axis][place] for axis in "xy"])


def test_points_are_the_objectives_and_the_attitude(figure, problem, X, F):
    points = named(figure, "plans")
    np.testing.assert_array_equal(points.customdata, np.arange(len(X)))
    np.testing.assert_array_equal(points.x, F[:, 0])
    sigma = attitude_sigma_deg(problem.view(X).nominal.covariance)
    np.testing.assert_array_equal(points.y, sigma)
    np.testing.assert_array_equal(by_trace(figure, "plans"), F)
    np.testing.assert_array_equal(by_trace(figure, "boundary"), F[find_front_rows(F)])


def test_what_flights_keep_has_a_boundary_of_its_own(figure, problem, X):
    kept = problem.view(X[select_sample_rows(len(X))]).monte_carlo_objectives
    drawn = by_trace(figure, "in 9 of 10 Monte Carlo runs")
    np.testing.assert_array_equal(drawn, kept[find_front_rows(kept)])


def test_a_problem_knows_its_dead_end_and_its_longest_run(problem, X):
    scenario = dataclasses.replace(
        problem.scenario, duration=400.0, required_sigma={"attitude_deg": 1e-4}
    )
    figure = AttitudeManeuverProblem(scenario).view(X[:3]).figures()["front"]
    assert "3 plans, none of which satisfies all constraints" in figure.layout.title.text
    # as do most flights of them, which is no time to be kept
    assert len(named(figure, "not converged").x) == 3
    assert not named(figure, "plans").visible


def test_no_point_is_below_what_no_maneuver_can_beat(figure, problem, F):
    times, least = by_trace(figure, "lower bound").T
    assert times[0] < F[:, 0].min()
    assert times[-1] == F[:, 0].max()
    limit = problem.lower_bound
    np.testing.assert_array_equal(least, np.interp(times, limit.times, limit.trace))
    assert (F[:, 1] > np.interp(F[:, 0], times, least)).all()


def test_what_flights_keep_of_the_attitude_is_that_of_each_flight(problem, X):
    """Against one flight after another, each by itself."""
    view = problem.view(X[:2])
    errors = dataclasses.replace(
        MonteCarloSettings(), n_runs=20, seed=MonteCarloSettings().seed + 1
    )
    sigma = [
        attitude_sigma_deg(
            evaluate(each.model, each.apply_errors(X[:2]), 1, covariance=True).covariance
        )
        for each in draw_runs(problem.scenario, problem.model, errors)
    ]
    np.testing.assert_array_equal(view.monte_carlo_sigma_deg, np.sort(sigma, axis=0)[17])


def test_names_in_a_scenario_are_no_markup():
    evil = "<a href='https://x'>%{x}</a>"
    scenario = dataclasses.replace(
        Scenario.paper(),
        name=evil,
        duration=600.0,
        path_constraints=(
            PathConstraint(name=evil, boresight=(1.0, 0.0, 0.0), half_angle_deg=20.0),
        ),
    )
    problem = AttitudeManeuverProblem(scenario)
    X = np.array([[0.5, 0.0, 0.0, 60.0] * 3])
    front = problem.view(X).figures()["front"]
    assert f"scenario {escape_markup(evil)}; " in front.layout.title.text
    drawn = [front, *problem.view(X).solution_figures()[0].values()]
    names = [trace.name for figure in drawn for trace in figure.data]
    assert any("&lt;a href" in (name or "") for name in names)
    assert not any("<a href" in figure.to_json() for figure in drawn)
    assert not any("\\u003ca href" in figure.to_json() for figure in drawn)
