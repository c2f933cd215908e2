"""Geomagnetic field of the model IGRF-14 (IAGA), evaluated by ppigrf, and its gradient."""

from __future__ import annotations

import math
from datetime import datetime
from threading import Lock

import numpy as np
from threadpoolctl import threadpool_limits

from mgeo_attitude._typing import Complexes, Floats
from mgeo_attitude.environment.constants import FIELD_MODEL_END, FIELD_MODEL_START
from mgeo_attitude.environment.times import as_utc

# East and south are undefined at the poles. Positions are moved 1e-7° (1 cm) away from the poles,
# which changes the field vector by less than 1e-4 nT.
_MIN_POLE_DISTANCE = np.radians(1e-7)

# ppigrf needs 13 kB per point. Batches of this size fit in the cache, which halves the run time.
_BATCH_SIZE = 4096

# The order of sums in BLAS depends on the number of threads. With one thread, the last bit of the
# field, and so the result of a seeded run, does not depend on the number of processors. The limit
# applies to the whole process, so that concurrent calls must wait.
_blas_lock = Lock()

#: Degree and order of IGRF, and its reference radius [m].
FIELD_DEGREE = 13
FIELD_RADIUS = 6371200.0


def geomagnetic_field(position: Floats, date: datetime) -> Floats:
    """Evaluate the IGRF-14 geomagnetic field [nT] at given positions [m] on one date.

    Positions and field vectors are in ITRS, shape (n, 3). The field changes by about 0.3 nT per
    day, so that the date in the middle of a run is valid for the whole run.

    Raises
    ------
    ValueError
        If the date has no UTC offset or is outside of the model's years.
    """
    utc = _check_date(date)
    pieces = range(0, max(len(position), 1), _BATCH_SIZE)
    with _blas_lock, threadpool_limits(1, user_api="blas"):
        return np.concatenate([_evaluate_field(position[k : k + _BATCH_SIZE], utc) for k in pieces])


def field_gradient(position: Floats, date: datetime) -> Floats:
    """Evaluate the gradient of the IGRF-14 geomagnetic field [nT/m] in ITRS, shape (n, 3, 3).

    Rows are components of the field, and columns are components of the position. Parameters and
    exceptions are those of `geomagnetic_field`.
    """
    coefficients = load_gauss_coefficients(_check_date(date))
    pieces = range(0, max(len(position), 1), _BATCH_SIZE)
    return np.concatenate(
        [_evaluate_gradient(position[k : k + _BATCH_SIZE], coefficients) for k in pieces]
    )


def load_gauss_coefficients(date: datetime) -> Complexes:
    """Load the Gauss coefficients g + ih of IGRF-14 [nT] for a given date.

    The coefficients are Schmidt quasi-normalized. The complex array is indexed by degree and order.
    """
    import ppigrf

    g, h = ppigrf.ppigrf.read_shc()
    at = np.datetime64(as_utc(date).replace(tzinfo=None))
    days = (g.index.to_numpy().astype("datetime64[us]") - at) / np.timedelta64(1, "D")
    coefficients = np.zeros((FIELD_DEGREE + 1, FIELD_DEGREE + 1), dtype=np.complex128)
    for n, m in g.columns:
        for table, unit in ((g, 1.0), (h, 1j)):
            coefficients[n, m] += unit * np.interp(0.0, days, table[n, m].to_numpy(dtype=float))
    return coefficients


def _check_date(date: datetime) -> datetime:
    utc = as_utc(date)
    if not FIELD_MODEL_START <= utc <= FIELD_MODEL_END:
        raise ValueError(
            f"date = {date.isoformat()}: expected a date in the years of IGRF-14, from "
            f"{FIELD_MODEL_START:%Y-%m-%d} to {FIELD_MODEL_END:%Y-%m-%d} UTC"
        )
    return utc


def _evaluate_field(position: Floats, utc: datetime) -> Floats:
    import ppigrf  # This imports pandas, which takes a third of a second.

    x, y, z = position.T
    radius = np.linalg.norm(position, axis=1)
    colatitude = np.clip(
        np.arctan2(np.hypot(x, y), z), _MIN_POLE_DISTANCE, np.pi - _MIN_POLE_DISTANCE
    )
    longitude = np.arctan2(y, x)
    # A single date is passed, since ppigrf returns every combination of dates and points.
    outward, southward, eastward = ppigrf.igrf_gc(
        radius / 1e3, np.degrees(colatitude), np.degrees(longitude), utc.replace(tzinfo=None)
    )
    sin_c, cos_c = np.sin(colatitude), np.cos(colatitude)
    sin_l, cos_l = np.sin(longitude), np.cos(longitude)
    horizontal = outward[0] * sin_c + southward[0] * cos_c
    return np.stack(
        [
            horizontal * cos_l - eastward[0] * sin_l,
            horizontal * sin_l + eastward[0] * cos_l,
            outward[0] * cos_c - southward[0] * sin_c,
        ],
        axis=1,
    )


def _evaluate_gradient(position: Floats, coefficients: Complexes) -> Floats:
    """Compute the field gradient as the negative second derivatives of the scalar potential.

    The potential is a Σ (a/r)ⁿ⁺¹ (g cos mλ + h sin mλ) P_n^m. The derivatives of solid harmonics
    I_n^m = (n - m)! P_n^m(cos θ) exp(imλ) / rⁿ⁺¹ are solid harmonics: ∂z I_n^m = -I_{n+1}^m and (∂x
    + i∂y) I_n^m = -I_{n+1}^{m+1}, with I_n^-m = (-1)^m conj(I_n^m).
    """
    N = FIELD_DEGREE
    x, y, z = position.T / FIELD_RADIUS
    r2 = x * x + y * y + z * z
    # The second axis has the orders from -(N + 2) to N + 2.
    solid = np.zeros((N + 3, 2 * N + 5, len(position)), dtype=np.complex128)
    nonnegative = solid[:, N + 2 :]
    nonnegative[0, 0] = 1.0 / np.sqrt(r2)
    for m in range(N + 3):
        if m:
            nonnegative[m, m] = (2 * m - 1) * (x + 1j * y) / r2 * nonnegative[m - 1, m - 1]
        for n in range(m, N + 2):
            nonnegative[n + 1, m] = (2 * n + 1) * z * nonnegative[n, m] / r2
            if n > m:
                nonnegative[n + 1, m] -= (n * n - m * m) * nonnegative[n - 1, m] / r2
        solid[:, N + 2 - m] = (-1) ** m * nonnegative[:, m].conj()
    weights = np.zeros((N + 1, 2 * N + 1), dtype=np.complex128)
    for n in range(1, N + 1):
        for m in range(n + 1):
            c = coefficients[n, m] / math.sqrt(math.factorial(n - m) * math.factorial(n + m))
            weights[n, N + m] += c.conjugate() / math.sqrt(2.0 if m else 4.0)
            weights[n, N - m] += (-1) ** m * c / math.sqrt(2.0 if m else 4.0)
    # These are ∂z², (∂x + i∂y) ∂z and (∂x + i∂y)² of the potential, where ∂x² + ∂y² = -∂z².
    zz, tilted, square = (
        np.einsum("nm,nmk->k", weights, solid[2:, 2 + up : 2 * N + 3 + up], optimize=True)
        for up in range(3)
    )
    xx, xy = 0.5 * (square.real - zz.real), 0.5 * square.imag
    xz, yz = tilted.real, tilted.imag
    rows = [[xx, xy, xz], [xy, -zz.real - xx, yz], [xz, yz, zz.real]]
    return np.moveaxis(np.array(rows), 2, 0) / -FIELD_RADIUS


def dipole_gradient(position: Floats, field: Floats) -> Floats:
    """Approximate the gradient of a magnetic field by that of a dipole at the Earth's center.

    At each position, the dipole produces the given field vector. The field of a dipole m is B = (3
    (m·n) n - m) / r³ with n = position / r, so that the moment follows from one field vector. The
    gradient is symmetric and has zero trace, as in every current-free field. The dipole
    approximates a field of which only values are given. At 750 km its gradient differs from that of
    IGRF by 12 % (root mean square).

    Parameters
    ----------
    position, field : arrays, shape (n, 3)
        Positions relative to the Earth's center and field vectors, in the same axes.

    Returns
    -------
    array, shape (n, 3, 3)
        Rows are components of the field, and columns are components of the position. The unit is
        that of the field per unit of the position.
    """
    r = np.linalg.norm(position, axis=1)[:, None, None]
    n = (position / r[:, 0])[:, :, None]
    B = field[:, :, None]
    radial = (n * B).sum(axis=1, keepdims=True)
    m = 1.5 * radial * n - B  # This is the moment divided by r³.
    both = m @ n.swapaxes(1, 2)
    axial = radial * (0.5 * np.eye(3) - 2.5 * n @ n.swapaxes(1, 2))
    gradient: Floats = 3.0 / r * (both + both.swapaxes(1, 2) + axial)
    return gradient
