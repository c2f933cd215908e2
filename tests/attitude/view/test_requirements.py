"""What is said of required 1-sigmas, against runs by other rules and from other starts."""

import dataclasses
import json
import re

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, reference_run
from mgeo_attitude.scenario import Convergence
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.plugins.view import view_of
from mgeo.runs.answer import dead_end

SHORT = {"preset": "cubesat_6u", "duration": 2400.0, "step": 4.0}
SHORT |= {"maneuvers": {"count": 3}, "convergence": {"rule": "trace"}}


def asked(required, **more):
    return AttitudeManeuverProblem(
        Scenario.from_dict({**SHORT, "required_sigma": required, **more})
    )


def designs(problem, n=6, longest=100.0):
    X = np.random.default_rng(5).uniform(problem.xl, problem.xu, (n, problem.n_var))
    X[:, 3::4] *= longest / problem.xu[3]
    return X


def told(problem, X, word):
    return [line for line in problem.view(X).remarks() if word in line]


@pytest.mark.slow
def test_plans_that_meet_what_is_required_long_before_they_end_are_told():
    problem = asked({"attitude_deg": 0.5})
    X = designs(problem)
    by_need = asked({"attitude_deg": 0.5}, convergence={"rule": "required"})
    trace, need = (each.evaluate(X, return_values_of=["F"])[:, 0] for each in (problem, by_need))
    (line,) = told(problem, X, "required_sigma")
    found = re.match(
        r"(\d) of 6 plans meet required_sigma for good before they end, the first after (\S+) s, "
        r"where the fastest ends after (\S+) s: convergence.rule = \"required\" searches for such",
        line,
    )
    assert [float(text) for text in found.groups()] == [
        (need < trace).sum(),
        need.min(),
        trace.min(),
    ]
    assert need.min() < 0.6 * trace.min()  # by how much the rule matters here
    assert told(asked({}), X, "required_sigma") == []
    assert told(by_need, X, "required_sigma") == []


def test_what_is_met_and_lost_again_is_told():
    """Near what can be reached the attitude is better and worse known by turns."""
    near = Scenario.from_dict(
        {
            **SHORT,
            "duration": 5800.0,
            "step": 10.0,
            "required_sigma": {"attitude_deg": 0.2065},
            "convergence": {"rule": "required"},
        }
    )
    problem = AttitudeManeuverProblem(near)
    X = designs(problem)[[1]]
    t_end = float(problem.evaluate(X, return_values_of=["F"])[0, 0])
    (line,) = told(problem, X, "loses it again")
    first, until = map(float, re.findall(r"(\S+) s\b", line)[:2])
    history = reference_run(problem.model.endless, X[0])
    met = np.degrees(history.sigma[:, :3].max(axis=1)) <= 0.2065
    assert (until, met[round(until / 10.0) :].all()) == (t_end, True)
    assert met[round(first / 10.0)]
    assert not met[: round(first / 10.0)].any()
    assert first < until - 300.0
    by_trace = dataclasses.replace(near, convergence=Convergence(rule="trace"))
    assert told(AttitudeManeuverProblem(by_trace), X, "loses it again") == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("required", "expected"),
    [
        (
            {"attitude_deg": 0.08},
            r"attitude: 0\.0\d+ of its (\S+) deg are an error of gyro misalignment, of which these "
            r"plans learn nothing \((9\d|100)% of its initial 1-sigma is left\)",
        ),
        (
            {"gyro.misalignment_deg": 0.02},
            r"gyro misalignment: of it these plans learn nothing \((9\d|100)% of its initial",
        ),
    ],
)
def test_an_error_that_no_turn_makes_smaller_is_named(required, expected):
    """A gyro's misalignment turns with the body: attitude and sensors hide it."""
    problem = asked(required, gyro={"initial_misalignment_deg": 0.08})
    X = designs(problem, 6, 1200.0)
    way, *relax = dead_end(problem.view(X)).ways
    assert re.match(expected, way), way
    assert re.search(r"know (gyro misalignment|it) better at the start, or relax$", way)
    assert relax[0].startswith("relax required 1-sigma of")
    # what is said is so: with half of that error the attitude is known so much better
    better = asked(required, gyro={"initial_misalignment_deg": 0.04})
    name = f"{next(iter(required)).removesuffix('_deg').replace('.', ' ')} 1-sigma [deg]"
    ratio = better.view(X).describe()[name] / problem.view(X).describe()[name]
    assert ratio.min() < 0.75


def test_what_no_sensor_has_seen_anything_of_is_no_source():
    """A Sun sensor that the Sun is never in view of: nothing is correlated with its errors."""
    blind = {"kind": "sun-sensor", "name": "sun", "half_angle_deg": 0.01}
    problem = asked({"attitude_deg": 1e-3}, sensors=[blind, {"kind": "magnetometer"}])
    X = designs(problem, n=2)
    P = problem.view(X).exactly.covariance
    place = 3 * problem.model.suite.blocks.index("sun.misalignment")
    assert (P[:, :3, place : place + 3] == 0.0).all()
    assert not any("sun" in line for line in problem.view(X).ways_out())


def test_what_more_turns_make_smaller_is_not_named():
    problem = asked({"attitude_deg": 1e-3, "mag.bias_nt": 0.1})
    X = designs(problem, 3)
    assert (problem.evaluate(X, return_values_of=["G"]) > 0.0).all()
    assert problem.view(X).ways_out() == []
    assert asked({"attitude_deg": 90.0}).view(X).ways_out() == []


def test_errors_too_large_for_the_covariance_are_told_before_and_after_a_search(tmp_path):
    large = Scenario.from_dict({**SHORT, "initial": {"attitude_deg": 30.0}})
    problem = AttitudeManeuverProblem(large)
    note = "initial.attitude_deg = 30: the linear covariance was found true up to 20"
    *assumed, line = view_of(problem).notes()
    assert assumed == list(large.assumed)
    assert line.startswith(note)
    assert line in problem.view(designs(problem, 2)).remarks()
    assert view_of(asked({})).notes() == assumed
    (tmp_path / "large.toml").write_text(large.to_toml(), encoding="utf-8")
    arguments = ["solve", "attitude", "--scenario", str(tmp_path / "large.toml"), "--dry-run"]
    shown = CliRunner().invoke(app, [*arguments, "--out", str(tmp_path / "run")]).stdout
    assert note in " ".join(shown.split())
    document = CliRunner().invoke(app, [*arguments, "--out", str(tmp_path / "run"), "--json"])
    assert json.loads(document.stdout)["notes"] == [*assumed, line]
