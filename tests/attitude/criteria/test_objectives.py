"""Objectives, compared with the reference filter, and required 1-sigmas."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, run_reference_filter
from mgeo_attitude.maneuvers.motion import list_phases
from mgeo_attitude.scenario.actuators import Wheels
from mgeo_attitude.scenario.constraints import ManeuverBounds, PathConstraint
from mgeo_attitude.scenario.criteria import Convergence

DURATION = 900.0


def scenario(**changes):
    short = dataclasses.replace(
        Scenario.paper(), duration=DURATION, convergence=Convergence(window=60.0)
    )
    return dataclasses.replace(short, **changes)


def designs(n=6):
    rng = np.random.default_rng(3)
    X = rng.uniform(-1.0, 1.0, (n, 12))
    X[:, 3::4] = rng.uniform(20.0, 150.0, (n, 3))
    return X


def evaluate_designs(problem, X):
    return problem.evaluate(X, return_as_dictionary=True)


LIMITED = scenario(
    maneuvers=ManeuverBounds(max_acceleration_deg_s2=0.02),
    wheels=Wheels(inertia=(0.02, 0.03, 0.04), max_momentum=5e-4, max_torque=1e-5),
    path_constraints=(
        PathConstraint(boresight=(0.0, 0.0, 3.0), half_angle_deg=30.0, attitude_sigmas=0.0),
        PathConstraint(
            name="second", boresight=(1.0, -1.0, 0.0), half_angle_deg=60.0, attitude_sigmas=0.0
        ),
    ),
    required_sigma={"attitude_deg": np.degrees(0.02), "gyro.bias_deg_h": 3600 * np.degrees(1e-4)},
)


@pytest.fixture(scope="module")
def limited():
    problem = AttitudeManeuverProblem(
        LIMITED,
        objectives=(
            "t_end",
            "trace",
            "normalized_trace",
            "log_det",
            "max_eigenvalue",
            "t_required",
            "trace:attitude,gyro.bias",
        ),
    )
    X = designs()
    return (
        problem,
        X,
        evaluate_designs(problem, X),
        [run_reference_filter(problem.model, x) for x in X],
    )


def test_covariance_objectives_equal_reference(limited):
    problem, _, out, runs = limited
    sigma = problem.model.initial_sigma
    for F, run in zip(out["F"], runs, strict=True):
        scaled = run.covariance / np.outer(sigma, sigma)
        assert F[2] == pytest.approx(np.trace(scaled) / 18, rel=1e-9)
        assert F[3] == pytest.approx(np.log10(np.linalg.det(scaled)) / 18, rel=1e-9)
        assert F[4] == pytest.approx(np.linalg.eigvalsh(scaled)[-1], rel=1e-9)
        assert F[6] == pytest.approx(np.trace(run.covariance[:6, :6]), rel=1e-9)


def test_time_to_required_sigma(limited):
    _, _, out, runs = limited
    expected = []
    for run in runs:
        missed = (run.sigma[:, :3] > 0.02).any(axis=1) | (run.sigma[:, 3:6] > 1e-4).any(axis=1)
        last = np.flatnonzero(missed)[-1]
        expected.append(DURATION if last == len(missed) - 1 else run.times[last + 1])
    np.testing.assert_array_equal(out["F"][:, 5], expected)
    assert len(set(expected)) > 1


PARTLY_EXECUTED_DESIGNS = [
    # Only the last rate is executed.
    ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0], 3**0.5 * DURATION, 3**0.5),
    # The second maneuver ends before the step at which it would start.
    ([0.5, 0.0, 0.0, 100.5, -1.0, 0.0, 0.0, 0.2, 0.5, 0.0, 0.0, 50.0], 0.5 * DURATION, 0.5),
    # The last maneuver would start after the end.
    ([0.5, 0.0, 0.0, 800.0, 0.0, 0.0, 0.0, 150.0, 1.0, 0.0, 0.0, 9.0], 400.0, 1.0),
]


@pytest.mark.parametrize(("design", "angle", "rate_change"), PARTLY_EXECUTED_DESIGNS)
def test_rotation_angle_includes_only_executed_maneuvers(design, angle, rate_change):
    unconverged = scenario(convergence=Convergence(window=60.0, relative_decrease=1e-9))
    problem = AttitudeManeuverProblem(unconverged, objectives=("t_end", "angle", "rate_change"))
    F = evaluate_designs(problem, np.array([design]))["F"][0]
    assert F.tolist() == pytest.approx([DURATION, angle, rate_change], rel=1e-12)


@pytest.mark.parametrize("acceleration", [None, 0.02])
def test_rotation_angle_equals_sum_of_phases(acceleration):
    limits = ManeuverBounds(max_acceleration_deg_s2=acceleration)
    problem = AttitudeManeuverProblem(
        scenario(maneuvers=limits), objectives=("t_end", "angle", "rate_change")
    )
    X = designs(30)
    X[10:20, 3::4] *= np.random.default_rng(5).random((10, 3)) > 0.4
    X[20:, 3::4] *= 0.05
    F = evaluate_designs(problem, X)["F"]
    slew_limits = problem.model.slew_limits
    angles = [
        sum(phase.rotation_deg for phase in list_phases(x, t_end, 1.0, slew_limits))
        for x, t_end in zip(X, F[:, 0], strict=True)
    ]
    np.testing.assert_allclose(F[:, 1], angles, rtol=1e-12)
    separate = [evaluate_designs(problem, x[None])["F"][0] for x in X]
    np.testing.assert_array_equal(F, separate)  # Results do not depend on the batch.
    assert (problem.map_to_indicator_space(F) <= 1.0).all()


@pytest.mark.parametrize(
    ("objectives", "error", "message"),
    [
        (("t_end", "tracce"), ValueError, r"objectives\[1\] = 'tracce': .*did you mean 'trace'"),
        (("trace", "trace"), ValueError, r"objectives\[1\] = 'trace': expected no duplicates"),
        (("t_required",), ValueError, "no required_sigma"),
    ],
)
def test_invalid_objectives_are_rejected(objectives, error, message):
    with pytest.raises(error, match=message):
        AttitudeManeuverProblem(objectives=objectives)
    with pytest.raises(error, match=message):
        Scenario.from_dict({"preset": "paper", "objectives": objectives})


def test_required_sigma_is_converted_from_unit_of_key():
    """The filter units are rad, rad/s and 50 µT."""
    required = {
        "attitude_deg": 0.1,
        "gyro": {"bias_deg_h": 2.0},
        "sun.misalignment_deg": 0.2,
        "sun.bias": 0.003,
        "mag.bias_nt": 25.0,
    }
    table = {"preset": "paper", "required_sigma": required}
    model = AttitudeManeuverProblem(Scenario.from_dict(table)).model
    np.testing.assert_allclose(
        model.required_sigma[::3],
        [np.radians(0.1), np.radians(2.0 / 3600.0), np.radians(0.2), 0.003, np.inf, 25.0 / 50e3],
        rtol=1e-15,
    )
