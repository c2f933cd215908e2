"""How a plan is flown: with which errors, and when it may begin and has to be over."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Protocol

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.fields.checking import Validated
from mgeo_attitude.fields.quantity import InvalidValue, expect, quantity
from mgeo_attitude.scenario.settings import Convergence


@dataclass(frozen=True, kw_only=True)
class FlightErrors(Validated):
    """Flights over which a plan is judged, each with errors drawn from these.

    Flight k of a seed is the same however many others there are.

    Examples
    --------
    >>> from mgeo_attitude.scenario import FlightErrors
    >>> FlightErrors(count=32, attitude_deg=5.0, rate_error_deg_s=0.01).quantile
    0.9
    """

    count: int = quantity(16, low=1, high=10_000, doc="number of flights, the same for all plans")
    seed: int = quantity(0, low=0, doc="seed of what is drawn")
    quantile: float = quantity(
        0.9,
        low=0.0,
        high=1.0,
        open_low=True,
        doc="share of the flights that must keep the value of an objective; 1 for the worst",
    )
    mean: bool = quantity(False, doc="whether objectives are means over the flights instead")
    kept: float = quantity(
        1.0, low=0.0, high=1.0, open_low=True, doc="share of the flights that must keep each limit"
    )
    grow: tuple[int, ...] = quantity(
        (),
        low=0,
        high=10_000,
        doc="how many there are in the stages of a search before its last; 0 for none but the "
        "exact one",
    )
    attitude_deg: float | None = quantity(
        None,
        unit="deg",
        low=0.0,
        high=180.0,
        doc="attitude error at the start, 1-sigma per axis; initial.attitude_deg if not given",
    )
    rate_error_deg_s: float | None = quantity(
        None,
        unit="deg/s",
        low=0.0,
        doc="error of all rates, 1-sigma per axis; the gyro's initial bias if not given",
    )
    maneuver_rate_error_deg_s: float = quantity(
        0.0, unit="deg/s", low=0.0, doc="error of the rate of each maneuver, 1-sigma per axis"
    )
    duration_error: float = quantity(
        0.0, unit="s", low=0.0, doc="error of the duration of each maneuver, 1-sigma"
    )
    start_delay: float = quantity(
        0.0,
        unit="s",
        low=0.0,
        high=31 * 86400.0,
        doc="greatest delay of the start, of which all are equally likely; 604800 for a plan that "
        "holds at any time of a week",
    )

    noise_spread: float = quantity(
        0.0,
        low=0.0,
        high=2.0,
        doc="by how much the noise of the gyro and of each sensor may be other than is believed: "
        "1-sigma of the logarithm of their ratio",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        counts = [*self.grow, self.count]
        expect(counts == sorted(counts), "grow", self.grow, f"ascending, up to {self.count}")

    def in_stage(self, stage: int | None) -> int:
        """Number of flights in a stage of a search, from 0; all after the last, or if None."""
        counts = [*self.grow, self.count]
        return self.count if stage is None else counts[min(stage, len(counts) - 1)]


@dataclass(frozen=True, kw_only=True)
class _Span(Validated):
    """From a start to an end, both converted to UTC."""

    start: datetime
    end: datetime

    def __post_init__(self) -> None:
        super().__post_init__()
        for key in ("start", "end"):
            time = getattr(self, key)
            zone = time.utcoffset() is not None
            expect(zone, key, time.isoformat(), "a UTC offset, such as a Z at the end")
            object.__setattr__(self, key, time.astimezone(UTC))
        later = f"later than start = {self.start.isoformat()}"
        expect(self.end > self.start, "end", self.end.isoformat(), later)

    def __str__(self) -> str:
        return f"{self.start:%Y-%m-%dT%H:%M:%SZ} to {self.end:%Y-%m-%dT%H:%M:%SZ}"


@dataclass(frozen=True, kw_only=True)
class Window(_Span):
    """A time in which a plan may be flown as a whole; both ends are converted to UTC.

    Examples
    --------
    >>> from datetime import UTC, datetime
    >>> from mgeo_attitude.scenario import Window
    >>> start, end = (datetime(2026, 3, 1, hour, tzinfo=UTC) for hour in (10, 11))
    >>> Window(start=start, end=end).end.hour
    11
    """

    start: datetime = quantity(doc="no plan begins earlier; with its UTC offset")
    end: datetime = quantity(doc="every plan is over by then, with the slew back")


@dataclass(frozen=True, kw_only=True)
class Contact(_Span):
    """A ground contact, in which a plan may be commanded to begin; both ends are converted.

    Examples
    --------
    >>> from datetime import UTC, datetime
    >>> from mgeo_attitude.scenario import Contact
    >>> start, end = (datetime(2026, 3, 1, 10, minute, tzinfo=UTC) for minute in (4, 13))
    >>> str(Contact(start=start, end=end))
    '2026-03-01T10:04:00Z to 2026-03-01T10:13:00Z'
    """

    start: datetime = quantity(doc="the contact begins; with its UTC offset")
    end: datetime = quantity(doc="it ends: a plan has begun by then, and may go on")


class Operated(Protocol):
    """What a scenario says of when plans may be flown."""

    @property
    def epoch(self) -> datetime: ...
    @property
    def step(self) -> float: ...
    @property
    def windows(self) -> tuple[Window, ...]: ...
    @property
    def contacts(self) -> tuple[Contact, ...]: ...
    @property
    def convergence(self) -> Convergence: ...
    @property
    def flight(self) -> FlightErrors | None: ...


def seconds(epoch: datetime, spans: Sequence[_Span]) -> Floats:
    """Starts and ends [s] after an epoch, shape (k, 2)."""
    return np.array(
        [[(t - epoch).total_seconds() for t in (span.start, span.end)] for span in spans]
    ).reshape(-1, 2)


def deadline(scenario: Operated) -> float:
    """Return when plans have to be over [s] after the epoch.

    Infinite without windows; minus infinity if none is open at the epoch. The deadline holds even
    if a plan begins as late as the flights that it is judged over.
    """
    if not scenario.windows:
        return math.inf
    late = 0.0 if scenario.flight is None else scenario.flight.start_delay
    return float(_ends_of_open(scenario, scenario.windows).max()) - late


def _ends_of_open(scenario: Operated, spans: Sequence[_Span]) -> Floats:
    """End of each span [s] after the epoch; minus infinity of one not open then."""
    first, last = seconds(scenario.epoch, spans).T
    ends: Floats = np.where((first <= 0.0) & (last > 0.0), last, -np.inf)
    return ends


def check_windows(scenario: Operated) -> None:
    """Refuse an epoch at which no plan may begin, or after which none would be over in time.

    Raises
    ------
    InvalidValue
        Naming the epoch, or the end of the window.
    """
    for name, spans in (("windows", scenario.windows), ("contacts", scenario.contacts)):
        within = f"a start in one of the {name}, {', '.join(map(str, spans))}"
        is_open = not spans or np.isfinite(_ends_of_open(scenario, spans)).any()
        expect(is_open, "epoch", scenario.epoch.isoformat(), within)
    # no other rule waits for a window after the start
    waits = scenario.convergence.rule == "trace"
    least, name = (
        (scenario.convergence.window, "convergence.window") if waits else (scenario.step, "a step")
    )
    left = deadline(scenario)
    if left >= least:
        return
    ends = _ends_of_open(scenario, scenario.windows)
    index = int(ends.argmax())
    expected = (
        f"expected {least + ends[index] - left:g} s or more after the epoch, {name} and "
        "flight.start_delay: no plan is over sooner"
    )
    end = scenario.windows[index].end.isoformat()
    raise InvalidValue(f"windows[{index}].end", end, expected)
