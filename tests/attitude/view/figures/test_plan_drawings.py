"""Small figures of single plans against results of the problem and of the reference filter."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.view.figures.curves import (
    MAP_HALF_SIZE,
    draw_graticule,
    project_directions,
    simplify_curves,
)


@pytest.fixture(scope="module")
def short_problem():
    return AttitudeManeuverProblem(dataclasses.replace(Scenario.paper(), duration=2400.0))


def test_curves_equal_those_of_the_reference_filter(short_problem, X):
    plan = ManeuverPlan.from_design(short_problem, X[0])
    (figures,) = short_problem.view(X[:1]).solution_figures()
    history = plan.history
    trace = figures["trace"].data[0]
    steps = plan.to_steps(trace.x)
    assert (steps[0], trace.x[-1]) == (0, plan.t_end)
    np.testing.assert_allclose(trace.y, history.trace[steps], rtol=1e-6)
    accuracy = plan.build_accuracy_table()
    for name in ("attitude", "gyro bias", "mag bias"):
        for line in figures[name].data:
            final = accuracy.loc[f"{name} {line.name}"]
            np.testing.assert_allclose(line.y[-1], final["after"], rtol=1e-6)
            assert f"[{final['unit']}]" in figures[name].layout.yaxis.title.text


def test_rates_change_at_phases_of_timeline(short_problem, X):
    plan = ManeuverPlan.from_design(short_problem, X[0])
    (figures,) = short_problem.view(X[:1]).solution_figures()
    timeline = plan.build_timeline()
    for axis, line in zip("xyz", figures["rates"].data[:3], strict=True):
        drawn_rates = line.y[np.searchsorted(line.x, timeline["start [s]"], side="right") - 1]
        np.testing.assert_allclose(drawn_rates, timeline[f"rate {axis} [deg/s]"], atol=1e-12)


def test_ramp_is_drawn_as_straight_line(X):
    scenario = Scenario.paper()
    maneuvers = dataclasses.replace(scenario.maneuvers, max_acceleration_deg_s2=0.02)
    problem = AttitudeManeuverProblem(dataclasses.replace(scenario, maneuvers=maneuvers))
    (figures,) = problem.view(X[:1]).solution_figures()
    schedule = problem.model.build_schedule(X[:1])
    has_duration = schedule.has_duration()[0]
    starts, rates = schedule.starts[0, has_duration], np.degrees(schedule.rates[0, has_duration])
    for axis in range(3):
        line = figures["rates"].data[axis]
        assert len(line.x) < 12
        middle = (starts + 0.5) * problem.model.step
        before = middle < line.x[-1]
        seen = np.interp(middle[before], line.x, line.y)
        np.testing.assert_allclose(seen, rates[before, axis], atol=0.002 * np.ptp(line.y) + 1e-6)


def test_field_direction_is_in_body_axes(short_problem, X):
    plan = ManeuverPlan.from_design(short_problem, X[0])
    (figures,) = short_problem.view(X[:1]).solution_figures()
    field = next(trace for trace in figures["directions"].data if trace.name == "magnetic field")
    body = np.einsum(
        "kij,kj->ki",
        plan.history.attitude,
        short_problem.environment.field[: len(plan.history.times)],
    )
    for index, step in ((0, 0), (-1, -1)):
        across, up = project_directions(body[[step]])
        np.testing.assert_allclose([field.x[index], field.y[index]], [across[0], up[0]], atol=1)


def test_eclipses_are_shaded_and_have_no_sun_points(X):
    scenario = dataclasses.replace(Scenario.paper(), duration=4000.0, eclipse=True)
    problem = AttitudeManeuverProblem(scenario)
    (figures,) = problem.view(X[:1]).solution_figures()
    environment = problem.environment
    shaded = np.zeros(len(environment.times), dtype=bool)
    for shape in figures["rates"].layout.shapes:
        shaded |= (environment.times >= shape.x0) & (environment.times < shape.x1)
    dark = ~environment.sunlit
    assert 0 < dark[:-1].sum() < len(dark) - 1
    np.testing.assert_array_equal(shaded[:-1], dark[:-1])  # No interval follows the last step.
    traces = {trace.name: trace for trace in figures["directions"].data}
    dark_until_end = dark[: int(figures["trace"].data[0].x[-1]) + 1]
    share = len(traces["Sun"].x) / len(traces["magnetic field"].x)
    assert share == pytest.approx(1.0 - dark_until_end.mean(), abs=0.02)


def test_map_has_equal_areas_and_correct_axes():
    across, up = project_directions(np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 5], [np.nan, 0, 0]]))
    assert (across[0], up[0], up[1], across[2]) == (0, 0, 0, 0)
    assert across[1] > 0
    assert up[2] == 5000
    vectors = np.random.default_rng(1).normal(size=(40_000, 3))
    across, up = project_directions(vectors)
    inner = (across / 5000.0) ** 2 + (up / 2500.0) ** 2 < 1.0  # A quarter of the area of the map.
    assert inner.mean() == pytest.approx(0.25, abs=0.01)
    assert (np.abs(across) <= MAP_HALF_SIZE[0]).all()
    assert len(draw_graticule()) == 2


def test_simplification_finds_corners():
    x = np.arange(101.0)
    curves = np.column_stack([np.interp(x, [0, 20, 100], [0, 5, 5]), np.abs(x - 70.0), 0.0 * x])
    assert simplify_curves(x, curves, 4).tolist() == [0, 20, 70, 100]
    assert len(simplify_curves(x, np.sin(x)[:, None], 30)) == 30
    assert simplify_curves(np.array([1.0]), np.ones((1, 2)), 9).tolist() == [0]
