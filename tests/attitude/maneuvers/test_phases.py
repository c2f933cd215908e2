"""Phases of a plan, by hand."""

import numpy as np
import pytest
from mgeo_attitude.maneuvers.actuation import SlewLimits
from mgeo_attitude.maneuvers.motion import HOLD_LABEL, list_phases


def seen(design, t_end, step=1.0):
    return [(p.label, p.start, p.end, p.rates_deg_s) for p in list_phases(design, t_end, step)]


def test_maneuvers_then_the_last_rate_held():
    design = [0.3, 0, 0, 100.0, 0, -0.6, 0.8, 50.5]
    assert seen(design, 900.0) == [
        ("maneuver 1", 0.0, 100.0, (0.3, 0.0, 0.0)),
        ("maneuver 2", 100.0, 151.0, (0.0, -0.6, 0.8)),  # ends at the next step
        (HOLD_LABEL, 151.0, 900.0, (0.0, -0.6, 0.8)),
    ]
    second = list_phases(design, 900.0, 1.0)[1]
    assert second.duration == 51.0
    assert second.rotation_deg == pytest.approx(51.0, rel=1e-15)


def test_a_run_that_ends_with_the_maneuvers_holds_nothing():
    assert [label for label, *_ in seen([0.3, 0, 0, 100.0], 100.0)] == ["maneuver 1"]
    assert seen([0.3, 0, 0, 100.0], 40.0) == [("maneuver 1", 0.0, 40.0, (0.3, 0.0, 0.0))]


def test_no_maneuver_at_all_is_a_rate_held():
    assert seen([0.3, 0, 0, 0.0, 0, 0, 0, 0.0], 40.0) == [(HOLD_LABEL, 0.0, 40.0, (0.0, 0.0, 0.0))]


def test_what_is_not_flown_leaves_its_number_out():
    design = [0.1, 0, 0, 100.0, 0.2, 0, 0, 0.0, 0.3, 0, 0, 0.0]
    assert seen(design, 400.0) == [
        ("maneuver 1", 0.0, 100.0, (0.1, 0.0, 0.0)),
        (HOLD_LABEL, 100.0, 400.0, (0.3, 0.0, 0.0)),
    ]


def test_ramps_are_phases_of_their_own():
    """0.02 deg/s²: 20 s from rest to 0.4 deg/s, then 25 s down, cut short at 10 s."""
    slow = SlewLimits(np.radians(0.02), np.inf, np.eye(3))
    design = [0.4, 0.0, 0.0, 100.0, -0.1, 0.0, 0.0, 10.0, 0.495, 0.0, 0.0, 50.0]
    found = list_phases(design, 200.0, 1.0, slow)
    assert [(p.label, p.start, p.end) for p in found] == [
        ("ramp to maneuver 1", 0.0, 20.0),
        ("maneuver 1", 20.0, 100.0),
        ("ramp to maneuver 2", 100.0, 110.0),
        ("ramp to maneuver 3", 110.0, 125.0),
        ("maneuver 3", 125.0, 160.0),
        (HOLD_LABEL, 160.0, 200.0),
    ]
    assert found[0].rates_deg_s == pytest.approx((0.2, 0.0, 0.0))
    assert found[0].rotation_deg == pytest.approx(0.2 * 20.0)
    assert found[2].rates_deg_s == pytest.approx((0.3, 0.0, 0.0))  # from 0.4 to 0.2 deg/s
