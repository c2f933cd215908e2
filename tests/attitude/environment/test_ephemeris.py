"""Ephemerides against the orbits that they are samples of, and what is refused in them."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.environment.constants import EARTH_MU
from mgeo_attitude.scenario import EphemerisOrbit, FlightErrors, Orbit
from mgeo_attitude.settings.errors import InvalidValue

SCENARIO = dataclasses.replace(Scenario.paper(), step=20.0, duration=12000.0)


def sampled(
    orbit: Orbit = SCENARIO.orbit, spacing: float = 60.0, velocities: bool = True, **changes: Any
) -> EphemerisOrbit:
    """Samples of a two-body orbit from ten minutes before the run to ten minutes after it."""
    times = np.arange(-600.0, SCENARIO.duration + 601.0, spacing)
    position, velocity = orbit.propagate(SCENARIO.epoch, times)
    given = {
        "epoch": SCENARIO.epoch,
        "times": times.tolist(),
        "position": position.tolist(),
        "velocity": velocity.tolist() if velocities else (),
    }
    return EphemerisOrbit(**given | changes)


def moved(entries: list[Any], k: int, by: Any) -> list[Any]:
    """The entries with one changed."""
    return [*entries[:k], (np.array(entries[k]) + by).tolist(), *entries[k + 1 :]]


def test_samples_every_minute_give_the_environment_of_the_orbit() -> None:
    expected = Environment.from_scenario(SCENARIO)
    found = Environment.from_scenario(dataclasses.replace(SCENARIO, orbit=sampled()))
    assert np.abs(found.position - expected.position).max() < 1e-6
    assert np.abs(found.velocity - expected.velocity).max() < 1e-8
    assert np.abs(found.field - expected.field).max() < 1e-6
    np.testing.assert_allclose(found.sun, expected.sun, rtol=0.0, atol=1e-15)
    np.testing.assert_array_equal(found.sunlit, expected.sunlit)
    assert (found.position != expected.position).any()  # nobody has computed it the other way


@pytest.mark.parametrize(
    ("velocities", "degree", "samples", "spacing"),
    [
        (True, 3, 2, 100.0),
        (True, 5, 3, 200.0),
        (True, 7, 4, 300.0),
        (False, 3, 4, 100.0),
        (False, 5, 6, 200.0),
        (False, 7, 8, 300.0),
    ],
)
def test_the_error_is_that_of_the_polynomial(
    velocities: bool, degree: int, samples: int, spacing: float
) -> None:
    """On a circle f - p = f^(n+1) / (n+1)! times the product of distances to the nodes."""
    circle = dataclasses.replace(SCENARIO.orbit, eccentricity=0.0)
    radius = circle.semi_major_axis
    orbit = sampled(circle, spacing, velocities, degree=degree)
    times = np.arange(3000.0, 6000.0, 5.0)
    found, _ = orbit.propagate(SCENARIO.epoch, times)
    error = np.linalg.norm(found - circle.propagate(SCENARIO.epoch, times)[0], axis=1)
    rate = np.sqrt(EARTH_MU / radius**3)
    nodes = spacing * (np.arange(samples) - (samples - 1) // 2)
    between = np.linspace(*((0.0, 1.0) if samples % 2 == 0 else (-0.5, 0.5)), 61) * spacing
    product = np.abs(np.prod(between[:, None] - nodes, axis=1)).max() ** (1 + velocities)
    bound = radius * rate ** (degree + 1) / np.prod(np.arange(1.0, degree + 2)) * product
    assert 0.9 * bound < error.max() < 1.1 * bound


def test_the_velocity_is_the_slope() -> None:
    times = np.arange(0.0, 3000.0, 7.0)
    for velocities in (True, False):
        orbit = sampled(velocities=velocities)
        velocity = orbit.propagate(SCENARIO.epoch, times)[1]
        ahead, _ = orbit.propagate(SCENARIO.epoch, times + 0.5)
        behind, _ = orbit.propagate(SCENARIO.epoch, times - 0.5)
        assert np.abs(ahead - behind - velocity).max() < 1e-3
        expected = SCENARIO.orbit.propagate(SCENARIO.epoch, times)[1]
        assert np.abs(velocity - expected).max() < 1e-6


def test_the_period_is_that_of_the_orbit() -> None:
    expected = SCENARIO.orbit.period
    for velocities in (True, False):
        assert sampled(velocities=velocities).period == pytest.approx(expected, rel=1e-9)


def test_a_flight_that_may_begin_too_late_for_the_samples_is_refused() -> None:
    late = dataclasses.replace(SCENARIO, flight=FlightErrors(start_delay=600.0), orbit=sampled())
    assert late.latest_end == SCENARIO.duration + 600.0
    with pytest.raises(InvalidValue, match=r"orbit\.times .*whole run, from 0 to 12601 s after"):
        dataclasses.replace(late, flight=FlightErrors(start_delay=601.0))


def without(entries: list[Any], first: int, last: int) -> list[Any]:
    return [*entries[:first], *entries[last:]]


@pytest.mark.parametrize(
    "change",
    [
        lambda o: {"times": moved(o["times"], 70, 30.0)},
        lambda o: {"position": moved(o["position"], 90, 5000.0)},
        lambda o: {"velocity": (1e-3 * np.array(o["velocity"])).tolist()},
        lambda o: {k: o[k][::20] for k in ("times", "position", "velocity")},
        lambda o: {k: without(o[k], 60, 110) for k in ("times", "position", "velocity")},
    ],
    ids=["time", "position", "velocities in km/s", "too far apart", "gap"],
)
def test_samples_that_do_not_agree_with_their_neighbors_are_refused_to_runs(change: Any) -> None:
    table = Scenario.to_dict(dataclasses.replace(SCENARIO, orbit=sampled()))["orbit"]
    del table["propagator"], table["source"]
    orbit = EphemerisOrbit(**{**table, "epoch": SCENARIO.epoch} | change(table))
    with pytest.raises(
        InvalidValue, match=r"^orbit\.times = '2018.* agree to 1000 m, not \d.* Start"
    ):
        dataclasses.replace(SCENARIO, orbit=orbit)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda o: {"times": o["times"][:-1]}, "position = '221 vectors': expected 220, one"),
        (
            lambda o: {"times": moved(o["times"], 7, -90.0)},
            "times[7] = -270.0: expected more than the -240.0 s before it",
        ),
        (
            lambda o: {"position": (1e-3 * np.array(o["position"])).tolist()},
            "not 7131.12 m",  # km where m is meant
        ),
        (  # six times as fast
            lambda o: {
                "times": (np.array(o["times"]) / 6.0).tolist(),
                "velocity": (6.0 * np.array(o["velocity"])).tolist(),
            },
            "expected a position and a speed of a bound orbit about the Earth",
        ),
    ],
)
def test_samples_that_are_refused(change, message: str) -> None:
    table = Scenario.to_dict(dataclasses.replace(SCENARIO, orbit=sampled()))["orbit"]
    del table["propagator"], table["source"]
    given = table | {"epoch": SCENARIO.epoch}
    with pytest.raises(InvalidValue) as caught:
        EphemerisOrbit(**given | change(given))
    assert message in str(caught.value)
