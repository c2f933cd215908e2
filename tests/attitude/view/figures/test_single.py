"""Figures of single plans, against the problem's own numbers and the reference filter."""

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
def short():
    return AttitudeManeuverProblem(dataclasses.replace(Scenario.paper(), duration=2400.0))


def test_curves_are_those_of_the_reference_filter(short, X):
    plan = ManeuverPlan.from_design(short, X[0])
    (figures,) = short.view(X[:1]).solution_figures()
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
            assert figures[name].layout.yaxis.title.text in (final["unit"], "")


def test_rates_step_where_the_plan_says(short, X):
    plan = ManeuverPlan.from_design(short, X[0])
    (figures,) = short.view(X[:1]).solution_figures()
    timeline = plan.build_timeline()
    for axis, line in zip("xyz", figures["rates"].data[:3], strict=True):
        held = line.y[np.searchsorted(line.x, timeline["start [s]"], side="right") - 1]
        np.testing.assert_allclose(held, timeline[f"rate {axis} [deg/s]"], atol=1e-12)


def test_a_ramp_is_a_straight_line(X):
    scenario = Scenario.paper()
    maneuvers = dataclasses.replace(scenario.maneuvers, max_acceleration_deg_s2=0.02)
    problem = AttitudeManeuverProblem(dataclasses.replace(scenario, maneuvers=maneuvers))
    (figures,) = problem.view(X[:1]).solution_figures()
    plan = problem.model.build_schedule(X[:1])
    flown = plan.has_duration()[0]
    starts, rates = plan.starts[0, flown], np.degrees(plan.rates[0, flown])
    for axis in range(3):
        line = figures["rates"].data[axis]
        assert len(line.x) < 12
        middle = (starts + 0.5) * problem.model.step
        before = middle < line.x[-1]
        seen = np.interp(middle[before], line.x, line.y)
        np.testing.assert_allclose(seen, rates[before, axis], atol=0.002 * np.ptp(line.y) + 1e-6)


def test_directions_are_the_environment_seen_from_the_body(short, X):
    plan = ManeuverPlan.from_design(short, X[0])
    (figures,) = short.view(X[:1]).solution_figures()
    field = next(trace for trace in figures["directions"].data if trace.name == "field")
    body = np.einsum(
        "kij,kj->ki", plan.history.attitude, short.environment.field[: len(plan.history.times)]
    )
    for index, step in ((0, 0), (-1, -1)):
        across, up = project_directions(body[[step]])
        np.testing.assert_allclose([field.x[index], field.y[index]], [across[0], up[0]], atol=1)


def test_the_shadow_of_the_earth_is_shaded_and_the_sun_is_not_drawn_in_it(X):
    scenario = dataclasses.replace(Scenario.paper(), duration=4000.0, eclipse=True)
    problem = AttitudeManeuverProblem(scenario)
    (figures,) = problem.view(X[:1]).solution_figures()
    environment = problem.environment
    shaded = np.zeros(len(environment.times), dtype=bool)
    for shape in figures["rates"].layout.shapes:
        shaded |= (environment.times >= shape.x0) & (environment.times < shape.x1)
    dark = ~environment.sunlit
    assert 0 < dark[:-1].sum() < len(dark) - 1
    np.testing.assert_array_equal(shaded[:-1], dark[:-1])  # the last has no stretch after it
    traces = {trace.name: trace for trace in figures["directions"].data}
    flown = dark[: int(figures["trace"].data[0].x[-1]) + 1]
    share = len(traces["Sun"].x) / len(traces["field"].x)
    assert share == pytest.approx(1.0 - flown.mean(), abs=0.02)


def test_the_map_has_equal_areas_and_its_axes_where_they_belong():
    across, up = project_directions(np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 5], [np.nan, 0, 0]]))
    assert (across[0], up[0], up[1], across[2]) == (0, 0, 0, 0)
    assert across[1] > 0
    assert up[2] == 5000
    vectors = np.random.default_rng(1).normal(size=(40_000, 3))
    across, up = project_directions(vectors)
    inner = (across / 5000.0) ** 2 + (up / 2500.0) ** 2 < 1.0  # a quarter of the ellipse
    assert inner.mean() == pytest.approx(0.25, abs=0.01)
    assert (np.abs(across) <= MAP_HALF_SIZE[0]).all()
    assert len(draw_graticule()) == 2


def test_corners_of_a_polyline_are_found():
    x = np.arange(101.0)
    curves = np.column_stack([np.interp(x, [0, 20, 100], [0, 5, 5]), np.abs(x - 70.0), 0.0 * x])
    assert simplify_curves(x, curves, 4).tolist() == [0, 20, 70, 100]
    assert len(simplify_curves(x, np.sin(x)[:, None], 30)) == 30
    assert simplify_curves(np.array([1.0]), np.ones((1, 2)), 9).tolist() == [0]
