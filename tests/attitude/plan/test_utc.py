"""UTC texts against Python's calendar, and across leap seconds, which it does not know."""

from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mgeo_attitude.plan.utc import utc_texts


@given(
    st.datetimes(datetime(2017, 1, 2), datetime(2030, 1, 1)),
    st.integers(0, 10**11),
)
def test_between_leap_seconds_it_is_the_calendar(epoch, microseconds):
    expected = epoch + timedelta(microseconds=microseconds)
    (text,) = utc_texts(epoch.replace(tzinfo=UTC), [1e-6 * microseconds])
    found = datetime.fromisoformat(text)
    assert abs(found - expected) <= timedelta(microseconds=1)  # of a float, after 10^11 of them
    assert len(text) == 26


def test_the_leap_second_of_2016():
    epoch = datetime(2016, 12, 31, 23, 59, 59, tzinfo=UTC)
    assert utc_texts(epoch, [0.0, 1.0, 1.5, 2.0]) == [
        "2016-12-31T23:59:59.000000",
        "2016-12-31T23:59:60.000000",
        "2016-12-31T23:59:60.500000",
        "2017-01-01T00:00:00.000000",
    ]


def test_other_offsets_and_years_without_leap_seconds():
    west = timezone(timedelta(hours=-3))
    assert utc_texts(datetime(2018, 6, 4, 21, tzinfo=west), 60.25) == ["2018-06-05T00:01:00.250000"]
    assert utc_texts(datetime(1950, 1, 1, tzinfo=UTC), [1.0]) == ["1950-01-01T00:00:01.000000"]
    assert utc_texts(datetime(2029, 12, 31, tzinfo=UTC), [1.0]) == ["2029-12-31T00:00:01.000000"]


def test_a_naive_epoch_is_refused():
    with pytest.raises(ValueError, match="UTC offset"):
        utc_texts(datetime(2018, 6, 5), [0.0])
