"""NASA's ephemeris of the ISS with a reboost, which no polynomial may cross."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.environment.thrust import find_thrust
from mgeo_attitude.scenario import EphemerisOrbit, OrbitFile, TLEOrbit

from .integration import integrated

FILE = Path(__file__).parents[1] / "reference" / "iss-2023-07-04-reboost.oem"
START = datetime(2023, 7, 4, 21, 17, tzinfo=UTC)
END = datetime(2023, 7, 4, 21, 35, 52, 102000, tzinfo=UTC)


def orbit_of(epoch: datetime, duration: float) -> EphemerisOrbit:
    found = OrbitFile(file=str(FILE)).prepare_for_run(epoch, duration)
    assert isinstance(found, EphemerisOrbit)
    return found


@pytest.mark.parametrize(
    "epoch",
    [START - timedelta(minutes=47), START + timedelta(minutes=5), END - timedelta(minutes=1)],
)
def test_a_run_with_the_maneuver_is_refused(tmp_path: Path, epoch: datetime) -> None:
    path = tmp_path / "s.toml"
    path.write_text(
        f'preset = "cubesat_6u"\nepoch = {epoch.isoformat()}\nduration = 3600.0\n'
        f'[orbit]\npropagator = "file"\nfile = "{FILE}"\n'
    )
    with pytest.raises(
        ValueError, match=r"orbit\.file = .*: a maneuver, .* from 2023-07-04T21:17:00"
    ):
        Scenario.from_toml(path)


def test_from_the_end_of_thrust_on_it_is_the_motion_of_a_free_body() -> None:
    """An integration by the main terms of gravity; across the end of thrust it was 28 km off."""
    orbit = orbit_of(END, 4200.0)
    state = np.concatenate([orbit.position[0], orbit.velocity[0]])
    at = np.linspace(0.0, 240.0, 25)
    expected = integrated(state, at)[:, :3]
    found, _ = orbit.propagate(END, at)
    assert np.linalg.norm(found - expected, axis=1).max() < 5.0


def test_it_is_where_the_element_set_of_the_day_before_says() -> None:
    """SGP4 loses 1 to 3 km a day, and the set does not contain the thrust."""
    elements = TLEOrbit(
        line1="1 25544U 98067A   23184.70990191  .00010129  00000-0  18119-3 0  9990",
        line2="2 25544  51.6418 246.6181 0004736  98.2457  48.5828 15.50625415404355",
    )
    for epoch, least, most in (
        (START - timedelta(hours=1), 0.0, 3.2e3),
        (END, 2e3, 35e3),
    ):
        times = np.arange(0.0, 3600.0, 20.0)
        (found, _), (expected, _) = (
            one.propagate(epoch, times) for one in (orbit_of(epoch, 3600.0), elements)
        )
        apart = np.linalg.norm(found - expected, axis=1)
        assert least <= apart.min() < apart.max() < most


@pytest.mark.parametrize("spacing", [1.0, 10.0, 60.0, 180.0])
def test_thrust_is_found_whatever_the_time_between_samples(spacing: float) -> None:
    """1e-3 m/s² over ten minutes, in velocities rounded to 1 mm/s."""
    orbit = Scenario.paper().orbit
    times = np.arange(0.0, 5400.0, spacing)
    start = np.hstack(orbit.propagate(START, np.zeros(1)))[0]
    coasting = integrated(start, times)
    thrust = np.clip(times - 1800.0, 0.0, 600.0)[:, None] * [6e-4, 8e-4, 0.0]
    velocity = np.round(coasting[:, 3:] + thrust, 3)
    assert find_thrust(times, coasting[:, :3], np.round(coasting[:, 3:], 3)) == []
    (found,) = find_thrust(times, coasting[:, :3], velocity)
    assert abs(found.start - 1800.0) <= max(spacing, 60.0)
    assert abs(found.end - 2400.0) <= max(spacing, 60.0)
    assert found.acceleration == pytest.approx(1e-3, rel=0.05)
