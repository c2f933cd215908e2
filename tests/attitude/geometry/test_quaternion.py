"""Quaternions, compared with the CCSDS standard and scipy, and UTC time stamps."""

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.geometry.quaternion import interpolate_quaternions, quaternions_from_matrices
from scipy.spatial.transform import Rotation

HALF = np.sqrt(0.5)


def test_quaternion_equals_example_of_ccsds_standard():
    """CCSDS 504.0-B-2, F2.2: the body is rotated by +90 deg about z."""
    matrix = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(matrix @ [1.0, 0.0, 0.0], [0.0, -1.0, 0.0])
    np.testing.assert_allclose(
        quaternions_from_matrices(matrix[None]), [[0.0, 0.0, HALF, HALF]], atol=1e-15
    )


@pytest.mark.parametrize("noise", [1e-16, -1e-16])
def test_half_turn_has_unique_sign(noise):
    C = Rotation.from_rotvec([0.0, -np.pi + noise, 0.0]).as_matrix()
    np.testing.assert_allclose(
        quaternions_from_matrices(C[None]), [[0.0, 1.0, 0.0, 0.0]], atol=1e-9
    )


vectors = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3).map(np.array)


@given(vectors, vectors)
def test_quaternion_transforms_inertial_to_body_coordinates(rotvec, v):
    """The quaternion rotates GCRF axes to body axes, so that its inverse transforms coordinates."""
    C = Rotation.from_rotvec(rotvec).as_matrix()
    (q,) = quaternions_from_matrices(C[None])
    assert q[3] >= -1e-9
    np.testing.assert_allclose(Rotation.from_quat(q).inv().apply(v), C @ v, atol=1e-12)


@given(vectors.filter(lambda w: np.linalg.norm(w) > 1e-3), st.floats(0.0, 9.0))
def test_interpolated_attitude_rotates_at_constant_rate(omega, at):
    times = np.arange(10.0)
    C = Rotation.from_rotvec(-np.outer(times, 0.5 * omega)).as_matrix()
    grid = np.linspace(0.0, 9.0, 91)
    q = interpolate_quaternions(times, C, np.append(grid, at))
    exact = Rotation.from_rotvec(-at * 0.5 * omega).as_matrix()
    v = np.array([0.3, -0.2, 0.9])
    np.testing.assert_allclose(Rotation.from_quat(q[-1]).inv().apply(v), exact @ v, atol=1e-12)
    assert q[0, 3] == 1.0
    assert (np.einsum("ki,ki->k", q[:90], q[1:91]) > 0.0).all()  # The sign does not jump.


@given(
    st.datetimes(datetime(2017, 1, 2), datetime(2030, 1, 1)),
    st.integers(0, 10**11),
)
def test_time_stamps_equal_calendar_between_leap_seconds(epoch, microseconds):
    expected = epoch + timedelta(microseconds=microseconds)
    (text,) = format_time_stamps(epoch.replace(tzinfo=UTC), [1e-6 * microseconds])
    actual = datetime.fromisoformat(text)
    assert abs(actual - expected) <= timedelta(microseconds=1)  # resolution of a float
    assert len(text) == 26


def test_time_stamps_include_leap_second_of_2016():
    epoch = datetime(2016, 12, 31, 23, 59, 59, tzinfo=UTC)
    assert format_time_stamps(epoch, [0.0, 1.0, 1.5, 2.0]) == [
        "2016-12-31T23:59:59.000000",
        "2016-12-31T23:59:60.000000",
        "2016-12-31T23:59:60.500000",
        "2017-01-01T00:00:00.000000",
    ]


def test_time_stamps_support_offsets_and_years_without_leap_seconds():
    west = timezone(timedelta(hours=-3))
    assert format_time_stamps(datetime(2018, 6, 4, 21, tzinfo=west), 60.25) == [
        "2018-06-05T00:01:00.250000"
    ]
    assert format_time_stamps(datetime(1950, 1, 1, tzinfo=UTC), [1.0]) == [
        "1950-01-01T00:00:01.000000"
    ]
    assert format_time_stamps(datetime(2029, 12, 31, tzinfo=UTC), [1.0]) == [
        "2029-12-31T00:00:01.000000"
    ]
