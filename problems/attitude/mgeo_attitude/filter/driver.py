"""Compiled loop over filter steps, with one candidate in each vector lane.

The driver is compiled once for all sensor suites. `kernel.py` writes this module to the user's
cache.
"""

import math

import numpy as np

from mgeo_attitude._compiled import compile_cached, helper
from mgeo_attitude.filter.discretization import compute_step_rotation, discretize
from mgeo_attitude.filter.lanewise import call_address, fetch_add, load_acquire, store_release
from mgeo_attitude.filter.polynomials import discretize_isotropic

# Number of steps of a lane between two checks that its covariance is positive definite. Rare checks
# suffice because a lost positive definiteness persists. A check takes as long as half a step.
CHECK_PERIOD = 256

#: Step number beyond the end of every run.
UNREACHABLE_STEP = 2**62

#: Size of the cache of discretized maneuvers, enough for a batch of about a dozen finite-difference
#: gradients.
CACHE_SIZE = 256


@helper
def allocate_workspace(n_slots, lanes):
    """Return a zero-filled workspace for the filter values of all SIMD lanes. The array, shape
    (n_slots, lanes), is aligned to a cache line.

    A vector that spans two cache lines loads at half the speed.
    """
    line = 8
    buffer = np.zeros(n_slots * lanes + line)
    skip = -(buffer.ctypes.data // buffer.itemsize) % line
    return buffer[skip : skip + n_slots * lanes].reshape(n_slots, lanes)


@helper
def allocate_ring_buffer(window, lanes):
    """Allocate a ring buffer for the latest covariance traces of the candidates in all SIMD lanes.

    The buffer has the shape (size, lanes). Its size is the smallest power of two that exceeds the
    convergence window, in steps. With a power of two, an index is computed by a bit mask. The
    traces of a complete run would not fit in the second-level cache.
    """
    size = 1
    while size <= window:
        size *= 2
    return np.zeros((size, lanes))


@compile_cached("Tuple((float64[:,::1], float64[:,::1]))(float64[:,::1], float64[::1], float64)")
def discretize_compiled(A, density, dt):
    """Discretize the error dynamics of one filter step, compiled for calls from Python.

    See `discretize`.
    """
    return discretize(A, density, dt)


@helper
def write_maneuver(values, omega, dynamics):
    """Compute the constants of a filter step at a given body rate, and write them to `values`.

    The constants are the step rotation, the transition matrix and the process noise, in the order
    of the workspace slots.
    """
    parts, density, pattern, dt, by_polynomials = dynamics
    if by_polynomials:
        scratch = np.zeros((2, 6, 6))
        F, Q, polynomial_scratch = scratch[0], scratch[1], np.empty((2, 3, 3))
        densities = density[0], density[3]
        discretize_isotropic(
            -parts[0, 3, 3],
            densities,
            omega,
            dt,
            F,
            Q,
            polynomial_scratch[0],
            polynomial_scratch[1],
        )
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
    """Hash a body rate and a model variant to a row of the cache of discretized maneuvers.

    The key consists of the model variant and the bits of the body rate.
    """
    value = np.uint64(0)
    for number in key:
        value = (value ^ np.uint64(number)) * np.uint64(0x9E3779B97F4A7C15)
        value ^= value >> np.uint64(32)
    return np.int64(value % np.uint64(CACHE_SIZE))


@helper
def load_maneuver(W, lane, rotation, omega, dynamics, variant, cache):
    """Load the filter-step constants for a body rate into a SIMD lane. They are read from a cache
    if possible, and computed otherwise.

    The constants are the step rotation, the transition matrix and the process noise.
    """
    keys, values_of_row = cache
    bits = omega.view(np.int64)
    key = (variant + 1, bits[0], bits[1], bits[2])
    row = compute_cache_row(key)
    values, stored = values_of_row[row], keys[row]
    if stored[0] != key[0] or stored[1] != key[1] or stored[2] != key[2] or stored[3] != key[3]:
        write_maneuver(values, omega, dynamics)
        for i in range(4):
            stored[i] = key[i]
    for k in range(len(values)):
        W[rotation + k, lane] = values[k]


@helper
def load_axis_angle(W, lane, slot, omega, dt):
    """Compute the rotation of the body in one filter step, and store it in a SIMD lane.

    The values are the unit axis, the angle, and the sine and cosine of the angle. The axis is zero
    at zero rate.
    """
    rate = math.sqrt(omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2)
    for i in range(3):
        W[slot + i, lane] = omega[i] / rate if rate > 0.0 else 0.0
    W[slot + 3, lane] = rate * dt
    W[slot + 4, lane], W[slot + 5, lane] = math.sin(rate * dt), math.cos(rate * dt)


@helper
def save_lane(W, lane, n_values, traces, row, n, state):
    """Copy the filter state and the latest n covariance traces of a SIMD lane to `state`."""
    for j in range(n_values):
        state[j] = W[j, lane]
    for j in range(n):
        state[n_values + j] = traces[(row - j) % len(traces), lane]


@helper
def restore_lane(W, lane, n_values, traces, row, n, state):
    """Restore the filter state of a SIMD lane from an array that `save_lane` has written."""
    for j in range(n_values):
        W[j, lane] = state[j]
    for j in range(n):
        traces[(row - j) % len(traces), lane] = state[n_values + j]


@helper
def has_converged(traces, lane, row, window, decrease, allow_rise):
    """Return True if the covariance trace of the candidate in a SIMD lane has converged.

    The trace has converged if it fell by less than the fraction `decrease` over the convergence
    window. A rise counts as convergence only if `allow_rise` is true. A NaN trace counts as
    converged, to end the run.
    """
    start_trace = traces[(row - window) & (len(traces) - 1), lane]
    fall = start_trace - traces[row, lane]
    return not (fall >= decrease * start_trace or (fall < 0.0 and not allow_rise))


@helper
def count_settled_steps(traces, lane, row, k, factor):
    """Count the consecutive preceding steps whose covariance trace is at most `factor` times the
    current trace. The count is at most k.
    """
    bound, n = factor * traces[row, lane], 0
    while n < k and traces[(row - n - 1) & (len(traces) - 1), lane] <= bound:
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
    """Run the covariance filter for all jobs in a queue, and write the results to output arrays.
    Each job is a range of filter steps of one design.

    Several threads may call the function at once. A lane that has finished a job takes the next job
    from the queue and restarts its clock. Lanes do not exchange values, and a job continues from
    the exact final state of its parent job. The result of a design therefore depends only on the
    model and the design.

    Parameters
    ----------
    code : tuple of three int
        Addresses of the compiled functions ``step`` and ``check`` of the suite; number of lanes.
    layout : tuple of int
        See `layout.Layout`.
    queue : arrays of int, shapes (1,) and (n_jobs,)
        State shared by all threads: number of jobs taken; and the status of each job, 0 until its
        final state is stored, then 1, or 2 if the covariance is not positive definite.
    jobs : five arrays of int, shape (n_jobs,)
        See `jobs.Jobs`.
    states : array, shape (n_states + n_variants, rotation + window + 1)
        Final states of jobs, then the initial states of the variants in reverse order.
    plan : arrays, shapes (n, n_stretches, 3), (n, n_stretches), (n,) and (n,)
        Body rates [rad/s], start steps of the rates, end step of the last maneuver, and model
        variant of each design.
    dynamics : tuple of three arrays, float and bool
        Dynamics matrix A at zero rate and the derivative of A with respect to each rate component,
        shape (n_variants, 4, n_dynamic, n_dynamic); process-noise density, (n_variants, n_dynamic);
        (row, column) entries of the transition matrix that a step reads, (n_entries, 2); step [s];
        whether to discretize with `polynomials`.
    table : array, shape (n_samples, n_columns)
        Orbit table, see `FilterModel.orbit_table`.
    constants : array, shape (n_variants, n_constants)
        See `variants.stack_constants`.
    convergence : int, float, bool, float
        Window [steps]; relative decrease of the trace over the window below which a run has
        converged; whether a rise is accepted; and the factor on the final trace below which the
        trace is settled, or 0. With a factor, the window must be longer than the run.
    step_limits : three arrays of int, shape (n,)
        Last allowed step of each design; and, as output, the end step and the first step from
        which the trace remains settled.
    trace : array, shape (n,), output
        Weighted trace at the end; NaN if the covariance is not positive definite.
    final_values : arrays, shapes (n, n_monitors) and (n or 0, n_states (n_states + 1) / 2), output
        Monitored values at the end and, unless empty, the lower triangle of the covariance, row by
        row.
    record : array, shape (n or 0, n_steps + 1, n_states), output
        Variance of each state at each step, unless empty.
    """
    step, check, lanes = code
    n_taken, job_status = queue
    designs, start_steps, job_ends, parents, slots = jobs
    rates, starts, maneuver_end_steps, variants = plan
    parts, densities, pattern, dt, by_polynomials = dynamics
    window, decrease, allow_rise, factor = convergence
    last_steps, end_step, settling_steps = step_limits
    monitor_values, covariances = final_values
    n_jobs, n_maneuvers = len(designs), starts.shape[1]
    attitude, monitors, rotation, _, _, axis_angle_slot, rate_slot, omega_slot = layout[:8]
    trace_slot, pivot, _, table_slot, first_constant = layout[8:]
    n_constants = constants.shape[1]
    W, recent_traces = (
        allocate_workspace(first_constant + n_constants, lanes),
        allocate_ring_buffer(window, lanes),
    )
    n_dynamic = densities.shape[1]
    n_values = 9 + len(pattern) + n_dynamic * (n_dynamic + 1) // 2
    cache = np.zeros((CACHE_SIZE, 4), dtype=np.int64), np.empty((CACHE_SIZE, n_values))
    for k in range(n_constants):
        W[first_constant + k] = constants[0, k]
    address, mask = W.ctypes.data, len(recent_traces) - 1
    now = 0  # Row of `recent_traces` of the current step, the same for all lanes.
    job = np.empty(lanes, dtype=np.int64)
    clock = np.zeros(lanes, dtype=np.int64)
    maneuver = np.zeros(lanes, dtype=np.int64)
    is_running = np.zeros(lanes, dtype=np.int64)
    is_positive = np.ones(lanes, dtype=np.bool_)
    first_test_step = np.full(lanes, UNREACHABLE_STEP)
    n_active = 0
    for lane in range(lanes):
        job[lane] = fetch_add(n_taken, 1)
        n_active += job[lane] < n_jobs
    while n_active > 0:
        # Start the jobs and maneuvers that are due, and count the steps until the next event.
        n_steps = UNREACHABLE_STEP
        for lane in range(lanes):
            job_index, k = job[lane], clock[lane]
            if job_index >= n_jobs:
                continue
            i = designs[job_index]
            if not is_running[lane]:
                parent = parents[job_index]
                parent_status = 1 if parent < 0 else load_acquire(job_status, parent)
                if parent_status == 0:
                    continue
                is_running[lane], is_positive[lane] = 1, parent_status == 1
                maneuver[lane] = 0
                k = start_steps[job_index]
                clock[lane] = k
                first_test_step[lane] = max(maneuver_end_steps[i], window)
                for c in range(n_constants):
                    W[first_constant + c, lane] = constants[variants[i], c]
                state = states[parent if parent < 0 else slots[parent]]
                restore_lane(W, lane, rotation, recent_traces, now, min(window, k) + 1, state)
            m = maneuver[lane]
            while m < n_maneuvers and starts[i, m] <= k:
                m += 1
            if m > maneuver[lane]:
                # If several maneuvers start at this step, only the last of them takes effect.
                maneuver_dynamics = (
                    parts[variants[i]],
                    densities[variants[i]],
                    pattern,
                    dt,
                    by_polynomials,
                )
                load_maneuver(
                    W, lane, rotation, rates[i, m - 1], maneuver_dynamics, variants[i], cache
                )
                if axis_angle_slot < rate_slot:
                    load_axis_angle(W, lane, axis_angle_slot, rates[i, m - 1], dt)
                omega = rates[i, m - 1]
                if rate_slot < omega_slot:
                    W[rate_slot, lane] = omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2
                if omega_slot < trace_slot:
                    for axis in range(3):
                        W[omega_slot + axis, lane] = omega[axis]
                maneuver[lane] = m
            next_event = min(last_steps[i], k - k % CHECK_PERIOD + CHECK_PERIOD)
            if m < n_maneuvers:
                next_event = min(next_event, starts[i, m])
            if job_ends[job_index] >= 0:
                next_event = min(next_event, job_ends[job_index])
            n_steps = min(n_steps, next_event - k)
        if n_steps == UNREACHABLE_STEP:
            # Every job of this thread waits for its parent job in another thread.
            continue

        any_converged = False
        while n_steps > 0 and not any_converged:
            n_steps -= 1
            now = (now + 1) & mask
            for lane in range(lanes):
                clock[lane] += is_running[lane]
            for k in range(table.shape[1]):
                for lane in range(lanes):
                    W[table_slot + k, lane] = table[clock[lane], k]
            call_address(step, address)
            for lane in range(lanes):
                recent_traces[now, lane] = W[trace_slot, lane]
                is_tested = clock[lane] >= first_test_step[lane]
                any_converged |= is_tested & has_converged(
                    recent_traces, lane, now, window, decrease, allow_rise
                )
            if len(record) > 0:
                for lane in range(lanes):
                    if is_running[lane]:
                        for j in range(record.shape[2]):
                            variance = W[j * (j + 1) // 2 + j, lane]
                            record[designs[job[lane]], clock[lane], j] = variance

        is_checked = False
        for lane in range(lanes):
            if not is_running[lane]:
                continue
            job_index, k = job[lane], clock[lane]
            has_ended = k == last_steps[designs[job_index]] or (
                k >= first_test_step[lane]
                and has_converged(recent_traces, lane, now, window, decrease, allow_rise)
            )
            if has_ended or k % CHECK_PERIOD == 0:
                if not is_checked:
                    call_address(check, address)
                    is_checked = True
                is_positive[lane] &= W[pivot, lane] > 0.0
            if k == job_ends[job_index]:
                state = states[slots[job_index]]
                save_lane(W, lane, rotation, recent_traces, now, min(window, k) + 1, state)
                store_release(job_status, job_index, 1 if is_positive[lane] else 2)
            elif has_ended:
                i = designs[job_index]
                end_step[i] = k
                if factor > 0.0:
                    settling_steps[i] = k - count_settled_steps(recent_traces, lane, now, k, factor)
                trace[i] = recent_traces[now, lane] if is_positive[lane] else np.nan
                for j in range(monitor_values.shape[1]):
                    monitor_values[i, j] = W[monitors + j, lane]
                if len(covariances) > 0:
                    for j in range(attitude):
                        covariances[i, j] = W[j, lane]
            else:
                continue
            is_running[lane], clock[lane], first_test_step[lane] = 0, 0, UNREACHABLE_STEP
            job[lane] = fetch_add(n_taken, 1)
            n_active -= job[lane] >= n_jobs
