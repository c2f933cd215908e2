"""A design vector as maneuvers, and maneuvers as steps of the filter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.maneuvers.drives import CoilDrive, SlewLimits

#: What turns the satellite from one rate to the next; without it rates change at once.
Turning = SlewLimits | CoilDrive | None

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


def durations_of(designs: Floats) -> Floats:
    """Durations [s], shape (..., m), of designs, shape (..., 4 m): a view of them."""
    return designs[..., VARIABLES_PER_MANEUVER - 1 :: VARIABLES_PER_MANEUVER]


def holding(rate: Floats) -> Floats:
    """The design of a plan of nothing, shape (4,): the rate at the start [rad/s] is held.

    A satellite that coils turn moves freely, as they are off.
    """
    return np.append(np.degrees(rate), 0.0)


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
        Body rates [rad/s]; of a step of a ramp, or of coils, that which turns the body as it does.
    end_rates : array, shape (n, k, 3)
        Those at the end of each stretch, the same but in ramps and with coils.
    starts : array, shape (n, k)
        First step of each stretch, ascending; one that starts with the next is not flown.
    over : array, shape (n,)
        Step at which the last maneuver is over; the last rate is held.
    maneuver : array, shape (n, k)
        Which maneuver of the design each stretch belongs to, from 0.
    free : array of bool, shape (n, k), optional
        Of coils, whether they are off.
    asked : arrays, shapes (n, m, 3) and (n, m), optional
        Of coils, rates and first steps of the maneuvers: designs that are asked for the same until
        some step fly the same until then.
    """

    rates: Floats
    end_rates: Floats
    starts: Ints
    over: Ints
    maneuver: Ints
    free: Bools | None = None
    asked: tuple[Floats, Ints] | None = None

    def steady(self) -> Bools:
        """Which stretches are no step on the way to a maneuver's rate, shape (n, k)."""
        if self.free is not None:
            return self.free
        unchanged: Bools = (self.rates == self.end_rates).all(axis=2)
        return unchanged

    def lasting(self, end_steps: ArrayLike = NEVER) -> Ints:
        """Steps for which each stretch is flown, shape (n, k), in runs that end at `end_steps`."""
        limit = np.reshape(np.asarray(end_steps, dtype=np.int64), (-1, 1))
        ends = np.append(self.starts[:, 1:], np.full((len(self.starts), 1), NEVER), axis=1)
        lasting: Ints = np.minimum(ends, limit) - np.minimum(self.starts, limit)
        return lasting

    def flown(self) -> Bools:
        """Which stretches last a step or more, shape (n, k)."""
        return self.lasting() > 0


def schedule(
    designs: ArrayLike, step: float, limits: Turning = None, n_steps: int = NEVER
) -> Schedule:
    """What is flown of designs, shape (n, 4 m), until step `n_steps`.

    Without `limits` rates change at once, as in the paper. With them the rate moves along a
    straight line to that of the next maneuver, at first from the initial one, as fast as it can;
    every step of such a ramp is a stretch at the exact mean of the rate during it. A ramp counts to
    the maneuver it leads into and is cut short where that ends first, except the last one, whose
    rate is held. What would begin at `n_steps` or later starts at `NEVER`, or is left out.

    With coils every step is a stretch, and the last rate is that of free motion.

    Raises
    ------
    ValueError
        See `decode`.
    """
    rates, durations = decode(designs)
    starts, over = maneuver_steps(durations, step)
    n, m = starts.shape
    if limits is None:
        starts = np.where(starts < n_steps, starts, NEVER)
        return Schedule(rates, rates, starts, over, np.broadcast_to(np.arange(m), (n, m)))
    if isinstance(limits, CoilDrive):
        mean, end, free = limits.rates(rates, starts, step, n_steps)
        steps = np.tile(np.arange(mean.shape[1]), (len(free), 1))
        begun = (starts[:, None, :] <= steps[:, :, None]).sum(axis=2)
        return Schedule(mean, end, steps, over, begun - 1, free, (rates, starts))
    ends = np.column_stack([starts[:, 1:], np.full(n, NEVER)])
    time, length = np.empty((n, m)), np.empty((n, m), dtype=np.int64)
    before = np.empty((n, m, 3))  # the rate that each maneuver begins with
    before[:, 0] = limits.initial_rate
    change = rates.copy()
    for j in range(m):
        if j > 0:
            made = _share_made(step * length[:, j - 1].astype(float), time[:, j - 1])
            before[:, j] = before[:, j - 1] + made[:, None] * change[:, j - 1]
        change[:, j] -= before[:, j]
        time[:, j] = limits.ramp_time(change[:, j])
        steps = np.ceil(np.minimum(time[:, j] / step, NEVER))
        length[:, j] = np.minimum(steps, ends[:, j] - starts[:, j])
    over = np.maximum(over, starts[:, -1] + length[:, -1])

    # All designs' stretches one after the other: the steps of each ramp, then the rate held.
    count = np.clip(n_steps - starts, 0, length) + 1
    which = np.repeat(np.arange(n * m), count.ravel())
    place = _places(count.ravel())
    start = starts.ravel()[which] + place
    mean, end = (
        before.reshape(-1, 3)[which] + share[:, None] * change.reshape(-1, 3)[which]
        for share in _shares(step * place.astype(float), step, time.ravel()[which])
    )
    # And then in rows, a design in each.
    row, column = which // m, _places(count.sum(axis=1))
    plan = _unflown(n, column.max(initial=0) + 1, over)
    plan.rates[row, column], plan.end_rates[row, column] = mean, end
    plan.starts[row, column] = np.where(start < n_steps, start, NEVER)
    plan.maneuver[row, column] = which % m
    return plan


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
    steady : array of bool, shape (k,)
        Whether that is the maneuver's own rate, and the stretch no step of a ramp; with coils,
        whether they are off.
    over : float
        End of the last maneuver, or of the run if that comes first [s]; the last rate is held.
    """

    numbers: Ints
    times: Floats
    rates: Floats
    steady: Bools
    over: float


def flown(design: ArrayLike, t_end: float, step: float, limits: Turning = None) -> Flown:
    """What is flown of one design, shape (4 m,), in a run of `t_end` seconds; see `schedule`."""
    designs = np.atleast_1d(np.asarray(design, dtype=float))[None]
    plan = schedule(designs, step, limits, math.ceil(t_end / step) + 1)
    stretches = plan.flown()[0] & (plan.starts[0] * step < t_end)
    return Flown(
        numbers=plan.maneuver[0, stretches],
        times=np.append(plan.starts[0, stretches] * step, t_end),
        rates=plan.rates[0, stretches],
        steady=plan.steady()[0, stretches],
        over=min(float(plan.over[0]) * step, t_end),
    )


def _unflown(n: int, count: int, over: Ints) -> Schedule:
    """So many stretches of n designs, none of which is flown."""
    rates, end_rates = np.zeros((2, n, count, 3))
    starts, maneuver = np.full((n, count), NEVER), np.zeros((n, count), dtype=np.int64)
    return Schedule(rates, end_rates, starts, over, maneuver)


def _places(counts: Ints) -> Ints:
    """Places from 0 in groups of so many, one group after the other."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)


def _shares(begin: Floats, step: float, time: Floats) -> tuple[Floats, Floats]:
    """Share of a change that is made in steps of a ramp: their mean, and at their ends.

    Steps begin `begin` seconds after the start of a ramp that takes `time` seconds, and may end
    within one.
    """
    part = np.clip((time - begin) / step, 0.0, 1.0)  # of the step that belongs to the ramp
    mean = part * _share_made(begin + 0.5 * part * step, time) + (1.0 - part)
    return mean, _share_made(begin + step, time)


def _share_made(after: Floats, time: Floats) -> Floats:
    """Share of a change that is made `after` seconds of a ramp that takes `time`."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(time > 0.0, np.clip(after / time, 0.0, 1.0), 1.0)
