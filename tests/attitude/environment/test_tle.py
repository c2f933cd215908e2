"""SGP4 and its frame, compared with the verification output of its authors.

Values: Vallado, Crawford, Hujsak & Kelso, Revisiting Spacetrack Report #3 (AIAA 2006-6753), its
test output tcppver.out and (for J2000) Vallado, Fundamentals of Astrodynamics, section 3.7.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import erfa
import numpy as np
import pytest
from mgeo_attitude.environment.element_set import TLEOrbit, compute_gcrs_states, compute_teme_states
from mgeo_attitude.environment.times import JulianDates, compute_julian_dates
from sgp4.api import Satrec

VANGUARD_1 = (
    "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753",
    "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667",
)
MOLNIYA_2_14 = (  # deep-space orbit with 12 h resonance
    "1 08195U 75081A   06176.33215444  .00000099  00000-0  11873-3 0   813",
    "2 08195  64.1586 279.0717 6877146 264.7651  20.2257  2.00491383225656",
)


def satellite(lines: tuple[str, str]) -> Satrec:
    return TLEOrbit(line1=lines[0], line2=lines[1]).build_satellite()


def compute_dates_after_epoch(lines: tuple[str, str], minutes: list[float]) -> JulianDates:
    year, day = 2000 + int(lines[0][18:20]), float(lines[0][20:32])
    epoch = datetime(year, 1, 1, tzinfo=UTC) + timedelta(days=day - 1.0)
    return compute_julian_dates(epoch, 60.0 * np.array(minutes))


@pytest.mark.parametrize(
    ("lines", "minutes", "position", "velocity"),
    [
        (
            VANGUARD_1,
            [0.0, 360.0, 4320.0],
            [
                [7022.46529266, -1400.08296755, 0.03995155],
                [-7154.03120202, -3783.17682504, -3536.19412294],
                [-9060.47373569, 4658.70952502, 813.68673153],
            ],
            [
                [1.893841015, 6.405893759, 4.534807250],
                [4.741887409, -4.151817765, -2.093935425],
                [-2.232832783, -4.110453490, -3.157345433],
            ],
        ),
        (
            MOLNIYA_2_14,
            [120.0, 360.0],
            [
                [15223.91713658, -17852.95881713, 25280.39558224],
                [19089.29762968, 3107.89495018, 39958.14661370],
            ],
            [
                [1.079041732, 0.875187372, 2.485682813],
                [-0.410308034, 1.640332277, -0.306873818],
            ],
        ),
    ],
)
def test_teme_vectors_equal_verification_output(
    lines: tuple[str, str],
    minutes: list[float],
    position: list[list[float]],
    velocity: list[list[float]],
) -> None:
    found_position, found_velocity = compute_teme_states(
        satellite(lines), compute_dates_after_epoch(lines, minutes)
    )
    np.testing.assert_allclose(found_position, 1e3 * np.array(position), rtol=0.0, atol=0.02)
    np.testing.assert_allclose(found_velocity, 1e3 * np.array(velocity), rtol=0.0, atol=2e-5)


def test_gcrs_vector_agrees_with_published_j2000_vector() -> None:
    """IAU 1976/1980 without pole corrections has an error of 0.05", or 2 m at 10 000 km."""
    at = compute_dates_after_epoch(VANGUARD_1, [4320.0])
    frame_bias, _, _ = erfa.bp06(at.midnight, at.tt[0])
    position, velocity = compute_gcrs_states(satellite(VANGUARD_1), at)
    j2000 = 1e3 * np.array([-9059.9413786, 4659.6972000, 813.9588875])
    assert np.linalg.norm(frame_bias @ position[0] - j2000) < 2.5
    j2000_velocity = 1e3 * np.array([-2.233348094, -4.110136162, -3.157394074])
    assert np.linalg.norm(frame_bias @ velocity[0] - j2000_velocity) < 1.5e-3


def test_velocity_in_gcrs_is_as_accurate_as_in_teme() -> None:
    """The velocity of SGP4 has an error of up to 0.4 m/s, which the rotation must not increase."""
    at = compute_dates_after_epoch(MOLNIYA_2_14, [120.0 - 1.0 / 60.0, 120.0, 120.0 + 1.0 / 60.0])
    errors = []
    for propagate in (compute_teme_states, compute_gcrs_states):
        position, velocity = propagate(satellite(MOLNIYA_2_14), at)
        errors.append(np.linalg.norm((position[2] - position[0]) / 2.0 - velocity[1]))
    assert errors[0] < 0.5
    assert errors[1] == pytest.approx(errors[0], abs=1e-3)
