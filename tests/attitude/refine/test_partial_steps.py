"""Maneuvers that end within filter steps."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.maneuvers.schedule import compute_maneuver_steps, decode_designs
from mgeo_attitude.refine.evaluators import (
    build_fixed_time_evaluator,
    merge_partial_steps,
    round_to_steps,
)


def compute_step_rates(designs, step, n_steps):
    """Return the rate of each design in each step, shape (n, n_steps, 3)."""
    rates, durations = decode_designs(designs)
    starts, _ = compute_maneuver_steps(durations, step)
    return np.array(
        [
            design_rates[np.searchsorted(first, np.arange(n_steps), side="right") - 1]
            for design_rates, first in zip(rates, starts, strict=True)
        ]
    )


@pytest.mark.parametrize("step", [0.1, 1.0, 7.0])
def test_each_step_has_its_mean_rate(step):
    rng = np.random.default_rng(3)
    designs = rng.random((40, 20))
    designs[:, 3::4] *= 12.0 * step
    designs[:8, 7::8] = 0.0  # These maneuvers have no duration.
    designs[8:16, 3::4] *= 0.1  # Several maneuvers end in one step.
    designs[16:24, 3::4] = step * np.round(designs[16:24, 3::4] / step)
    n, fine = 40, 1000
    rates, durations = decode_designs(designs)
    ends = np.cumsum(durations, axis=1) / step
    middles = (np.arange(n * fine) + 0.5) / fine
    expected = np.array(
        [
            design_rates[np.minimum(np.searchsorted(each, middles, side="right"), 4)]
            for design_rates, each in zip(rates, ends, strict=True)
        ]
    )
    expected = expected.reshape(40, n, fine, 3).mean(axis=2)
    np.testing.assert_allclose(
        compute_step_rates(merge_partial_steps(designs, step), step, n),
        expected,
        atol=6.0 / fine * 0.02,
    )


def test_maneuvers_that_end_on_steps_are_unchanged():
    designs = np.array([[0.3, 0.0, 0.1, 4.0, 0.0, 0.2, 0.0, 6.0, -0.1, 0.0, 0.0, 2.0]])
    merged = merge_partial_steps(designs, 2.0)
    assert merged.shape == (1, 20)
    np.testing.assert_array_equal(
        compute_step_rates(merged, 2.0, 9), compute_step_rates(designs, 2.0, 9)
    )
    np.testing.assert_array_equal(merge_partial_steps(designs[:, :4], 2.0), designs[:, :4])


@pytest.mark.parametrize("step", [1.0, 4.0])
def test_maneuver_ends_are_rounded_to_nearest_steps(step):
    short = {"preset": "paper", "duration": 1200.0, "step": step}
    evaluator = build_fixed_time_evaluator(AttitudeManeuverProblem(Scenario.from_dict(short)))
    designs = np.random.default_rng(4).random((50, 20)) * 40.0
    rounded = round_to_steps(evaluator, designs)
    ends = np.cumsum(designs[:, 3::4], axis=1) / step
    starts, ends_step = compute_maneuver_steps(rounded[:, 3::4], step)
    np.testing.assert_array_equal(np.column_stack([starts[:, 1:], ends_step]), np.rint(ends))
    np.testing.assert_array_equal(
        np.delete(rounded, np.s_[3::4], 1), np.delete(designs, np.s_[3::4], 1)
    )
