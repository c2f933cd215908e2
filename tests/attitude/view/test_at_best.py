"""Plans beside what no maneuver can beat, in words."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, evaluate
from mgeo_attitude.scenario import MonteCarloSettings
from mgeo_attitude.view.lower_bound import compute_bound_curves, is_valid_for_monte_carlo

from mgeo.plugins.view import build_view

DESIGN = np.array([[0.4, -0.2, 0.1, 700.0, 0.3, 0.5, -0.4, 500.0, -0.6, 0.1, 0.2, 300.0]])


def asking(**required):
    keys = {name.replace("__", "."): value for name, value in required.items()}
    table = {"preset": "paper", "step": 8.0, "convergence": {"window": 304.0}}
    return Scenario.from_dict(table | {"required_sigma": keys})


def test_what_no_maneuver_reaches_is_said_with_the_least_that_one_may():
    (line,) = build_view(
        AttitudeManeuverProblem(asking(sun__misalignment_deg=0.05))
    ).infeasibility_reasons()
    problem = AttitudeManeuverProblem(asking(sun__misalignment_deg=0.05, mag__bias_nt=1000.0))
    assert build_view(problem).infeasibility_reasons() == [line]
    least = np.degrees(problem.lower_bound.compute_sigma("sun.misalignment").min())
    assert line == (
        "required 1-sigma of sun misalignment: 0.05 deg cannot be reached within 3 h 19 min 44 s "
        f"by any maneuver: relax it to more than {np.ceil(least * 1e4) / 1e4:.4f} deg, take better "
        "sensors, or a longer duration"
    )


def test_what_one_may_reach_is_left_to_the_search():
    assert (
        build_view(
            AttitudeManeuverProblem(asking(sun__misalignment_deg=0.07))
        ).infeasibility_reasons()
        == []
    )
    assert build_view(AttitudeManeuverProblem(Scenario.paper())).infeasibility_reasons() == []


@pytest.mark.parametrize(
    ("monte_carlo", "gyro", "holds"),
    [
        ({}, {}, True),
        ({"start_delay": 60.0}, {}, False),
        ({"noise_spread": 0.1}, {}, False),
        ({}, {"initial_scale_factor": 1e-3}, False),
    ],
)
def test_over_which_flights_the_limit_holds(monte_carlo, gyro, holds):
    scenario = dataclasses.replace(
        asking(sun__misalignment_deg=0.05), monte_carlo=MonteCarloSettings(n_runs=4, **monte_carlo)
    )
    scenario = dataclasses.replace(scenario, gyro=dataclasses.replace(scenario.gyro, **gyro))
    assert is_valid_for_monte_carlo(scenario) == holds
    problem = AttitudeManeuverProblem(scenario)
    assert bool(build_view(problem).infeasibility_reasons()) == holds
    curve = compute_bound_curves(problem, np.array([800.0, 4000.0]))
    assert bool(len(curve)) == holds
    if holds:
        times, trace, sigma = curve.T
        assert (np.diff(sigma) <= 0.0).all()
        assert (times[0], times[-1]) == (640.0, 4000.0)
        assert (np.diff(trace) <= 0.0).all()


def test_no_flight_is_below_the_limit_that_is_shown_under_its_front():
    scenario = dataclasses.replace(
        asking(mag__bias_nt=1e4), monte_carlo=MonteCarloSettings(n_runs=8)
    )
    problem = AttitudeManeuverProblem(scenario)
    times, trace, _ = compute_bound_curves(problem, np.array([304.0, 11984.0])).T
    for flight in problem.monte_carlo_runs:
        ran = evaluate(flight.model, flight.apply_errors(DESIGN))
        assert ran.trace[0] > np.interp(ran.t_end[0], times, trace)
