"""Geomagnetic field of IGRF-14, compared with the original program `igrf14syn`."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude.environment.field import geomagnetic_field
from threadpoolctl import threadpool_limits

REFERENCE = Path(__file__).parents[1] / "reference" / "igrf14_geocentric.txt"
_DATE = datetime(2020, 6, 19, tzinfo=UTC)


def parse_decimal_year(decimal_year: float) -> datetime:
    year = int(decimal_year)
    start, end = datetime(year, 1, 1, tzinfo=UTC), datetime(year + 1, 1, 1, tzinfo=UTC)
    return start + (decimal_year - year) * (end - start)


def compute_local_axes(colatitude: np.ndarray, longitude: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return unit vectors to the north, to the east and down, each of shape (n, 3)."""
    sin_c, cos_c = np.sin(colatitude), np.cos(colatitude)
    sin_l, cos_l = np.sin(longitude), np.cos(longitude)
    north = np.stack([-cos_c * cos_l, -cos_c * sin_l, sin_c], axis=1)
    east = np.stack([-sin_l, cos_l, 0.0 * cos_l], axis=1)
    down = -np.stack([sin_c * cos_l, sin_c * sin_l, cos_c], axis=1)
    return north, east, down


@pytest.mark.slow
def test_field_equals_igrf14syn() -> None:
    """Years with many rows are compared, since a call has a single date."""
    rows = np.loadtxt(REFERENCE)
    rows = rows[rows[:, 0] <= 2030.0]
    years, inverse, counts = np.unique(rows[:, 0], return_inverse=True, return_counts=True)
    busiest = np.argsort(-counts, kind="stable")[:75]
    chosen = {0, len(years) - 1, *busiest.tolist()}  # The first and the last year are included.
    n_compared, max_error = 0, 0.0
    for index in chosen:
        _, radius, colatitude_deg, longitude_deg, *components, total = rows[inverse == index].T
        axes = compute_local_axes(np.radians(colatitude_deg), np.radians(longitude_deg))
        position = -1e3 * radius[:, None] * axes[2]
        field = geomagnetic_field(position, parse_decimal_year(years[index]))
        for axis, component in zip(axes, components, strict=True):
            max_error = max(max_error, np.abs((field * axis).sum(axis=1) - component).max())
        max_error = max(max_error, np.abs(np.linalg.norm(field, axis=1) - total).max())
        n_compared += len(total)
    assert n_compared >= 300
    assert max_error < 0.3


@pytest.mark.slow
def test_field_of_many_points_equals_field_of_few_points() -> None:
    rng = np.random.default_rng(0)
    date = datetime(2025, 1, 1, tzinfo=UTC)
    position = 7e6 * rng.uniform(-1.0, 1.0, (21000, 3)) + [7e6, 0.0, 0.0]
    selection = np.arange(19990, 20010)
    field, few_points = (
        geomagnetic_field(position, date)[selection],
        geomagnetic_field(position[selection], date),
    )
    np.testing.assert_allclose(field, few_points, rtol=1e-12, atol=1e-9 * np.abs(few_points).max())


@pytest.mark.parametrize("pole", [1.0, -1.0])
def test_field_is_continuous_at_poles(pole: float) -> None:
    """The field at the pole is the mean of opposite points near the pole."""
    z = pole * 7.1e6
    ring = np.array([[30.0, 0.0, z], [-30.0, 0.0, z], [0.0, 30.0, z], [0.0, -30.0, z]])
    at_pole = geomagnetic_field(np.array([[0.0, 0.0, z]]), _DATE)[0]
    around = geomagnetic_field(ring, _DATE)
    assert np.isfinite(at_pole).all()
    np.testing.assert_allclose(at_pole, around.mean(axis=0), atol=1e-3)
    np.testing.assert_allclose(around, np.broadcast_to(at_pole, (4, 3)), atol=1.0)


def test_date_outside_model_years_is_rejected() -> None:
    date = datetime(2030, 1, 1, 0, 0, 1, tzinfo=UTC)
    with pytest.raises(ValueError, match=r"date = .*IGRF-14, from 1900-01-01 to 2030-01-01"):
        geomagnetic_field(np.array([[7e6, 0.0, 0.0]]), date)


def test_field_does_not_depend_on_number_of_blas_threads() -> None:
    position = np.random.default_rng(0).normal(size=(5001, 3))
    position *= 7e6 / np.linalg.norm(position, axis=1, keepdims=True)
    fields = []
    for threads in (1, 2):
        with threadpool_limits(threads, user_api="blas"):
            fields.append(geomagnetic_field(position, _DATE))
    np.testing.assert_array_equal(*fields)
