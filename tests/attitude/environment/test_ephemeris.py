"""Sampled ephemerides compared with exact orbits, and invalid ephemerides."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.scenario import EphemerisOrbit, MonteCarloSettings, Orbit
from mgeo_attitude.settings.errors import InvalidValue

SCENARIO = dataclasses.replace(Scenario.paper(), step=20.0, duration=12000.0)


def sample_orbit(
    orbit: Orbit = SCENARIO.orbit, spacing: float = 60.0, velocities: bool = True, **changes: Any
) -> EphemerisOrbit:
    """Return samples of an orbit from ten minutes before the run to ten minutes after the run."""
    times = np.arange(-600.0, SCENARIO.duration + 601.0, spacing)
    position, velocity = orbit.propagate(SCENARIO.epoch, times)
    given = {
        "epoch": SCENARIO.epoch,
        "times": times.tolist(),
        "position": position.tolist(),
        "velocity": velocity.tolist() if velocities else (),
    }
    return EphemerisOrbit(**given | changes)


def change_entry(entries: list[Any], k: int, by: Any) -> list[Any]:
    """Return a copy of the entries in which one entry is changed."""
    return [*entries[:k], (np.array(entries[k]) + by).tolist(), *entries[k + 1 :]]


def test_sampled_orbit_gives_environment_of_exact_orbit() -> None:
    expected = Environment.from_scenario(SCENARIO)
    environment = Environment.from_scenario(dataclasses.replace(SCENARIO, orbit=sample_orbit()))
    assert np.abs(environment.position - expected.position).max() < 1e-6
    assert np.abs(environment.velocity - expected.velocity).max() < 1e-8
    assert np.abs(environment.field - expected.field).max() < 1e-6
    np.testing.assert_allclose(environment.sun, expected.sun, rtol=0.0, atol=1e-15)
    np.testing.assert_array_equal(environment.sunlit, expected.sunlit)
    assert (environment.position != expected.position).any()  # The orbits are not identical.


def test_period_of_samples_equals_period_of_orbit() -> None:
    expected = SCENARIO.orbit.period
    for velocities in (True, False):
        assert sample_orbit(velocities=velocities).period == pytest.approx(expected, rel=1e-9)


def test_start_delay_beyond_samples_is_rejected() -> None:
    delayed = dataclasses.replace(
        SCENARIO, monte_carlo=MonteCarloSettings(start_delay=600.0), orbit=sample_orbit()
    )
    assert delayed.latest_end == SCENARIO.duration + 600.0
    with pytest.raises(InvalidValue, match=r"orbit\.times .*whole run, from 0 to 12601 s after"):
        dataclasses.replace(delayed, monte_carlo=MonteCarloSettings(start_delay=601.0))


def remove_entries(entries: list[Any], first: int, last: int) -> list[Any]:
    return [*entries[:first], *entries[last:]]


@pytest.mark.parametrize(
    "change",
    [
        lambda o: {"times": change_entry(o["times"], 70, 30.0)},
        lambda o: {"position": change_entry(o["position"], 90, 5000.0)},
        lambda o: {"velocity": (1e-3 * np.array(o["velocity"])).tolist()},
        lambda o: {k: o[k][::20] for k in ("times", "position", "velocity")},
        lambda o: {k: remove_entries(o[k], 60, 110) for k in ("times", "position", "velocity")},
    ],
    ids=["time", "position", "velocities in km/s", "too far apart", "gap"],
)
def test_inconsistent_samples_are_rejected_for_runs(change: Any) -> None:
    table = Scenario.to_dict(dataclasses.replace(SCENARIO, orbit=sample_orbit()))["orbit"]
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
            lambda o: {"times": change_entry(o["times"], 7, -90.0)},
            "times[7] = -270.0: expected more than the previous time, -240.0 s",
        ),
        (
            lambda o: {"position": (1e-3 * np.array(o["position"])).tolist()},
            "not 7131.12 m",  # Positions are in km.
        ),
        (  # Velocities are six times as large.
            lambda o: {
                "times": (np.array(o["times"]) / 6.0).tolist(),
                "velocity": (6.0 * np.array(o["velocity"])).tolist(),
            },
            "expected a position and a speed of a bound orbit about the Earth",
        ),
    ],
)
def test_invalid_samples_are_rejected(change, message: str) -> None:
    table = Scenario.to_dict(dataclasses.replace(SCENARIO, orbit=sample_orbit()))["orbit"]
    del table["propagator"], table["source"]
    given = table | {"epoch": SCENARIO.epoch}
    with pytest.raises(InvalidValue) as caught:
        EphemerisOrbit(**given | change(given))
    assert message in str(caught.value)
