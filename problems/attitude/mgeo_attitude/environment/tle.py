"""Two-line element sets by SGP4 (package `sgp4`, an extra), in GCRS.

SGP4 itself is good to about 1 km at the epoch of the set and loses 1 to 3 km a day; the rotation
from its frame adds less than 1 m.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import ClassVar, Self

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.constants import DAY, EARTH_MU, EARTH_RADIUS
from mgeo_attitude.environment.time_frames import Instants, instants, rotate, teme_to_gcrs
from mgeo_attitude.fields import Validated, expect, quantity

#: An element set older than this places the satellite tens of kilometers off and more.
MAX_AGE = timedelta(days=30)

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


class SGP4Error(ArithmeticError):
    """SGP4 cannot propagate an element set to the wanted instant."""


@dataclass(frozen=True, kw_only=True)
class TLEOrbit(Validated):
    """A NORAD two-line element set, propagated by SGP4 from the set's own epoch.

    Raises
    ------
    InvalidValue, InvalidType
        For a line of the wrong length, number or checksum, lines of two satellites, an entry that
        is not a number, or a perigee below the Earth's surface.
    """

    propagator: ClassVar[str] = "sgp4"

    line1: str = quantity(doc="first line of the element set")
    line2: str = quantity(doc="second line of the element set")

    def __post_init__(self) -> None:
        super().__post_init__()
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
        fastest = DAY * math.sqrt(EARTH_MU * ((1.0 - eccentricity) / EARTH_RADIUS) ** 3) / math.tau
        above = (
            f"a perigee above the Earth's surface, between 0 and {fastest:.6g} revolutions a day "
            "(columns 53-63)"
        )
        expect(0.0 < revolutions < fastest, "line2", self.line2, above)

    @property
    def epoch(self) -> datetime:
        """Epoch of the element set, UTC."""
        short_year = int(self.line1[18:20])
        century = 1900 if short_year >= _FIRST_YEAR else 2000
        new_year = datetime(century + short_year, 1, 1, tzinfo=UTC)
        return new_year + timedelta(days=float(self.line1[20:32]) - 1.0)

    @property
    def period(self) -> float:
        """Period of the mean motion [s]."""
        return DAY / float(self.line2[52:63])

    def propagate(self, epoch: datetime, times: Floats) -> tuple[Floats, Floats]:
        """As `sgp4_gcrs`, at `times` [s] after the epoch."""
        return sgp4_gcrs(self.line1, self.line2, instants(epoch, times))

    def for_run(self, epoch: datetime, duration: float) -> Self:
        """Itself, or an InvalidValue for an epoch that the set is too old, or too new, for."""
        near = (
            f"an element set within {MAX_AGE.days} days of epoch = {epoch.isoformat()}, not of "
            f"{self.epoch.isoformat()}"
        )
        expect(abs(epoch - self.epoch) <= MAX_AGE, "line1", self.line1, near)
        return self

    def later(self, time: float) -> Self:
        """Itself: it has an epoch of its own."""
        return self


def sgp4_gcrs(line1: str, line2: str, at: Instants) -> tuple[Floats, Floats]:
    """Position [m] and velocity [m/s], GCRS, shape (n, 3), from the two (checked) lines of a set.

    The velocity takes TEME as inertial, which costs 1e-4 m/s in a low orbit. A decayed satellite,
    or what else SGP4 reports, is an SGP4Error; without the package sgp4 it is an ImportError.
    """
    position, velocity = sgp4_teme(line1, line2, at)
    rotation = teme_to_gcrs(at)
    return rotate(rotation, position), rotate(rotation, velocity)


def sgp4_teme(line1: str, line2: str, at: Instants) -> tuple[Floats, Floats]:
    """As `sgp4_gcrs`, in SGP4's own frame, the true equator and mean equinox of date."""
    try:
        from sgp4.api import SGP4_ERRORS, Satrec
    except ImportError as error:
        raise ImportError(
            "a two-line element set needs the package sgp4: pip install sgp4"
        ) from error
    satellite = Satrec.twoline2rv(line1, line2)  # with WGS72, for which element sets are made
    codes, position, velocity = satellite.sgp4_array(np.full_like(at.ut, at.midnight), at.ut)
    for k in np.flatnonzero(codes)[:1]:
        raise SGP4Error(
            f"satellite {line1[2:7]}: SGP4 error {codes[k]} at t = "
            f"{(at.ut[k] - at.ut[0]) * DAY:.1f} s, {SGP4_ERRORS[int(codes[k])]}"
        )
    return 1e3 * position, 1e3 * velocity


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
