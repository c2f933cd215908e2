"""Constraints of a scenario: bounds of the design vector, path constraints and time windows."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import DIRECTIONS, Cone
from mgeo_attitude.geometry.vector import unit_vector
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import expect
from mgeo_attitude.settings.types import (
    Degrees,
    DegreesPerSecond,
    Direction,
    DisplayName,
    Instant,
    Seconds,
    Unit,
    restrict_to,
)

if TYPE_CHECKING:
    from mgeo_attitude.scenario.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class ManeuverBounds(Settings):
    """Number of maneuvers in a plan, with bounds on rates, durations and accelerations.

    Examples
    --------
    >>> from mgeo_attitude.scenario import ManeuverBounds
    >>> ManeuverBounds(count=6, max_rate_deg_s=0.5, max_duration=900.0, slew_back=True).count
    6
    """

    count: int = Field(default=3, ge=1, le=100)
    """number of constant-rate maneuvers in a plan"""
    max_rate_deg_s: DegreesPerSecond = Field(default=1.0, gt=0.0)
    """largest body rate about each axis"""
    max_duration: Seconds = Field(default=2000.0, gt=0.0)
    """longest duration of one maneuver"""
    max_acceleration_deg_s2: Annotated[float | None, Unit("deg/s²")] = Field(default=None, gt=0.0)
    """largest angular acceleration about each axis; default: instantaneous changes of rate"""
    slew_back: bool = False
    """true if a plan ends, after t_end, with a slew back to the attitude law of [initial]"""
    end_tolerance_deg: Degrees | None = Field(default=None, gt=0.0)
    """largest 3-sigma attitude error after the slew back, about the worst axis, relative to the
    attitude law of [initial]; default: any error"""

    def __post_init__(self) -> None:
        expected = (
            "no value without slew_back = true, since the plan then does not return to the "
            "attitude of [initial]"
        )
        is_possible = self.end_tolerance_deg is None or self.slew_back
        expect(is_possible, "end_tolerance_deg", self.end_tolerance_deg, expected)


@dataclass(frozen=True, kw_only=True)
class PathConstraint(Settings):
    """Cone about a body axis that must contain or exclude a direction during the whole plan.

    An example of a direction is the Sun. For the Earth's disc, angles are measured from the limb
    and are negative inside of the disc. The Sun counts in sunlight only. The axis follows from the
    estimated attitude: the constraint has a margin of `attitude_sigmas` times the 1-sigma of the
    angle, see equation (3) of docs/explanation/maneuvers-and-constraints.md.

    Examples
    --------
    >>> from mgeo_attitude.scenario import PathConstraint
    >>> PathConstraint(name="camera", boresight=(0.0, 0.0, 1.0), half_angle_deg=20.0).sense
    'keep-out'
    """

    name: DisplayName = "payload"
    """name of the constraint, for display"""
    reference: Annotated[str, restrict_to(DIRECTIONS)] = "sun"
    """direction that the cone must contain or exclude; angles to 'earth' are measured from the
    Earth's limb, angles to 'nadir' from the Earth's center"""
    sense: Literal["keep-out", "keep-in"] = "keep-out"
    """'keep-out' if the direction must stay outside of the cone, 'keep-in' if it must stay
    inside"""
    boresight: Direction
    """axis of the cone, body axes (any length)"""
    half_angle_deg: Degrees = Field(gt=0.0, lt=180.0)
    """half-angle of the cone"""
    attitude_sigmas: float = Field(default=3.0, ge=0.0)
    """margin for the attitude error, as a multiple of the 1-sigma of the angle; 0 for no margin"""

    @property
    def keep_in(self) -> bool:
        """True if the direction must stay inside the cone."""
        return self.sense == "keep-in"

    @property
    def label(self) -> str:
        """Name for display, such as ``Sun off camera`` or ``nadir in antenna``."""
        preposition = "in" if self.keep_in else "off"
        return f"{DIRECTIONS[self.reference].label} {preposition} {self.name}"

    def build_cone(self) -> Cone:
        """Return the cone of the constraint, with its half-angle in rad."""
        half_angle = math.radians(self.half_angle_deg)
        return Cone(self.reference, unit_vector(self.boresight), half_angle, self.keep_in)


@dataclass(frozen=True, kw_only=True)
class Window(Settings):
    """Time window that must contain the whole plan.

    Start and end are converted to UTC.

    Examples
    --------
    >>> from datetime import UTC, datetime
    >>> from mgeo_attitude.scenario import Window
    >>> start, end = (datetime(2026, 3, 1, hour, tzinfo=UTC) for hour in (10, 11))
    >>> Window(start=start, end=end).end.hour
    11
    """

    start: Instant
    """earliest start of a plan, with its UTC offset"""
    end: Instant
    """latest end of a plan, slew back included, with its UTC offset"""

    def __post_init__(self) -> None:
        expected = f"later than start = {self.start.isoformat()}"
        expect(self.end > self.start, "end", self.end.isoformat(), expected)

    def __str__(self) -> str:
        return f"{self.start:%Y-%m-%dT%H:%M:%SZ} to {self.end:%Y-%m-%dT%H:%M:%SZ}"


def compute_deadline(scenario: Scenario) -> float:
    """Return the latest time at which a plan may end [s after the epoch].

    The time windows of the scenario determine this deadline. It is earlier by the largest start
    delay of Monte Carlo runs. It is infinite without windows, and minus infinity if no window is
    open at the epoch.
    """
    if not scenario.windows:
        return math.inf
    delay = 0.0 if scenario.monte_carlo is None else scenario.monte_carlo.start_delay
    return float(_compute_open_window_ends(scenario).max()) - delay


def _compute_open_window_ends(scenario: Scenario) -> Floats:
    """Return the end of each time window [s after the epoch].

    The value is -inf for a window that is not open at the epoch.
    """
    spans = ((each.start - scenario.epoch, each.end - scenario.epoch) for each in scenario.windows)
    seconds = ((start.total_seconds(), end.total_seconds()) for start, end in spans)
    return np.array([end if start <= 0.0 < end else -np.inf for start, end in seconds])


def check_windows(scenario: Scenario) -> None:
    """Raise InvalidValue unless a plan may start at the epoch and can end within a time window.

    Raises
    ------
    InvalidValue
        If no window is open at the epoch, or if the window closes before any plan can end.
    """
    if not scenario.windows:
        return
    ends = _compute_open_window_ends(scenario)
    expected = f"a start in one of the windows, {', '.join(map(str, scenario.windows))}"
    expect(np.isfinite(ends).any(), "epoch", scenario.epoch.isoformat(), expected)
    # With rules other than "trace", a plan may end after one step.
    shortest, name = scenario.step, "a step"
    if scenario.convergence.rule == "trace":
        shortest, name = scenario.convergence.window, "convergence.window"
    deadline, index = compute_deadline(scenario), int(ends.argmax())
    expected = (
        f"{shortest + ends[index] - deadline:g} s or more after the epoch, {name} and "
        "monte_carlo.start_delay: no plan ends earlier"
    )
    key, end = f"windows[{index}].end", scenario.windows[index].end.isoformat()
    expect(deadline >= shortest, key, end, expected)
