"""Feeds the lanes of the generated `step`: the text of this module ends every kernel module."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit

from .atomic import fetch_add, load_acquire, store_release
from .discretization import discretize, turn

if TYPE_CHECKING:  # defined above this text in the generated module, see codegen.py
    LANES: int
    CACHE: bool
    N_STATES: int
    N_DYNAMIC: int
    F_ENTRIES: np.ndarray
    ATTITUDE: int
    ROTATION: int
    F_SLOT: int
    Q_SLOT: int
    REFERENCE: int
    N_REFERENCE: int
    GATE: int
    N_GATES: int
    TRACE: int
    PIVOT: int
    N_SLOTS: int

    def step(W: Any, C: Any) -> None:
        """One filter step of all lanes, in place."""

    def check(W: Any, C: Any) -> None:
        """Last pivot of the covariance of all lanes."""


# Steps of a lane between two checks that its covariance is positive. Lost positivity stays lost
# for long, and a check costs half a step.
CHECK_PERIOD = 256


@njit(cache=CACHE)
def take(queue, n):
    """The next job's number, or -1 where none is left."""
    i = fetch_add(queue, 1)
    return i if i < n else -1


@njit(cache=CACHE)
def workspace():
    """Zeros that begin with a cache line: vectors across two lines load at half the speed."""
    line = 8
    buffer = np.zeros(N_SLOTS * LANES + line)
    skip = -(buffer.ctypes.data // buffer.itemsize) % line
    return buffer[skip : skip + N_SLOTS * LANES]


@njit(cache=CACHE)
def variance_slot(i):
    return i * (i + 1) // 2 + i


@njit(cache=CACHE, error_model="numpy")
def reset(W, lane, variances, C, history):
    """Put a lane at time zero: initial covariance, body axes along GCRS."""
    for k in range(N_SLOTS):
        W[k * LANES + lane] = 0.0
    total = 0.0
    for i in range(N_STATES):
        W[variance_slot(i) * LANES + lane] = variances[i]
        total += C[len(C) - N_STATES + i] * variances[i]
    for i in range(3):
        W[(ATTITUDE + 4 * i) * LANES + lane] = 1.0
    history[lane, 0] = total


@njit(cache=CACHE, error_model="numpy")
def load_maneuver(W, lane, omega, dynamics, density, dt):
    """Write the maneuver's exact transition, process noise and turn per step to a lane."""
    A = dynamics[0] + omega[0] * dynamics[1] + omega[1] * dynamics[2] + omega[2] * dynamics[3]
    F, Q = discretize(A, density, dt)
    rotation = turn(omega, dt)
    for k in range(len(F_ENTRIES)):
        W[(F_SLOT + k) * LANES + lane] = F[F_ENTRIES[k, 0], F_ENTRIES[k, 1]]
    for i in range(N_DYNAMIC):
        for j in range(i + 1):
            W[(Q_SLOT + i * (i + 1) // 2 + j) * LANES + lane] = Q[i, j]
    for i in range(3):
        for j in range(3):
            W[(ROTATION + 3 * i + j) * LANES + lane] = rotation[i, j]


@njit(cache=CACHE)
def parent_is_done(done, parent):
    """Whether a job may start: its parent, if it has one, has left its final state."""
    return parent < 0 or load_acquire(done, parent) != 0


@njit(cache=CACHE)
def save(W, lane, history, k, window, snapshot):
    """Store a lane's covariance, attitude and the trace's last window, at step k."""
    for j in range(ROTATION):
        snapshot[j] = W[j * LANES + lane]
    for j in range(min(window, k) + 1):
        snapshot[ROTATION + j] = history[lane, k - j]


@njit(cache=CACHE)
def restore(W, lane, history, k, window, snapshot):
    """Inverse of `save`."""
    for j in range(ROTATION):
        W[j * LANES + lane] = snapshot[j]
    for j in range(min(window, k) + 1):
        history[lane, k - j] = snapshot[ROTATION + j]


@njit(
    "void(int64[::1], int64[::1], int64[::1], int64[::1], int64[::1], int64[::1], int64[::1],"
    "float64[:,::1], float64[:,:,::1], int64[:,::1], int64[::1], float64[:,:,::1], float64[::1],"
    "float64[:,::1], float64[:,::1], float64[::1], float64[::1], int64, float64, float64,"
    "int64[::1], float64[::1], float64[:,:,::1], int64)",
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
    references,
    gates,
    variances,
    C,
    window,
    decrease,
    dt,
    end_step,
    trace,
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
    references, gates : arrays, shapes (n_steps + 1, 3 n_sensors) and (n_steps + 1, n_gates)
        Reference vectors in GCRS and availabilities (one or zero) of the sensors.
    variances : array, shape (n_states,)
        Initial variances.
    C : array
        Constants of `step`.
    window, decrease, dt
        Convergence window [steps], least relative decrease of the trace over it, step [s].
    end_step, trace : arrays, shape (n,), written
        Step at which the design ended and its trace there; NaN if the covariance lost
        positivity.
    record : array, shape (n or 0, n_steps + 1, n_states), written
        Variance of each state at each step, if asked for.
    lanes
        LANES, as a variable: loops over a constant would be unrolled, and compile twice as long.
    """
    n_jobs = designs.shape[0]
    last_step = references.shape[0] - 1
    W = workspace()
    history = np.empty((LANES, last_step + 1))
    job = np.full(LANES, -1)
    clock = np.zeros(LANES, dtype=np.int64)
    maneuver = np.zeros(LANES, dtype=np.int64)
    running = np.zeros(LANES, dtype=np.bool_)
    healthy = np.ones(LANES, dtype=np.bool_)
    active = 0
    for lane in range(lanes):
        reset(W, lane, variances, C, history)
        job[lane] = take(queue, n_jobs)
        active += job[lane] >= 0
    while active > 0:
        any_running = False
        for lane in range(lanes):
            if job[lane] < 0:
                continue
            if not running[lane]:
                parent = parents[job[lane]]
                if not parent_is_done(done, parent):
                    continue
                running[lane] = True
                maneuver[lane] = 0
                clock[lane] = begins[job[lane]]
                healthy[lane] = True
                if parent < 0:
                    reset(W, lane, variances, C, history)
                else:
                    restore(W, lane, history, clock[lane], window, snapshots[slots[parent]])
                    healthy[lane] = done[parent] == 1
            any_running = True
            i, k = designs[job[lane]], clock[lane]
            while maneuver[lane] < starts.shape[1] and starts[i, maneuver[lane]] <= k:
                m = maneuver[lane]
                maneuver[lane] += 1
                # of several maneuvers that have started only the last one is flown
                if maneuver[lane] == starts.shape[1] or starts[i, m + 1] > k:
                    load_maneuver(W, lane, rates[i, m], dynamics, density, dt)
            for j in range(N_REFERENCE):
                W[(REFERENCE + j) * LANES + lane] = references[k + 1, j]
            for j in range(N_GATES):
                W[(GATE + j) * LANES + lane] = gates[k + 1, j]
        if not any_running:
            continue
        step(W.ctypes, C.ctypes)
        checked = False
        for lane in range(lanes):
            if not running[lane]:
                continue
            this, k = job[lane], clock[lane] + 1
            i = designs[this]
            clock[lane] = k
            now = W[TRACE * LANES + lane]
            history[lane, k] = now
            if k % CHECK_PERIOD == 0:
                if not checked:
                    check(W.ctypes, C.ctypes)
                    checked = True
                healthy[lane] &= W[PIVOT * LANES + lane] > 0.0
            if record.shape[0] > 0:
                for j in range(N_STATES):
                    record[i, k, j] = W[variance_slot(j) * LANES + lane]
            if k == ends[this]:
                save(W, lane, history, k, window, snapshots[slots[this]])
                store_release(done, this, 1 if healthy[lane] else 2)
            elif k < last_step and (k < over[i] or k < window):
                continue
            else:
                before = history[lane, max(k - window, 0)]
                # not >=, so that a NaN ends the run as well
                if k < last_step and before - now >= decrease * before:
                    continue
                if not checked:
                    check(W.ctypes, C.ctypes)
                    checked = True
                healthy[lane] &= W[PIVOT * LANES + lane] > 0.0
                end_step[i] = k
                trace[i] = now if healthy[lane] else np.nan
            running[lane] = False
            job[lane] = take(queue, n_jobs)
            active -= job[lane] < 0
