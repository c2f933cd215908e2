"""Time stamps with leap seconds, compared with erfa and astropy."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

import erfa
import numpy as np
import pytest
from astropy import units
from astropy.time import Time
from mgeo_attitude.environment.times import (
    convert_calendar_seconds,
    parse_time_stamps,
    seconds_between,
)

EPOCH = datetime(2016, 12, 31, 23, 59, 50, 250000, tzinfo=UTC)


def test_elapsed_seconds_include_leap_second() -> None:
    stamps = ["2016-12-31T23:59:59.25", "2016-12-31T23:59:60.25", "2017-01-01T00:00:00.25"]
    np.testing.assert_allclose(
        parse_time_stamps(EPOCH, stamps), [9.0, 10.0, 11.0], rtol=0, atol=1e-9
    )
    assert seconds_between(EPOCH, EPOCH + timedelta(seconds=10)) == pytest.approx(11.0, abs=1e-9)


@pytest.mark.parametrize("stamp", ["2016-12-31T23:59:51.25", "2016-366T23:59:51.25Z"])
def test_calendar_date_and_day_of_year_are_equivalent(stamp: str) -> None:
    assert parse_time_stamps(EPOCH, [stamp])[0] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("system", ["TAI", "GPS", "TT"])
def test_uniform_time_scales_agree_with_astropy(system: str) -> None:
    utc = Time("2023-03-04T05:06:07.5", scale="utc")
    stamp = (utc.tai - 19.0 * units.s if system == "GPS" else getattr(utc, system.lower())).isot
    actual = parse_time_stamps(datetime(2023, 3, 4, 5, 6, 0, tzinfo=UTC), [stamp], system)
    assert actual[0] == pytest.approx(7.5, abs=1e-3)  # The format isot has milliseconds.
    clock = (datetime.fromisoformat(stamp).replace(tzinfo=UTC) - EPOCH).total_seconds()
    assert convert_calendar_seconds(EPOCH, [clock], system)[0] == pytest.approx(
        (utc - Time(EPOCH.replace(tzinfo=None), scale="utc")).to_value("s"), abs=1e-3
    )


def test_elapsed_seconds_agree_with_erfa() -> None:
    epoch = datetime(1972, 7, 1, 3, tzinfo=timezone(timedelta(hours=1)))
    start = sum(np.array(erfa.utctai(*erfa.dtf2d("UTC", 1972, 7, 1, 2, 0, 0.0))))
    for year in range(1973, 2024):
        end = sum(np.array(erfa.utctai(*erfa.dtf2d("UTC", year, 2, 3, 4, 5, 6.0))))
        actual = parse_time_stamps(epoch, [f"{year}-02-03T04:05:06"])[0]
        assert actual == pytest.approx(
            86400.0 * (end - start), abs=1e-4
        )  # A Julian date in a single float has this resolution.
        assert actual == seconds_between(epoch, datetime(year, 2, 3, 4, 5, 6, tzinfo=UTC))


@pytest.mark.parametrize(
    "stamp",
    ["",  "2018-02-30T00:00:00", "2018-366T00:00:00",
     "2018-01-01T00:60:00", "2018-01-01T00:00:60", "2018-01-01T00:00:00+01:00", ],
)  # fmt: skip
def test_invalid_time_stamp_is_rejected(stamp: str) -> None:
    with pytest.raises(ValueError, match=r"^time '.*': expected one such as 2018-06-05T00:00:00"):
        parse_time_stamps(EPOCH, [stamp])
