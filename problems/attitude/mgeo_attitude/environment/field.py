"""Geomagnetic field: IGRF-14 (IAGA), evaluated by ppigrf, and near enough how it changes.

What errors of the position do to it is told by a dipole's gradient.
"""

from __future__ import annotations

from datetime import datetime

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import FIELD_MODEL_END, FIELD_MODEL_START
from mgeo_attitude.environment.time_frames import as_utc

# East and south are undefined on the axis. 1e-7° beside it (1 cm) they are, and the field vector
# is the same to 1e-4 nT as long as these directions are taken at the same point.
_NEAREST_TO_POLE = np.radians(1e-7)

# ppigrf takes 13 kB a point, so that not all points of long telemetry are evaluated at once.
_AT_ONCE = 20000


def geomagnetic_field(position: Floats, date: datetime) -> Floats:
    """Field [nT] at positions [m], both ITRS and of shape (n, 3), on one date for all of them.

    The field drifts by some 0.3 nT a day, so the middle of a run stands for all of it. A date
    without UTC offset, or outside the model's years, is a ValueError.
    """
    utc = as_utc(date)
    if not FIELD_MODEL_START <= utc <= FIELD_MODEL_END:
        raise ValueError(
            f"date = {date.isoformat()}: expected a date in the years of IGRF-14, from "
            f"{FIELD_MODEL_START:%Y-%m-%d} to {FIELD_MODEL_END:%Y-%m-%d} UTC"
        )
    pieces = range(0, max(len(position), 1), _AT_ONCE)
    return np.concatenate([_field(position[k : k + _AT_ONCE], utc) for k in pieces])


def _field(position: Floats, utc: datetime) -> Floats:
    import ppigrf  # it takes pandas a third of a second

    x, y, z = position.T
    radius = np.linalg.norm(position, axis=1)
    colatitude = np.clip(np.arctan2(np.hypot(x, y), z), _NEAREST_TO_POLE, np.pi - _NEAREST_TO_POLE)
    longitude = np.arctan2(y, x)
    # One date, not one per sample: ppigrf returns every combination of dates and points.
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


def dipole_gradient(position: Floats, field: Floats) -> Floats:
    """Derivative of the field by the position of the one dipole at the origin that has this field.

    A dipole m has B = (3 (m·n) n - m) / r³ with n = position / r, so that its moment follows from
    the field at one place. Its gradient is symmetric and of trace zero, as in every field without
    currents. That of IGRF at 750 km differs from it by 12 % (root mean square).

    Parameters
    ----------
    position, field : arrays, shape (n, 3)
        In the same axes.

    Returns
    -------
    array, shape (n, 3, 3)
        Row of the field, column of the position; unit of the field per unit of the position.
    """
    r = np.linalg.norm(position, axis=1)[:, None, None]
    n = (position / r[:, 0])[:, :, None]
    B = field[:, :, None]
    radial = (n * B).sum(axis=1, keepdims=True)
    m = 1.5 * radial * n - B  # the moment over r³
    both = m @ n.swapaxes(1, 2)
    axial = radial * (0.5 * np.eye(3) - 2.5 * n @ n.swapaxes(1, 2))
    gradient: Floats = 3.0 / r * (both + both.swapaxes(1, 2) + axial)
    return gradient
