"""A design vector as maneuvers, and maneuvers as steps of the filter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Variables of one maneuver: three rates and a duration.
VARIABLES_PER_MANEUVER = 4


def decode(designs: ArrayLike) -> tuple[Floats, Floats]:
    """Split designs into body rates and durations.

    Parameters
    ----------
    designs : array_like, shape (n, 4 m) or (4 m,)
        ωx, ωy, ωz [deg/s] and duration [s] of each of m maneuvers in turn.

    Returns
    -------
    rates : array, shape (n, m, 3)
        Body rates [rad/s].
    durations : array, shape (n, m)
        Durations [s].

    Raises
    ------
    ValueError
        If the number of columns is no multiple of four, a value is not finite or a duration is
        negative.
    """
    table = np.atleast_2d(np.asarray(designs, dtype=float))
    if table.ndim != 2 or table.shape[1] == 0 or table.shape[1] % VARIABLES_PER_MANEUVER:
        raise ValueError(
            f"designs of shape {np.shape(designs)}: expected 4 columns for each maneuver "
            "(three rates [deg/s] and a duration [s])"
        )
    count = table.shape[1] // VARIABLES_PER_MANEUVER
    maneuvers = table.reshape(len(table), count, VARIABLES_PER_MANEUVER)
    rates, durations = np.radians(maneuvers[:, :, :3]), maneuvers[:, :, 3]
    bad = ~np.isfinite(table).all(axis=1) | (durations < 0.0).any(axis=1)
    if bad.any():
        first = int(np.argmax(bad))
        raise ValueError(
            f"design {first} = {table[first].tolist()}: expected finite rates and durations >= 0"
        )
    return rates, durations


def maneuver_steps(durations: Floats, step: float) -> tuple[Ints, Ints]:
    """First step of each maneuver, and the step at which the last one is over.

    A maneuver begins at the first step at or after its start; one that ends before that step is
    not flown, except the last one, whose rate is held to the end of the run.

    Parameters
    ----------
    durations : array, shape (n, m)
        [s]
    step : float
        Filter step [s].

    Returns
    -------
    starts : array, shape (n, m)
    over : array, shape (n,)
    """
    ends = np.ceil(np.cumsum(durations, axis=1) / step).astype(np.int64)
    starts = np.hstack([np.zeros((len(ends), 1), dtype=np.int64), ends[:, :-1]])
    return starts, ends[:, -1].copy()


@dataclass(frozen=True)
class Flown:
    """One design as the filter flies it, until `times[-1]`: k stretches of constant rate.

    Attributes
    ----------
    numbers : array, shape (k,)
        Which maneuver of the design each stretch is, from 0.
    times : array, shape (k + 1,)
        Their starts, then the end of the run [s].
    rates : array, shape (k, 3)
        Body rates [rad/s].
    over : float
        End of the last maneuver, or of the run if that comes first [s]; the last rate is held.
    """

    numbers: Ints
    times: Floats
    rates: Floats
    over: float


def flown(design: ArrayLike, t_end: float, step: float) -> Flown:
    """The maneuvers of one design, shape (4 m,), that are flown in a run of `t_end` seconds."""
    rates, durations = (part[0] for part in decode(design))
    starts, over = (part[0] for part in maneuver_steps(durations[None], step))
    # of maneuvers that start at the same step only the last is flown
    numbers = np.flatnonzero(np.append(np.diff(starts) > 0, True) & (starts * step < t_end))
    times = np.append(starts[numbers] * step, t_end)
    return Flown(numbers, times, rates[numbers], min(float(over) * step, t_end))
