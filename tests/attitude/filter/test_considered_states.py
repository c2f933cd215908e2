"""Update of the reference filter with considered states, compared with Joseph's form."""

import numpy as np
import pytest
from mgeo_attitude.filter.reference import update_with_considered_states


@pytest.mark.parametrize("considered", [[], [3, 4, 5, 9]])
def test_considered_states_have_zero_gain_and_constant_covariance(considered):
    rng = np.random.default_rng(0)
    root, H = rng.standard_normal((12, 12)), rng.standard_normal((3, 12))
    P, R = root @ root.T, np.diag(rng.uniform(0.1, 1.0, 3))
    K = P @ H.T @ np.linalg.inv(R + H @ P @ H.T)
    K[considered] = 0.0
    error_transition = np.eye(12) - K @ H
    updated = update_with_considered_states(P, H, R, np.array(considered, dtype=int))
    np.testing.assert_allclose(
        updated, error_transition @ P @ error_transition.T + K @ R @ K.T, rtol=1e-10, atol=1e-10
    )
    block = np.ix_(considered, considered)
    np.testing.assert_array_equal(updated[block], P[block])
