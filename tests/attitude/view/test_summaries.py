"""Summaries of plans whose end the design determines."""

import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.view.plans import MONTE_CARLO_SHARE_TEXT

from mgeo._text import format_two_digits


@pytest.mark.parametrize("objectives", [["t_end", "trace"], ["t_end", "trace", "rate_change"]])
def test_summary_of_fixed_end_has_attitude_sigma_over_monte_carlo_runs(objectives):
    table = {"preset": "cubesat_6u", "duration": 600.0, "maneuvers": {"count": 1}}
    scenario = Scenario.from_dict(table | {"objectives": objectives})
    view = AttitudeManeuverProblem(scenario).view([[1.0, 0.2, -0.5, 60.0], [1.0, 0.2, -0.5, 599.0]])
    assert view.nominal.t_end.tolist() == [60.0, 599.0]
    for line, sigma in zip(view.summaries(), view.monte_carlo_sigma_deg, strict=True):
        assert line.endswith(
            f"attitude {format_two_digits(sigma)} deg or less in {MONTE_CARLO_SHARE_TEXT}"
        )
        assert "onverge" not in line
