"""Ephemerides against the orbits that they are samples of, and what is refused in them."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.scenario import EphemerisOrbit, MonteCarloSettings, Orbit
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


def test_the_period_is_that_of_the_orbit() -> None:
    expected = SCENARIO.orbit.period
    for velocities in (True, False):
        assert sampled(velocities=velocities).period == pytest.approx(expected, rel=1e-9)


def test_a_flight_that_may_begin_too_late_for_the_samples_is_refused() -> None:
    late = dataclasses.replace(
        SCENARIO, monte_carlo=MonteCarloSettings(start_delay=600.0), orbit=sampled()
    )
    assert late.latest_end == SCENARIO.duration + 600.0
    with pytest.raises(InvalidValue, match=r"orbit\.times .*whole run, from 0 to 12601 s after"):
        dataclasses.replace(late, monte_carlo=MonteCarloSettings(start_delay=601.0))


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
