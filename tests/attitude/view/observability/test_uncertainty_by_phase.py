"""Uncertainty by phase against the covariance history."""

import numpy as np
import pytest
from mgeo_attitude.view.observability.error_budget import compute_uncertainty_by_phase


def test_rows_are_ends_of_phases(problem, design, history):
    table = compute_uncertainty_by_phase(problem.model, design, history)
    assert list(table.index) == ["start", "maneuver 1", "maneuver 3", "constant-rate hold"]
    assert table["time [s]"].tolist() == [0.0, 200.0, 351.0, history.t_end]
    np.testing.assert_array_equal(table["trace [-]"], history.trace[[0, 200, 351, -1]])
    attitude = table["attitude y [deg]"].to_numpy()
    assert attitude[0] == pytest.approx(5.0, rel=1e-12)
    np.testing.assert_allclose(attitude, np.degrees(history.sigma[[0, 200, 351, -1], 1]))
    np.testing.assert_allclose(
        table["mag bias x [nT]"], 50e3 * history.sigma[[0, 200, 351, -1], 15], rtol=1e-14
    )
