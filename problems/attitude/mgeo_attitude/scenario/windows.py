"""How a plan is flown: with which errors, and when it may begin and has to be over."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect
from mgeo_attitude.settings.types import Degrees, DegreesPerSecond, Instant, Seconds

if TYPE_CHECKING:
    from mgeo_attitude.scenario.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class FlightErrors(Settings):
    """Flights over which a plan is judged, each with errors drawn from these.

    Flight k of a seed is the same however many others there are.

    Examples
    --------
    >>> from mgeo_attitude.scenario import FlightErrors
    >>> FlightErrors(count=32, attitude_deg=5.0, rate_error_deg_s=0.01).quantile
    0.9
    """

    count: int = Field(default=16, ge=1, le=10_000)
    """number of flights, the same for all plans"""
    seed: int = Field(default=0, ge=0)
    """seed of what is drawn"""
    quantile: float = Field(default=0.9, gt=0.0, le=1.0)
    """share of the flights that must keep the value of an objective; 1 for the worst"""
    mean: bool = False
    """whether objectives are means over the flights instead"""
    kept: float = Field(default=1.0, gt=0.0, le=1.0)
    """share of the flights that must keep each limit"""
    grow: tuple[Annotated[int, Field(ge=0, le=10_000)], ...] = ()
    """how many there are in the stages of a search before its last; 0 for none but the exact one"""
    attitude_deg: Degrees | None = Field(default=None, ge=0.0, le=180.0)
    """attitude error at the start, 1-sigma per axis; initial.attitude_deg if not given"""
    rate_error_deg_s: DegreesPerSecond | None = Field(default=None, ge=0.0)
    """error of all rates, 1-sigma per axis; the gyro's initial bias if not given"""
    maneuver_rate_error_deg_s: DegreesPerSecond = Field(default=0.0, ge=0.0)
    """error of the rate of each maneuver, 1-sigma per axis"""
    duration_error: Seconds = Field(default=0.0, ge=0.0)
    """error of the duration of each maneuver, 1-sigma"""
    start_delay: Seconds = Field(default=0.0, ge=0.0, le=31 * 86400.0)
    """greatest delay of the start, of which all are equally likely; 604800 for a plan that holds at
    any time of a week"""

    noise_spread: float = Field(default=0.0, ge=0.0, le=2.0)
    """by how much the noise of the gyro and of each sensor may be other than is believed: 1-sigma
    of the logarithm of their ratio"""

    def __post_init__(self) -> None:
        counts = [*self.grow, self.count]
        expect(counts == sorted(counts), "grow", self.grow, f"ascending, up to {self.count}")

    def in_stage(self, stage: int | None) -> int:
        """Number of flights in a stage of a search, from 0; all after the last, or if None."""
        counts = [*self.grow, self.count]
        return self.count if stage is None else counts[min(stage, len(counts) - 1)]


#: Starts of which the best is looked for: each has a limit of its own.
MOST_STARTS = 2000


@dataclass(frozen=True, kw_only=True)
class Window(Settings):
    """A time in which a plan may be flown as a whole; both ends are converted to UTC.

    Examples
    --------
    >>> from datetime import UTC, datetime
    >>> from mgeo_attitude.scenario import Window
    >>> start, end = (datetime(2026, 3, 1, hour, tzinfo=UTC) for hour in (10, 11))
    >>> Window(start=start, end=end).end.hour
    11
    """

    start: Instant
    """no plan begins earlier; with its UTC offset"""
    end: Instant
    """every plan is over by then, with the slew back"""

    def __post_init__(self) -> None:
        later = f"later than start = {self.start.isoformat()}"
        expect(self.end > self.start, "end", self.end.isoformat(), later)

    def __str__(self) -> str:
        return f"{self.start:%Y-%m-%dT%H:%M:%SZ} to {self.end:%Y-%m-%dT%H:%M:%SZ}"


def seconds(epoch: datetime, windows: Sequence[Window]) -> Floats:
    """Starts and ends [s] after an epoch, shape (k, 2)."""
    return np.array(
        [[(t - epoch).total_seconds() for t in (each.start, each.end)] for each in windows]
    ).reshape(-1, 2)


def deadlines(scenario: Scenario, starts: Floats) -> Floats:
    """When plans that begin at `starts` [s] after the epoch have to be over, [s] after that.

    Infinite without windows; minus infinity where none is open. It is so even if a plan begins as
    late as the flights that it is judged over.
    """
    starts = np.asarray(starts, dtype=float)
    if not scenario.windows:
        return np.full(starts.shape, np.inf)
    late = 0.0 if scenario.flight is None else scenario.flight.start_delay
    first, last = seconds(scenario.epoch, scenario.windows).T[:, :, None]
    is_open = (first <= starts) & (starts < last)
    ends: Floats = np.where(is_open, last - starts - late, -np.inf).max(axis=0)
    return ends


def start_times(scenario: Scenario) -> Floats:
    """When plans may begin [s] after the epoch, ascending; at the epoch unless it is free.

    Raises
    ------
    InvalidValue
        If they may not, or no plan that begins then would be over in time.
    """
    limits = scenario.maneuvers
    last = limits.latest_start
    interval = limits.between_starts
    count = 0 if last is None else math.floor(last / interval + 1e-9)
    times = interval * np.arange(count + 1, dtype=float)
    key: str = "epoch"
    value: object = scenario.epoch.isoformat()
    if last is not None:
        fewest = last / (MOST_STARTS - 1)
        few = f"at least {fewest:.4g} s, so that latest_start has at most {MOST_STARTS} of them"
        expect(count < MOST_STARTS, "maneuvers.start_interval", interval, few)
        key, value = "maneuvers.latest_start", last
    if scenario.windows:
        begin, end = seconds(scenario.epoch, scenario.windows).T[:, :, None]
        times = times[((begin <= times) & (times < end)).any(axis=0)]
        within = f"a start in one of the windows, {', '.join(map(str, scenario.windows))}"
        expect(len(times) > 0, key, value, within)
    return _in_time(scenario, times)


def _in_time(scenario: Scenario, times: Floats) -> Floats:
    """Of start times those after which the shortest plan is over in time."""
    left = deadlines(scenario, times)
    # no other rule waits for a window after the start
    waits = scenario.convergence.rule == "trace"
    least, name = (
        (scenario.convergence.window, "convergence.window") if waits else (scenario.step, "a step")
    )
    if (left >= least).any():
        return times[left >= least]
    best = int(left.argmax())
    first, last = seconds(scenario.epoch, scenario.windows).T
    index = int(np.where((first <= times[best]) & (times[best] < last), last, -np.inf).argmax())
    window, late = scenario.windows[index], last[index] - times[best] - left[best]
    after = "the epoch" if scenario.maneuvers.latest_start is None else "the first start in it"
    expected = (
        f"expected {least + late:g} s or more after {after}, {name} and flight.start_delay: no "
        "plan is over sooner"
    )
    raise InvalidValue(f"windows[{index}].end", window.end.isoformat(), expected)
