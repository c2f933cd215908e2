"""Orbits by an element set: its two lines and their columns, or its numbers as in messages."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, ClassVar

from mgeo_attitude.environment.constants import DAY
from mgeo_attitude.environment.element_set import ElementSet, fastest, sgp4_api
from mgeo_attitude.fields import expect, positive, quantity

if TYPE_CHECKING:
    from sgp4.api import Satrec

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


@dataclass(frozen=True, kw_only=True)
class TLEOrbit(ElementSet):
    """A NORAD two-line element set, propagated by SGP4 from the set's own epoch.

    Blanks at the ends of the lines, which files often have, are dropped.

    Raises
    ------
    InvalidValue, InvalidType
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

    line1: str = quantity(doc="first line of the element set")
    line2: str = quantity(doc="second line of the element set")
    source: str | None = quantity(None, doc="where they come from")

    def __post_init__(self) -> None:
        super().__post_init__()
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
    def revolutions(self) -> float:
        """Mean motion [revolutions a day]."""
        return float(self.line2[52:63])

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


#: From which `Satrec.sgp4init` counts days.
_ZERO = datetime(1949, 12, 31, tzinfo=UTC)


@dataclass(frozen=True, kw_only=True)
class MeanElements(ElementSet):
    """Mean elements of SGP4 (TEME, mean motion of Kozai), propagated from their own epoch.

    Raises
    ------
    InvalidValue, InvalidType
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

    source: str | None = quantity(None, doc="where they come from")
    epoch: datetime = quantity(doc="instant of the elements, with its UTC offset")
    mean_motion_rev_day: float = positive(unit="rev/day", doc="mean motion")
    eccentricity: float = quantity(low=0.0, high=1.0, open_high=True, doc="eccentricity")
    inclination_deg: float = quantity(unit="deg", low=0.0, high=180.0, doc="inclination")
    raan_deg: float = quantity(
        unit="deg", low=-360.0, high=360.0, doc="right ascension of the ascending node"
    )
    argument_of_perigee_deg: float = quantity(
        unit="deg", low=-360.0, high=360.0, doc="argument of perigee"
    )
    mean_anomaly_deg: float = quantity(unit="deg", low=-360.0, high=360.0, doc="mean anomaly")
    bstar: float = quantity(0.0, unit="1/Earth radii", doc="drag term")

    def __post_init__(self) -> None:
        super().__post_init__()
        offset = self.epoch.utcoffset() is not None
        expect(offset, "epoch", self.epoch.isoformat(), "a UTC offset, such as a Z at the end")
        most = fastest(self.eccentricity)
        above = f"a perigee above the Earth's surface, at most {most:.6g} revolutions a day"
        found = self.mean_motion_rev_day
        expect(found < most, "mean_motion_rev_day", found, above)

    @property
    def instant(self) -> datetime:
        """The epoch."""
        return self.epoch.astimezone(UTC)

    @property
    def revolutions(self) -> float:
        """Mean motion [revolutions a day]."""
        return self.mean_motion_rev_day

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
