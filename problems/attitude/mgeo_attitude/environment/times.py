"""Time scales, elapsed seconds and ISO 8601 time stamps."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, date, datetime, timedelta
from typing import NamedTuple

import erfa
import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment.constants import DAY

_MJD_ZERO = 2400000.5
_MJD_START = datetime(1858, 11, 17, tzinfo=UTC)

# The pattern matches calendar dates and days of the year, CCSDS 301.0-B, 3.5.1.1 and 3.5.1.2.
_STAMP = re.compile(
    r"(\d{4})-(?:(\d\d)-(\d\d)|(\d{3}))[T ](\d\d):(\d\d)(?::(\d\d(?:\.\d*)?))?(?:Z|\+00:00)?"
)

#: TAI minus the time of each uniform time scale [s].
TAI_OFFSETS = {"TAI": 0.0, "GPS": 19.0, "TT": -erfa.TTMTAI}


class JulianDates(NamedTuple):
    """Julian dates of n instants in UT and TT, relative to a common midnight.

    `ut` represents both UTC and UT1 by SI seconds since the UTC epoch, and is continuous through a
    leap second like UT1. `tt` is terrestrial time, which differs from TDB by less than 2 ms.
    """

    midnight: float
    ut: Floats
    tt: Floats


def as_utc(epoch: datetime) -> datetime:
    """Convert a datetime with UTC offset to UTC.

    Raises
    ------
    ValueError
        If the epoch has no UTC offset.
    """
    if epoch.utcoffset() is None:
        raise ValueError(f"epoch = {epoch.isoformat()}: expected a UTC offset, such as tzinfo=UTC")
    return epoch.astimezone(UTC)


def compute_julian_dates(epoch: datetime, times: ArrayLike) -> JulianDates:
    """Compute Julian dates at given times [s] after an epoch with UTC offset.

    The leap seconds are those of erfa, which has none before 1960 and none that are not yet
    announced. The error of TT in such years is up to 40 s plus future leap seconds, which changes
    the direction of the Sun by less than 0.0005°.
    """
    utc = as_utc(epoch)
    midnight = utc.replace(hour=0, minute=0, second=0, microsecond=0)
    day_fraction = (utc - midnight).total_seconds() / DAY
    ut = day_fraction + np.asarray(times, dtype=np.float64) / DAY
    return JulianDates(
        midnight=_MJD_ZERO + (midnight - _MJD_START).days,
        ut=ut,
        tt=ut + (tai_minus_utc(utc) + erfa.TTMTAI) / DAY,
    )


def seconds_between(since: datetime, until: datetime) -> float:
    """Return the SI seconds between two datetimes with UTC offset, including leap seconds."""
    start, end = as_utc(since), as_utc(until)
    return (end - start).total_seconds() + tai_minus_utc(end) - tai_minus_utc(start)


def instant_after(epoch: datetime, seconds: float) -> datetime:
    """Add SI seconds to an epoch, counting leap seconds, and return the datetime in UTC."""
    instant = as_utc(epoch) + timedelta(seconds=seconds)
    return instant - timedelta(seconds=seconds_between(epoch, instant) - seconds)


def format_instant(epoch: datetime, seconds: float) -> str:
    """Format an instant as a UTC time stamp such as ``2018-06-05T00:00:00.000Z``.

    The instant is `seconds` after the epoch.
    """
    instant = as_utc(epoch) + timedelta(seconds=float(seconds))
    return instant.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def tai_minus_utc(utc: datetime) -> float:
    """Return TAI minus UTC [s] at a datetime in UTC."""
    midnight = utc.replace(hour=0, minute=0, second=0, microsecond=0)
    # The function erfa.dat warns for some years, and a warning filter would affect all threads.
    fraction = (utc - midnight).total_seconds() / DAY
    return float(erfa.ufunc.dat(utc.year, utc.month, utc.day, fraction)[0])


def parse_time_stamps(epoch: datetime, stamps: Sequence[str], time_scale: str = "UTC") -> Floats:
    """Parse ISO 8601 time stamps, and return SI seconds after an epoch, shape (n,).

    A leap second is second 60 of its minute.

    Parameters
    ----------
    epoch : datetime
    stamps : sequence of str
        ISO 8601, with a calendar date or a day of year.
    time_scale : str
        Time scale of the stamps: UTC or one of `TAI_OFFSETS`.

    Raises
    ------
    ValueError
        If a text is not a time stamp.
    """
    utc = as_utc(epoch)
    days, clocks = zip(*map(_parse_stamp, stamps), strict=True) if stamps else ((), ())
    seconds = np.array([DAY * (day - utc.date()).days for day in days]) + np.array(clocks)
    dates = np.array([(day.year, day.month, day.day) for day in days]).reshape(-1, 3)
    ahead = _compute_tai_offsets(time_scale, dates, np.minimum(np.array(clocks) / DAY, 1.0))
    midnight = utc.replace(hour=0, minute=0, second=0, microsecond=0)
    # Whole seconds are added first to preserve the last digit of a microsecond.
    return np.asarray(seconds - (utc - midnight).total_seconds() + (ahead - tai_minus_utc(utc)))


def convert_calendar_seconds(
    epoch: datetime, seconds: ArrayLike, time_scale: str = "UTC"
) -> Floats:
    """Convert calendar seconds, which omit leap seconds, to SI seconds after an epoch.

    Parameters
    ----------
    epoch : datetime
    seconds : array_like, shape (n,)
        Calendar seconds from the epoch to instants of a time scale, without leap seconds, as in
        Unix time. NaN gives NaN.
    time_scale : str
        Time scale of the dates: UTC or one of `TAI_OFFSETS`.
    """
    utc, clock = as_utc(epoch), np.asarray(seconds, dtype=float)
    is_finite = np.isfinite(clock)
    midnight = utc.replace(hour=0, minute=0, second=0, microsecond=0)
    today = np.floor(((utc - midnight).total_seconds() + clock[is_finite]) / DAY).astype(np.int64)
    days, which = np.unique(today, return_inverse=True)
    dates = [((midnight + timedelta(days=int(day))).timetuple()[:3]) for day in days]
    ahead = _compute_tai_offsets(time_scale, np.array(dates).reshape(-1, 3), np.zeros(len(dates)))
    result = clock.copy()
    result[is_finite] += ahead[which] - tai_minus_utc(utc)
    return result


def _compute_tai_offsets(time_scale: str, dates: Ints, fractions: Floats) -> Floats:
    """Return TAI minus another time scale [s] on each of n dates, shape (n,).

    Parameters
    ----------
    time_scale : str
        UTC or one of `TAI_OFFSETS`.
    dates : array, shape (n, 3)
        Year, month and day.
    fractions : array, shape (n,)
        Fractions of the day.
    """
    if time_scale in TAI_OFFSETS:
        return np.full(len(dates), TAI_OFFSETS[time_scale])
    # Unlike erfa.dat, the ufunc does not warn for years before 1960 and for future years.
    ahead: Floats = erfa.ufunc.dat(*dates.T, fractions)[0]
    return ahead


def _parse_stamp(stamp: str) -> tuple[date, float]:
    match = _STAMP.fullmatch(stamp)
    try:
        year, month, day, ordinal, hour, minute, second = match.groups("0") if match else ()
        first = date(int(year), 1, 1)
        of_year = first + timedelta(days=int(ordinal) - 1)
        when = of_year if int(ordinal) else date(int(year), int(month), int(day))
        last = 61.0 if (hour, minute) == ("23", "59") else 60.0
        day_exists = when.year == first.year
        if not (day_exists and int(hour) < 24 and int(minute) < 60 and float(second) < last):
            raise ValueError("no such time")
    except (ValueError, OverflowError):
        raise ValueError(
            f"time {stamp!r:.60}: expected one such as 2018-06-05T00:00:00.000 or 2018-156T00:00:00"
        ) from None
    return when, 3600.0 * int(hour) + 60.0 * int(minute) + float(second)


def format_time_stamps(epoch: datetime, times: ArrayLike) -> list[str]:
    """Format times [s] after an epoch as UTC time stamps in ISO 8601.

    The time stamps have microseconds and no time zone, such as ``2018-06-05T00:00:01.000000``, as
    in the calendar format of CCSDS 301.0-B. A leap second is second 60.

    Raises
    ------
    ValueError
        If the epoch has no UTC offset.
    """
    utc = as_utc(epoch)
    seconds = utc.second + 1e-6 * utc.microsecond
    # The functions of erfa warn for years before 1960 and for future years, and a warning filter
    # would affect all threads.
    date = utc.year, utc.month, utc.day, utc.hour, utc.minute, seconds
    *start, _ = erfa.ufunc.dtf2d("UTC", *date)
    day, fraction, _ = erfa.ufunc.utctai(*start)
    tai = fraction + np.atleast_1d(np.asarray(times, dtype=float)) / DAY
    *stop, _ = erfa.ufunc.taiutc(day, tai)
    years, months, days, clock, _ = erfa.ufunc.d2dtf("UTC", 6, *stop)
    return [
        f"{year:04}-{month:02}-{day:02}T{c['h']:02}:{c['m']:02}:{c['s']:02}.{c['f']:06}"
        for year, month, day, c in zip(years, months, days, clock, strict=True)
    ]
