"""The one number of the attitude against covariances whose axes are known."""

import numpy as np
import pytest
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg, attitude_sigma_deg
from scipy.spatial.transform import Rotation


def test_it_is_the_longest_axis_of_the_ellipsoid_however_that_lies():
    sigmas = np.radians([0.1, 0.3, 0.2])
    turns = Rotation.random(50, np.random.default_rng(1)).as_matrix()
    covariance = np.zeros((50, 6, 6))
    covariance[:, :3, :3] = turns @ np.diag(sigmas**2) @ turns.transpose(0, 2, 1)
    covariance[:, 3:, 3:] = 100.0 * np.eye(3)  # other states do not count
    np.testing.assert_allclose(attitude_accuracy_deg(covariance), 0.3, rtol=1e-12)
    body = attitude_sigma_deg(covariance)
    np.testing.assert_allclose(body[0], attitude_sigma_deg(covariance[0]))
    assert (body < 0.3).all()
    assert body.min() < 0.25  # the worst body axis hides a fifth of it


def test_a_lost_covariance_has_none():
    lost = np.full((2, 6, 6), np.nan)
    lost[1] = np.eye(6)
    for number in (attitude_accuracy_deg, attitude_sigma_deg):
        found = number(lost)
        assert np.isnan(found[0])
        assert found[1] == pytest.approx(np.degrees(1.0))
