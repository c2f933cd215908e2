"""Plans beside what no maneuver can beat, in words."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, NoLimit, Scenario, evaluate
from mgeo_attitude.scenario import FlightErrors
from mgeo_attitude.view.at_best import holds_over_flights, under
from mgeo_attitude.view.describe import BESIDE
from mgeo_attitude.view.plans import Plans

from mgeo.plugins.view import view_of
from mgeo.runs.answer import default_solution

DESIGN = np.array([[0.4, -0.2, 0.1, 700.0, 0.3, 0.5, -0.4, 500.0, -0.6, 0.1, 0.2, 300.0]])


def asking(**required):
    keys = {name.replace("__", "."): value for name, value in required.items()}
    table = {"preset": "paper", "step": 8.0, "convergence": {"window": 304.0}}
    return Scenario.from_dict(table | {"required_sigma": keys})


def test_what_no_maneuver_reaches_is_said_with_the_least_that_one_may():
    (line,) = view_of(AttitudeManeuverProblem(asking(sun__misalignment_deg=0.05))).impossible()
    problem = AttitudeManeuverProblem(asking(sun__misalignment_deg=0.05, mag__bias_nt=1000.0))
    assert view_of(problem).impossible() == [line]
    least = np.degrees(problem.limit_curves.sigma("sun.misalignment").min())
    assert line == (
        "required 1-sigma of sun misalignment: 0.05 deg cannot be reached within 3 h 19 min 44 s "
        f"by any maneuver: relax it to more than {np.ceil(least * 1e4) / 1e4:.4f} deg, take better "
        "sensors, or a longer duration"
    )


def test_what_one_may_reach_is_left_to_the_search():
    assert view_of(AttitudeManeuverProblem(asking(sun__misalignment_deg=0.07))).impossible() == []
    assert view_of(AttitudeManeuverProblem(Scenario.paper())).impossible() == []


def test_each_may_be_reached_and_not_both_at_once():
    """The Sun sensor is best known last; the attitude before the satellite is in the shadow."""
    table = {"preset": "cubesat_6u", "duration": 4600.0}
    curves = AttitudeManeuverProblem(Scenario.from_dict(table)).limit_curves
    attitude, sun = (np.degrees(curves.sigma(name)) for name in ("attitude", "sun.misalignment"))
    assert attitude[-1] > 1.2 * attitude.min()

    def told(attitude_deg):
        required = {"attitude_deg": attitude_deg, "sun.misalignment_deg": 1.0001 * sun[-1]}
        return view_of(
            AttitudeManeuverProblem(Scenario.from_dict(table | {"required_sigma": required}))
        ).impossible()

    assert told(1.0001 * attitude[-1]) == []
    assert told(1.0001 * attitude.min()) == [
        "required 1-sigmas of attitude and sun misalignment: each can be reached by itself, but "
        "not all at the same time by any maneuver: relax one of them"
    ]


@pytest.mark.parametrize(
    ("flight", "gyro", "holds"),
    [
        ({}, {}, True),
        ({"start_delay": 60.0}, {}, False),
        ({"noise_spread": 0.1}, {}, False),
        ({}, {"initial_scale_factor": 1e-3}, False),
    ],
)
def test_over_which_flights_the_limit_holds(flight, gyro, holds):
    scenario = dataclasses.replace(
        asking(sun__misalignment_deg=0.05), flight=FlightErrors(count=4, **flight)
    )
    scenario = dataclasses.replace(scenario, gyro=dataclasses.replace(scenario.gyro, **gyro))
    assert holds_over_flights(scenario) == holds
    problem = AttitudeManeuverProblem(scenario)
    assert bool(view_of(problem).impossible()) == holds
    curve = under(problem, np.array([800.0, 4000.0]))
    assert bool(len(curve)) == holds
    if holds:
        times, trace, sigma = curve.T
        assert (np.diff(sigma) <= 0.0).all()
        assert (times[0], times[-1]) == (640.0, 4000.0)
        assert (np.diff(trace) <= 0.0).all()


def test_no_flight_is_below_the_limit_that_is_shown_under_its_front():
    scenario = dataclasses.replace(asking(mag__bias_nt=1e4), flight=FlightErrors(count=8))
    problem = AttitudeManeuverProblem(scenario)
    times, trace, _ = under(problem, np.array([304.0, 11984.0])).T
    for flight in problem.flights:
        ran = evaluate(flight.model, flight.flown(DESIGN))
        assert ran.trace[0] > np.interp(ran.t_end[0], times, trace)


def test_remarks_tell_of_the_solution_that_is_shown_first():
    problem = AttitudeManeuverProblem(asking(mag__bias_nt=1e4), flights=0)
    designs = np.vstack([0.9 * DESIGN, DESIGN])
    told = problem.view(designs).remarks()[-2]
    F = problem.evaluate(designs, return_values_of=["F"])
    least = problem.limit_curves.trace[np.rint(F[:, 0] / 8.0).astype(int)]
    ratios = F[:, 1] / least
    first = default_solution(problem, F).row
    assert ratios[first] > ratios.min()
    assert told.startswith(f"no maneuver can have a trace of less than {least[first]:.3g} after ")
    assert f"solution {first} has {ratios[first]:.2f} times that limit" in told
    assert told.endswith(f"half of 2 plans have {np.median(ratios):.2f} times theirs or less")


def test_of_a_large_front_some_plans_are_looked_at(monkeypatch):
    problem = AttitudeManeuverProblem(asking(mag__bias_nt=1e4), flights=0)
    monkeypatch.setattr(Plans, "flights", 1)  # of so many that it would take long
    designs = np.linspace(0.2, 1.0, 130)[:, None] * DESIGN
    told = problem.view(designs).remarks()[-2]
    assert "half of 50 plans looked at have" in told
    row = int(told.partition("solution ")[2].split()[0])
    assert row == default_solution(problem, problem.evaluate(designs, return_values_of=["F"])).row
    found = problem.view(designs[[row]]).describe()[BESIDE]
    assert told.split(": ")[1].startswith(f"solution {row} has {found[0]:.2f} times")


@pytest.mark.slow
def test_a_scenario_without_a_limit_says_why_and_goes_on(monkeypatch):
    def none(*_):
        raise NoLimit("odd: what a sample tells of odd.bias depends on the attitude")

    monkeypatch.setattr("mgeo_attitude.bound.assembly.limit", none)
    problem = AttitudeManeuverProblem(asking(sun__misalignment_deg=1e-6))
    assert view_of(problem).impossible() == []
    assert problem.view(DESIGN).remarks()[-2] == (
        "how good a plan can be at best is not known: odd: what a sample tells of odd.bias depends "
        "on the attitude"
    )
    assert "no maneuver can beat" not in [
        t.name for t in problem.view(DESIGN).figures()["front"].data if t.visible
    ]
