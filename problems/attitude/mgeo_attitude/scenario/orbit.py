"""How the satellite moves: Keplerian elements at the epoch, or a two-line element set."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import ClassVar

from ..constants import DAY, EARTH_MU, EARTH_RADIUS
from ..fields import InvalidValue, Validated, quantity

_TLE_LENGTH = 69
_TLE_FIRST_YEAR = 57  # two-digit years from 57 on are 19yy (the first satellite flew in 1957)
_TLE_ANGLES = (  # first and last column on line 2
    (9, 16, "inclination"),
    (18, 25, "right ascension of the node"),
    (35, 42, "argument of perigee"),
    (44, 51, "mean anomaly"),
)


@dataclass(frozen=True, kw_only=True)
class Orbit(Validated):
    """Osculating (two-body) or mean (J2) Keplerian elements at the scenario's epoch, GCRS axes.

    Raises
    ------
    InvalidValue, InvalidType
        For an element out of its range, or a perigee below the Earth's surface.
    """

    propagator: str = quantity(
        "two-body", choices=("two-body", "j2"), doc="unperturbed, or with the secular effects of J2"
    )
    semi_major_axis: float = quantity(unit="m", low=0.0, open_low=True, doc="semi-major axis")
    eccentricity: float = quantity(low=0.0, high=1.0, open_high=True, doc="eccentricity")
    inclination_deg: float = quantity(unit="deg", low=0.0, high=180.0, doc="inclination")
    raan_deg: float = quantity(
        unit="deg", low=-360.0, high=360.0, doc="right ascension of the ascending node"
    )
    argument_of_perigee_deg: float = quantity(
        unit="deg", low=-360.0, high=360.0, doc="argument of perigee"
    )
    true_anomaly_deg: float = quantity(
        unit="deg", low=-360.0, high=360.0, doc="true anomaly at the epoch"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        perigee = self.semi_major_axis * (1.0 - self.eccentricity)
        if perigee <= EARTH_RADIUS:
            raise InvalidValue(
                "semi_major_axis",
                self.semi_major_axis,
                "expected a perigee above the Earth's surface, semi_major_axis * (1 - "
                f"eccentricity) > {EARTH_RADIUS:.12g} m, not {perigee:.12g} m",
            )

    @property
    def period(self) -> float:
        """Keplerian period [s]."""
        return math.tau * math.sqrt(self.semi_major_axis**3 / EARTH_MU)


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
        if self.line1[2:7] != self.line2[2:7]:
            raise InvalidValue(
                "line2",
                self.line2,
                f"expected the satellite number of line 1, {self.line1[2:7]!r} (columns 3-7)",
            )
        day = _entry("line1", self.line1, 21, 32, "day of the year")
        if not 1.0 <= day < 367.0:
            raise InvalidValue("line1", self.line1, "expected a day in [1, 367) (columns 21-32)")
        _entry("line1", self.line1, 19, 20, "year")
        for first, last, element in _TLE_ANGLES:
            _entry("line2", self.line2, first, last, element)
        revolutions = _entry("line2", self.line2, 53, 63, "revolutions a day")
        eccentricity = _entry("line2", self.line2, 27, 33, "eccentricity") * 1e-7
        # Not only decayed satellites: the usual mistake is a line shifted by a column.
        fastest = DAY * math.sqrt(EARTH_MU * ((1.0 - eccentricity) / EARTH_RADIUS) ** 3) / math.tau
        if not 0.0 < revolutions < fastest:
            raise InvalidValue(
                "line2",
                self.line2,
                f"expected a perigee above the Earth's surface, between 0 and {fastest:.6g} "
                "revolutions a day (columns 53-63)",
            )

    @property
    def epoch(self) -> datetime:
        """Epoch of the element set, UTC."""
        short_year = int(self.line1[18:20])
        century = 1900 if short_year >= _TLE_FIRST_YEAR else 2000
        new_year = datetime(century + short_year, 1, 1, tzinfo=UTC)
        return new_year + timedelta(days=float(self.line1[20:32]) - 1.0)

    @property
    def period(self) -> float:
        """Period of the mean motion [s]."""
        return DAY / float(self.line2[52:63])


def _check_line(key: str, line: str, number: str) -> None:
    if len(line) != _TLE_LENGTH or not line.isascii():
        problem = f"expected {_TLE_LENGTH} ASCII characters, not {len(line)}"
    elif not line.startswith(f"{number} "):
        problem = f"expected a line that starts with '{number} '"
    elif line[-1] != (checksum := _checksum(line)):
        problem = f"expected the checksum {checksum} in column {_TLE_LENGTH}, not {line[-1]!r}"
    else:
        return
    raise InvalidValue(key, line, f"{problem} (two-line element set)")


def _checksum(line: str) -> str:
    """Sum of the digits before the last column, a minus sign counting one, modulo 10."""
    return str(sum(1 if c == "-" else int(c) for c in line[:-1] if c.isdigit() or c == "-") % 10)


def _entry(key: str, line: str, first: int, last: int, meaning: str) -> float:
    """The unsigned number in columns `first` to `last`, counted from 1."""
    text = line[first - 1 : last]
    if not re.fullmatch(r" *\d+(\.\d+)? *", text):
        raise InvalidValue(
            key, line, f"expected the {meaning} in columns {first}-{last}, not {text!r}"
        )
    return float(text)
