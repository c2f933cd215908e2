"""NASA's ephemeris of the ISS with a reboost: nodes left out around and within it, and others'."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.environment.arc import Arc, interpolate, nearest
from mgeo_attitude.scenario import EphemerisOrbit, OrbitFile, TLEOrbit

from .integration import integrated

FILE = Path(__file__).parents[1] / "reference" / "iss-2023-07-04-reboost.oem"
EPOCH = datetime(2023, 7, 4, 20, 30, tzinfo=UTC)
START, END = 47.0 * 60.0, 65.0 * 60.0 + 52.102  # of the thrust: 21:17:00 to 21:35:52.102


@pytest.fixture(scope="module")
def orbit() -> EphemerisOrbit:
    found = OrbitFile(file=str(FILE)).for_run(EPOCH, 7200.0)
    assert isinstance(found, EphemerisOrbit)
    return found


def arc(orbit: EphemerisOrbit, kept: np.ndarray | slice = slice(None)) -> Arc:
    """Hermite of degree 7 through some of the samples."""
    columns = (np.array(each)[kept] for each in (orbit.times, orbit.position, orbit.velocity))
    return Arc(*columns, count=4)


def misses(orbit: EphemerisOrbit, left_out: np.ndarray) -> np.ndarray:
    """Meters from samples to the polynomials through all others."""
    kept = np.ones(len(orbit.times), dtype=bool)
    kept[left_out] = False
    found, _ = arc(orbit, kept).at(np.array(orbit.times)[left_out])
    return np.linalg.norm(found - np.array(orbit.position)[left_out], axis=1)


def test_a_scenario_reads_it(tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    path.write_text(
        'preset = "cubesat_6u"\nepoch = 2023-07-04T20:30:00Z\nduration = 7200.0\n'
        '[orbit]\npropagator = "ephemeris-file"\n'
        f'file = "{FILE}"\n'
    )
    scenario = Scenario.from_toml(path)
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    position, _ = scenario.orbit.propagate(EPOCH, np.arange(0.0, 7201.0, 60.0))
    height = np.linalg.norm(position, axis=1) - 6378136.3
    assert 404e3 < height.min() < height.max() < 430e3


def test_samples_follow_from_the_others(orbit: EphemerisOrbit) -> None:
    """With one left out steps are 480 s; away from the thrust that costs a meter at most."""
    times = np.array(orbit.times)
    (edges,) = np.nonzero(np.minimum(abs(times - START), abs(times - END)) < 9.0)
    (far,) = np.nonzero((times < START) | (times > END))
    missed = {k: misses(orbit, np.array([k]))[0] for k in {*edges, *far[1:-1]}}
    inside = [k for k in edges if START < times[k] < END - 3.0]
    assert len(inside) >= 6
    assert max(missed[k] for k in inside) < 1e-6
    assert max(missed[k] for k in missed if times[k] <= START) < 1.0
    assert max(missed.values()) < 1.5  # start and end of the thrust are among these


@pytest.mark.parametrize(("every", "meters"), [(5, 1e-6), (15, 1e-5), (30, 1e-4)])
def test_the_thrust_by_fewer_samples(orbit: EphemerisOrbit, every: int, meters: float) -> None:
    times = np.array(orbit.times)
    (inside,) = np.nonzero((times > START) & (times < END - 0.05))
    left_out = np.setdiff1d(inside[:-1], inside[::every])
    assert misses(orbit, left_out).max() < meters
    # and where the end itself is between samples
    assert misses(orbit, np.append(left_out, inside[-1] + np.arange(2))).max() < 0.5


def test_after_the_thrust_it_is_the_motion_of_a_free_body(orbit: EphemerisOrbit) -> None:
    """An integration from the end of thrust on, by the main terms of gravity only."""
    times = np.array(orbit.times)
    k = int(np.searchsorted(times, END - 1e-3))
    state = np.concatenate([orbit.position[k], orbit.velocity[k]])
    at = np.linspace(0.0, 240.0, 25)
    expected = integrated(state, at)[:, :3]
    assert np.linalg.norm(expected[-1] - orbit.position[k + 1]) < 5.0
    found, _ = orbit.propagate(EPOCH, END + at)
    assert np.linalg.norm(found - expected, axis=1).max() < 5.0
    # through samples of both sides, as one would without thinking
    position, velocity = np.array(orbit.position), np.array(orbit.velocity)
    rows = nearest(times, END + at, 4)
    across, _ = interpolate(times, position, velocity, rows, END + at)
    assert np.linalg.norm(across - expected, axis=1).max() > 20e3


def test_it_is_where_the_element_set_of_the_day_before_says(orbit: EphemerisOrbit) -> None:
    """SGP4 loses 1 to 3 km a day, and knows nothing of the thrust."""
    elements = TLEOrbit(
        line1="1 25544U 98067A   23184.70990191  .00010129  00000-0  18119-3 0  9990",
        line2="2 25544  51.6418 246.6181 0004736  98.2457  48.5828 15.50625415404355",
    )
    times = np.arange(0.0, 7201.0, 20.0)
    (found, _), (expected, _) = (one.propagate(EPOCH, times) for one in (orbit, elements))
    apart = np.linalg.norm(found - expected, axis=1)
    assert apart[times < START].max() < 3.2e3
    assert apart[-1] > 25e3
