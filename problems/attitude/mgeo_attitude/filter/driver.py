"""Feeds the lanes of the generated `step`: the text of this module ends every kernel module."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit

from .atomic import fetch_add, load_acquire, store_release

if TYPE_CHECKING:  # above this text in the generated module, see codegen.py
    from .lane import (
        ATTITUDE,
        CACHE,
        LANES,
        MONITORS,
        N_MONITORS,
        N_STATES,
        PIVOT,
        TRACE,
        converged,
        load_maneuver,
        reset,
        restore,
        ring,
        save,
        variance_slot,
        workspace,
    )

    def step(W: Any, C: Any, R: Any, rows: Any) -> None:
        """One filter step of all lanes, in place."""

    def check(W: Any, C: Any, R: Any, rows: Any) -> None:
        """Last pivot of the covariance of all lanes."""


# Steps of a lane between two checks that its covariance is positive. Lost positivity stays lost
# for long, and a check costs half a step.
CHECK_PERIOD = 256

#: Later than any step.
NEVER = 2**62


@njit(cache=CACHE)
def take(queue, n):
    """The next job's number, or -1 where none is left."""
    i = fetch_add(queue, 1)
    return i if i < n else -1


@njit(cache=CACHE)
def parent_is_done(done, parent):
    """Whether a job may start: its parent, if it has one, has left its final state."""
    return parent < 0 or load_acquire(done, parent) != 0


@njit(
    "void(int64[::1], int64[::1], int64[::1], int64[::1], int64[::1], int64[::1], int64[::1],"
    "float64[:,::1], float64[:,:,::1], int64[:,::1], int64[::1], float64[:,:,::1], float64[::1],"
    "float64[:,::1], float64[::1], float64[::1], float64[::1], int64, float64, boolean, float64,"
    "int64[::1], float64[::1], float64[:,::1], float64[:,::1], float64[:,:,::1], int64)",
    error_model="numpy",
    nogil=True,
    cache=CACHE,
)
def run(
    queue,
    done,
    designs,
    begins,
    ends,
    parents,
    slots,
    snapshots,
    rates,
    starts,
    over,
    dynamics,
    density,
    table,
    variances,
    monitors,
    C,
    window,
    decrease,
    allow_rise,
    dt,
    end_step,
    trace,
    watched,
    final,
    record,
    lanes,
):
    """Run jobs from the queue until it is empty; any number of threads may share it.

    A lane that has finished a job takes the next one from the queue, with a clock of its own. No
    value ever crosses lanes, and a job goes on from its parent's state exactly as that left it, so
    a result does not depend on what else is run.

    Parameters
    ----------
    queue : array of one int
        Number of jobs already taken, shared by the threads.
    done : array of int, shape (n_jobs,)
        Zero until a job has left its final state; then 1, or 2 if its covariance had already lost
        positivity. Shared by the threads.
    designs, begins, ends, parents, slots : arrays, shape (n_jobs,)
        See `jobs.Jobs`.
    snapshots : array, shape (n_slots, ROTATION + window + 1)
        States that jobs leave.
    rates : array, shape (n, n_maneuvers, 3)
        Body rates [rad/s].
    starts, over : arrays, shapes (n, n_maneuvers) and (n,)
        Steps at which each maneuver begins, and at which the last one is over.
    dynamics : array, shape (4, n_dynamic, n_dynamic)
        A at rest, and what a unit rate about each axis adds to it.
    density : array, shape (n_dynamic,)
        Process-noise density.
    table : array, shape (n_steps + 1, n_values)
        Reference vectors in GCRS and availabilities (one or zero) of the sensors.
    variances, monitors : arrays, shapes (n_states,) and (n_monitors,)
        Variances and monitors at time zero.
    C : array
        Constants of `step`.
    window, decrease, allow_rise, dt
        Convergence window [steps], least relative decrease of the trace over it, whether it may
        have risen, step [s].
    end_step, trace : arrays, shape (n,), written
        Step at which the design ended and its trace there; NaN if the covariance lost
        positivity.
    watched : array, shape (n, n_monitors), written
        Monitors at the end.
    final : array, shape (n or 0, n_states (n_states + 1) / 2), written
        Lower triangle of the covariance at the end, row by row, if asked for.
    record : array, shape (n or 0, n_steps + 1, n_states), written
        Variance of each state at each step, if asked for.
    lanes
        LANES, as a variable: loops over a constant would be unrolled, and compile twice as long.
    """
    n_jobs, n_maneuvers, last_step = len(designs), starts.shape[1], len(table) - 1
    W, recent = workspace(), ring(window)
    mask, now = len(recent) - 1, 0  # the row of `recent` for the present step of every lane
    job = np.empty(LANES, dtype=np.int64)
    clock = np.zeros(LANES, dtype=np.int64)
    maneuver = np.zeros(LANES, dtype=np.int64)
    running = np.zeros(LANES, dtype=np.int64)
    healthy = np.ones(LANES, dtype=np.bool_)
    test_from = np.full(LANES, NEVER)
    active = 0
    for lane in range(lanes):
        reset(W, lane, variances, monitors, C, recent, now)
        job[lane] = take(queue, n_jobs)
        active += job[lane] >= 0
    while active > 0:
        # what is due before the next step, and how many steps there are until more is
        n_steps = NEVER
        for lane in range(lanes):
            this, k = job[lane], clock[lane]
            if this < 0:
                continue
            i = designs[this]
            if not running[lane]:
                parent = parents[this]
                if not parent_is_done(done, parent):
                    continue
                running[lane] = 1
                maneuver[lane] = 0
                k = begins[this]
                clock[lane] = k
                test_from[lane] = max(over[i], window)
                if parent < 0:
                    reset(W, lane, variances, monitors, C, recent, now)
                    healthy[lane] = True
                else:
                    restore(W, lane, recent, now, min(window, k) + 1, snapshots[slots[parent]])
                    healthy[lane] = done[parent] == 1
            m = maneuver[lane]
            while m < n_maneuvers and starts[i, m] <= k:
                m += 1
            if m > maneuver[lane]:
                # of several maneuvers that have started only the last one is flown
                load_maneuver(W, lane, rates[i, m - 1], dynamics, density, dt)
                maneuver[lane] = m
            due = min(last_step, k - k % CHECK_PERIOD + CHECK_PERIOD)
            if m < n_maneuvers:
                due = min(due, starts[i, m])
            if ends[this] >= 0:
                due = min(due, ends[this])
            n_steps = min(n_steps, due - k)
        if n_steps == NEVER:  # every job here waits for its parent in another thread
            continue

        ended = False
        while n_steps > 0 and not ended:
            n_steps -= 1
            now = (now + 1) & mask
            for lane in range(lanes):
                clock[lane] += running[lane]
            step(W.ctypes, C.ctypes, table.ctypes, clock.ctypes)
            for lane in range(lanes):
                recent[now, lane] = W[TRACE * LANES + lane]
                tested = clock[lane] >= test_from[lane]
                ended |= tested & converged(recent, lane, now, window, decrease, allow_rise)
            if len(record) > 0:
                for lane in range(lanes):
                    if running[lane]:
                        for j in range(N_STATES):
                            variance = W[variance_slot(j) * LANES + lane]
                            record[designs[job[lane]], clock[lane], j] = variance

        checked = False
        for lane in range(lanes):
            if not running[lane]:
                continue
            this, k = job[lane], clock[lane]
            at_end = k == last_step or (
                k >= test_from[lane] and converged(recent, lane, now, window, decrease, allow_rise)
            )
            if at_end or k % CHECK_PERIOD == 0:
                if not checked:
                    check(W.ctypes, C.ctypes, table.ctypes, clock.ctypes)
                    checked = True
                healthy[lane] &= W[PIVOT * LANES + lane] > 0.0
            if k == ends[this]:
                save(W, lane, recent, now, min(window, k) + 1, snapshots[slots[this]])
                store_release(done, this, 1 if healthy[lane] else 2)
            elif at_end:
                i = designs[this]
                end_step[i] = k
                trace[i] = recent[now, lane] if healthy[lane] else np.nan
                for j in range(N_MONITORS):
                    watched[i, j] = W[(MONITORS + j) * LANES + lane]
                if len(final) > 0:
                    for j in range(ATTITUDE):
                        final[i, j] = W[j * LANES + lane]
            else:
                continue
            running[lane], clock[lane], test_from[lane] = 0, 0, NEVER
            job[lane] = take(queue, n_jobs)
            active -= job[lane] < 0
