"""Instants of a plan as UTC text, leap seconds included."""

from __future__ import annotations

from datetime import datetime

import erfa
import numpy as np
from numpy.typing import ArrayLike

from ..constants import DAY
from ..environment.time_frames import as_utc


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
