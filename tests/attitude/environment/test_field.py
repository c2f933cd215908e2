"""IGRF-14 against the original program `igrf14syn`, and at its limits."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude.environment.field import geomagnetic_field
from threadpoolctl import threadpool_limits

REFERENCE = Path(__file__).parents[1] / "reference" / "igrf14_geocentric.txt"
_DATE = datetime(2020, 6, 19, tzinfo=UTC)


def date_of(decimal_year: float) -> datetime:
    year = int(decimal_year)
    start, end = datetime(year, 1, 1, tzinfo=UTC), datetime(year + 1, 1, 1, tzinfo=UTC)
    return start + (decimal_year - year) * (end - start)


def local_axes(colatitude: np.ndarray, longitude: np.ndarray) -> tuple[np.ndarray, ...]:
    """Unit vectors to the north, the east and down, each (n, 3)."""
    sin_c, cos_c = np.sin(colatitude), np.cos(colatitude)
    sin_l, cos_l = np.sin(longitude), np.cos(longitude)
    north = np.stack([-cos_c * cos_l, -cos_c * sin_l, sin_c], axis=1)
    east = np.stack([-sin_l, cos_l, 0.0 * cos_l], axis=1)
    down = -np.stack([sin_c * cos_l, sin_c * sin_l, cos_c], axis=1)
    return north, east, down


@pytest.mark.slow
def test_against_igrf14syn() -> None:
    """The years with most rows, so that a call, which takes one date, covers several of them."""
    rows = np.loadtxt(REFERENCE)
    rows = rows[rows[:, 0] <= 2030.0]
    years, inverse, counts = np.unique(rows[:, 0], return_inverse=True, return_counts=True)
    busiest = np.argsort(-counts, kind="stable")[:75]
    chosen = {0, len(years) - 1, *busiest.tolist()}  # with the first and last year of all
    compared, worst = 0, 0.0
    for index in chosen:
        _, radius, colatitude_deg, longitude_deg, *components, total = rows[inverse == index].T
        axes = local_axes(np.radians(colatitude_deg), np.radians(longitude_deg))
        position = -1e3 * radius[:, None] * axes[2]
        field = geomagnetic_field(position, date_of(years[index]))
        for axis, component in zip(axes, components, strict=True):
            worst = max(worst, np.abs((field * axis).sum(axis=1) - component).max())
        worst = max(worst, np.abs(np.linalg.norm(field, axis=1) - total).max())
        compared += len(total)
    assert compared >= 300
    assert worst < 0.3


@pytest.mark.slow
def test_many_points_are_those_of_each_alone() -> None:
    rng = np.random.default_rng(0)
    date = datetime(2025, 1, 1, tzinfo=UTC)
    position = 7e6 * rng.uniform(-1.0, 1.0, (21000, 3)) + [7e6, 0.0, 0.0]
    some = np.arange(19990, 20010)
    field, alone = geomagnetic_field(position, date)[some], geomagnetic_field(position[some], date)
    np.testing.assert_allclose(field, alone, rtol=1e-12, atol=1e-9 * np.abs(alone).max())


@pytest.mark.parametrize("pole", [1.0, -1.0])
def test_continuous_through_the_poles(pole: float) -> None:
    """At the exact pole the field is the mean of opposite points beside it."""
    z = pole * 7.1e6
    ring = np.array([[30.0, 0.0, z], [-30.0, 0.0, z], [0.0, 30.0, z], [0.0, -30.0, z]])
    at_pole = geomagnetic_field(np.array([[0.0, 0.0, z]]), _DATE)[0]
    around = geomagnetic_field(ring, _DATE)
    assert np.isfinite(at_pole).all()
    np.testing.assert_allclose(at_pole, around.mean(axis=0), atol=1e-3)
    np.testing.assert_allclose(around, np.broadcast_to(at_pole, (4, 3)), atol=1.0)


def test_dates_outside_the_model_are_refused() -> None:
    date = datetime(2030, 1, 1, 0, 0, 1, tzinfo=UTC)
    with pytest.raises(ValueError, match=r"date = .*IGRF-14, from 1900-01-01 to 2030-01-01"):
        geomagnetic_field(np.array([[7e6, 0.0, 0.0]]), date)


def test_it_is_the_same_to_the_last_bit_in_however_many_threads_blas_has() -> None:
    position = np.random.default_rng(0).normal(size=(5001, 3))
    position *= 7e6 / np.linalg.norm(position, axis=1, keepdims=True)
    found = []
    for threads in (1, 2):
        with threadpool_limits(threads, user_api="blas"):
            found.append(geomagnetic_field(position, _DATE))
    np.testing.assert_array_equal(*found)
