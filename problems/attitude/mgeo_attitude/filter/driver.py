"""Driver of the generated filter step, with one candidate in each vector lane.

The driver is compiled once for all suites: `kernel.py` writes this module to the user's cache.
"""

import math

import numpy as np

from mgeo_attitude._compiled import compile_cached, helper
from mgeo_attitude.filter.discretization import compute_step_rotation, discretize
from mgeo_attitude.filter.lanewise import call_address, fetch_add, load_acquire, store_release
from mgeo_attitude.filter.polynomials import discretize_isotropic

# Steps of a lane between two checks that its covariance is positive definite. Rare checks suffice
# because lost positivity persists, and a check takes as long as half a step.
CHECK_PERIOD = 256

#: Step number that no run reaches.
UNREACHABLE_STEP = 2**62

#: Size of the cache of discretized maneuvers, enough for a batch of about a dozen finite-difference
#: gradients.
CACHE_SIZE = 256


@helper
def allocate_workspace(n_slots, lanes):
    """Return zeros, shape (n_slots, lanes), aligned to a cache line.

    A vector that spans two cache lines loads at half the speed.
    """
    line = 8
    buffer = np.zeros(n_slots * lanes + line)
    skip = -(buffer.ctypes.data // buffer.itemsize) % line
    return buffer[skip : skip + n_slots * lanes].reshape(n_slots, lanes)


@helper
def allocate_ring_buffer(window, lanes):
    """Return a ring buffer for the traces of all lanes over the convergence window.

    The length is a power of two, so that indexing is a bit mask. A full history would not fit the
    second-level cache.
    """
    size = 1
    while size <= window:
        size *= 2
    return np.zeros((size, lanes))


@compile_cached("Tuple((float64[:,::1], float64[:,::1]))(float64[:,::1], float64[::1], float64)")
def discretize_compiled(A, density, dt):
    """Return F and Q of `discretize`, for calls from Python."""
    return discretize(A, density, dt)


@helper
def write_maneuver(values, omega, dynamics):
    """Compute the rotation per step, transition and process noise of a maneuver, in slot order."""
    parts, density, pattern, dt, by_polynomials = dynamics
    if by_polynomials:
        room = np.zeros((2, 6, 6))
        F, Q, own = room[0], room[1], np.empty((2, 3, 3))
        densities = density[0], density[3]
        discretize_isotropic(-parts[0, 3, 3], densities, omega, dt, F, Q, own[0], own[1])
    else:
        A = parts[0] + omega[0] * parts[1] + omega[1] * parts[2] + omega[2] * parts[3]
        F, Q = discretize(A, density, dt)
    rotation = compute_step_rotation(omega, dt)
    k = 0
    for i in range(3):
        for j in range(3):
            values[k] = rotation[i, j]
            k += 1
    for entry in range(len(pattern)):
        values[k] = F[pattern[entry, 0], pattern[entry, 1]]
        k += 1
    for i in range(len(Q)):
        for j in range(i + 1):
            values[k] = Q[i, j]
            k += 1


@helper
def compute_cache_row(key):
    """Return the cache row of a maneuver: a hash of the variant and of the bits of the rate."""
    value = np.uint64(0)
    for number in key:
        value = (value ^ np.uint64(number)) * np.uint64(0x9E3779B97F4A7C15)
        value ^= value >> np.uint64(32)
    return np.int64(value % np.uint64(CACHE_SIZE))


@helper
def load_maneuver(W, lane, rotation, omega, dynamics, variant, cache):
    """Copy the rotation, F and Q of a maneuver to a lane, from a cache of recent maneuvers."""
    keys, values_of_row = cache
    bits = omega.view(np.int64)
    key = (variant + 1, bits[0], bits[1], bits[2])
    place = compute_cache_row(key)
    values, stored = values_of_row[place], keys[place]
    if stored[0] != key[0] or stored[1] != key[1] or stored[2] != key[2] or stored[3] != key[3]:
        write_maneuver(values, omega, dynamics)
        for i in range(4):
            stored[i] = key[i]
    for k in range(len(values)):
        W[rotation + k, lane] = values[k]


@helper
def load_axis_angle(W, lane, slot, omega, dt):
    """Write the unit axis, angle, sine and cosine of a maneuver's rotation per step to a lane."""
    rate = math.sqrt(omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2)
    for i in range(3):
        W[slot + i, lane] = omega[i] / rate if rate > 0.0 else 0.0
    W[slot + 3, lane] = rate * dt
    W[slot + 4, lane], W[slot + 5, lane] = math.sin(rate * dt), math.cos(rate * dt)


@helper
def save_lane(W, lane, n_values, traces, row, n, state):
    """Store the covariance, attitude, monitors and the last n trace values of a lane in `state`."""
    for j in range(n_values):
        state[j] = W[j, lane]
    for j in range(n):
        state[n_values + j] = traces[(row - j) % len(traces), lane]


@helper
def restore_lane(W, lane, n_values, traces, row, n, state):
    """Load a lane from a `state` that `save` stored."""
    for j in range(n_values):
        W[j, lane] = state[j]
    for j in range(n):
        traces[(row - j) % len(traces), lane] = state[n_values + j]


@helper
def has_converged(traces, lane, row, window, decrease, allow_rise):
    """Return whether a run has converged by equation (6).

    The trace must have fallen by less than the fraction `decrease` over the window, without a rise.
    A rise is accepted if `allow_rise` is set. A NaN trace counts as converged, to end the run.
    """
    before = traces[(row - window) & (len(traces) - 1), lane]
    fall = before - traces[row, lane]
    return not (fall >= decrease * before or (fall < 0.0 and not allow_rise))


@helper
def count_settled_steps(traces, lane, row, k, factor):
    """Count the latest steps, at most k, with a trace of at most `factor` times the current one."""
    limit, n = factor * traces[row, lane], 0
    while n < k and traces[(row - n - 1) & (len(traces) - 1), lane] <= limit:
        n += 1
    return n


@compile_cached(
    "void(UniTuple(int64, 3), UniTuple(int64, 13), UniTuple(int64[::1], 2),"
    "UniTuple(int64[::1], 5), float64[:,::1],"
    "Tuple((float64[:,:,::1], int64[:,::1], int64[::1], int64[::1])),"
    "Tuple((float64[:,:,:,::1], float64[:,::1], int64[:,::1], float64, boolean)), float64[:,::1],"
    "float64[:,::1], Tuple((int64, float64, boolean, float64)), UniTuple(int64[::1], 3),"
    "float64[::1],"
    "UniTuple(float64[:,::1], 2), float64[:,:,::1])"
)
def run(
    code,
    layout,
    queue,
    jobs,
    states,
    plan,
    dynamics,
    table,
    constants,
    convergence,
    step_limits,
    trace,
    final_values,
    record,
):
    """Run jobs from the shared queue until the queue is empty, in any number of threads.

    A lane that has finished a job takes the next job from the queue and restarts its clock. Lanes
    do not exchange values, and a job continues from the exact final state of its parent, so a
    result depends only on the model and the design.

    Parameters
    ----------
    code : tuple of three int
        Addresses of the compiled ``step`` and ``check`` functions of the suite; number of lanes.
    layout : tuple of int
        See `layout.Layout`.
    queue : arrays of int, shapes (1,) and (n_jobs,)
        State shared by all threads: number of jobs taken; and the status of each job, 0 until its
        final state is stored, then 1, or 2 if the covariance had lost positivity.
    jobs : five arrays of int, shape (n_jobs,)
        See `jobs.Jobs`.
    states : array, shape (n_states + n_variants, rotation + window + 1)
        Final states of jobs; then the initial states of the variants, the first variant last.
    plan : arrays, shapes (n, n_stretches, 3), (n, n_stretches), (n,) and (n,)
        Body rates [rad/s], start steps of the rates, end step of the last maneuver, and model
        variant of each design.
    dynamics : tuple of three arrays, float and bool
        A at zero rate and the derivative of A by each rate component, shape (n_variants, 4,
        n_dynamic, n_dynamic); process-noise density, (n_variants, n_dynamic); (row, column) entries
        of the transition that a step reads, (n_entries, 2); step [s]; whether to discretize by
        `polynomials`.
    table : array, shape (n_samples, n_given)
        Orbit table, see `FilterModel.table`.
    constants : array, shape (n_variants, n_constants)
        See `variants.stack_constants`.
    convergence : int, float, bool, float
        Window [steps], least relative decrease of the trace over the window, whether a rise counts
        as converged, and the factor of a settled trace, or 0 to skip it. With a factor, the window
        must be longer than the run.
    step_limits : three arrays of int, shape (n,)
        Last allowed step of each design; and, written, the end step and the step from which on the
        trace was settled.
    trace : array, shape (n,), written
        Weighted trace at the end; NaN if the covariance lost positivity.
    final_values : arrays, shapes (n, n_monitors) and (n or 0, n_states (n_states + 1) / 2), written
        Monitors at the end and, unless empty, the lower triangle of the covariance, row by row.
    record : array, shape (n or 0, n_steps + 1, n_states), written
        Variance of each state at each step, unless empty.
    """
    step, check, lanes = code
    taken, done = queue
    designs, begins, ends, parents, slots = jobs
    rates, starts, over, variants = plan
    parts, densities, pattern, dt, by_polynomials = dynamics
    window, decrease, allow_rise, factor = convergence
    stops, end_step, settled = step_limits
    watched, final = final_values
    n_jobs, n_maneuvers = len(designs), starts.shape[1]
    attitude, monitors, rotation, _, _, turned, rate, omega_slot = layout[:8]
    trace_slot, pivot, _, given, first_constant = layout[8:]
    n_constants = constants.shape[1]
    W, recent = (
        allocate_workspace(first_constant + n_constants, lanes),
        allocate_ring_buffer(window, lanes),
    )
    n_dynamic = densities.shape[1]
    n_values = 9 + len(pattern) + n_dynamic * (n_dynamic + 1) // 2
    cache = np.zeros((CACHE_SIZE, 4), dtype=np.int64), np.empty((CACHE_SIZE, n_values))
    for k in range(n_constants):
        W[first_constant + k] = constants[0, k]
    address, mask = W.ctypes.data, len(recent) - 1
    now = 0  # The row of `recent` for the current step is common to all lanes.
    job = np.empty(lanes, dtype=np.int64)
    clock = np.zeros(lanes, dtype=np.int64)
    maneuver = np.zeros(lanes, dtype=np.int64)
    running = np.zeros(lanes, dtype=np.int64)
    healthy = np.ones(lanes, dtype=np.bool_)
    test_from = np.full(lanes, UNREACHABLE_STEP)
    active = 0
    for lane in range(lanes):
        job[lane] = fetch_add(taken, 1)
        active += job[lane] < n_jobs
    while active > 0:
        # Start jobs and maneuvers that are due, and count the steps until the next event.
        n_steps = UNREACHABLE_STEP
        for lane in range(lanes):
            this, k = job[lane], clock[lane]
            if this >= n_jobs:
                continue
            i = designs[this]
            if not running[lane]:
                parent = parents[this]
                left = 1 if parent < 0 else load_acquire(done, parent)
                if left == 0:
                    continue
                running[lane], healthy[lane] = 1, left == 1
                maneuver[lane] = 0
                k = begins[this]
                clock[lane] = k
                test_from[lane] = max(over[i], window)
                for c in range(n_constants):
                    W[first_constant + c, lane] = constants[variants[i], c]
                state = states[parent if parent < 0 else slots[parent]]
                restore_lane(W, lane, rotation, recent, now, min(window, k) + 1, state)
            m = maneuver[lane]
            while m < n_maneuvers and starts[i, m] <= k:
                m += 1
            if m > maneuver[lane]:
                # If several maneuvers start at this step, only the last one takes effect.
                own = parts[variants[i]], densities[variants[i]], pattern, dt, by_polynomials
                load_maneuver(W, lane, rotation, rates[i, m - 1], own, variants[i], cache)
                if turned < rate:
                    load_axis_angle(W, lane, turned, rates[i, m - 1], dt)
                omega = rates[i, m - 1]
                if rate < omega_slot:
                    W[rate, lane] = omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2
                if omega_slot < trace_slot:
                    for axis in range(3):
                        W[omega_slot + axis, lane] = omega[axis]
                maneuver[lane] = m
            due = min(stops[i], k - k % CHECK_PERIOD + CHECK_PERIOD)
            if m < n_maneuvers:
                due = min(due, starts[i, m])
            if ends[this] >= 0:
                due = min(due, ends[this])
            n_steps = min(n_steps, due - k)
        if (
            n_steps == UNREACHABLE_STEP
        ):  # Every job of this thread waits for its parent in another thread.
            continue

        ended = False
        while n_steps > 0 and not ended:
            n_steps -= 1
            now = (now + 1) & mask
            for lane in range(lanes):
                clock[lane] += running[lane]
            for k in range(table.shape[1]):
                for lane in range(lanes):
                    W[given + k, lane] = table[clock[lane], k]
            call_address(step, address)
            for lane in range(lanes):
                recent[now, lane] = W[trace_slot, lane]
                tested = clock[lane] >= test_from[lane]
                ended |= tested & has_converged(recent, lane, now, window, decrease, allow_rise)
            if len(record) > 0:
                for lane in range(lanes):
                    if running[lane]:
                        for j in range(record.shape[2]):
                            variance = W[j * (j + 1) // 2 + j, lane]
                            record[designs[job[lane]], clock[lane], j] = variance

        checked = False
        for lane in range(lanes):
            if not running[lane]:
                continue
            this, k = job[lane], clock[lane]
            over_now = k == stops[designs[this]] or (
                k >= test_from[lane]
                and has_converged(recent, lane, now, window, decrease, allow_rise)
            )
            if over_now or k % CHECK_PERIOD == 0:
                if not checked:
                    call_address(check, address)
                    checked = True
                healthy[lane] &= W[pivot, lane] > 0.0
            if k == ends[this]:
                state = states[slots[this]]
                save_lane(W, lane, rotation, recent, now, min(window, k) + 1, state)
                store_release(done, this, 1 if healthy[lane] else 2)
            elif over_now:
                i = designs[this]
                end_step[i] = k
                if factor > 0.0:
                    settled[i] = k - count_settled_steps(recent, lane, now, k, factor)
                trace[i] = recent[now, lane] if healthy[lane] else np.nan
                for j in range(watched.shape[1]):
                    watched[i, j] = W[monitors + j, lane]
                if len(final) > 0:
                    for j in range(attitude):
                        final[i, j] = W[j, lane]
            else:
                continue
            running[lane], clock[lane], test_from[lane] = 0, 0, UNREACHABLE_STEP
            job[lane] = fetch_add(taken, 1)
            active -= job[lane] >= n_jobs
