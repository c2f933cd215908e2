"""Scalar measures of attitude accuracy."""

import numpy as np
import pytest
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg, attitude_sigma_deg
from scipy.spatial.transform import Rotation


def test_attitude_accuracy_is_longest_axis_of_error_ellipsoid():
    sigmas = np.radians([0.1, 0.3, 0.2])
    rotations = Rotation.random(50, np.random.default_rng(1)).as_matrix()
    covariance = np.zeros((50, 6, 6))
    covariance[:, :3, :3] = rotations @ np.diag(sigmas**2) @ rotations.transpose(0, 2, 1)
    covariance[:, 3:, 3:] = 100.0 * np.eye(3)  # Other states must not matter.
    np.testing.assert_allclose(attitude_accuracy_deg(covariance), 0.3, rtol=1e-12)
    body_sigma = attitude_sigma_deg(covariance)
    np.testing.assert_allclose(body_sigma[0], attitude_sigma_deg(covariance[0]))
    assert (body_sigma < 0.3).all()
    assert body_sigma.min() < 0.25  # The worst body axis can be a fifth smaller.


def test_nan_covariance_gives_nan_accuracy():
    covariance = np.full((2, 6, 6), np.nan)
    covariance[1] = np.eye(6)
    for measure in (attitude_accuracy_deg, attitude_sigma_deg):
        accuracy = measure(covariance)
        assert np.isnan(accuracy[0])
        assert accuracy[1] == pytest.approx(np.degrees(1.0))
