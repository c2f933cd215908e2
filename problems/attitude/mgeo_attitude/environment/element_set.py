"""Orbits by an element set, of two lines or of numbers, propagated by SGP4, in GCRS.

SGP4 (package `sgp4`, an extra) is good to about 1 km at the epoch of the set and loses 1 to 3 km a
day; the rotation from its frame adds less than 1 m.
"""

from __future__ import annotations

import math
import re
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import DAY, EARTH_MU, EARTH_RADIUS
from mgeo_attitude.environment.frames import rotate, teme_to_gcrs
from mgeo_attitude.environment.times import Instants, instants, utc_text
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect
from mgeo_attitude.settings.types import Degrees, Instant, Unit

if TYPE_CHECKING:
    from sgp4.api import Satrec

#: An element set older than this places the satellite tens of kilometers off and more.
MAX_AGE = timedelta(days=30)

_PROBE = 10.0  # s between the instants at which a run is tried; a dive into the ground takes longer
_MOST_PROBES = 100_000
_LENGTH = 69
_FIRST_YEAR = 57  # two-digit years from 57 on are 19yy (the first satellite flew in 1957)
_ENTRIES = (  # line, its first and last column, meaning
    ("line1", 21, 32, "day of the year"),
    ("line1", 19, 20, "year"),
    ("line2", 9, 16, "inclination"),
    ("line2", 18, 25, "right ascension of the node"),
    ("line2", 35, 42, "argument of perigee"),
    ("line2", 44, 51, "mean anomaly"),
    ("line2", 53, 63, "revolutions a day"),
    ("line2", 27, 33, "eccentricity"),
)
#: From which `Satrec.sgp4init` counts days.
_ZERO = datetime(1949, 12, 31, tzinfo=UTC)


#: An angle, which may be given a revolution too far.
Angle = Annotated[float, Unit("deg"), Field(ge=-360.0, le=360.0)]


class SGP4Error(ArithmeticError):
    """SGP4 cannot propagate an element set to the wanted instant."""


class ElementSet(Settings):
    """Mean elements for SGP4, with an epoch of their own; a class says how they are given."""

    selector: ClassVar[str] = "propagator"
    #: The key that has the epoch.
    epoch_key: ClassVar[str]

    @property
    def instant(self) -> datetime:
        """Epoch of the elements, UTC."""
        raise NotImplementedError

    def satellite(self) -> Satrec:
        """What SGP4 propagates; without the package sgp4 it is an ImportError."""
        raise NotImplementedError

    def propagate(self, epoch: datetime, times: Floats) -> tuple[Floats, Floats]:
        """As `gcrs_of`, at `times` [s] after the epoch."""
        return gcrs_of(self.satellite(), instants(epoch, times))

    def for_run(self, epoch: datetime, duration: float) -> Self:
        """Itself, or an InvalidValue.

        For an epoch that the set is too old, or too new, for, a satellite that decays within the
        run, or whatever else SGP4 reports in it, and a missing package sgp4.
        """
        key, value = self.epoch_key, getattr(self, self.epoch_key)
        value = value.isoformat() if isinstance(value, datetime) else value
        near = (
            f"an element set within {MAX_AGE.days} days of epoch = {epoch.isoformat()}, not of "
            f"{self.instant.isoformat()}"
        )
        expect(abs(epoch - self.instant) <= MAX_AGE, key, value, near)
        count = min(_MOST_PROBES, 2 + int(duration / _PROBE))
        times = np.linspace(0.0, duration, count)
        try:
            codes, _, _ = _states(self.satellite(), instants(epoch, times))
        except ImportError as error:
            raise InvalidValue(key, value, f"{error}") from None
        for k in np.flatnonzero(codes)[:1]:
            lasting = (
                "an element set that SGP4 propagates through the run; at "
                f"{utc_text(epoch, times[k])}, t = {times[k]:.0f} s, it says: "
                f"{_said(int(codes[k]))}"
            )
            expect(False, key, value, lasting)
        return self

    def later(self, time: float) -> Self:
        """Itself: it has an epoch of its own."""
        return self


def gcrs_of(satellite: Satrec, at: Instants) -> tuple[Floats, Floats]:
    """Position [m] and velocity [m/s], GCRS, shape (n, 3), by SGP4.

    The velocity takes TEME as inertial, which costs 1e-4 m/s in a low orbit. A decayed satellite,
    or what else SGP4 reports, is an SGP4Error.
    """
    position, velocity = teme_of(satellite, at)
    rotation = teme_to_gcrs(at)
    return rotate(rotation, position), rotate(rotation, velocity)


def teme_of(satellite: Satrec, at: Instants) -> tuple[Floats, Floats]:
    """As `gcrs_of`, in SGP4's own frame, the true equator and mean equinox of date."""
    codes, position, velocity = _states(satellite, at)
    for k in np.flatnonzero(codes)[:1]:
        code = int(codes[k])
        name = f"satellite {satellite.satnum_str}: " if satellite.satnum else ""
        raise SGP4Error(
            f"{name}SGP4 error {code} at t = {(at.ut[k] - at.ut[0]) * DAY:.1f} s, {_said(code)}"
        )
    return 1e3 * position, 1e3 * velocity


def sgp4_api() -> Any:
    """The package's module of classes and constants."""
    try:
        import sgp4.api as api
    except ImportError as error:
        raise ImportError("an element set needs the package sgp4: pip install sgp4") from error
    return api


def fastest(eccentricity: float) -> float:
    """Revolutions a day with the perigee at the Earth's surface."""
    return DAY * math.sqrt(EARTH_MU * ((1.0 - eccentricity) / EARTH_RADIUS) ** 3) / math.tau


def _states(satellite: Satrec, at: Instants) -> tuple[Floats, Floats, Floats]:
    codes, position, velocity = satellite.sgp4_array(np.full_like(at.ut, at.midnight), at.ut)
    return codes, position, velocity


def _said(code: int) -> str:
    return str(sgp4_api().SGP4_ERRORS[code])


@dataclass(frozen=True, kw_only=True)
class TLEOrbit(ElementSet):
    """A NORAD two-line element set, propagated by SGP4 from the set's own epoch.

    Blanks at the ends of the lines, which files often have, are dropped.

    Raises
    ------
    InvalidValue
        For a line of the wrong length, number or checksum, lines of two satellites, an entry that
        is not a number, or a perigee below the Earth's surface.

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
    """where they come from"""

    def __post_init__(self) -> None:
        for key in ("line1", "line2"):
            object.__setattr__(self, key, getattr(self, key).rstrip())
        _check_line("line1", self.line1, "1")
        _check_line("line2", self.line2, "2")
        number = self.line1[2:7]
        one = f"the satellite number of line 1, {number!r} (columns 3-7)"
        expect(self.line2[2:7] == number, "line2", self.line2, one)
        entries = {
            meaning: _entry(key, getattr(self, key), first, last, meaning)
            for key, first, last, meaning in _ENTRIES
        }
        day = entries["day of the year"]
        expect(1.0 <= day < 367.0, "line1", self.line1, "a day in [1, 367) (columns 21-32)")
        revolutions, eccentricity = entries["revolutions a day"], entries["eccentricity"] * 1e-7
        # Not only decayed satellites: the usual mistake is a line shifted by a column.
        most = fastest(eccentricity)
        above = (
            f"a perigee above the Earth's surface, between 0 and {most:.6g} revolutions a day "
            "(columns 53-63)"
        )
        expect(0.0 < revolutions < most, "line2", self.line2, above)

    @property
    def epoch(self) -> datetime:
        """Epoch of the element set, UTC."""
        return epoch_of(self.line1)

    @property
    def instant(self) -> datetime:
        """The same, as of every element set."""
        return self.epoch

    @property
    def period(self) -> float:
        """Period of the mean motion [s]."""
        return DAY / float(self.line2[52:63])

    def satellite(self) -> Satrec:
        """With the constants of WGS72, for which element sets are made."""
        return sgp4_api().Satrec.twoline2rv(self.line1, self.line2)


def epoch_of(line1: str) -> datetime:
    """Epoch of an element set, UTC, from columns 19 to 32; a ValueError if they are no numbers."""
    try:
        short_year, day = int(line1[18:20]), float(line1[20:32])
    except ValueError:
        raise ValueError(f"{line1!r:.80}: expected an epoch in columns 19-32") from None
    century = 1900 if short_year >= _FIRST_YEAR else 2000
    return datetime(century + short_year, 1, 1, tzinfo=UTC) + timedelta(days=day - 1.0)


def _check_line(key: str, line: str, number: str) -> None:
    # the digits before the last column, a minus sign counting one, modulo 10
    digits = line[:-1].replace("-", "1")
    checksum = sum(int(c) for c in digits if c in "0123456789") % 10
    for holds, expected in (
        (
            len(line) == _LENGTH and line.isascii(),
            f"{_LENGTH} ASCII characters, not {len(line)}",
        ),
        (line.startswith(f"{number} "), f"a line that starts with '{number} '"),
        (
            line[-1:] == str(checksum),
            f"the checksum {checksum} in column {_LENGTH}, not {line[-1:]!r}",
        ),
    ):
        expect(holds, key, line, f"{expected} (two-line element set)")


def _entry(key: str, line: str, first: int, last: int, meaning: str) -> float:
    """The unsigned number in columns `first` to `last`, counted from 1."""
    text = line[first - 1 : last]
    number = re.fullmatch(r" *\d+(\.\d+)? *", text)
    expect(number, key, line, f"the {meaning} in columns {first}-{last}, not {text!r}")
    return float(text)


@dataclass(frozen=True, kw_only=True)
class MeanElements(ElementSet):
    """Mean elements of SGP4 (TEME, mean motion of Kozai), propagated from their own epoch.

    Raises
    ------
    InvalidValue
        For an element out of its range, or a perigee below the Earth's surface.

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
    """where they come from"""
    epoch: Instant
    """instant of the elements, with its UTC offset"""
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
    """drag term"""

    def __post_init__(self) -> None:
        most = fastest(self.eccentricity)
        above = f"a perigee above the Earth's surface, at most {most:.6g} revolutions a day"
        found = self.mean_motion_rev_day
        expect(found < most, "mean_motion_rev_day", found, above)

    @property
    def instant(self) -> datetime:
        """The epoch."""
        return self.epoch

    @property
    def period(self) -> float:
        """Period of the mean motion [s]."""
        return DAY / self.mean_motion_rev_day

    def satellite(self) -> Satrec:
        """With the constants of WGS72, for which element sets are made.

        Its number, which changes nothing, is 0: the package has none above 339999.
        """
        api = sgp4_api()
        satellite: Satrec = api.Satrec()
        satellite.sgp4init(
            api.WGS72,
            "i",
            0,
            (self.instant - _ZERO).total_seconds() / DAY,
            self.bstar,
            0.0,  # its derivatives are of older theories
            0.0,
            self.eccentricity,
            math.radians(self.argument_of_perigee_deg),
            math.radians(self.inclination_deg),
            math.radians(self.mean_anomaly_deg),
            self.mean_motion_rev_day * math.tau / 1440.0,
            math.radians(self.raan_deg),
        )
        return satellite
