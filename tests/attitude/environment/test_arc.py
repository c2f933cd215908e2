"""Samples of uneven steps, with gaps and with jumps, against orbits computed otherwise."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.environment.arc import Arc
from mgeo_attitude.environment.constants import EARTH_MU, EARTH_RADIUS
from mgeo_attitude.scenario import EphemerisOrbit, OrbitFile
from mgeo_attitude.settings.errors import InvalidValue

from .integration import integrated, own_steps

EPOCH = datetime(2018, 6, 5, tzinfo=UTC)
LOW = Scenario.paper().orbit


def samples(times: np.ndarray, states: np.ndarray, **changes: Any) -> EphemerisOrbit:
    given = {
        "epoch": EPOCH,
        "times": times.tolist(),
        "position": states[:, :3].tolist(),
        "velocity": states[:, 3:].tolist(),
    }
    return EphemerisOrbit(**given | changes)


def transfer() -> np.ndarray:
    """State at the perigee, 250 km high, of an orbit up to the geostationary one."""
    perigee, apogee = EARTH_RADIUS + 250e3, 42164e3
    speed = np.sqrt(EARTH_MU * (2.0 / perigee - 2.0 / (perigee + apogee)))
    tilt = np.radians(7.0)
    return np.array([perigee, 0.0, 0.0, 0.0, speed * np.cos(tilt), speed * np.sin(tilt)])


@pytest.mark.parametrize(("tolerance", "meters"), [(1e-8, 15.0), (1e-10, 0.5), (1e-12, 0.01)])
def test_steps_of_an_integrator(tolerance: float, meters: float) -> None:
    """From hundredths of a second to an hour, in an orbit from 250 to 36,000 km."""
    duration = 43200.0
    steps = own_steps(transfer(), duration, tolerance)
    at = np.arange(0.0, duration, 10.0)
    both = np.unique(np.concatenate([steps, at]))
    states = integrated(transfer(), both)
    orbit = samples(steps, states[np.searchsorted(both, steps)])
    assert np.diff(steps).max() > 1000.0 * np.diff(steps).min()
    found, velocity = orbit.for_run(EPOCH, at[-1]).propagate(EPOCH, at)
    expected = states[np.searchsorted(both, at)]
    assert np.linalg.norm(found - expected[:, :3], axis=1).max() < meters
    assert np.linalg.norm(velocity - expected[:, 3:], axis=1).max() < 0.1 * meters


def test_steps_too_coarse_for_the_degree_are_refused() -> None:
    steps = own_steps(transfer(), 43200.0, 1e-6)
    with pytest.raises(InvalidValue, match="samples are too far apart"):
        samples(steps, integrated(transfer(), steps))


def with_gap(minutes: int) -> EphemerisOrbit:
    """Samples a minute apart, but for some that are left out from 3000 s on."""
    times = np.arange(-600.0, 9001.0, 60.0)
    times = times[(times <= 3000.0) | (times >= 3000.0 + 60.0 * minutes)]
    return samples(times, np.hstack(LOW.propagate(EPOCH, times)))


@pytest.mark.parametrize(("minutes", "meters"), [(5, 0.001), (15, 10.0)])
def test_a_gap_that_polynomials_bridge(minutes: int, meters: float) -> None:
    at = np.arange(0.0, 8000.0, 20.0)
    found, _ = with_gap(minutes).for_run(EPOCH, 8000.0).propagate(EPOCH, at)
    assert np.linalg.norm(found - LOW.propagate(EPOCH, at)[0], axis=1).max() < meters


@pytest.mark.parametrize(("count", "velocities"), [(2, True), (4, True), (8, False), (9, False)])
@pytest.mark.parametrize("gap", [300.0, 900.0, 2000.0, 3000.0])
def test_the_error_between_samples_is_known(count: int, velocities: bool, gap: float) -> None:
    times = np.arange(-3600.0, 12000.0, 60.0)
    times = times[(times <= 3000.0) | (times >= 3000.0 + gap)]
    position, velocity = LOW.propagate(EPOCH, times)
    arc = Arc(times, position, velocity if velocities else None, count)
    at = np.linspace(3000.0, 3000.0 + gap, 41)
    error = np.linalg.norm(arc.at(at)[0] - LOW.propagate(EPOCH, at)[0], axis=1).max()
    assert arc.error[int(np.searchsorted(times, 3000.0))] == pytest.approx(error, rel=0.2)


def test_a_gap_that_they_do_not_is_refused_to_runs_through_it() -> None:
    orbit = with_gap(50)
    assert orbit.for_run(EPOCH, 3000.0) == orbit
    with pytest.raises(InvalidValue) as caught:
        dataclasses.replace(Scenario.paper(), orbit=orbit, duration=6000.0)
    message = str(caught.value)
    assert message.startswith(
        "orbit.times = '2018-06-05T00:50:00.000Z to 2018-06-05T01:40:00.000Z': expected samples "
        "in this gap of 3000 s, in which polynomials of degree 7 are off by about "
    )
    assert message.endswith("m (at most 1000 m)")


def pushed(instant: float, push: Sequence[float]) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """States of an orbit at times, of which some are after a push [m/s] at an instant."""
    start = np.hstack(LOW.propagate(EPOCH, np.array([instant])))[0] + [0.0, 0.0, 0.0, *push]

    def states(times: np.ndarray, after: np.ndarray) -> np.ndarray:
        found = np.hstack(LOW.propagate(EPOCH, times))
        grid, rows = np.unique([instant, *times[after]], return_inverse=True)
        found[after] = integrated(start, grid, oblate=False)[rows[1:]]
        return found

    return states


def test_the_same_time_twice_is_a_jump() -> None:
    """100 m/s at once: each side is as true as without it, and the instant itself is after it."""
    instant = 3000.0
    states = pushed(instant, [60.0, 80.0, 0.0])
    times = np.sort(np.append(np.arange(-600.0, 7001.0, 60.0), instant))
    k = int(np.searchsorted(times, instant))
    orbit = samples(times, states(times, np.arange(len(times)) > k))
    at = np.arange(0.0, 6001.0, 10.0)
    found, velocity = orbit.for_run(EPOCH, 6000.0).propagate(EPOCH, at)
    expected = states(at, at >= instant)
    assert np.linalg.norm(found - expected[:, :3], axis=1).max() < 1e-4
    assert np.linalg.norm(velocity - expected[:, 3:], axis=1).max() < 1e-6
    scenario = dataclasses.replace(Scenario.paper(), orbit=orbit, duration=6000.0)
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    thrice = np.insert(times, k, instant)
    with pytest.raises(InvalidValue, match=r"^times\[61\] = 3000.0: expected more than the 3000"):
        samples(thrice, states(thrice, thrice > instant))


def test_no_more_samples_than_the_degree_needs() -> None:
    at = np.arange(0.0, 200.0, 7.0)
    expected, _ = LOW.propagate(EPOCH, at)
    for velocities, times in ((False, 30.0 * np.arange(8)), (True, 70.0 * np.arange(4))):
        states = np.hstack(LOW.propagate(EPOCH, times))
        changes = {} if velocities else {"velocity": ()}
        found, _ = samples(times, states, **changes).for_run(EPOCH, 200.0).propagate(EPOCH, at)
        assert np.linalg.norm(found - expected, axis=1).max() < 1e-4
        with pytest.raises(InvalidValue, match=r"samples': expected at least \d for degree = 7; f"):
            samples(times[1:], states[1:], **changes)
    far = 1500.0 * np.arange(4)  # nobody else says what is between them
    with pytest.raises(InvalidValue, match=r"(gap of 1500 s|are too far apart)"):
        samples(far, np.hstack(LOW.propagate(EPOCH, far))).for_run(EPOCH, 4500.0)


def message(*segments: tuple[np.ndarray, np.ndarray]) -> str:
    """An orbit ephemeris message, each segment times [s] after the epoch and states."""
    lines = ["CCSDS_OEM_VERS = 2.0", "CREATION_DATE = 2018-06-04T00:00:00", "ORIGINATOR = SOMEBODY"]
    for times, states in segments:
        lines += ["META_START", "OBJECT_NAME = PAPER", "OBJECT_ID = 2018-001A"]
        lines += ["CENTER_NAME = EARTH", "REF_FRAME = GCRF", "TIME_SYSTEM = UTC", "META_STOP"]
        for time, state in zip(times.tolist(), (1e-3 * states).tolist(), strict=True):
            stamp = np.datetime64("2018-06-05T00:00:00.000") + np.timedelta64(
                round(1e3 * time), "ms"
            )
            lines.append(" ".join([str(stamp), *map(repr, state)]))
    return "\n".join(lines)


def test_segments_that_meet_are_joined_by_a_jump(tmp_path: Path) -> None:
    """They share an instant; the first goes on beyond it, for interpolation."""
    instant = 3000.0
    states = pushed(instant, [6.0, 8.0, 0.0])
    early, late = np.arange(-600.0, 3301.0, 60.0), np.arange(3000.0, 7000.0, 60.0)
    path = tmp_path / "two.oem"
    first = (early, np.hstack(LOW.propagate(EPOCH, early)))
    second = (late, states(late, late >= instant))
    path.write_text(message(first, second))
    at = np.arange(0.0, 6001.0, 10.0)
    found, _ = OrbitFile(file=str(path)).for_run(EPOCH, 6000.0).propagate(EPOCH, at)
    expected = states(at, at >= instant)[:, :3]
    assert np.linalg.norm(found - expected, axis=1).max() < 1e-3
    middle = late[late <= 4200.0], late[late >= 4200.0]  # the second in two, in any order
    parts = [(times, states(times, times >= instant)) for times in middle]
    path.write_text(message(parts[1], first, parts[0]))
    orbit = OrbitFile(file=str(path)).for_run(EPOCH, 6000.0)
    assert np.linalg.norm(orbit.propagate(EPOCH, at)[0] - expected, axis=1).max() < 1e-3
    assert [t for t, after in pairwise(orbit.times) if t == after] == [3000.0, 4200.0]
    apart = late + 30.0
    path.write_text(message(first, (apart, states(apart, apart >= instant))))
    with pytest.raises(InvalidValue, match="in one segment, or in some that share an instant"):
        OrbitFile(file=str(path)).for_run(EPOCH, 6000.0)
