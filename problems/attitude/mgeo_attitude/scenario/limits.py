"""Limits of a scenario: of the design vector, of directions along the way, and of time.

`criteria.constraints` measures path limits.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import DIRECTIONS, Cone
from mgeo_attitude.geometry.vector import unit
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import expect
from mgeo_attitude.settings.types import (
    Degrees,
    DegreesPerSecond,
    Direction,
    Instant,
    Line,
    Seconds,
    Unit,
    one_of,
)

if TYPE_CHECKING:
    from mgeo_attitude.scenario.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class ManeuverLimits(Settings):
    """Bounds of the design vector.

    Examples
    --------
    >>> from mgeo_attitude.scenario import ManeuverLimits
    >>> ManeuverLimits(count=6, max_rate_deg_s=0.5, max_duration=900.0, slew_back=True).count
    6
    """

    count: int = Field(default=3, ge=1, le=100)
    """number of constant-rate maneuvers"""
    max_rate_deg_s: DegreesPerSecond = Field(default=1.0, gt=0.0)
    """greatest body rate per axis"""
    max_duration: Seconds = Field(default=2000.0, gt=0.0)
    """greatest duration of one maneuver"""
    max_acceleration_deg_s2: Annotated[float | None, Unit("deg/s²")] = Field(default=None, gt=0.0)
    """greatest angular acceleration per axis; without it rates change at once"""
    slew_back: bool = False
    """whether a plan ends, after t_end, with a slew back to the attitude of [initial]"""
    end_tolerance_deg: Degrees | None = Field(default=None, gt=0.0)
    """by how much the attitude may be off that of [initial] after the slew back, as 3 times the
    1-sigma about the worst axis that the filter knows then"""

    def __post_init__(self) -> None:
        needed = "none without slew_back = true: a plan then ends wherever its last maneuver does"
        alone = self.end_tolerance_deg is not None and not self.slew_back
        expect(not alone, "end_tolerance_deg", self.end_tolerance_deg, needed)


@dataclass(frozen=True, kw_only=True)
class PathLimit(Settings):
    """A cone around a body axis that a direction must stay out of, or in, along the whole plan.

    Of the Earth, a disc, the angle counts from the limb: inside of it it is negative. The Sun
    counts while it shines. The axis is where the filter believes it: the cone is kept with a margin
    of `attitude_sigmas` times the 1-sigma of the angle; equation (14) of docs/theory.md.

    Examples
    --------
    >>> from mgeo_attitude.scenario import PathLimit
    >>> PathLimit(name="camera", boresight=(0.0, 0.0, 1.0), half_angle_deg=20.0).sense
    'keep-out'
    """

    name: Line = "payload"
    """name of the limit, for people"""
    reference: Annotated[str, one_of(DIRECTIONS)] = "sun"
    """direction that counts; of earth from the limb, of nadir from the Earth's center"""
    sense: Literal["keep-out", "keep-in"] = "keep-out"
    """whether it must stay out of the cone or in it"""
    boresight: Direction
    """axis of the cone, body axes (any length)"""
    half_angle_deg: Degrees = Field(gt=0.0, lt=180.0)
    """half-angle of the cone"""
    attitude_sigmas: float = Field(default=3.0, ge=0.0)
    """margin for the unknown attitude, in 1-sigmas of the angle; 0 is none"""

    @property
    def keep_in(self) -> bool:
        return self.sense == "keep-in"

    @property
    def label(self) -> str:
        """What is limited, for people: ``Sun off camera``, ``nadir in antenna``."""
        way = "in" if self.keep_in else "off"
        return f"{DIRECTIONS[self.reference].label} {way} {self.name}"

    def cone(self) -> Cone:
        """The cone, in rad."""
        half_angle = math.radians(self.half_angle_deg)
        return Cone(self.reference, unit(self.boresight), half_angle, self.keep_in)


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
