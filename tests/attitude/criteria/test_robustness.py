"""Plans judged over flights."""

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
    """As many as a user has: what they keep is tested here."""


def scenario(**errors) -> Scenario:
    paper = Scenario.paper()
    convergence = dataclasses.replace(paper.convergence, window=60.0)
    return dataclasses.replace(
        paper, duration=900.0, convergence=convergence, monte_carlo=MonteCarloSettings(**errors)
    )


def flights(**errors):
    of = scenario(**errors)
    return draw_runs(of, FilterModel.from_scenario(of), of.monte_carlo)


def designs(n, seed=0):
    rng = np.random.default_rng(seed)
    rates, durations = rng.uniform(-1, 1, (n, 3, 3)), rng.uniform(20, 200, (n, 3, 1))
    return np.concatenate([rates, durations], axis=2).reshape(n, 12)


def test_values_are_those_of_the_reference_filter_in_each_flight():
    X = designs(2)
    problem = AttitudeManeuverProblem(
        scenario(n_runs=3, quantile=0.5, duration_error=5.0, maneuver_rate_error_deg_s=0.05)
    )
    by_hand = np.array(
        [
            [
                (run.t_end, run.trace[-1])
                for run in (run_reference_filter(f.model, x) for x in f.apply_errors(X))
            ]
            for f in problem.monte_carlo_runs
        ]
    )
    F = problem.evaluate(X, return_values_of=["F"])
    np.testing.assert_allclose(F, np.sort(by_hand, axis=0)[1], rtol=1e-9)


def test_flights_without_errors_are_the_plan():
    exact = scenario(n_runs=4, attitude_deg=0.0, rate_error_deg_s=0.0)
    X = designs(3)
    np.testing.assert_allclose(
        AttitudeManeuverProblem(exact).evaluate(X),
        AttitudeManeuverProblem(exact, n_runs=0).evaluate(X),
        rtol=1e-12,
    )


def test_a_flight_begins_from_another_attitude_by_as_much_as_is_believed():
    model = FilterModel.from_scenario(scenario())
    turns = []
    for flight in flights(n_runs=400):
        turn = Rotation.align_vectors(flight.model.references[:, 0], model.references[:, 0])
        turns.append(turn[0].as_rotvec(degrees=True))
        turned = turn[0].apply(model.references[9, 1])
        np.testing.assert_allclose(flight.model.references[9, 1], turned, atol=1e-6)
    # 1200 numbers: three standard deviations of their spread are 6 %
    assert np.std(turns) == pytest.approx(5.0, rel=0.06)


def test_rates_are_off_by_the_gyros_bias():
    added = np.array([flight.rate_errors for flight in flights(n_runs=400)])
    assert (added == added[:, :1]).all()  # the same for all maneuvers of a flight
    assert np.std(added[:, 0]) == pytest.approx(0.01, rel=0.06)


def test_noise_is_other_than_believed_by_a_factor_that_the_filter_knows():
    X, names = designs(2), ("angle_random_walk_deg_per_sqrt_h", "noise_deg", "noise_nt")
    of = scenario(n_runs=300, noise_spread=0.3)
    drawn = draw_runs(of, FilterModel.from_scenario(of), of.monte_carlo)
    for noisy, exact in zip(drawn, flights(n_runs=3), strict=False):
        np.testing.assert_array_equal(noisy.model.references, exact.model.references)
        np.testing.assert_array_equal(noisy.rate_errors, exact.rate_errors)
    believed = [of.gyro, *of.sensors]
    found = [[each.variants[0].suite.gyro, *each.variants[0].suite.sensors] for each in drawn]
    factors = [
        [
            getattr(a, name) / getattr(b, name)
            for a, b, name in zip(parts, believed, names, strict=True)
        ]
        for parts in found
    ]
    # 900 numbers: three standard deviations of their spread are 7 %
    assert np.std(np.log(factors)) == pytest.approx(0.3, rel=0.07)
    assert np.abs(np.corrcoef(np.log(factors).T)[np.triu_indices(3, 1)]).max() < 0.2
    problem = AttitudeManeuverProblem(dataclasses.replace(of, monte_carlo=None), n_runs=1)
    values = evaluate_runs(drawn[:2], X, lambda _, ran: ran.trace[:, None], 1, False)
    by_hand = [
        [run_reference_filter(f.variants[0], x).trace[-1] for x in f.apply_errors(X)]
        for f in drawn[:2]
    ]
    np.testing.assert_allclose(values[..., 0], by_hand, rtol=1e-9)
    assert not np.allclose(values[..., 0], problem.evaluate(X)[:, 1], rtol=0.05)


def test_a_delayed_run_is_a_run_of_the_scenario_that_begins_later():
    """Vectors with gradients, path limits and wheel loads, six hours along the orbit."""
    errors = {"n_runs": 1, "attitude_deg": 0.0, "start_delay": 6 * 3600.0, "seed": 1}
    wheels = {"inertia": [0.13, 0.1, 0.05], "residual_dipole": [0.01, 0.02, 0.0]}
    limit = {"reference": "earth", "sense": "keep-in", "boresight": [0.0, 0.0, 1.0]}
    of = Scenario.from_dict(
        {
            "preset": "cubesat_6u_full",
            "duration": 600.0,
            "monte_carlo": errors,
            "wheels": wheels | {"initial_momentum": [1e-3, 0.0, 0.0], "max_momentum": 0.01},
            "path_constraints": [limit | {"half_angle_deg": 179.0}],
        }
    )
    (flight,) = draw_runs(of, FilterModel.from_scenario(of), of.monte_carlo)
    later = FilterModel.from_scenario(
        dataclasses.replace(of.shift_start(flight.start_delay), monte_carlo=None)
    )
    assert flight.start_delay > 1800.0
    np.testing.assert_allclose(flight.model.references, later.references, rtol=0, atol=1e-10)
    found, expected = (evaluate(each, designs(2)) for each in (flight.model, later))
    np.testing.assert_allclose(found.path_angle, expected.path_angle, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.wheel_load, expected.wheel_load, rtol=1e-6)


def test_constraints_are_the_worst_of_the_share_of_runs_that_keeps_them():
    wheels = Wheels(inertia=(0.1, 0.2, 0.1), initial_momentum=(1e-3, 0.0, 0.0), max_momentum=0.01)
    limit = PathConstraint(boresight=(0.0, 1.0, 0.0), half_angle_deg=20.0, attitude_sigmas=1.0)
    of = dataclasses.replace(
        scenario(n_runs=4, attitude_deg=20.0, start_delay=600.0),
        wheels=wheels,
        path_constraints=(limit,),
    )
    problem, X = AttitudeManeuverProblem(of), designs(2)
    ran = [evaluate(each.model, each.apply_errors(X)) for each in problem.monte_carlo_runs]
    load = np.max([each.wheel_load[:, 0] for each in ran], axis=0) / 0.01 - 1.0
    off = 1.0 - np.min([each.path_angle[:, 0] for each in ran], axis=0) / np.radians(20.0)
    assert problem.constraint_names == ("wheel momentum", "Sun off payload")
    found = problem.evaluate(X, return_values_of=["G"])
    np.testing.assert_allclose(found, np.column_stack([load, off]), rtol=0, atol=1e-12)


def test_kept_by_is_the_least_value_that_the_share_does_not_exceed():
    values = np.random.default_rng(1).permutation(np.arange(1.0, 21.0))[:, None]
    for share, expected in ((0.9, 18.0), (1.0, 20.0), (0.05, 1.0), (0.901, 19.0)):
        assert compute_quantile(values, share) == expected
        assert (values <= expected).mean() >= share
        assert (values <= expected - 1.0).mean() < share


def test_a_lost_covariance_is_above_every_number():
    assert compute_quantile(np.array([[1.0], [np.nan], [2.0]]), 0.6) == 2.0
    assert np.isnan(compute_quantile(np.array([[1.0], [np.nan], [2.0]]), 1.0))


def test_objectives_may_be_means_and_limits_be_kept_by_some():
    values = np.arange(12.0).reshape(4, 1, 3)
    errors = MonteCarloSettings(mean=True, constraint_share=0.5)
    np.testing.assert_array_equal(reduce_runs(values, 2, errors), [[4.5, 5.5, 5.0]])


def test_promises_are_those_of_the_plan_and_of_other_flights():
    of = scenario(n_runs=4)
    problem, X = AttitudeManeuverProblem(of), designs(3)
    table = problem.view(X).compare_with_monte_carlo(n_runs=11, seed=5)
    own = problem.evaluate(X, return_values_of=["F"])
    others = dataclasses.replace(of, monte_carlo=MonteCarloSettings(n_runs=11, seed=5))
    kept = AttitudeManeuverProblem(others).evaluate(X, return_values_of=["F"])
    np.testing.assert_array_equal(table.filter(regex="^predicted"), own)
    np.testing.assert_array_equal(table.filter(regex="^Monte Carlo (?!/)"), kept)
    np.testing.assert_allclose(table.filter(regex="^Monte Carlo /"), kept / own)


@pytest.mark.parametrize(
    ("stage", "flights"),
    [
        (0, None),
        (1, 3),
        (2, 8),
    ],
)
def test_a_stage_of_a_search_has_as_many_flights_as_it_says(stage, flights):
    X = designs(3)
    problem = AttitudeManeuverProblem(scenario(n_runs=8, fidelities=(0, 3)))
    expected = AttitudeManeuverProblem(scenario(n_runs=flights or 1), n_runs=flights or 0)
    judge = problem.at_fidelity(stage)
    F = judge.evaluate(X, return_values_of=["F"])
    np.testing.assert_array_equal(F, expected.evaluate(X, return_values_of=["F"]))
    assert (judge is problem) == (stage >= 2)
    assert judge.to_options() == problem.to_options()


@pytest.mark.slow
def test_flights_after_a_calibration_are_drawn_from_its_covariance():
    """Attitude and rate errors together: off by more about an axis, and by correlated numbers."""
    of = scenario(n_runs=4000)
    sigma = FilterModel.from_scenario(of).initial_sigma
    rng = np.random.default_rng(3)
    mixed = rng.standard_normal((len(sigma), len(sigma))) + 2.0 * np.eye(len(sigma))
    scale = 0.1 * sigma / np.sqrt(np.diag(mixed @ mixed.T))
    P = scale[:, None] * (mixed @ mixed.T) * scale
    prior = Prior(
        quaternion=(0.5, -0.5, 0.5, 0.5),
        rate_deg_s=(0.1, 0.0, 0.0),
        states=np.zeros((len(sigma) // 3 - 1, 3)).tolist(),
        covariance=(0.5 * (P + P.T)).tolist(),
    )
    of = dataclasses.replace(of, prior=prior)
    model = FilterModel.from_scenario(of)
    errors = []
    for flight in draw_runs(of, model, of.monte_carlo):
        # what is seen there is what is seen from the true attitude R(-e) C
        turn, *_ = np.linalg.lstsq(model.references[:50, 1], flight.model.references[:50, 1])
        C = model.initial_attitude
        error = -Rotation.from_matrix(C @ turn.T @ C.T).as_rotvec()
        errors.append([*error, *-np.radians(flight.rate_errors[0])])
    P = P[:6, :6]
    found = np.cov(np.array(errors).T) / np.sqrt(np.outer(np.diag(P), np.diag(P)))
    expected = P / np.sqrt(np.outer(np.diag(P), np.diag(P)))
    assert np.abs(expected - np.eye(6)).max() > 0.3
    np.testing.assert_allclose(found, expected, rtol=0, atol=0.08)  # 1.6 % 1-sigma, times 5
    given = dataclasses.replace(of.monte_carlo, attitude_deg=0.0, rate_error_deg_s=0.0, n_runs=2)
    for flight in draw_runs(of, model, given):
        np.testing.assert_array_equal(flight.model.references, model.references)
        np.testing.assert_array_equal(flight.rate_errors, np.zeros((3, 3)))
