"""A design vector as maneuvers, and maneuvers as steps of the filter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .slew import SlewLimits, ramp_shares, share_made

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A step that no run reaches: the start of what is never flown.
NEVER = 2**40

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
    times = np.cumsum(durations, axis=1) / step
    ends = np.ceil(np.minimum(times, NEVER)).astype(np.int64)
    starts = np.hstack([np.zeros((len(ends), 1), dtype=np.int64), ends[:, :-1]])
    return starts, ends[:, -1].copy()


@dataclass(frozen=True)
class Schedule:
    """n designs as stretches of constant rate on the filter's steps.

    Attributes
    ----------
    rates : array, shape (n, k, 3)
        Body rates [rad/s]; of a step of a ramp the mean.
    end_rates : array, shape (n, k, 3)
        Those at the end of each stretch, the same but in ramps.
    starts : array, shape (n, k)
        First step of each stretch, ascending; one that starts with the next is not flown.
    over : array, shape (n,)
        Step at which the last maneuver is over; the last rate is held.
    maneuver : array, shape (n, k)
        Which maneuver of the design each stretch belongs to, from 0.
    """

    rates: Floats
    end_rates: Floats
    starts: Ints
    over: Ints
    maneuver: Ints

    def lasting(self, end_steps: ArrayLike = NEVER) -> Ints:
        """Steps for which each stretch is flown, shape (n, k), in runs that end at `end_steps`."""
        limit = np.reshape(np.asarray(end_steps, dtype=np.int64), (-1, 1))
        ends = np.append(self.starts[:, 1:], np.full((len(self.starts), 1), NEVER), axis=1)
        lasting: Ints = np.minimum(ends, limit) - np.minimum(self.starts, limit)
        return lasting

    def flown(self) -> NDArray[np.bool_]:
        """Which stretches last a step or more, shape (n, k)."""
        return self.lasting() > 0


def schedule(designs: ArrayLike, step: float, limits: SlewLimits | None = None) -> Schedule:
    """What is flown of designs, shape (n, 4 m).

    Without `limits` rates change at once, as in the paper. With it the rate moves along a
    straight line to that of the next maneuver, from rest at first, as fast as it can; every step
    of such a ramp is a stretch at the exact mean of the rate during it. A ramp counts to the
    maneuver it leads into and is cut short where that ends first, except the last one, whose rate
    is held.

    Raises
    ------
    ValueError
        See `decode`.
    """
    rates, durations = decode(designs)
    starts, over = maneuver_steps(durations, step)
    n, m = starts.shape
    number = np.broadcast_to(np.arange(m), (n, m))
    if limits is None:
        return Schedule(rates, rates, starts, over, number)
    ends = np.column_stack([starts[:, 1:], np.full(n, NEVER)])
    reached = np.zeros((n, 3))
    parts: list[tuple[Floats, Floats, Ints, Ints]] = []
    for j in range(m):
        change = rates[:, j] - reached
        time = limits.ramp_time(change)
        length = np.minimum(np.ceil(time / step).astype(np.int64), ends[:, j] - starts[:, j])
        place = np.arange(int(length.max(initial=0)) + 1)
        held = starts[:, j, None] + place
        # where the ramp is cut short, and beyond its end, nothing is left to fly
        at = np.where(place <= length[:, None], np.minimum(held, ends[:, j, None]), -1)
        mean, end = (
            reached[:, None] + share[:, :, None] * change[:, None]
            for share in ramp_shares(step * place.astype(float), step, time[:, None])
        )
        parts.append((mean, end, at, place * 0 + j))
        reached = reached + share_made(length * step, time)[:, None] * change
        if j == m - 1:
            over = np.maximum(over, starts[:, j] + length)
    return _packed(parts, over)


def _packed(parts: list[tuple[Floats, Floats, Ints, Ints]], over: Ints) -> Schedule:
    """Stretches of all designs one after the other, those that start at -1 left out."""
    starts = np.concatenate([part[2] for part in parts], axis=1)
    maneuver = np.broadcast_to(np.concatenate([part[3] for part in parts]), starts.shape)
    most = int((starts >= 0).sum(1).max(initial=1))  # each design has one at least
    order = np.argsort(starts < 0, axis=1, kind="stable")[:, :most]
    starts = np.take_along_axis(starts, order, axis=1)
    empty = starts < 0
    starts[empty] = NEVER

    def packed(rates: list[Floats]) -> Floats:
        found = np.take_along_axis(np.concatenate(rates, axis=1), order[:, :, None], axis=1)
        found[empty] = 0.0
        return found

    return Schedule(
        packed([part[0] for part in parts]),
        packed([part[1] for part in parts]),
        starts,
        over,
        np.take_along_axis(maneuver, order, axis=1),
    )


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


def flown(design: ArrayLike, t_end: float, step: float, limits: SlewLimits | None = None) -> Flown:
    """What is flown of one design, shape (4 m,), in a run of `t_end` seconds; see `schedule`."""
    plan = schedule(np.atleast_1d(np.asarray(design, dtype=float))[None], step, limits)
    starts, over = plan.starts[0], plan.over[0]
    stretches = np.flatnonzero(plan.flown()[0] & (starts * step < t_end))
    times = np.append(starts[stretches] * step, t_end)
    return Flown(
        plan.maneuver[0, stretches],
        times,
        plan.rates[0, stretches],
        min(float(over) * step, t_end),
    )
