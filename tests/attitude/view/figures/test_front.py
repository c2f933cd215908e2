"""The picture of the front against the objectives that it shows."""

import dataclasses
import re

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.scenario import FlightErrors, PathLimit
from mgeo_attitude.view.figures.front import front_figure
from mgeo_attitude.view.figures.solutions import Solutions
from mgeo_attitude.view.plans import spread

from mgeo.algorithms.dominance import front_rows
from mgeo.figures.style import literal
from mgeo.plugins import view_of


@pytest.fixture(scope="module")
def figure(problem, X):
    return problem.view(X).figures()["front"]


def drawn(F, **more):
    """A front figure of made-up objectives for the paper's scenario, with designs of zeros."""
    F = np.asarray(F, dtype=float)
    n = len(F)
    labels = tuple(f"solution {i}" for i in range(n))
    solutions = Solutions(np.arange(n), np.zeros((n, 12)), F, np.ones(n), labels)
    return front_figure(Scenario.paper(), solutions, **more)


def test_points_are_the_objectives(figure, F, problem):
    later = F[:, 0] > problem.scenario.orbit.period
    assert later.any()
    assert not later.all()
    first, second = figure.data[1:3]
    for trace, group in ((first, ~later), (second, later)):
        np.testing.assert_array_equal(trace.x, F[group, 0])
        np.testing.assert_array_equal(trace.y, F[group, 1])
        np.testing.assert_array_equal(trace.customdata, np.flatnonzero(group))
    assert (first.name, second.name) == ("first orbit", "second orbit")
    assert first.marker.color != second.marker.color
    assert first.marker.symbol != second.marker.symbol


def test_boundary_holds_the_nondominated_points():
    boundary = drawn([[900, 1e-4], [1500, 2e-4], [7000, 1e-5], [3000, 5e-5]]).data[0]
    np.testing.assert_array_equal(boundary.x, [900, 3000, 7000])
    np.testing.assert_array_equal(boundary.y, [1e-4, 5e-5, 1e-5])
    assert boundary.line.shape == "hv"


@pytest.mark.slow
def test_hover_text_is_the_plan(problem, X, F):
    X = X[:80]
    figure = problem.view(X).figures()["front"]
    sigma = problem.view(X).describe()["attitude 1-sigma [deg]"]
    looked_at = spread(len(X))
    assert len(looked_at) < len(X)
    kept = problem.view(X[looked_at]).promises().set_index(looked_at)
    for trace in figure.data[1:3]:
        for number, text in zip(trace.customdata, trace.hovertext, strict=True):
            head, t_end, trace_line, *flights, attitude, _, m1, m2, m3 = text.split("<br>")
            maneuvers = m1, m2, m3
            assert bool(flights) == (number in looked_at)
            for line in flights:
                found = re.fullmatch(r"9 of 10 flights keep t_end (\S+) s, trace (\S+)", line)
                assert float(found[1]) == kept["kept t_end [s]"][number]
                assert float(found[2]) == pytest.approx(kept["kept trace [-]"][number], rel=1e-3)
            assert attitude == f"attitude {sigma[number]:.3g} deg (1-sigma, worst body axis)"
            assert head == f"<b>solution {number}</b>"
            assert float(t_end.split()[1]) == F[number, 0]
            assert float(trace_line.split()[1]) == pytest.approx(F[number, 1], rel=1e-3)
            numbers = [re.findall(r"[+-]?\d+\.\d+", line) for line in maneuvers]
            shown = np.array(numbers, dtype=float).reshape(-1)
            np.testing.assert_allclose(
                shown[np.arange(12) % 4 != 3], X[number].reshape(3, 4)[:, :3].ravel(), atol=5.1e-4
            )
            np.testing.assert_allclose(shown[3::4], X[number, 3::4], atol=0.051)


def test_what_flights_keep_has_a_boundary_of_its_own(figure, problem, X):
    kept = (
        problem.view(X[spread(len(X))]).promises()[["kept t_end [s]", "kept trace [-]"]].to_numpy()
    )
    safe = kept[front_rows(kept)]
    np.testing.assert_array_equal(np.column_stack([figure.data[3].x, figure.data[3].y]), safe)
    assert figure.data[3].name == "kept by 9 of 10 flights"


def test_a_front_over_flights_is_that_of_its_own_promises(problem, X):
    own, X = AttitudeManeuverProblem(problem.scenario, flights=3), X[:20]
    F = own.evaluate(X, return_values_of=["F"])
    for trace in own.view(X).figures()["front"].data[1:3]:
        shown = np.column_stack([trace.x, trace.y])
        np.testing.assert_array_equal(shown, F[np.asarray(trace.customdata)])


def test_plans_that_do_not_converge_or_keep_no_limits_say_so():
    _, first, second, endless = drawn([[900, 1e-4], [11984, 2e-5]], longest=11984.0).data
    assert (list(first.x), list(second.x), list(endless.x)) == ([900], [], [11984])
    assert (endless.name, list(endless.customdata)) == ("not converged", [1])
    title = drawn([[900, 1e-4], [1000, 2e-5]], dead_end=True).layout.title.text
    assert "2 plans, none of which keeps all limits" in title
    assert "on the front" not in title


def test_a_problem_knows_its_dead_end_and_its_longest_run(problem, X):
    scenario = dataclasses.replace(
        problem.scenario, duration=400.0, required_sigma={"attitude_deg": 1e-4}
    )
    figure = AttitudeManeuverProblem(scenario).view(X[:3]).figures()["front"]
    assert "3 plans, none of which keeps all limits" in figure.layout.title.text
    # as do most flights of them, which is no time to be kept
    assert [len(trace.x) for trace in figure.data[1:-1]] == [0, 0, 3]


def test_no_point_is_below_what_no_maneuver_can_beat(figure, problem, X, F):
    least = figure.data[-1]
    assert least.name == "no maneuver can beat"
    assert least.x[0] < F[:, 0].min()
    assert least.x[-1] == F[:, 0].max()
    np.testing.assert_array_equal(
        least.y, np.interp(least.x, problem.limit_curves.times, problem.limit_curves.trace)
    )
    assert (F[:, 1] > np.interp(F[:, 0], least.x, least.y)).all()


def test_flights_that_begin_late_have_no_such_curve(problem, X):
    flight = FlightErrors(count=2, start_delay=60.0)
    coarse = dataclasses.replace(problem.scenario, flight=flight, step=4.0, duration=1200.0)
    late = AttitudeManeuverProblem(coarse)
    drawn = late.view(X[:3]).figures()["front"].data
    assert "no maneuver can beat" not in [trace.name for trace in drawn]


def test_axes(figure, problem):
    layout = figure.layout
    period = problem.scenario.orbit.period
    assert layout.yaxis.type == "log"
    assert layout.xaxis.title.text == "t_end [s]"
    assert layout.xaxis2.title.text == "t_end [orbits]"
    assert layout.xaxis2.matches == "x"
    assert layout.xaxis2.side == "top"
    for value, text in zip(layout.xaxis2.tickvals, layout.xaxis2.ticktext, strict=True):
        assert value == pytest.approx(float(text) * period)
    assert max(layout.xaxis2.tickvals) >= 11984.0
    # plotly draws an axis only if some trace lies on it
    assert "x2" in {trace.xaxis for trace in figure.data}
    (line,) = layout.shapes
    assert line.x0 == line.x1 == period


def test_title_counts_as_the_front_summary_does(figure, problem, F):
    first, second = view_of(problem).front_summary(F).values()
    assert f"first orbit {first}, second orbit {second};" in figure.layout.title.text


def test_longer_runs_have_later_orbits(problem, X, F):
    scenario = dataclasses.replace(problem.scenario, duration=20000.0)
    rows = np.arange(2)
    figure = front_figure(scenario, Solutions(rows, X[rows], F[rows], np.ones(2), ("a", "b")))
    assert figure.data[2].name == "later orbits"
    ticks = np.array(figure.layout.xaxis2.tickvals)
    assert len(ticks) <= 21
    assert ticks[-1] >= 20000.0


@pytest.mark.parametrize("F", [[[1000.0, 1e-4]], [[11984.0, 2e-6]]])
def test_a_single_point(F):
    figure = drawn(F)
    assert sum(len(trace.x) for trace in figure.data[1:]) == 1
    assert "<html>" in figure.to_html()


def test_names_in_a_scenario_are_no_markup():
    evil = "<a href='https://x'>%{x}</a>"
    scenario = dataclasses.replace(
        Scenario.paper(),
        name=evil,
        duration=600.0,
        path_limits=(PathLimit(name=evil, boresight=(1.0, 0.0, 0.0), half_angle_deg=20.0),),
    )
    problem = AttitudeManeuverProblem(scenario)
    X = np.array([[0.5, 0.0, 0.0, 60.0] * 3])
    front = problem.view(X).figures()["front"]
    assert f"scenario {literal(evil)}; " in front.layout.title.text
    drawn = [front, *problem.view(X).solution_figures()[0].values()]
    names = [trace.name for figure in drawn for trace in figure.data]
    assert any("&lt;a href" in (name or "") for name in names)
    assert not any("<a href" in figure.to_json() for figure in drawn)
    assert not any("\\u003ca href" in figure.to_json() for figure in drawn)
