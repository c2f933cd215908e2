"""Conversion of a design vector to maneuvers, and of maneuvers to filter steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive, SlewLimits

#: Limits on rate changes, or magnetorquer control; None for instantaneous changes.
RotationDynamics = SlewLimits | MagnetorquerDrive | None

#: Step number that no run reaches; the start of an interval that is skipped.
UNREACHED_STEP = 2**40

#: Number of variables of a maneuver: three rates and a duration.
VARIABLES_PER_MANEUVER = 4


def decode_designs(designs: ArrayLike) -> tuple[Floats, Floats]:
    """Convert design vectors to the body rates [rad/s] and durations [s] of their maneuvers.

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
        If the number of columns is not a multiple of four, a value is not finite or a duration is
        negative.
    """
    table = np.atleast_2d(np.asarray(designs, dtype=float))
    if table.ndim != 2 or table.shape[1] == 0 or table.shape[1] % VARIABLES_PER_MANEUVER:
        raise ValueError(
            f"designs of shape {np.shape(designs)}: expected 4 columns per maneuver "
            "(three rates [deg/s] and a duration [s])"
        )
    count = table.shape[1] // VARIABLES_PER_MANEUVER
    maneuvers = table.reshape(len(table), count, VARIABLES_PER_MANEUVER)
    rates, durations = np.radians(maneuvers[:, :, :3]), maneuvers[:, :, 3]
    is_invalid = ~np.isfinite(table).all(axis=1) | (durations < 0.0).any(axis=1)
    if is_invalid.any():
        first = int(np.argmax(is_invalid))
        raise ValueError(
            f"design {first} = {table[first].tolist()}: expected finite rates and durations >= 0"
        )
    return rates, durations


def get_durations(designs: Floats) -> Floats:
    """Return the maneuver durations [s] in an array of design vectors, as a view of the array.

    Design vectors of shape (..., 4 m) have durations of shape (..., m).
    """
    return designs[..., VARIABLES_PER_MANEUVER - 1 :: VARIABLES_PER_MANEUVER]


def build_hold_design(rate: Floats) -> Floats:
    """Build a design that holds the initial body rate during the whole run.

    The design, shape (4,), has one maneuver of zero duration. With magnetorquers, the satellite
    rotates freely, since its initial rate is already reached.

    Parameters
    ----------
    rate : array, shape (3,)
        Initial body rate [rad/s].
    """
    return np.append(np.degrees(rate), 0.0)


def compute_maneuver_steps(durations: Floats, step: float) -> tuple[Ints, Ints]:
    """Return the first filter step of each maneuver, and the step at which the last one ends.

    A maneuver begins at the first step at or after its start. A maneuver that ends before that step
    is skipped, except the last one, whose rate is held to the end of the run.

    Parameters
    ----------
    durations : array, shape (n, m)
        Durations of the maneuvers of n designs [s].
    step : float
        Filter step [s].

    Returns
    -------
    starts : array, shape (n, m)
        First step of each maneuver.
    ends : array, shape (n,)
        Step at which the last maneuver ends.
    """
    times = np.cumsum(durations, axis=1) / step
    ends = np.ceil(np.minimum(times, UNREACHED_STEP)).astype(np.int64)
    starts = np.hstack([np.zeros((len(ends), 1), dtype=np.int64), ends[:, :-1]])
    return starts, ends[:, -1].copy()


@dataclass(frozen=True)
class Schedule:
    """Body rates of n designs, as intervals of constant rate between filter steps.

    Attributes
    ----------
    rates : array, shape (n, k, 3)
        Body rates [rad/s]. In a step of a ramp or with magnetorquers, the equivalent constant rate.
    end_rates : array, shape (n, k, 3)
        Body rates at the end of each interval; differ from `rates` in ramps and with magnetorquers.
    starts : array, shape (n, k)
        First step of each interval, ascending. An interval with the same start as the next one is
        skipped.
    maneuver_end_steps : array, shape (n,)
        Step at which the last maneuver ends; its rate is held afterwards.
    maneuver_numbers : array, shape (n, k)
        Number of the maneuver, from 0, that contains each interval.
    free : array of bool, shape (n, k), optional
        With magnetorquers, whether the magnetorquers are off.
    commands : arrays, shapes (n, m, 3) and (n, m), optional
        With magnetorquers, commanded rates and first steps of the maneuvers. Designs with equal
        commands up to a step have equal motion up to that step.
    """

    rates: Floats
    end_rates: Floats
    starts: Ints
    maneuver_end_steps: Ints
    maneuver_numbers: Ints
    free: Bools | None = None
    commands: tuple[Floats, Ints] | None = None

    def is_constant(self) -> Bools:
        """Return a mask of the intervals in which the body rate is constant.

        With magnetorquers, intervals in which the magnetorquers are off are True.

        Returns
        -------
        array of bool, shape (n, k)
        """
        if self.free is not None:
            return self.free
        unchanged: Bools = (self.rates == self.end_rates).all(axis=2)
        return unchanged

    def count_steps(self, end_steps: ArrayLike = UNREACHED_STEP) -> Ints:
        """Return the number of filter steps in each interval until the end of each run.

        Parameters
        ----------
        end_steps : int or array of int, shape (n,)
            Step at which the run of each design ends; default: no end.

        Returns
        -------
        array of int, shape (n, k)
        """
        limit = np.reshape(np.asarray(end_steps, dtype=np.int64), (-1, 1))
        ends = np.append(self.starts[:, 1:], np.full((len(self.starts), 1), UNREACHED_STEP), axis=1)
        result: Ints = np.minimum(ends, limit) - np.minimum(self.starts, limit)
        return result

    def has_duration(self) -> Bools:
        """Return a mask, shape (n, k), of the intervals that last at least one step."""
        return self.count_steps() > 0


def build_schedule(
    designs: ArrayLike, step: float, limits: RotationDynamics = None, n_steps: int = UNREACHED_STEP
) -> Schedule:
    """Convert designs to intervals of constant body rate that begin and end at filter steps.

    Without `limits`, rates change instantaneously, as in the paper. With `SlewLimits`, the rate
    moves along a straight line to the rate of the next maneuver, first from the initial rate, in
    the shortest time. Each step of a ramp is an interval at the exact mean rate of the step. A ramp
    belongs to the maneuver that it leads to, and is cut short if that maneuver ends first; the last
    maneuver is extended instead. With magnetorquers, every step is an interval.

    Parameters
    ----------
    designs : array_like, shape (n, 4 m)
        Rates and durations of m maneuvers; see `decode_designs`.
    step : float
        Filter step [s].
    limits : SlewLimits or MagnetorquerDrive, optional
        Limits on rate changes, or magnetorquer control; None for instantaneous changes.
    n_steps : int
        Number of steps. Intervals that would start at this step or later start at `UNREACHED_STEP`
        or are missing.

    Returns
    -------
    Schedule

    Raises
    ------
    ValueError
        If a design is invalid; see `decode_designs`.
    """
    rates, durations = decode_designs(designs)
    starts, last_end = compute_maneuver_steps(durations, step)
    n, m = starts.shape
    if limits is None:
        starts = np.where(starts < n_steps, starts, UNREACHED_STEP)
        return Schedule(rates, rates, starts, last_end, np.broadcast_to(np.arange(m), (n, m)))
    if isinstance(limits, MagnetorquerDrive):
        mean, end, free = limits.compute_rates(rates, starts, step, n_steps)
        steps = np.tile(np.arange(mean.shape[1]), (len(free), 1))
        started = (starts[:, None, :] <= steps[:, :, None]).sum(axis=2)
        return Schedule(mean, end, steps, last_end, started - 1, free, (rates, starts))
    ends = np.column_stack([starts[:, 1:], np.full(n, UNREACHED_STEP)])
    time, length = np.empty((n, m)), np.empty((n, m), dtype=np.int64)
    before = np.empty((n, m, 3))  # Rates at the start of each maneuver.
    before[:, 0] = limits.initial_rate
    change = rates.copy()
    for j in range(m):
        if j > 0:
            share = _compute_completed_share(step * length[:, j - 1].astype(float), time[:, j - 1])
            before[:, j] = before[:, j - 1] + share[:, None] * change[:, j - 1]
        change[:, j] -= before[:, j]
        time[:, j] = limits.compute_ramp_time(change[:, j])
        steps = np.ceil(np.minimum(time[:, j] / step, UNREACHED_STEP))
        length[:, j] = np.minimum(steps, ends[:, j] - starts[:, j])
    last_end = np.maximum(last_end, starts[:, -1] + length[:, -1])

    # The intervals of all designs in sequence: the steps of each ramp, then the constant rate.
    count = np.clip(n_steps - starts, 0, length) + 1
    maneuver = np.repeat(np.arange(n * m), count.ravel())
    index = _compute_group_indices(count.ravel())
    start = starts.ravel()[maneuver] + index
    mean, end = (
        before.reshape(-1, 3)[maneuver] + share[:, None] * change.reshape(-1, 3)[maneuver]
        for share in _compute_ramp_shares(step * index.astype(float), step, time.ravel()[maneuver])
    )
    # Arrange the intervals with one design per row.
    row, column = maneuver // m, _compute_group_indices(count.sum(axis=1))
    plan = _build_empty_schedule(n, column.max(initial=0) + 1, last_end)
    plan.rates[row, column], plan.end_rates[row, column] = mean, end
    plan.starts[row, column] = np.where(start < n_steps, start, UNREACHED_STEP)
    plan.maneuver_numbers[row, column] = maneuver % m
    return plan


@dataclass(frozen=True)
class RateIntervals:
    """Body rates of one design during a run, as k consecutive intervals of constant rate.

    Attributes
    ----------
    maneuver_numbers : array, shape (k,)
        Number of the maneuver, from 0, of each interval.
    times : array, shape (k + 1,)
        Starts of the intervals, then the end of the run [s].
    rates : array, shape (k, 3)
        Body rates [rad/s].
    is_constant : array of bool, shape (k,)
        Whether the interval has the rate of its maneuver and is no step of a ramp; with
        magnetorquers, whether the magnetorquers are off.
    maneuver_end : float
        End of the last maneuver [s], or of the run if earlier; the last rate is held afterwards.
    """

    maneuver_numbers: Ints
    times: Floats
    rates: Floats
    is_constant: Bools
    maneuver_end: float


def build_rate_intervals(
    design: ArrayLike, t_end: float, step: float, limits: RotationDynamics = None
) -> RateIntervals:
    """Convert one design to intervals of constant body rate until the end of a run.

    Parameters
    ----------
    design : array_like, shape (4 m,)
        Rates and durations of m maneuvers; see `decode_designs`.
    t_end : float
        End of the run [s].
    step : float
        Filter step [s].
    limits : SlewLimits or MagnetorquerDrive, optional
        See `build_schedule`.

    Returns
    -------
    RateIntervals
    """
    designs = np.atleast_1d(np.asarray(design, dtype=float))[None]
    plan = build_schedule(designs, step, limits, math.ceil(t_end / step) + 1)
    selected = plan.has_duration()[0] & (plan.starts[0] * step < t_end)
    return RateIntervals(
        maneuver_numbers=plan.maneuver_numbers[0, selected],
        times=np.append(plan.starts[0, selected] * step, t_end),
        rates=plan.rates[0, selected],
        is_constant=plan.is_constant()[0, selected],
        maneuver_end=min(float(plan.maneuver_end_steps[0]) * step, t_end),
    )


def _build_empty_schedule(n: int, count: int, maneuver_end_steps: Ints) -> Schedule:
    rates, end_rates = np.zeros((2, n, count, 3))
    starts, maneuver = np.full((n, count), UNREACHED_STEP), np.zeros((n, count), dtype=np.int64)
    return Schedule(rates, end_rates, starts, maneuver_end_steps, maneuver)


def _compute_group_indices(counts: Ints) -> Ints:
    """Return the index of each element within its group.

    The groups are consecutive and have the given sizes.
    """
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)


def _compute_ramp_shares(start: Floats, step: float, time: Floats) -> tuple[Floats, Floats]:
    """Return two completed fractions of a ramp: the mean over a filter step, and the value at its
    end.

    The step begins `start` seconds after the start of a ramp that takes `time` seconds. The ramp
    may end within the step.
    """
    part = np.clip((time - start) / step, 0.0, 1.0)  # Part of the step that the ramp covers.
    mean = part * _compute_completed_share(start + 0.5 * part * step, time) + (1.0 - part)
    return mean, _compute_completed_share(start + step, time)


def _compute_completed_share(elapsed: Floats, time: Floats) -> Floats:
    """Return the completed fraction of a ramp at a given time after its start.

    The ramp takes `time` seconds.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(time > 0.0, np.clip(elapsed / time, 0.0, 1.0), 1.0)
