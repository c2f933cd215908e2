"""Plans evaluated over Monte Carlo runs."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    AttitudeManeuverProblem,
    FilterModel,
    Scenario,
    evaluate,
    run_reference_filter,
)
from mgeo_attitude.criteria.robustness import (
    compute_quantile,
    draw_runs,
    evaluate_runs,
    reduce_runs,
)
from mgeo_attitude.scenario import MonteCarloSettings, PathConstraint, Prior, Wheels
from scipy.spatial.transform import Rotation


@pytest.fixture(scope="module", autouse=True)
def few_flights():
    """Keep the default number of Monte Carlo runs in these tests."""


def scenario(**errors) -> Scenario:
    paper = Scenario.paper()
    convergence = dataclasses.replace(paper.convergence, window=60.0)
    return dataclasses.replace(
        paper, duration=900.0, convergence=convergence, monte_carlo=MonteCarloSettings(**errors)
    )


def draw_test_runs(**errors):
    modified_scenario = scenario(**errors)
    return draw_runs(
        modified_scenario,
        FilterModel.from_scenario(modified_scenario),
        modified_scenario.monte_carlo,
    )


def designs(n, seed=0):
    rng = np.random.default_rng(seed)
    rates, durations = rng.uniform(-1, 1, (n, 3, 3)), rng.uniform(20, 200, (n, 3, 1))
    return np.concatenate([rates, durations], axis=2).reshape(n, 12)


def test_run_values_equal_reference_filter():
    X = designs(2)
    problem = AttitudeManeuverProblem(
        scenario(n_runs=3, quantile=0.5, duration_error=5.0, maneuver_rate_error_deg_s=0.05)
    )
    expected = np.array(
        [
            [
                (run.t_end, run.trace[-1])
                for run in (run_reference_filter(f.model, x) for x in f.apply_errors(X))
            ]
            for f in problem.monte_carlo_runs
        ]
    )
    F = problem.evaluate(X, return_values_of=["F"])
    np.testing.assert_allclose(F, np.sort(expected, axis=0)[1], rtol=1e-9)


def test_runs_without_errors_equal_nominal_run():
    exact = scenario(n_runs=4, attitude_deg=0.0, rate_error_deg_s=0.0)
    X = designs(3)
    np.testing.assert_allclose(
        AttitudeManeuverProblem(exact).evaluate(X),
        AttitudeManeuverProblem(exact, n_runs=0).evaluate(X),
        rtol=1e-12,
    )


def test_initial_attitude_errors_have_initial_sigma():
    model = FilterModel.from_scenario(scenario())
    rotation_vectors = []
    for run in draw_test_runs(n_runs=400):
        rotation = Rotation.align_vectors(run.model.references[:, 0], model.references[:, 0])
        rotation_vectors.append(rotation[0].as_rotvec(degrees=True))
        rotated = rotation[0].apply(model.references[9, 1])
        np.testing.assert_allclose(run.model.references[9, 1], rotated, atol=1e-6)
    # For 1200 numbers, three standard deviations of the estimate are 6 %.
    assert np.std(rotation_vectors) == pytest.approx(5.0, rel=0.06)


def test_rate_errors_have_sigma_of_gyro_bias():
    added = np.array([run.rate_errors for run in draw_test_runs(n_runs=400)])
    assert (added == added[:, :1]).all()  # The error is common to all maneuvers of a run.
    assert np.std(added[:, 0]) == pytest.approx(0.01, rel=0.06)


def test_filter_uses_noise_levels_of_each_run():
    X, names = designs(2), ("angle_random_walk_deg_per_sqrt_h", "noise_deg", "noise_nt")
    noisy_scenario = scenario(n_runs=300, noise_spread=0.3)
    drawn = draw_runs(
        noisy_scenario, FilterModel.from_scenario(noisy_scenario), noisy_scenario.monte_carlo
    )
    for noisy, exact in zip(drawn, draw_test_runs(n_runs=3), strict=False):
        np.testing.assert_array_equal(noisy.model.references, exact.model.references)
        np.testing.assert_array_equal(noisy.rate_errors, exact.rate_errors)
    nominal = [noisy_scenario.gyro, *noisy_scenario.sensors]
    actual = [[each.variants[0].suite.gyro, *each.variants[0].suite.sensors] for each in drawn]
    factors = [
        [
            getattr(a, name) / getattr(b, name)
            for a, b, name in zip(parts, nominal, names, strict=True)
        ]
        for parts in actual
    ]
    # For 900 numbers, three standard deviations of the estimate are 7 %.
    assert np.std(np.log(factors)) == pytest.approx(0.3, rel=0.07)
    assert np.abs(np.corrcoef(np.log(factors).T)[np.triu_indices(3, 1)]).max() < 0.2
    problem = AttitudeManeuverProblem(
        dataclasses.replace(noisy_scenario, monte_carlo=None), n_runs=1
    )
    values = evaluate_runs(drawn[:2], X, lambda _, ran: ran.trace[:, None], 1, False)
    expected = [
        [run_reference_filter(f.variants[0], x).trace[-1] for x in f.apply_errors(X)]
        for f in drawn[:2]
    ]
    np.testing.assert_allclose(values[..., 0], expected, rtol=1e-9)
    assert not np.allclose(values[..., 0], problem.evaluate(X)[:, 1], rtol=0.05)


def test_delayed_run_equals_run_of_later_scenario():
    """The scenario has gradients, a path constraint and wheel loads."""
    errors = {"n_runs": 1, "attitude_deg": 0.0, "start_delay": 6 * 3600.0, "seed": 1}
    wheels = {"inertia": [0.13, 0.1, 0.05], "residual_dipole": [0.01, 0.02, 0.0]}
    limit = {"reference": "earth", "sense": "keep-in", "boresight": [0.0, 0.0, 1.0]}
    delayed_scenario = Scenario.from_dict(
        {
            "preset": "cubesat_6u_full",
            "duration": 600.0,
            "monte_carlo": errors,
            "wheels": wheels | {"initial_momentum": [1e-3, 0.0, 0.0], "max_momentum": 0.01},
            "path_constraints": [limit | {"half_angle_deg": 179.0}],
        }
    )
    (run,) = draw_runs(
        delayed_scenario, FilterModel.from_scenario(delayed_scenario), delayed_scenario.monte_carlo
    )
    later = FilterModel.from_scenario(
        dataclasses.replace(delayed_scenario.shift_start(run.start_delay), monte_carlo=None)
    )
    assert run.start_delay > 1800.0
    np.testing.assert_allclose(run.model.references, later.references, rtol=0, atol=1e-10)
    result, expected = (evaluate(each, designs(2)) for each in (run.model, later))
    np.testing.assert_allclose(result.path_angle, expected.path_angle, rtol=0, atol=1e-9)
    np.testing.assert_allclose(result.wheel_load, expected.wheel_load, rtol=1e-6)


def test_constraint_value_is_quantile_over_runs():
    wheels = Wheels(inertia=(0.1, 0.2, 0.1), initial_momentum=(1e-3, 0.0, 0.0), max_momentum=0.01)
    constraint = PathConstraint(boresight=(0.0, 1.0, 0.0), half_angle_deg=20.0, attitude_sigmas=1.0)
    modified = dataclasses.replace(
        scenario(n_runs=4, attitude_deg=20.0, start_delay=600.0),
        wheels=wheels,
        path_constraints=(constraint,),
    )
    problem, X = AttitudeManeuverProblem(modified), designs(2)
    results = [evaluate(each.model, each.apply_errors(X)) for each in problem.monte_carlo_runs]
    load = np.max([each.wheel_load[:, 0] for each in results], axis=0) / 0.01 - 1.0
    angle = 1.0 - np.min([each.path_angle[:, 0] for each in results], axis=0) / np.radians(20.0)
    assert problem.constraint_names == ("wheel momentum", "Sun off payload")
    violations = problem.evaluate(X, return_values_of=["G"])
    np.testing.assert_allclose(violations, np.column_stack([load, angle]), rtol=0, atol=1e-12)


def test_quantile_is_smallest_value_not_exceeded_in_share():
    values = np.random.default_rng(1).permutation(np.arange(1.0, 21.0))[:, None]
    for share, expected in ((0.9, 18.0), (1.0, 20.0), (0.05, 1.0), (0.901, 19.0)):
        assert compute_quantile(values, share) == expected
        assert (values <= expected).mean() >= share
        assert (values <= expected - 1.0).mean() < share


def test_nan_is_largest_value_in_quantile():
    assert compute_quantile(np.array([[1.0], [np.nan], [2.0]]), 0.6) == 2.0
    assert np.isnan(compute_quantile(np.array([[1.0], [np.nan], [2.0]]), 1.0))


def test_runs_are_reduced_to_means_and_constraint_quantiles():
    values = np.arange(12.0).reshape(4, 1, 3)
    errors = MonteCarloSettings(mean=True, constraint_share=0.5)
    np.testing.assert_array_equal(reduce_runs(values, 2, errors), [[4.5, 5.5, 5.0]])


def test_comparison_uses_predicted_values_and_independent_runs():
    nominal = scenario(n_runs=4)
    problem, X = AttitudeManeuverProblem(nominal), designs(3)
    table = problem.view(X).compare_with_monte_carlo(n_runs=11, seed=5)
    predicted = problem.evaluate(X, return_values_of=["F"])
    independent = dataclasses.replace(nominal, monte_carlo=MonteCarloSettings(n_runs=11, seed=5))
    robust = AttitudeManeuverProblem(independent).evaluate(X, return_values_of=["F"])
    np.testing.assert_array_equal(table.filter(regex="^predicted"), predicted)
    np.testing.assert_array_equal(table.filter(regex="^Monte Carlo (?!/)"), robust)
    np.testing.assert_allclose(table.filter(regex="^Monte Carlo /"), robust / predicted)


@pytest.mark.parametrize(
    ("fidelity", "n_runs"),
    [
        (0, None),
        (1, 3),
        (2, 8),
    ],
)
def test_fidelity_level_has_configured_number_of_runs(fidelity, n_runs):
    X = designs(3)
    problem = AttitudeManeuverProblem(scenario(n_runs=8, fidelities=(0, 3)))
    expected = AttitudeManeuverProblem(scenario(n_runs=n_runs or 1), n_runs=n_runs or 0)
    level_problem = problem.at_fidelity(fidelity)
    F = level_problem.evaluate(X, return_values_of=["F"])
    np.testing.assert_array_equal(F, expected.evaluate(X, return_values_of=["F"]))
    assert (level_problem is problem) == (fidelity >= 2)
    assert level_problem.to_options() == problem.to_options()


@pytest.mark.slow
def test_errors_after_calibration_follow_prior_covariance():
    """The errors of attitude and rate are correlated."""
    modified = scenario(n_runs=4000)
    sigma = FilterModel.from_scenario(modified).initial_sigma
    rng = np.random.default_rng(3)
    factor = rng.standard_normal((len(sigma), len(sigma))) + 2.0 * np.eye(len(sigma))
    scale = 0.1 * sigma / np.sqrt(np.diag(factor @ factor.T))
    P = scale[:, None] * (factor @ factor.T) * scale
    prior = Prior(
        quaternion=(0.5, -0.5, 0.5, 0.5),
        rate_deg_s=(0.1, 0.0, 0.0),
        states=np.zeros((len(sigma) // 3 - 1, 3)).tolist(),
        covariance=(0.5 * (P + P.T)).tolist(),
    )
    modified = dataclasses.replace(modified, prior=prior)
    model = FilterModel.from_scenario(modified)
    errors = []
    for run in draw_runs(modified, model, modified.monte_carlo):
        # The vectors of the run are those seen from the true attitude R(-e) C.
        rotation, *_ = np.linalg.lstsq(model.references[:50, 1], run.model.references[:50, 1])
        C = model.initial_attitude
        error = -Rotation.from_matrix(C @ rotation.T @ C.T).as_rotvec()
        errors.append([*error, *-np.radians(run.rate_errors[0])])
    P = P[:6, :6]
    covariance = np.cov(np.array(errors).T) / np.sqrt(np.outer(np.diag(P), np.diag(P)))
    expected = P / np.sqrt(np.outer(np.diag(P), np.diag(P)))
    assert np.abs(expected - np.eye(6)).max() > 0.3
    np.testing.assert_allclose(
        covariance, expected, rtol=0, atol=0.08
    )  # five times the 1-sigma of 1.6 %
    without_errors = dataclasses.replace(
        modified.monte_carlo, attitude_deg=0.0, rate_error_deg_s=0.0, n_runs=2
    )
    for run in draw_runs(modified, model, without_errors):
        np.testing.assert_array_equal(run.model.references, model.references)
        np.testing.assert_array_equal(run.rate_errors, np.zeros((3, 3)))
