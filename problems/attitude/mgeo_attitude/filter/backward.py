"""Runs designs through the filter step, and then backward through `adjoint.py`'s.

Compiled once for all suites: `kernel.py` puts the text of this module into the user's cache.
"""

import numpy as np

from mgeo_attitude._compiled import helper, kept
from mgeo_attitude.filter.lane import KEPT, load_maneuver, workspace, write_maneuver
from mgeo_attitude.filter.lanewise import call, fetch_add

#: Change of the angle of a step [rad] by which derivatives of what a maneuver writes are taken.
SMALL = 1e-5


@helper
def by_rate(W, lane, first, omega, dynamics, found):
    """The derivative by a rate of what it writes to a lane, times what is then forgotten."""
    n_values = 9 + len(dynamics[2]) + len(dynamics[1]) * (len(dynamics[1]) + 1) // 2
    more, less, small = np.empty(n_values), np.empty(n_values), SMALL / dynamics[3]
    for axis in range(3):
        changed = omega.copy()
        changed[axis] = omega[axis] + small
        write_maneuver(more, changed, dynamics)
        changed[axis] = omega[axis] - small
        write_maneuver(less, changed, dynamics)
        total = 0.0
        for k in range(n_values):
            total += W[first + k, lane] * (more[k] - less[k])
        found[axis] = total / (2.0 * small)
    for k in range(n_values):
        W[first + k, lane] = 0.0


@kept(
    "void(UniTuple(int64, 4), UniTuple(int64, 13), UniTuple(int64, 9), int64[::1],"
    "Tuple((float64[:,:,::1], int64[:,::1], int64[::1])),"
    "Tuple((float64[:,:,::1], float64[::1], int64[:,::1], float64, boolean)), float64[:,::1],"
    "UniTuple(float64[::1], 3), float64[::1], float64[:,:,::1])"
)
def run(code, layout, places, taken, plan, dynamics, table, numbers, trace, slopes):
    """Values of designs from a queue until it is empty; any number of threads may share it.

    Parameters
    ----------
    code : tuple of four int
        Addresses of the suite's ``step``, ``check`` and ``back``; number of lanes.
    layout, places : tuples of int
        See `layout.Layout` and `adjoint.Places`.
    taken : array of int, shape (1,)
        Shared by the threads: the number of designs already taken.
    plan : arrays, shapes (n, k, 3), (n, k) and (n,)
        Body rates [rad/s], the steps they begin at, and that at which a design stops.
    dynamics : as of `driver.run`, of the one variant that flies all
    table : array, shape (n_samples, n_given)
        What the orbit gives at each sample.
    numbers : arrays, shapes (n_constants,), (n_values,) and (n_states,)
        Constants of a step; values at time zero, see `variants.initial_values`; and weights of the
        trace.
    trace : array, shape (n,), written
        At the end; NaN if the covariance lost positivity.
    slopes : array, shape (n, k, 3), to be written
        Zeros; where a stretch is flown, the derivatives of the trace by its rates.
    """
    step, check, back, lanes = code
    rates, starts, stops = plan
    constants, initial, weights = numbers
    rotation, trace_slot, pivot, given = layout[2], layout[8], layout[9], layout[11]
    by_covariance, by_maneuver, size = places[0], places[2], places[8]
    n, n_stretches, n_states = len(stops), starts.shape[1], len(weights)
    W = workspace(size, lanes)
    for k in range(len(constants)):
        W[layout[12] + k] = constants[k]
    n_values = 9 + len(dynamics[2]) + len(dynamics[1]) * (len(dynamics[1]) + 1) // 2
    known = np.zeros((KEPT, 4), dtype=np.int64), np.empty((KEPT, n_values))
    # flat, as they are copied a third faster
    state, record = W.reshape(-1)[: rotation * lanes], np.empty((stops.max() + 1, rotation * lanes))
    flown, design = np.zeros(lanes, dtype=np.int64), np.zeros(lanes, dtype=np.int64)
    while True:
        first = fetch_add(taken, lanes)
        if first >= n:
            break
        last = 0
        for lane in range(lanes):
            design[lane], flown[lane] = min(first + lane, n - 1), -1
            last = max(last, stops[design[lane]])
        for j in range(rotation):
            W[j] = initial[j]
        record[0] = state
        for k in range(1, last + 1):
            ends = False
            for lane in range(lanes):
                i, m = design[lane], flown[lane]
                while m + 1 < n_stretches and starts[i, m + 1] < k:
                    m += 1
                if m > flown[lane]:
                    load_maneuver(W, lane, rotation, rates[i, m], dynamics, 0, known)
                    flown[lane] = m
                ends |= stops[i] == k
            for j in range(table.shape[1]):
                W[given + j] = table[k, j]
            call(step, W.ctypes.data)
            record[k] = state
            if ends:
                call(check, W.ctypes.data)
                for lane in range(lanes):
                    if stops[design[lane]] == k:
                        sound = W[pivot, lane] > 0.0
                        trace[design[lane]] = W[trace_slot, lane] if sound else np.nan
        W[by_covariance : by_maneuver + n_values] = 0.0
        for k in range(last, 0, -1):
            state[:] = record[k - 1]
            for j in range(table.shape[1]):
                W[given + j] = table[k, j]
            for lane in range(lanes):
                i, m = design[lane], flown[lane]
                while starts[i, m] >= k:
                    m -= 1
                if m < flown[lane]:
                    later = flown[lane]
                    if first + lane < n:
                        by_rate(W, lane, by_maneuver, rates[i, later], dynamics, slopes[i, later])
                    load_maneuver(W, lane, rotation, rates[i, m], dynamics, 0, known)
                    flown[lane] = m
                if stops[i] == k:
                    for j in range(n_states):
                        W[by_covariance + j * n_states + j, lane] = weights[j]
            call(back, W.ctypes.data)
        for lane in range(lanes):
            i, m = design[lane], flown[lane]
            if first + lane < n:
                by_rate(W, lane, by_maneuver, rates[i, m], dynamics, slopes[i, m])
