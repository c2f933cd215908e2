"""Figures of single plans, against the problem's own numbers and the reference filter."""

import base64
import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.view.figures.curves import OUTLINE, corners, graticule, projected

from mgeo.report.solutions import figure_json


@pytest.fixture(scope="module")
def short():
    return AttitudeManeuverProblem(dataclasses.replace(Scenario.paper(), duration=2400.0))


def test_drawings_are_the_figures(short, X):
    """As a page gets them, to the last byte of every curve."""
    (trees,), (figures,) = short.view(X[:1]).drawings(), short.view(X[:1]).solution_figures()
    assert trees.keys() == figures.keys()
    for name, tree in trees.items():
        drawn, said = figure_json(figures[name]), figure_json(tree)
        for one, other in zip(said["data"], drawn["data"], strict=True):
            for key in one.keys() - {"x", "y", "z"}:
                assert one[key] == other[key]
            for key in one.keys() & {"x", "y", "z"}:
                np.testing.assert_array_equal(numbers(one[key]), numbers(other[key]))


def numbers(packed):
    if not isinstance(packed, dict):
        return np.array(packed, dtype=float)
    return np.frombuffer(base64.b64decode(packed["bdata"]), packed["dtype"]).astype(float)


def test_curves_are_those_of_the_reference_filter(short, X):
    plan = ManeuverPlan.from_design(short, X[0])
    (figures,) = short.view(X[:1]).solution_figures()
    history = plan.history
    trace = figures["trace"].data[0]
    steps = plan.steps(trace.x)
    assert (steps[0], trace.x[-1]) == (0, plan.t_end)
    np.testing.assert_allclose(trace.y, history.trace[steps], rtol=1e-6)
    accuracy = plan.accuracy()
    for name in ("attitude", "gyro bias", "mag bias"):
        for line in figures[name].data:
            final = accuracy.loc[f"{name} {line.name}"]
            np.testing.assert_allclose(line.y[-1], final["after"], rtol=1e-6)
            assert figures[name].layout.yaxis.title.text in (final["unit"], "")


def test_rates_step_where_the_plan_says(short, X):
    plan = ManeuverPlan.from_design(short, X[0])
    (figures,) = short.view(X[:1]).solution_figures()
    timeline = plan.timeline()
    for axis, line in zip("xyz", figures["rates"].data[:3], strict=True):
        held = line.y[np.searchsorted(line.x, timeline["start [s]"], side="right") - 1]
        np.testing.assert_allclose(held, timeline[f"rate {axis} [deg/s]"], atol=1e-12)


def test_a_ramp_is_a_straight_line(X):
    scenario = Scenario.paper()
    maneuvers = dataclasses.replace(scenario.maneuvers, max_acceleration_deg_s2=0.02)
    problem = AttitudeManeuverProblem(dataclasses.replace(scenario, maneuvers=maneuvers))
    (figures,) = problem.view(X[:1]).solution_figures()
    plan = problem.model.schedule(X[:1])
    flown = plan.flown()[0]
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
        across, up = projected(body[[step]])
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
    across, up = projected(np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 5], [np.nan, 0, 0]]))
    assert (across[0], up[0], up[1], across[2]) == (0, 0, 0, 0)
    assert across[1] > 0
    assert up[2] == 5000
    vectors = np.random.default_rng(1).normal(size=(40_000, 3))
    across, up = projected(vectors)
    inner = (across / 5000.0) ** 2 + (up / 2500.0) ** 2 < 1.0  # a quarter of the ellipse
    assert inner.mean() == pytest.approx(0.25, abs=0.01)
    assert (np.abs(across) <= OUTLINE[0]).all()
    assert len(graticule()) == 2


def test_figures_of_a_front_are_small(short, X):
    sizes = [
        sum(
            np.size(trace.x) + np.size(trace.y)
            for name, figure in figures.items()
            if name != "motion"  # only its turns differ from plan to plan
            for trace in figure.data
        )
        for figures in short.view(X[:3]).solution_figures()
    ]
    assert max(sizes) < 4000


def test_few_samples_draw_the_curves(short, X):
    plan = ManeuverPlan.from_design(short, X[0])
    (figures,) = short.view(X[:1]).solution_figures()
    for name, exact in (("trace", plan.history.trace), ("attitude", None)):
        line = figures[name].data[0]
        if exact is None:
            factor = line.y[0] / plan.history.sigma[0, 0]
            exact = plan.history.sigma[:, 0] * factor
        drawn = np.interp(plan.history.times, line.x, np.log10(line.y))
        off = np.abs(drawn - np.log10(exact)) / np.ptp(np.log10(exact))
        assert off.max() < 0.06
        assert len(line.x) == 48


def test_corners_of_a_polyline_are_found():
    x = np.arange(101.0)
    curves = np.column_stack([np.interp(x, [0, 20, 100], [0, 5, 5]), np.abs(x - 70.0), 0.0 * x])
    assert corners(x, curves, 4).tolist() == [0, 20, 70, 100]
    assert len(corners(x, np.sin(x)[:, None], 30)) == 30
    assert corners(np.array([1.0]), np.ones((1, 2)), 9).tolist() == [0]
