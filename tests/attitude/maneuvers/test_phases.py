"""Phases of a plan, against phases computed by hand."""

import numpy as np
import pytest
from mgeo_attitude.maneuvers.actuation import SlewLimits
from mgeo_attitude.maneuvers.motion import HOLD_LABEL, list_phases


def summarize_phases(design, t_end, step=1.0):
    return [(p.label, p.start, p.end, p.rates_deg_s) for p in list_phases(design, t_end, step)]


def test_maneuvers_are_followed_by_constant_rate_hold():
    design = [0.3, 0, 0, 100.0, 0, -0.6, 0.8, 50.5]
    assert summarize_phases(design, 900.0) == [
        ("maneuver 1", 0.0, 100.0, (0.3, 0.0, 0.0)),
        ("maneuver 2", 100.0, 151.0, (0.0, -0.6, 0.8)),  # The maneuver ends at the next step.
        (HOLD_LABEL, 151.0, 900.0, (0.0, -0.6, 0.8)),
    ]
    second = list_phases(design, 900.0, 1.0)[1]
    assert second.duration == 51.0
    assert second.rotation_deg == pytest.approx(51.0, rel=1e-15)


def test_run_that_ends_with_maneuvers_has_no_hold():
    assert [label for label, *_ in summarize_phases([0.3, 0, 0, 100.0], 100.0)] == ["maneuver 1"]
    assert summarize_phases([0.3, 0, 0, 100.0], 40.0) == [
        ("maneuver 1", 0.0, 40.0, (0.3, 0.0, 0.0))
    ]


def test_maneuvers_without_duration_give_hold_only():
    assert summarize_phases([0.3, 0, 0, 0.0, 0, 0, 0, 0.0], 40.0) == [
        (HOLD_LABEL, 0.0, 40.0, (0.0, 0.0, 0.0))
    ]


def test_skipped_maneuvers_keep_numbers_of_others():
    design = [0.1, 0, 0, 100.0, 0.2, 0, 0, 0.0, 0.3, 0, 0, 0.0]
    assert summarize_phases(design, 400.0) == [
        ("maneuver 1", 0.0, 100.0, (0.1, 0.0, 0.0)),
        (HOLD_LABEL, 100.0, 400.0, (0.3, 0.0, 0.0)),
    ]


def test_ramps_are_separate_phases():
    """At 0.02 deg/s², 0.4 deg/s take 20 s; the second ramp of 25 s is cut short at 10 s."""
    slow = SlewLimits(np.radians(0.02), np.inf, np.eye(3))
    design = [0.4, 0.0, 0.0, 100.0, -0.1, 0.0, 0.0, 10.0, 0.495, 0.0, 0.0, 50.0]
    phases = list_phases(design, 200.0, 1.0, slow)
    assert [(p.label, p.start, p.end) for p in phases] == [
        ("ramp to maneuver 1", 0.0, 20.0),
        ("maneuver 1", 20.0, 100.0),
        ("ramp to maneuver 2", 100.0, 110.0),
        ("ramp to maneuver 3", 110.0, 125.0),
        ("maneuver 3", 125.0, 160.0),
        (HOLD_LABEL, 160.0, 200.0),
    ]
    assert phases[0].rates_deg_s == pytest.approx((0.2, 0.0, 0.0))
    assert phases[0].rotation_deg == pytest.approx(0.2 * 20.0)
    assert phases[2].rates_deg_s == pytest.approx((0.3, 0.0, 0.0))  # from 0.4 to 0.2 deg/s
