"""Conversion of designs to maneuvers and filter steps."""

import numpy as np
import pytest
from mgeo_attitude.maneuvers.schedule import (
    UNREACHED_STEP,
    build_rate_intervals,
    compute_maneuver_steps,
    decode_designs,
)


def test_decode_designs_returns_radians_and_seconds():
    rates, durations = decode_designs([180.0, 0.0, -90.0, 10.0, 0.0, 36.0, 0.0, 0.5])
    np.testing.assert_allclose(rates, [[[np.pi, 0, -np.pi / 2], [0, np.pi / 5, 0]]])
    np.testing.assert_array_equal(durations, [[10.0, 0.5]])


@pytest.mark.parametrize(
    ("design", "message"),
    [
        ([1.0, 2.0, 3.0], r"shape \(3,\).*4 columns"),
        ([0.0, 0.0, 0.0, -1.0], r"design 0.*-1\.0.*durations >= 0"),
        ([[0.0, 0.0, 0.0, 1.0], [np.nan, 0.0, 0.0, 1.0]], r"design 1.*nan"),
        ([[[0.0, 0.0, 0.0, 1.0]]], "expected 4 columns"),
    ],
)
def test_error_names_invalid_design(design, message):
    with pytest.raises(ValueError, match=message):
        decode_designs(design)


@pytest.mark.parametrize(
    ("durations", "step", "starts", "end"),
    [
        ([0.0, 0.0, 0.0], 1.0, [0, 0, 0], 0),
        ([0.2, 0.2, 0.2], 1.0, [0, 1, 1], 1),  # The second maneuver ends before its first step.
        ([1.5, 1.5, 0.1], 1.0, [0, 2, 3], 4),
        ([10.0, 20.0, 5.0], 5.0, [0, 2, 6], 7),
        ([5.0, 1e300, 1e300], 1.0, [0, 5, UNREACHED_STEP], UNREACHED_STEP),
    ],
)
def test_maneuver_begins_at_first_step_at_or_after_its_start(durations, step, starts, end):
    first_steps, last_end = compute_maneuver_steps(np.array([durations]), step)
    np.testing.assert_array_equal(first_steps, [starts])
    np.testing.assert_array_equal(last_end, [end])


def test_rate_intervals_omit_skipped_maneuvers_and_end_with_run():
    design = [0.5, 0, 0, 100.0, 0, -1.0, 0, 0.0, 0, 0, 0.25, 50.5]
    intervals = build_rate_intervals(design, 900.0, 1.0)
    assert intervals.maneuver_numbers.tolist() == [
        0,
        2,
    ]  # The second maneuver ends before its first step.
    assert intervals.times.tolist() == [0.0, 100.0, 900.0]
    assert np.degrees(intervals.rates) == pytest.approx(np.array([[0.5, 0, 0], [0, 0, 0.25]]))
    assert intervals.maneuver_end == 151.0
    cut = build_rate_intervals(
        design, 100.0, 1.0
    )  # The third maneuver would begin at the end of the run.
    assert cut.maneuver_numbers.tolist() == [0]
    assert cut.times.tolist() == [0.0, 100.0]
    assert cut.maneuver_end == 100.0
