"""Orbits from two-line or mean element sets, propagated by SGP4 and rotated to GCRS.

SGP4 (package `sgp4`) has an error of about 1 km at the epoch of the elements, which grows by 1 to 3
km per day. The rotation from the frame of SGP4 adds less than 1 m.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Annotated, ClassVar, Self

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import DAY, EARTH_MU, EARTH_RADIUS
from mgeo_attitude.environment.frames import rotate, teme_to_gcrs
from mgeo_attitude.environment.times import JulianDates, compute_julian_dates, format_instant
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect
from mgeo_attitude.settings.types import Degrees, Instant, Unit

if TYPE_CHECKING:
    from sgp4.api import Satrec

#: Largest difference between the epochs of an element set and of a run, beyond which the position
#: error exceeds tens of kilometers.
MAX_AGE = timedelta(days=30)

#: Interval between test instants of a run [s], shorter than a descent to the ground.
_PROBE_INTERVAL = 10.0
#: Number of characters of a line.
_LINE_LENGTH = 69
#: Two-digit year from which on years are 19yy, since the first satellite was launched in 1957.
_FIRST_YEAR = 57
#: Epoch of the days that `Satrec.sgp4init` takes.
_SGP4_EPOCH = datetime(1949, 12, 31, tzinfo=UTC)


#: Angle [deg] of up to one revolution in either direction.
Angle = Annotated[float, Unit("deg"), Field(ge=-360.0, le=360.0)]


class SGP4Error(ArithmeticError):
    """Raised if SGP4 cannot propagate an element set to the requested instant."""


class ElementSet(Settings):
    """Base class of mean element sets, which SGP4 propagates.

    The elements have an epoch of their own.
    """

    selector: ClassVar[str] = "propagator"
    #: Name of the key that contains the epoch.
    epoch_key: ClassVar[str]

    @property
    def element_epoch(self) -> datetime:
        """Epoch of the elements, in UTC."""
        raise NotImplementedError

    def build_satellite(self) -> Satrec:
        """Return an sgp4 satellite object with these elements.

        The object uses the constants of WGS72, with which element sets are published.
        """
        raise NotImplementedError

    def propagate(self, epoch: datetime, times: Floats) -> tuple[Floats, Floats]:
        """Compute position [m] and velocity [m/s] in GCRS at given times [s] after an epoch.

        Both arrays have shape (n, 3).
        """
        return compute_gcrs_states(self.build_satellite(), compute_julian_dates(epoch, times))

    def prepare_for_run(self, epoch: datetime, duration: float) -> Self:
        """Return the element set after checking that SGP4 can propagate it through a whole run.

        Raises
        ------
        InvalidValue
            If the epochs of set and run differ by more than `MAX_AGE`, or if SGP4 reports an error
            during the run, such as a decayed satellite.
        """
        key, value = self.epoch_key, getattr(self, self.epoch_key)
        value = value.isoformat() if isinstance(value, datetime) else value
        near = (
            f"an element set within {MAX_AGE.days} days of epoch = {epoch.isoformat()}, not of "
            f"{self.element_epoch.isoformat()}"
        )
        expect(abs(epoch - self.element_epoch) <= MAX_AGE, key, value, near)
        times = np.linspace(0.0, duration, 2 + int(duration / _PROBE_INTERVAL))
        codes, _, _ = _run_sgp4(self.build_satellite(), compute_julian_dates(epoch, times))
        for k in np.flatnonzero(codes)[:1]:
            lasting = (
                "an element set that SGP4 propagates through the run; at "
                f"{format_instant(epoch, times[k])}, t = {times[k]:.0f} s, it reports: "
                f"{_format_sgp4_error(int(codes[k]))}"
            )
            expect(False, key, value, lasting)
        return self

    def shift_epoch(self, time: float) -> Self:
        """Return the element set unchanged, because its epoch does not depend on the scenario's
        start.
        """
        return self


def compute_gcrs_states(satellite: Satrec, at: JulianDates) -> tuple[Floats, Floats]:
    """Compute GCRS positions [m] and velocities [m/s] of a satellite with SGP4.

    Both arrays have shape (n, 3). For the velocity, TEME is treated as inertial, which causes an
    error of 1e-4 m/s in a low orbit.

    Raises
    ------
    SGP4Error
        If SGP4 reports an error, such as a decayed satellite.
    """
    position, velocity = compute_teme_states(satellite, at)
    rotation = teme_to_gcrs(at)
    return rotate(rotation, position), rotate(rotation, velocity)


def compute_teme_states(satellite: Satrec, at: JulianDates) -> tuple[Floats, Floats]:
    """Compute TEME positions [m] and velocities [m/s] of a satellite with SGP4.

    Both arrays have shape (n, 3). TEME is the frame of SGP4: true equator and mean equinox of date.

    Raises
    ------
    SGP4Error
        If SGP4 reports an error.
    """
    codes, position, velocity = _run_sgp4(satellite, at)
    for k in np.flatnonzero(codes)[:1]:
        code = int(codes[k])
        name = f"satellite {satellite.satnum_str}: " if satellite.satnum else ""
        time = (at.ut[k] - at.ut[0]) * DAY
        raise SGP4Error(f"{name}SGP4 error {code} at t = {time:.1f} s, {_format_sgp4_error(code)}")
    return 1e3 * position, 1e3 * velocity


def _run_sgp4(satellite: Satrec, at: JulianDates) -> tuple[Floats, Floats, Floats]:
    codes, position, velocity = satellite.sgp4_array(np.full_like(at.ut, at.midnight), at.ut)
    return codes, position, velocity


def _format_sgp4_error(code: int) -> str:
    from sgp4.api import SGP4_ERRORS

    return str(SGP4_ERRORS[code])


def _compute_max_revolutions(eccentricity: float) -> float:
    """Return the largest possible mean motion [rev/day] for a given eccentricity.

    At this mean motion, the perigee is at the Earth's surface.
    """
    return DAY * math.sqrt(EARTH_MU * ((1.0 - eccentricity) / EARTH_RADIUS) ** 3) / math.tau


@dataclass(frozen=True, kw_only=True)
class TLEOrbit(ElementSet):
    """NORAD two-line element set, propagated by SGP4.

    Trailing blanks of the lines are removed.

    Raises
    ------
    InvalidValue
        If the package sgp4 rejects a line, for example for a wrong checksum, or if the perigee is
        below the Earth's surface.

    Examples
    --------
    >>> from mgeo_attitude.scenario import TLEOrbit
    >>> orbit = TLEOrbit(
    ...     line1="1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927",
    ...     line2="2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537")
    >>> round(orbit.period)  # s
    5496
    """

    propagator: ClassVar[str] = "sgp4"
    epoch_key: ClassVar[str] = "line1"

    line1: str
    """first line of the element set"""
    line2: str
    """second line of the element set"""
    source: str | None = None
    """origin of the element set, such as the name of a file"""

    def __post_init__(self) -> None:
        for key in ("line1", "line2"):
            object.__setattr__(self, key, getattr(self, key).rstrip())
        _check_lines(self.line1, self.line2)
        # A line that is shifted by a column also has an impossible mean motion.
        max_revolutions = _compute_max_revolutions(float(f"0.{self.line2[26:33]}"))
        expected = (
            f"a perigee above the Earth's surface, at most {max_revolutions:.6g} revolutions a day"
        )
        expect(
            max_revolutions * self.period > DAY, "line2", self.line2, f"{expected} (columns 53-63)"
        )

    @property
    def epoch(self) -> datetime:
        """Epoch of the element set, in UTC."""
        return parse_epoch(self.line1)

    @property
    def element_epoch(self) -> datetime:
        return self.epoch

    @property
    def period(self) -> float:
        """Orbital period [s] from the mean motion of the element set."""
        return DAY / float(self.line2[52:63])

    def build_satellite(self) -> Satrec:
        from sgp4.api import Satrec

        return Satrec.twoline2rv(self.line1, self.line2)


def parse_epoch(line1: str) -> datetime:
    """Parse the epoch of an element set, in UTC, from columns 19 to 32 of its first line.

    Raises
    ------
    ValueError
        If the columns contain no numbers.
    """
    try:
        short_year, day = int(line1[18:20]), float(line1[20:32])
    except ValueError:
        raise ValueError(f"{line1!r:.80}: expected an epoch in columns 19-32") from None
    century = 1900 if short_year >= _FIRST_YEAR else 2000
    return datetime(century + short_year, 1, 1, tzinfo=UTC) + timedelta(days=day - 1.0)


def _check_lines(line1: str, line2: str) -> None:
    from sgp4.earth_gravity import wgs72
    from sgp4.io import twoline2rv, verify_checksum

    for key, line in (("line1", line1), ("line2", line2)):
        length = f"{_LINE_LENGTH} characters, not {len(line)} (two-line element set)"
        expect(len(line) == _LINE_LENGTH, key, line, length)
        try:
            verify_checksum(line)
        except ValueError as error:
            raise InvalidValue(key, line, f"{error}".partition("\n")[0]) from None
    try:
        twoline2rv(line1, line2, wgs72)
    except (ValueError, ArithmeticError) as error:
        reason = f"{error}".partition("\n")[0]
        expected = f"expected a two-line element set with line2 = {line2!r} ({reason})"
        raise InvalidValue("line1", line1, expected) from None


@dataclass(frozen=True, kw_only=True)
class MeanElements(ElementSet):
    """Mean orbital elements for SGP4, in the TEME frame and with Kozai's mean motion.

    Raises
    ------
    InvalidValue
        If an element is out of range or the perigee is below the Earth's surface.

    Examples
    --------
    >>> from datetime import UTC, datetime
    >>> from mgeo_attitude.scenario import MeanElements
    >>> elements = MeanElements(
    ...     epoch=datetime(2008, 9, 20, 12, 25, tzinfo=UTC),
    ...     mean_motion_rev_day=15.72,
    ...     eccentricity=0.00067,
    ...     inclination_deg=51.64,
    ...     raan_deg=247.46,
    ...     argument_of_perigee_deg=130.54,
    ...     mean_anomaly_deg=325.03,
    ... )
    >>> round(elements.period)  # s
    5496
    """

    propagator: ClassVar[str] = "mean-elements"
    epoch_key: ClassVar[str] = "epoch"

    source: str | None = None
    """origin of the elements, such as the name of a file"""
    epoch: Instant
    """epoch of the elements, with UTC offset"""
    mean_motion_rev_day: Annotated[float, Unit("rev/day")] = Field(gt=0.0)
    """mean motion"""
    eccentricity: float = Field(ge=0.0, lt=1.0)
    """eccentricity"""
    inclination_deg: Degrees = Field(ge=0.0, le=180.0)
    """inclination"""
    raan_deg: Angle
    """right ascension of the ascending node"""
    argument_of_perigee_deg: Angle
    """argument of perigee"""
    mean_anomaly_deg: Angle
    """mean anomaly"""
    bstar: Annotated[float, Unit("1/Earth radii")] = 0.0
    """drag term B* of SGP4"""

    def __post_init__(self) -> None:
        max_revolutions = _compute_max_revolutions(self.eccentricity)
        expected = (
            f"a perigee above the Earth's surface, at most {max_revolutions:.6g} revolutions a day"
        )
        motion = self.mean_motion_rev_day
        expect(motion < max_revolutions, "mean_motion_rev_day", motion, expected)

    @property
    def element_epoch(self) -> datetime:
        return self.epoch

    @property
    def period(self) -> float:
        """Orbital period [s] from the mean motion."""
        return DAY / self.mean_motion_rev_day

    def build_satellite(self) -> Satrec:
        from sgp4.api import WGS72, Satrec

        satellite = Satrec()
        satellite.sgp4init(
            WGS72,
            "i",
            0,  # The catalog number has no effect, and sgp4 supports none above 339999.
            (self.element_epoch - _SGP4_EPOCH).total_seconds() / DAY,
            self.bstar,
            0.0,  # SGP4 does not use the derivatives of the mean motion.
            0.0,
            self.eccentricity,
            math.radians(self.argument_of_perigee_deg),
            math.radians(self.inclination_deg),
            math.radians(self.mean_anomaly_deg),
            self.mean_motion_rev_day * math.tau / 1440.0,
            math.radians(self.raan_deg),
        )
        return satellite
