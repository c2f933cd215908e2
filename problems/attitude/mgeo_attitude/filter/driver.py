"""Runs designs through the generated filter step, one candidate in each lane.

Compiled once for all suites: `kernel.py` puts the text of this module into the user's cache.
"""

import math

import numpy as np

from mgeo_attitude._compiled import helper, kept
from mgeo_attitude.filter.discretization import discretize, turn
from mgeo_attitude.filter.lanewise import call, fetch_add, load_acquire, store_release
from mgeo_attitude.filter.polynomials import discretize_alike

# Steps of a lane between two checks that its covariance is positive. Lost positivity stays lost
# for long, and a check costs half a step.
CHECK_PERIOD = 256

#: Later than any step.
NEVER = 2**62

#: Maneuvers whose discretization is kept: more than a batch of slopes of a dozen has.
KEPT = 256


@helper
def workspace(n_slots, lanes):
    """Zeros that begin with a cache line: vectors across two lines load at half the speed."""
    line = 8
    buffer = np.zeros(n_slots * lanes + line)
    skip = -(buffer.ctypes.data // buffer.itemsize) % line
    return buffer[skip : skip + n_slots * lanes].reshape(n_slots, lanes)


@helper
def ring(window, lanes):
    """Room for the trace of all lanes over a window; a power of two, so that rows are found fast.

    The whole history would not stay in the second-level cache.
    """
    size = 1
    while size <= window:
        size *= 2
    return np.zeros((size, lanes))


@kept("Tuple((float64[:,::1], float64[:,::1]))(float64[:,::1], float64[::1], float64)")
def discretized(A, density, dt):
    """`discretize`, kept on disk for Python."""
    return discretize(A, density, dt)


@helper
def write_maneuver(values, omega, dynamics):
    """Write a maneuver's turn per step, exact transition and process noise, in a lane's order."""
    parts, density, pattern, dt, by_polynomials = dynamics
    if by_polynomials:
        room = np.zeros((2, 6, 6))
        F, Q, own = room[0], room[1], np.empty((2, 3, 3))
        densities = density[0], density[3]
        discretize_alike(-parts[0, 3, 3], densities, omega, dt, F, Q, own[0], own[1])
    else:
        A = parts[0] + omega[0] * parts[1] + omega[1] * parts[2] + omega[2] * parts[3]
        F, Q = discretize(A, density, dt)
    turned = turn(omega, dt)
    k = 0
    for i in range(3):
        for j in range(3):
            values[k] = turned[i, j]
            k += 1
    for entry in range(len(pattern)):
        values[k] = F[pattern[entry, 0], pattern[entry, 1]]
        k += 1
    for i in range(len(Q)):
        for j in range(i + 1):
            values[k] = Q[i, j]
            k += 1


@helper
def place_of(key):
    """Where the values of a maneuver are kept: a hash of its variant and rate, as bits."""
    found = np.uint64(0)
    for number in key:
        found = (found ^ np.uint64(number)) * np.uint64(0x9E3779B97F4A7C15)
        found ^= found >> np.uint64(32)
    return np.int64(found % np.uint64(KEPT))


@helper
def load_maneuver(W, lane, rotation, omega, dynamics, variant, kept):
    """Write them to a lane. Many designs of a batch have maneuvers in common: they are kept."""
    keys, known = kept
    bits = omega.view(np.int64)
    key = (variant + 1, bits[0], bits[1], bits[2])
    place = place_of(key)
    values, own = known[place], keys[place]
    if own[0] != key[0] or own[1] != key[1] or own[2] != key[2] or own[3] != key[3]:
        write_maneuver(values, omega, dynamics)
        for i in range(4):
            own[i] = key[i]
    for k in range(len(values)):
        W[rotation + k, lane] = values[k]


@helper
def load_turn(W, lane, slot, omega, dt):
    """Write the unit axis of a maneuver's turn per step, its angle, sine and cosine to a lane."""
    rate = math.sqrt(omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2)
    for i in range(3):
        W[slot + i, lane] = omega[i] / rate if rate > 0.0 else 0.0
    W[slot + 3, lane] = rate * dt
    W[slot + 4, lane], W[slot + 5, lane] = math.sin(rate * dt), math.cos(rate * dt)


@helper
def save(W, lane, n_values, recent, now, n, state):
    """Store a lane's covariance, attitude, monitors and the last n values of its trace."""
    for j in range(n_values):
        state[j] = W[j, lane]
    for j in range(n):
        state[n_values + j] = recent[(now - j) % len(recent), lane]


@helper
def restore(W, lane, n_values, recent, now, n, state):
    """Inverse of `save`."""
    for j in range(n_values):
        W[j, lane] = state[j]
    for j in range(n):
        recent[(now - j) % len(recent), lane] = state[n_values + j]


@helper
def converged(recent, lane, now, window, decrease, allow_rise):
    """Whether the trace fell by less than the least decrease, and did not rise, equation (6).

    A rise may be allowed. A trace of NaN has nothing left to wait for.
    """
    before = recent[(now - window) & (len(recent) - 1), lane]
    fall = before - recent[now, lane]
    return not (fall >= decrease * before or (fall < 0.0 and not allow_rise))


@helper
def settled_for(recent, lane, now, k, factor):
    """For how many of the last k steps the trace was within a factor of what it is now."""
    limit, n = factor * recent[now, lane], 0
    while n < k and recent[(now - n - 1) & (len(recent) - 1), lane] <= limit:
        n += 1
    return n


@kept(
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
    shared,
    jobs,
    states,
    plan,
    dynamics,
    table,
    constants,
    convergence,
    steps,
    trace,
    at_end,
    record,
):
    """Run jobs from the queue until it is empty; any number of threads may share it.

    A lane that has finished a job takes the next one from the queue, with a clock of its own. No
    value ever crosses lanes, and a job goes on from its parent's state exactly as that left it, so
    a result does not depend on what else is run.

    Parameters
    ----------
    code : tuple of three int
        Addresses of the suite's functions, one filter step and the last pivot of the covariance of
        all lanes, in place; number of lanes.
    layout : tuple of int
        See `layout.Layout`.
    shared : arrays of int, shapes (1,) and (n_jobs,)
        Shared by the threads: the number of jobs already taken; and zero until a job has left its
        final state, then 1, or 2 if its covariance had already lost positivity.
    jobs : five arrays of int, shape (n_jobs,)
        See `jobs.Jobs`.
    states : array, shape (n_states + n_variants, rotation + window + 1)
        States that jobs leave; the last ones are those at time zero, the first variant's the last.
    plan : arrays, shapes (n, n_stretches, 3), (n, n_stretches), (n,) and (n,)
        Body rates [rad/s], the steps they begin at, that at which the last maneuver is over, and
        the variant of the model that flies it.
    dynamics : arrays, shapes (n_variants, 4, n_dynamic, n_dynamic), (n_variants, n_dynamic) and
        (n_entries, 2); float
        A at rest, and what a unit rate about each axis adds to it; process-noise density; entries
        of the transition matrix that a step reads; step [s]; and whether `polynomials` have its
        transitions, where each step has a rate of its own.
    table : array, shape (n_samples, n_given)
        What the orbit gives at each sample.
    constants : array, shape (n_variants, n_constants)
        See `variants.constants_of`.
    convergence : int, float, bool, float
        Window [steps], least relative decrease of the trace over it, whether it may have risen;
        factor of a settled trace, 0 if nobody asks. With one, the window is the whole run.
    steps : three arrays of int, shape (n,)
        Step at which a design stops in any case; and, written, that at which it ended, and that
        from which on its trace was settled.
    trace : array, shape (n,), written
        At the end; NaN if the covariance lost positivity.
    at_end : arrays, shapes (n, n_monitors) and (n or 0, n_states (n_states + 1) / 2), written
        Monitors then and, if asked for, the lower triangle of the covariance, row by row.
    record : array, shape (n or 0, n_steps + 1, n_states), written
        Variance of each state at each step, if asked for.
    """
    step, check, lanes = code
    taken, done = shared
    designs, begins, ends, parents, slots = jobs
    rates, starts, over, variants = plan
    parts, densities, pattern, dt, by_polynomials = dynamics
    window, decrease, allow_rise, factor = convergence
    stops, end_step, settled = steps
    watched, final = at_end
    n_jobs, n_maneuvers = len(designs), starts.shape[1]
    attitude, monitors, rotation, _, _, turned, rate, omega_slot = layout[:8]
    trace_slot, pivot, _, given, first_constant = layout[8:]
    n_constants = constants.shape[1]
    W, recent = workspace(first_constant + n_constants, lanes), ring(window, lanes)
    n_dynamic = densities.shape[1]
    n_values = 9 + len(pattern) + n_dynamic * (n_dynamic + 1) // 2
    kept = np.zeros((KEPT, 4), dtype=np.int64), np.empty((KEPT, n_values))
    for k in range(n_constants):
        W[first_constant + k] = constants[0, k]
    address, mask = W.ctypes.data, len(recent) - 1
    now = 0  # the row of `recent` for the present step of every lane
    job = np.empty(lanes, dtype=np.int64)
    clock = np.zeros(lanes, dtype=np.int64)
    maneuver = np.zeros(lanes, dtype=np.int64)
    running = np.zeros(lanes, dtype=np.int64)
    healthy = np.ones(lanes, dtype=np.bool_)
    test_from = np.full(lanes, NEVER)
    active = 0
    for lane in range(lanes):
        job[lane] = fetch_add(taken, 1)
        active += job[lane] < n_jobs
    while active > 0:
        # what is due before the next step, and how many steps there are until more is
        n_steps = NEVER
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
                restore(W, lane, rotation, recent, now, min(window, k) + 1, state)
            m = maneuver[lane]
            while m < n_maneuvers and starts[i, m] <= k:
                m += 1
            if m > maneuver[lane]:
                # of several maneuvers that have started only the last one is flown
                own = parts[variants[i]], densities[variants[i]], pattern, dt, by_polynomials
                load_maneuver(W, lane, rotation, rates[i, m - 1], own, variants[i], kept)
                if turned < rate:
                    load_turn(W, lane, turned, rates[i, m - 1], dt)
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
        if n_steps == NEVER:  # every job here waits for its parent in another thread
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
            call(step, address)
            for lane in range(lanes):
                recent[now, lane] = W[trace_slot, lane]
                tested = clock[lane] >= test_from[lane]
                ended |= tested & converged(recent, lane, now, window, decrease, allow_rise)
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
                k >= test_from[lane] and converged(recent, lane, now, window, decrease, allow_rise)
            )
            if over_now or k % CHECK_PERIOD == 0:
                if not checked:
                    call(check, address)
                    checked = True
                healthy[lane] &= W[pivot, lane] > 0.0
            if k == ends[this]:
                state = states[slots[this]]
                save(W, lane, rotation, recent, now, min(window, k) + 1, state)
                store_release(done, this, 1 if healthy[lane] else 2)
            elif over_now:
                i = designs[this]
                end_step[i] = k
                if factor > 0.0:
                    settled[i] = k - settled_for(recent, lane, now, k, factor)
                trace[i] = recent[now, lane] if healthy[lane] else np.nan
                for j in range(watched.shape[1]):
                    watched[i, j] = W[monitors + j, lane]
                if len(final) > 0:
                    for j in range(attitude):
                        final[i, j] = W[j, lane]
            else:
                continue
            running[lane], clock[lane], test_from[lane] = 0, 0, NEVER
            job[lane] = fetch_add(taken, 1)
            active -= job[lane] >= n_jobs
