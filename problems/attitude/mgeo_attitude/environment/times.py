"""Instants: time scales, seconds between them, and texts, ISO 8601, that files have of them."""

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

# calendar dates and days of the year: CCSDS 301.0-B, sections 3.5.1.1 and 3.5.1.2
_STAMP = re.compile(
    r"(\d{4})-(?:(\d\d)-(\d\d)|(\d{3}))[T ](\d\d):(\d\d)(?::(\d\d(?:\.\d*)?))?(?:Z|\+00:00)?"
)

#: TAI less the time of each uniform time scale [s]; UTC has leap seconds.
TAI_MINUS = {"TAI": 0.0, "GPS": 19.0, "TT": -erfa.TTMTAI}


class Instants(NamedTuple):
    """Julian dates in two parts: one midnight for all, and days after it, shape (n,).

    `ut` counts SI seconds from the UTC epoch, standing for UTC and UT1 alike; it runs on through a
    leap second, as UT1 does. `tt` is terrestrial time (TDB is within 2 ms).
    """

    midnight: float
    ut: Floats
    tt: Floats


def as_utc(epoch: datetime) -> datetime:
    """The epoch in UTC; without a UTC offset it is a ValueError."""
    if epoch.utcoffset() is None:
        raise ValueError(f"epoch = {epoch.isoformat()}: expected a UTC offset, such as tzinfo=UTC")
    return epoch.astimezone(UTC)


def instants(epoch: datetime, times: ArrayLike) -> Instants:
    """Julian dates at `times` [s], shape (n,), after an epoch with a UTC offset.

    Leap seconds are those of erfa. It has none before 1960, when UTC did not exist, and none yet
    announced for years to come: TT is then off by up to 40 s and by the leap seconds still to be
    added, which turns the Sun by less than 0.0005°.
    """
    utc = as_utc(epoch)
    midnight = utc.replace(hour=0, minute=0, second=0, microsecond=0)
    day_fraction = (utc - midnight).total_seconds() / DAY
    ut = day_fraction + np.asarray(times, dtype=np.float64) / DAY
    return Instants(
        midnight=_MJD_ZERO + (midnight - _MJD_START).days,
        ut=ut,
        tt=ut + (tai_minus_utc(utc) + erfa.TTMTAI) / DAY,
    )


def elapsed(since: datetime, until: datetime) -> float:
    """SI seconds from one instant to another, with the leap seconds between them."""
    start, end = as_utc(since), as_utc(until)
    return (end - start).total_seconds() + tai_minus_utc(end) - tai_minus_utc(start)


def instant_after(epoch: datetime, seconds: float) -> datetime:
    """The instant some SI seconds after an epoch, UTC, with the leap seconds between them."""
    instant = as_utc(epoch) + timedelta(seconds=seconds)
    return instant - timedelta(seconds=elapsed(epoch, instant) - seconds)


def utc_text(epoch: datetime, seconds: float) -> str:
    """An instant some seconds after an epoch, for messages: 2018-06-05T00:00:00.000Z."""
    instant = as_utc(epoch) + timedelta(seconds=float(seconds))
    return instant.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def tai_minus_utc(utc: datetime) -> float:
    """Seconds by which TAI is ahead of UTC then, see `instants`."""
    midnight = utc.replace(hour=0, minute=0, second=0, microsecond=0)
    # erfa.dat would warn of some years, and filters of warnings are shared by all threads
    fraction = (utc - midnight).total_seconds() / DAY
    return float(erfa.ufunc.dat(utc.year, utc.month, utc.day, fraction)[0])


def seconds_after(epoch: datetime, stamps: Sequence[str], system: str = "UTC") -> Floats:
    """Return SI seconds from an epoch with a UTC offset to time stamps, shape (n,).

    Between 23:59:59 and midnight a leap second is second 60.

    Parameters
    ----------
    system : str
        Time scale of the stamps: UTC or one of `TAI_MINUS`.

    Raises
    ------
    ValueError
        For text that is no time stamp.
    """
    utc = as_utc(epoch)
    days, clocks = zip(*map(_parts, stamps), strict=True) if stamps else ((), ())
    seconds = np.array([DAY * (day - utc.date()).days for day in days]) + np.array(clocks)
    dates = np.array([(day.year, day.month, day.day) for day in days]).reshape(-1, 3)
    ahead = _tai_minus(system, dates, np.minimum(np.array(clocks) / DAY, 1.0))
    midnight = utc.replace(hour=0, minute=0, second=0, microsecond=0)
    # whole numbers first: sums of hours and fractions keep the last digit of a microsecond
    return np.asarray(seconds - (utc - midnight).total_seconds() + (ahead - tai_minus_utc(utc)))


def clock_seconds_after(epoch: datetime, seconds: ArrayLike, system: str = "UTC") -> Floats:
    """Return SI seconds from an epoch with a UTC offset to calendar instants, shape (n,).

    Parameters
    ----------
    seconds : array_like, shape (n,)
        Calendar seconds from the epoch's date to dates of a time scale, without leap seconds, as
        Unix counts; NaN stays.
    system : str
        Time scale of the dates: UTC or one of `TAI_MINUS`.
    """
    utc, clock = as_utc(epoch), np.asarray(seconds, dtype=float)
    known = np.isfinite(clock)
    midnight = utc.replace(hour=0, minute=0, second=0, microsecond=0)
    today = np.floor(((utc - midnight).total_seconds() + clock[known]) / DAY).astype(np.int64)
    days, which = np.unique(today, return_inverse=True)
    dates = [((midnight + timedelta(days=int(day))).timetuple()[:3]) for day in days]
    ahead = _tai_minus(system, np.array(dates).reshape(-1, 3), np.zeros(len(dates)))
    found = clock.copy()
    found[known] += ahead[which] - tai_minus_utc(utc)
    return found


def _tai_minus(system: str, dates: Ints, fractions: Floats) -> Floats:
    """TAI less a time scale [s] on dates (year, month, day), shape (n, 3), and day fractions."""
    if system in TAI_MINUS:
        return np.full(len(dates), TAI_MINUS[system])
    # erfa.dat would warn of years before 1960 and of those to come
    ahead: Floats = erfa.ufunc.dat(*dates.T, fractions)[0]
    return ahead


def _parts(stamp: str) -> tuple[date, float]:
    """The day, and seconds since its midnight."""
    found = _STAMP.fullmatch(stamp)
    try:
        year, month, day, ordinal, hour, minute, second = found.groups("0") if found else ()
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


def utc_texts(epoch: datetime, times: ArrayLike) -> list[str]:
    """ISO 8601 texts of the instants `times` [s], shape (n,), of SI seconds after an epoch.

    Microseconds and no designator, such as ``2018-06-05T00:00:01.000000``: the calendar format of
    CCSDS 301.0-B. A leap second is written as second 60.

    Raises
    ------
    ValueError
        For an epoch without UTC offset.
    """
    utc = as_utc(epoch)
    seconds = utc.second + 1e-6 * utc.microsecond
    # No leap seconds before 1960, and none yet announced for years to come: erfa's own functions
    # would warn of such years, and filters of warnings are shared by all threads.
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
