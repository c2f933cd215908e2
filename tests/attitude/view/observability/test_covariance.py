"""Least observable directions and correlations, for constructed covariances and for a filter
run.
"""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, StarTracker, run_reference_filter
from mgeo_attitude.view.observability.covariance import (
    StateLabels,
    compute_correlations,
    find_least_observable,
    normalize_covariance,
)


def test_initial_covariance_has_remaining_share_of_one(problem):
    P0 = np.diag(problem.model.initial_sigma**2)
    np.testing.assert_allclose(normalize_covariance(problem.model, P0), np.eye(18), atol=1e-15)
    table = find_least_observable(problem.model, P0, 18)
    np.testing.assert_allclose(table["remaining [-]"], 1.0, rtol=1e-12)
    np.testing.assert_array_equal(compute_correlations(problem.model, P0), np.eye(18))


def test_single_unobserved_direction_is_found(problem):
    """All errors are reduced to a thousandth, except a rotation of the magnetometer about z by 0.4
    deg.
    """
    model = problem.model
    remaining_error = np.zeros(18)
    remaining_error[14] = np.radians(0.4)
    P = np.diag((1e-3 * model.initial_sigma) ** 2) + np.outer(remaining_error, remaining_error)
    table = find_least_observable(model, P, 2)
    assert table.loc[0, "direction"] == "mag misalignment about body z"
    # The initial 1-sigma is 1 deg.
    assert table.loc[0, "remaining [-]"] == pytest.approx(0.4, rel=1e-5)
    assert table.loc[0, "mag misalignment [deg]"] == pytest.approx(0.4, rel=1e-5)
    assert table.loc[0, "attitude [deg]"] == pytest.approx(0.0, abs=1e-12)
    assert table.loc[1, "remaining [-]"] == pytest.approx(1e-3, rel=1e-5)


def test_star_tracker_does_not_observe_common_rotation():
    """A star tracker measures only the difference of attitude and misalignment.

    With initial 1-sigmas a and m and a known difference, the variance of the common rotation is a²
    m² / (a² + m²), which is (0.1998 deg)² for 5 deg and 0.2 deg.
    """
    scenario = dataclasses.replace(
        Scenario.paper(), sensors=(StarTracker(),), duration=900.0, trace_weights={}
    )
    model = AttitudeManeuverProblem(scenario).model
    history = run_reference_filter(model, np.zeros(12))
    table = find_least_observable(model, history.covariance, 3)
    assert set(table["direction"].str.partition(" about ")[0]) == {
        "common rotation of attitude and tracker"
    }
    np.testing.assert_allclose(table["remaining [-]"], 1.0, atol=1e-3)
    remaining_error = 5.0 * 0.2 / np.hypot(5.0, 0.2)
    np.testing.assert_allclose(table["tracker misalignment [deg]"], remaining_error, rtol=1e-3)
    np.testing.assert_allclose(table["attitude [deg]"], remaining_error, rtol=1e-3)


def test_directions_have_the_variance_of_the_covariance(problem, history):
    model = problem.model
    table = find_least_observable(model, history.covariance, 18)
    remaining = table["remaining [-]"].to_numpy()
    assert (np.diff(remaining) <= 0.0).all()
    scaled = history.covariance / np.outer(model.initial_sigma, model.initial_sigma)
    assert (remaining**2).sum() == pytest.approx(np.trace(scaled), rel=1e-12)
    # The worst direction has a larger remaining variance than any single state.
    assert remaining[0] ** 2 >= np.diag(scaled).max()
    # Squared lengths of the axes of a 1-sigma ellipsoid add up to the variance.
    total = (table["attitude [deg]"].to_numpy() ** 2).sum()
    assert total == pytest.approx(np.degrees(1.0) ** 2 * np.trace(history.covariance[:3, :3]))


def test_correlations_equal_those_of_the_covariance(problem, history):
    table = compute_correlations(problem.model, history.covariance)
    names = list(StateLabels.from_suite(problem.model.suite).names)
    assert list(table.index) == list(table.columns) == names
    assert names[5] == "gyro bias z"
    np.testing.assert_array_equal(np.diag(table), 1.0)
    P = history.covariance
    expected = P[0, 6] / np.sqrt(P[0, 0] * P[6, 6])
    assert table.loc["attitude x", "sun misalignment x"] == pytest.approx(expected, rel=1e-12)
    assert table.to_numpy().min() >= -1.0
