"""Tables of plans against runs of filterpy, and counts of front points by hand."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, run_reference_filter
from mgeo_attitude.view.summaries import BOUND_RATIO_COLUMN, count_front_points

from mgeo.plugins.view import build_view

DEG = 180.0 / np.pi
#: Factors from filter units to those of the table, by column, in the order of the state.
PAPER_SIGMAS = {
    "attitude 1-sigma [deg]": DEG,
    "gyro bias 1-sigma [deg/h]": DEG * 3600.0,
    "sun misalignment 1-sigma [deg]": DEG,
    "sun bias 1-sigma [arcmin]": DEG * 60.0,
    "mag misalignment 1-sigma [deg]": DEG,
    "mag bias 1-sigma [nT]": 50e3,
}
X = np.array(
    [
        [0.5, -1.0, 0.25, 400.0, -0.125, 0.75, 1.0, 350.5, 0.0625, -0.5, 0.875, 123.4],
        [1.0, 0.0, -1.0, 900.0, 0.0, 1.0, 0.5, 0.0, -0.3, 0.2, 0.9, 700.0],
        [0.0] * 12,
    ]
)


@pytest.fixture(scope="module")
def problem():
    return AttitudeManeuverProblem()


@pytest.fixture(scope="module")
def table(problem):
    return problem.view(X).describe()


def test_table_equals_results_of_the_reference_filter(problem, table):
    for row, x in enumerate(X):
        history = run_reference_filter(problem.model, x)
        assert table.loc[row, "t_end [s]"] == history.t_end
        assert table.loc[row, "t_end [orbits]"] == pytest.approx(history.t_end / 5992.87, rel=1e-6)
        assert table.loc[row, "trace [-]"] == pytest.approx(history.trace[-1], rel=1e-9)
        worst = history.sigma[-1].reshape(6, 3).max(axis=1)
        shown = table.loc[row, list(PAPER_SIGMAS)].to_numpy(dtype=float)
        np.testing.assert_allclose(shown, worst * list(PAPER_SIGMAS.values()), rtol=1e-9)


def test_table_has_ratio_of_trace_to_lower_bound(problem, table):
    bound = problem.lower_bound
    least = np.interp(table["t_end [s]"], bound.times, bound.trace)
    np.testing.assert_allclose(table[BOUND_RATIO_COLUMN], table["trace [-]"] / least, rtol=1e-12)
    assert (table[BOUND_RATIO_COLUMN] > 1.0).all()


def test_front_points_are_counted_by_orbit():
    scenario = Scenario.paper()
    period = scenario.orbit.period
    F = [
        [1000.0, 1e-4],
        [1000.0, 1e-4],  # Duplicate point.
        [1000.0, 2e-4],  # Dominated at equal time.
        [2000.0, 1e-4],  # Dominated at equal trace.
        [period, 1e-5],  # Counts for the first orbit.
        [period + 1.0, 9e-6],
        [7000.0, 2e-5],  # Dominated.
        [9000.0, 3e-6],
        [11984.0, 2e-6],
        [np.nan, np.nan],
    ]
    expected = {"points, first orbit": 2, "points, second orbit": 3}
    assert count_front_points(scenario, F) == expected
    assert count_front_points(scenario, F[::-1]) == expected
    none = {"points, first orbit": 0, "points, second orbit": 0}
    assert count_front_points(scenario, np.empty((0, 2))) == none
    assert build_view(AttitudeManeuverProblem()).front_summary(F[8]) == {
        **none,
        "points, second orbit": 1,
    }
