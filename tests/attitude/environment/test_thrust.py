"""Detection of thrust, with an ephemeris of the ISS that includes a reboost."""

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


def read_orbit(epoch: datetime, duration: float) -> EphemerisOrbit:
    actual = OrbitFile(file=str(FILE)).prepare_for_run(epoch, duration)
    assert isinstance(actual, EphemerisOrbit)
    return actual


@pytest.mark.parametrize(
    "epoch",
    [START - timedelta(minutes=47), START + timedelta(minutes=5), END - timedelta(minutes=1)],
)
def test_run_with_maneuver_is_rejected(tmp_path: Path, epoch: datetime) -> None:
    path = tmp_path / "s.toml"
    path.write_text(
        f'preset = "cubesat_6u"\nepoch = {epoch.isoformat()}\nduration = 3600.0\n'
        f'[orbit]\npropagator = "file"\nfile = "{FILE}"\n'
    )
    with pytest.raises(
        ValueError, match=r"orbit\.file = .*: a maneuver, .* from 2023-07-04T21:17:00"
    ):
        Scenario.from_toml(path)


def test_orbit_after_thrust_is_unpowered() -> None:
    """The reference is a numerical integration with the main terms of gravity."""
    orbit = read_orbit(END, 4200.0)
    state = np.concatenate([orbit.position[0], orbit.velocity[0]])
    at = np.linspace(0.0, 240.0, 25)
    expected = integrated(state, at)[:, :3]
    actual, _ = orbit.propagate(END, at)
    assert np.linalg.norm(actual - expected, axis=1).max() < 5.0


def test_orbit_agrees_with_element_set_of_previous_day() -> None:
    """The error of SGP4 grows by 1 to 3 km per day, and the set does not include the thrust."""
    elements = TLEOrbit(
        line1="1 25544U 98067A   23184.70990191  .00010129  00000-0  18119-3 0  9990",
        line2="2 25544  51.6418 246.6181 0004736  98.2457  48.5828 15.50625415404355",
    )
    for epoch, least, most in (
        (START - timedelta(hours=1), 0.0, 3.2e3),
        (END, 2e3, 35e3),
    ):
        times = np.arange(0.0, 3600.0, 20.0)
        (actual, _), (expected, _) = (
            one.propagate(epoch, times) for one in (read_orbit(epoch, 3600.0), elements)
        )
        apart = np.linalg.norm(actual - expected, axis=1)
        assert least <= apart.min() < apart.max() < most


@pytest.mark.parametrize("spacing", [1.0, 10.0, 60.0, 180.0])
def test_thrust_is_detected_for_any_sample_interval(spacing: float) -> None:
    """The acceleration is 1e-3 m/s² for ten minutes, and velocities are rounded to 1 mm/s."""
    orbit = Scenario.paper().orbit
    times = np.arange(0.0, 5400.0, spacing)
    start = np.hstack(orbit.propagate(START, np.zeros(1)))[0]
    coasting = integrated(start, times)
    thrust = np.clip(times - 1800.0, 0.0, 600.0)[:, None] * [6e-4, 8e-4, 0.0]
    velocity = np.round(coasting[:, 3:] + thrust, 3)
    assert find_thrust(times, coasting[:, :3], np.round(coasting[:, 3:], 3)) == []
    (actual,) = find_thrust(times, coasting[:, :3], velocity)
    assert abs(actual.start - 1800.0) <= max(spacing, 60.0)
    assert abs(actual.end - 2400.0) <= max(spacing, 60.0)
    assert actual.acceleration == pytest.approx(1e-3, rel=0.05)
