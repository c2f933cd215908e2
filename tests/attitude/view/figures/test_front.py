"""Figure of the front against the plotted objectives."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, evaluate
from mgeo_attitude.criteria.objectives import (
    PAPER_OBJECTIVES,
    attitude_sigma_deg,
    scale_for_indicators,
)
from mgeo_attitude.criteria.robustness import draw_runs
from mgeo_attitude.scenario import MonteCarloSettings, PathConstraint
from mgeo_attitude.view.plans import MONTE_CARLO_SHARE_TEXT, select_sample_rows

from mgeo.evaluation.dominance import find_front_rows
from mgeo.figures.style import escape_markup
from mgeo.runs.summary import find_knee


@pytest.fixture(scope="module")
def figure(problem, X):
    return problem.view(X).figures()["front"]


def find_trace(figure, name):
    (match,) = (trace for trace in figure.data if trace.name == name)
    return match


def read_trace_points(figure, name):
    """Return the points of one plotly trace after the button "trace" is pressed, shape (k, 2)."""
    index = [trace.name for trace in figure.data].index(name)
    attitude, trace = figure.layout.updatemenus[0].buttons
    assert (attitude.label, trace.label) == ("attitude", "trace")
    changes, layout = trace.args
    assert layout["yaxis.title.text"].startswith("trace")
    return np.column_stack([changes[axis][index] for axis in "xy"])


def test_points_are_objectives_and_attitude_sigma(figure, problem, X, F):
    points = find_trace(figure, "plans")
    np.testing.assert_array_equal(points.customdata, np.arange(len(X)))
    np.testing.assert_array_equal(points.x, F[:, 0] / 60.0)  # minutes
    sigma = attitude_sigma_deg(problem.view(X).nominal.covariance)
    np.testing.assert_array_equal(points.y, sigma)
    np.testing.assert_array_equal(read_trace_points(figure, "plans"), F / [60.0, 1.0])
    boundary = F[find_front_rows(F)] / [60.0, 1.0]
    np.testing.assert_array_equal(read_trace_points(figure, "boundary"), boundary)


def test_monte_carlo_values_are_marked(figure, problem, X):
    values = problem.view(X[select_sample_rows(len(X))]).monte_carlo_objectives
    np.testing.assert_array_equal(
        read_trace_points(figure, MONTE_CARLO_SHARE_TEXT), values / [60.0, 1.0]
    )


def test_labels_mark_extremes_and_knee(figure, F):
    labels = next(trace for trace in figure.data if trace.text and "min-time" in trace.text)
    assert labels.x[labels.text.index("min-time")] == F[:, 0].min() / 60.0
    assert labels.x[labels.text.index("min-trace")] == F[F[:, 1].argmin(), 0] / 60.0
    knee = find_knee(scale_for_indicators(PAPER_OBJECTIVES, F, Scenario.paper()))
    assert labels.x[labels.text.index("knee")] == F[knee, 0] / 60.0
    points = find_trace(figure, "plans")
    assert "min-time" in points.hovertext[F[:, 0].argmin()]
    assert "lower bound" in [text for trace in figure.data for text in trace.text or ()]


def test_infeasible_and_unconverged_plans_are_marked(problem, X):
    scenario = dataclasses.replace(
        problem.scenario, duration=400.0, required_sigma={"attitude_deg": 1e-4}
    )
    figure = AttitudeManeuverProblem(scenario).view(X[:3]).figures()["front"]
    assert "3 plans, none of which satisfies all constraints" in figure.layout.title.text
    # Most Monte Carlo runs do not converge either, so that no time is drawn for them.
    assert len(find_trace(figure, "not converged").x) == 3
    assert not find_trace(figure, "plans").visible


def test_no_point_is_below_the_lower_bound(figure, problem, F):
    times, least = read_trace_points(figure, "lower bound").T
    t_end = F[:, 0] / 60.0
    assert times[0] < t_end.min()
    assert times[-1] == t_end.max()
    bound = problem.lower_bound
    np.testing.assert_array_equal(least, np.interp(times, bound.times / 60.0, bound.trace))
    assert (F[:, 1] > np.interp(t_end, times, least)).all()


def test_attitude_sigma_is_quantile_over_monte_carlo_runs(problem, X):
    """The runs are evaluated one by one."""
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


def test_names_of_scenario_are_escaped():
    markup = "<a href='https://x'>%{x}</a>"
    scenario = dataclasses.replace(
        Scenario.paper(),
        name=markup,
        duration=600.0,
        path_constraints=(
            PathConstraint(name=markup, boresight=(1.0, 0.0, 0.0), half_angle_deg=20.0),
        ),
    )
    problem = AttitudeManeuverProblem(scenario)
    X = np.array([[0.5, 0.0, 0.0, 60.0] * 3])
    front = problem.view(X).figures()["front"]
    assert f"scenario {escape_markup(markup)}, " in front.layout.title.text
    figures = [front, *problem.view(X).solution_figures()[0].values()]
    names = [trace.name for figure in figures for trace in figure.data]
    assert any("&lt;a href" in (name or "") for name in names)
    assert not any("<a href" in figure.to_json() for figure in figures)
    assert not any("\\u003ca href" in figure.to_json() for figure in figures)
