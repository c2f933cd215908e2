"""The picture of the front against the objectives that it shows."""

import dataclasses
import re
from datetime import timedelta

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, evaluate
from mgeo_attitude.criteria.objectives import attitude_sigma_deg
from mgeo_attitude.criteria.robustness import draw_flights
from mgeo_attitude.scenario import FlightErrors, PathLimit, Window
from mgeo_attitude.view.figures.front import front_figure
from mgeo_attitude.view.figures.style import Solutions
from mgeo_attitude.view.plans import spread

from mgeo.evaluation.dominance import front_rows
from mgeo.figures.style import literal
from mgeo.plugins.view import view_of


@pytest.fixture(scope="module")
def figure(problem, X):
    return problem.view(X).figures()["front"]


def named(figure, name):
    (found,) = (trace for trace in figure.data if trace.name == name)
    return found


def drawn(F, **more):
    """A front figure of made-up objectives for the paper's scenario, with designs of zeros."""
    F = np.asarray(F, dtype=float)
    n = len(F)
    labels = tuple(f"solution {i}" for i in range(n))
    solutions = Solutions(np.arange(n), np.zeros((n, 12)), F, np.ones(n), labels)
    return front_figure(Scenario.paper(), solutions, **more)


@pytest.mark.slow
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
                found = re.fullmatch(
                    r"9 of 10 Monte Carlo samples keep t_end (\S+) s, trace (\S+), "
                    r"attitude \S+ deg",
                    line,
                )
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
    drawn = named(figure, "kept by 9 of 10 Monte Carlo samples")
    np.testing.assert_array_equal(np.column_stack([drawn.x, drawn.y]), safe)


@pytest.mark.slow
def test_a_front_over_flights_is_that_of_its_own_promises(problem, X):
    own, X = AttitudeManeuverProblem(problem.scenario, flights=3), X[:20]
    F = own.evaluate(X, return_values_of=["F"])
    for trace in own.view(X).figures()["front"].data[1:3]:
        shown = np.column_stack([trace.x, trace.y])
        np.testing.assert_array_equal(shown, F[np.asarray(trace.customdata)])


def test_plans_that_do_not_converge_or_keep_no_limits_say_so():
    _, first, second, endless, *_ = drawn([[900, 1e-4], [11984, 2e-5]], longest=11984.0).data
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
    assert len(named(figure, "not converged").x) == 3
    assert not named(figure, "plans").showlegend


def test_no_point_is_below_what_no_maneuver_can_beat(figure, problem, X, F):
    least = named(figure, "no maneuver can beat")
    assert least.x[0] < F[:, 0].min()
    assert least.x[-1] == F[:, 0].max()
    np.testing.assert_array_equal(
        least.y, np.interp(least.x, problem.limit_curves.times, problem.limit_curves.trace)
    )
    assert (F[:, 1] > np.interp(F[:, 0], least.x, least.y)).all()


@pytest.mark.slow
def test_flights_that_begin_late_have_no_such_curve(problem, X):
    flight = FlightErrors(count=2, start_delay=60.0)
    coarse = dataclasses.replace(problem.scenario, flight=flight, step=4.0, duration=1200.0)
    late = AttitudeManeuverProblem(coarse)
    drawn = late.view(X[:3]).figures()["front"]
    assert named(drawn, "no maneuver can beat").visible is False


@pytest.fixture(scope="module")
def engineers(problem, X):
    """Six plans of a satellite with a requirement and a window, and its problem."""
    window = Window(
        start=problem.scenario.epoch, end=problem.scenario.epoch + timedelta(seconds=3000.0)
    )
    scenario = dataclasses.replace(
        problem.scenario, required_sigma={"attitude_deg": 1.0}, windows=(window,)
    )
    of = AttitudeManeuverProblem(scenario)
    return of, of.view(X[:6]).figures()["front"]


@pytest.mark.slow
def test_requirements_are_drawn_in_degrees_with_the_window_and_the_knee(engineers, X):
    problem, figure = engineers
    points, required = named(figure, "plans"), named(figure, "required, 1 deg")
    sigma = problem.view(X[:6]).describe()["attitude 1-sigma [deg]"]
    np.testing.assert_allclose(points.y, sigma[points.customdata])
    assert "[deg]" in figure.layout.yaxis.title.text
    assert list(required.y) == [1.0, 1.0]
    assert required.visible
    texts = [note.text for note in figure.layout.annotations]
    assert "window closes" in texts
    assert figure.layout.xaxis.range[1] > 3000.0
    knee = named(figure, "knee")
    assert (knee.x[0], knee.y[0]) in list(zip(points.x, points.y, strict=True))
    least = named(figure, "no maneuver can beat")
    limit = np.degrees(problem.limit_curves.sigma("attitude"))
    np.testing.assert_array_equal(least.y, np.interp(least.x, problem.limit_curves.times, limit))


def test_a_button_shows_the_trace_instead(engineers, X):
    problem, figure = engineers
    attitude, trace = figure.layout.updatemenus[0].buttons
    assert (attitude.label, trace.label) == ("attitude", "trace")
    changes, layout, where = trace.args
    assert list(where) == list(range(len(figure.data)))
    place = [each.name for each in figure.data].index("plans")
    F = problem.view(X[:6]).promised
    np.testing.assert_array_equal(changes["y"][place], F[figure.data[place].customdata, 1])
    assert layout["yaxis.title.text"].startswith("trace")
    assert layout["yaxis.tickvals"] is None
    required = [each.name for each in figure.data].index("required, 1 deg")
    assert attitude.args[0]["visible"][required]
    assert not changes["visible"][required]


def test_what_flights_keep_of_the_attitude_is_that_of_each_flight(problem, X):
    """Against one flight after another, each by itself."""
    view = problem.view(X[:2])
    errors = dataclasses.replace(FlightErrors(), count=20, seed=FlightErrors().seed + 1)
    sigma = [
        attitude_sigma_deg(evaluate(each.model, each.flown(X[:2]), 1, covariance=True).covariance)
        for each in draw_flights(problem.scenario, problem.model, errors)
    ]
    np.testing.assert_array_equal(view.kept_sigma_deg, np.sort(sigma, axis=0)[17])


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
    # to where plans end, not to the end of the run
    last = max(max(trace.x) for trace in figure.data if len(trace.x))
    assert last < layout.xaxis.range[1] < 1.1 * last
    assert max(layout.xaxis2.tickvals) >= layout.xaxis.range[1]
    # plotly draws an axis only if some trace lies on it
    assert "x2" in {trace.xaxis for trace in figure.data}
    (line,) = layout.shapes
    assert line.x0 == line.x1 == period


def test_title_counts_as_the_front_summary_does(figure, problem, F):
    first, second = view_of(problem).front_summary(F).values()
    said = f"first orbit {first}" + (f", second orbit {second}" if second else "")
    assert f"{said};" in figure.layout.title.text
    both = drawn([[900, 1e-4], [7000, 1e-5], [8000, 1e-6]]).layout.title.text
    assert "first orbit 1, second orbit 2;" in both


def test_longer_runs_have_later_orbits(problem, X, F):
    scenario = dataclasses.replace(problem.scenario, duration=20000.0)
    rows = np.arange(2)
    figure = front_figure(scenario, Solutions(rows, X[rows], F[rows], np.ones(2), ("a", "b")))
    assert figure.data[2].name == "later orbits"
    assert len(figure.layout.xaxis2.tickvals) <= 22


@pytest.mark.parametrize("F", [[[1000.0, 1e-4]], [[11984.0, 2e-6]]])
def test_a_single_point(F):
    figure = drawn(F)
    assert sum(len(trace.x) for trace in figure.data[1:]) == 1
    assert "orbit 0" not in figure.layout.title.text
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
