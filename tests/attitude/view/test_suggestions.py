"""Suggestions for required 1-sigmas that plans miss because of an unobserved error."""

import re

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario

from mgeo.runs.summary import explain_infeasibility

SHORT = {"preset": "cubesat_6u", "duration": 2400.0, "step": 4.0}
SHORT |= {"maneuvers": {"count": 3}, "convergence": {"rule": "trace"}}


def build_problem(required, **more):
    return AttitudeManeuverProblem(
        Scenario.from_dict({**SHORT, "required_sigma": required, **more})
    )


def random_designs(problem, n=6, longest=100.0):
    X = np.random.default_rng(5).uniform(problem.xl, problem.xu, (n, problem.n_var))
    X[:, 3::4] *= longest / problem.xu[3]
    return X


@pytest.mark.slow
@pytest.mark.parametrize(
    ("required", "expected"),
    [
        (
            {"attitude_deg": 0.08},
            r"Required 1-sigma of attitude: gyro misalignment .*\((9\d|100) % of",
        ),
        (
            {"gyro.misalignment_deg": 0.02},
            r"Required 1-sigma of gyro misalignment: gyro misalignment .*\((9\d|100) % of",
        ),
    ],
)
def test_unobservable_error_is_named_as_cause(required, expected):
    """A misalignment of the gyro rotates with the body, so that attitude and sensors hide it."""
    problem = build_problem(required, gyro={"initial_misalignment_deg": 0.08})
    X = random_designs(problem, 6, 1200.0)
    suggestion, *relaxations = explain_infeasibility(problem.view(X), 960).suggestions
    assert re.match(expected, suggestion), suggestion
    assert relaxations[0].startswith("Relax 1-sigma of")
    # With half of that error, the required 1-sigma is clearly smaller.
    better = build_problem(required, gyro={"initial_misalignment_deg": 0.04})
    name = f"{next(iter(required)).removesuffix('_deg').replace('.', ' ')} 1-sigma [deg]"
    ratio = better.view(X).describe()[name] / problem.view(X).describe()[name]
    assert ratio.min() < 0.75


def test_observable_errors_are_not_named():
    problem = build_problem({"attitude_deg": 1e-3, "mag.bias_nt": 0.1})
    X = random_designs(problem, 3)
    assert (problem.evaluate(X, return_values_of=["G"]) > 0.0).all()
    assert problem.view(X).suggestions() == []
    assert build_problem({"attitude_deg": 90.0}).view(X).suggestions() == []
