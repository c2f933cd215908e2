"""Two-body and J2 motion, compared with published vectors and numerical integration."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from mgeo_attitude.environment.constants import EARTH_MU
from mgeo_attitude.environment.kepler import (
    Elements,
    eccentric_anomaly,
    j2_secular_rates,
    mean_anomaly_from_true,
    orbital_period,
    propagate_j2_secular,
    propagate_two_body,
)

from .integration import integrated


def compute_elements(position: np.ndarray, velocity: np.ndarray) -> Elements:
    """Return the elements of a state from the angular momentum and eccentricity vectors."""
    momentum = np.cross(position, velocity)
    toward_perigee = np.cross(velocity, momentum) / EARTH_MU - position / np.linalg.norm(position)
    eccentricity = float(np.linalg.norm(toward_perigee))
    node = np.array([-momentum[1], momentum[0], 0.0])
    normal = momentum / np.linalg.norm(momentum)

    def angle(start: np.ndarray, end: np.ndarray) -> float:
        return math.atan2(float(normal @ np.cross(start, end)), float(start @ end))

    return Elements(
        semi_major_axis=float(momentum @ momentum) / EARTH_MU / (1.0 - eccentricity**2),
        eccentricity=eccentricity,
        inclination=math.acos(normal[2]),
        raan=math.atan2(node[1], node[0]),
        argument_of_perigee=angle(node, toward_perigee),
        true_anomaly=angle(toward_perigee, position),
    )


def test_two_body_motion_equals_vallado_example_2_4() -> None:
    start = compute_elements(
        np.array([1131340.0, -2282343.0, 6672423.0]), np.array([-5643.05, 4303.33, 2428.79])
    )
    position, velocity = propagate_two_body(start, [0.0, 40.0 * 60.0])
    np.testing.assert_allclose(position[0], [1131340.0, -2282343.0, 6672423.0], atol=1e-6)
    np.testing.assert_allclose(velocity[0], [-5643.05, 4303.33, 2428.79], atol=1e-9)
    published = [-4219752.7, 4363029.2, -3958766.6]
    assert np.linalg.norm(position[1] - published) < 1.0
    assert velocity[1, 0] == pytest.approx(3689.866, abs=1e-3)


def test_j2_propagation_agrees_with_stk_after_four_days() -> None:
    angles = (math.radians(degrees) for degrees in (28.5, 100.0, 200.0, 45.0))
    position, _ = propagate_j2_secular(Elements(8e6, 0.015, *angles), [4 * 86400.0])
    assert np.linalg.norm(position[0] - [-6849654.348, -2253059.809, 3574529.667]) < 20.0


@pytest.mark.parametrize("eccentricity", [0.001111, 0.8])
def test_two_body_motion_equals_numerical_integration(eccentricity: float) -> None:
    elements = Elements(3e7, eccentricity, 1.7, 4.0, 1.6, 5.3)
    times = np.linspace(0.0, 1.5 * orbital_period(3e7), 31)
    position, velocity = propagate_two_body(elements, times)
    state = integrated(np.concatenate([position[0], velocity[0]]), times, oblate=False)
    assert np.abs(position - state[:, :3]).max() < 0.05
    assert np.abs(velocity - state[:, 3:]).max() < 1e-4


@pytest.mark.parametrize("inclination_deg", [28.5, 120.0])
def test_secular_rates_agree_with_numerical_integration(inclination_deg: float) -> None:
    """The drift of node and argument of latitude over 15 orbits agrees to 1 %."""
    inclination = math.radians(inclination_deg)
    circular = Elements(7.2e6, 0.0, inclination, 0.5, 0.0, 0.0)
    times = np.linspace(0.0, 15.0 * orbital_period(7.2e6), 3001)
    position, velocity = propagate_two_body(circular, [0.0])
    state = integrated(np.concatenate([position[0], velocity[0]]), times)
    momentum = np.cross(state[:, :3], state[:, 3:])
    node = np.unwrap(np.arctan2(momentum[:, 0], -momentum[:, 1]))
    raan_rate, perigee_rate, mean_rate = j2_secular_rates(7.2e6, 0.0, inclination)
    assert np.polyfit(times, node, 1)[0] == pytest.approx(raan_rate, rel=0.01)
    # The mean semi-major axis follows from the energy averaged over the orbits. It differs from the
    # osculating axis at the node by 10 km, which would hide the drift along the orbit.
    radius = np.linalg.norm(state[:, :3], axis=1)
    mean_axis = float(np.mean(1.0 / (2.0 / radius - (state[:, 3:] ** 2).sum(axis=1) / EARTH_MU)))
    motion = math.tau / orbital_period(mean_axis)
    across = np.cross(momentum / np.linalg.norm(momentum, axis=1, keepdims=True), _nodes(node))
    latitude = np.unwrap(
        np.arctan2((state[:, :3] * across).sum(axis=1), (state[:, :3] * _nodes(node)).sum(axis=1))
    )
    drift = np.polyfit(times, latitude, 1)[0] - motion
    assert drift == pytest.approx(perigee_rate + mean_rate, abs=2.5e-8)


def _nodes(angles: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)


def compute_decimal_mean_anomaly(eccentric: float, eccentricity: float) -> float:
    """Return E - e sin E, computed with 60 digits."""
    with localcontext() as context:
        context.prec = 60
        angle = Decimal(eccentric)
        sine, term, k = Decimal(0), angle, 1
        while abs(term) > Decimal("1e-58"):
            sine += term
            term *= -angle * angle / ((k + 1) * (k + 2))
            k += 2
        return float(angle - Decimal(eccentricity) * sine)


@pytest.mark.parametrize("eccentricity", [0.0, 1e-3, 0.5, 0.9, 0.99999, 1.0 - 2.0**-53])
def test_kepler_equation_is_solved_to_last_digits(eccentricity: float) -> None:
    expected = np.concatenate([np.geomspace(1e-12, 0.1, 40), np.linspace(0.1, math.pi, 60)])
    mean = np.array([compute_decimal_mean_anomaly(value, eccentricity) for value in expected])
    solved = eccentric_anomaly(mean, eccentricity)
    np.testing.assert_allclose(solved, expected, rtol=1e-15, atol=2e-15)
    np.testing.assert_array_equal(eccentric_anomaly(-mean, eccentricity), -solved)


def test_mean_anomaly_is_valid_for_any_revolution() -> None:
    for true_anomaly in (-6.0, 0.0, 2.0, 3.2, 12.0):
        eccentric = eccentric_anomaly(mean_anomaly_from_true(true_anomaly, 0.6), 0.6)
        cosine = (np.cos(eccentric) - 0.6) / (1.0 - 0.6 * np.cos(eccentric))
        assert cosine == pytest.approx(math.cos(true_anomaly), abs=1e-14)
        assert math.copysign(1.0, eccentric) == math.copysign(1.0, math.sin(true_anomaly) + 0.0)
