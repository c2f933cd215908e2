"""How a plan is flown: with which errors, and when it may begin and has to be over."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import expect
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


def deadline(scenario: Scenario) -> float:
    """Return when plans have to be over [s] after the epoch.

    Infinite without windows; minus infinity if none is open at the epoch. The deadline holds even
    if a plan begins as late as the flights that it is judged over.
    """
    if not scenario.windows:
        return math.inf
    late = 0.0 if scenario.flight is None else scenario.flight.start_delay
    return float(_ends_of_open(scenario).max()) - late


def _ends_of_open(scenario: Scenario) -> Floats:
    """End of each window [s] after the epoch; minus infinity of one not open then."""
    spans = ((each.start - scenario.epoch, each.end - scenario.epoch) for each in scenario.windows)
    seconds = ((start.total_seconds(), end.total_seconds()) for start, end in spans)
    return np.array([end if start <= 0.0 < end else -np.inf for start, end in seconds])


def check_windows(scenario: Scenario) -> None:
    """Refuse an epoch at which no plan may begin, or after which none would be over in time.

    Raises
    ------
    InvalidValue
        Naming the epoch, or the end of the window.
    """
    if not scenario.windows:
        return
    ends = _ends_of_open(scenario)
    within = f"a start in one of the windows, {', '.join(map(str, scenario.windows))}"
    expect(np.isfinite(ends).any(), "epoch", scenario.epoch.isoformat(), within)
    # no other rule waits for a window after the start
    waits = scenario.convergence.rule == "trace"
    least, name = (
        (scenario.convergence.window, "convergence.window") if waits else (scenario.step, "a step")
    )
    left, index = deadline(scenario), int(ends.argmax())
    after = (
        f"{least + ends[index] - left:g} s or more after the epoch, {name} and "
        "flight.start_delay: no plan is over sooner"
    )
    expect(left >= least, f"windows[{index}].end", scenario.windows[index].end.isoformat(), after)
