"""What a maneuver writes to a lane of the workspace, for the filter forward and backward."""

import numpy as np

from mgeo_attitude._compiled import helper
from mgeo_attitude.filter.discretization import discretize, turn
from mgeo_attitude.filter.polynomials import discretize_alike

#: Maneuvers whose discretization is kept: more than a plan, and what leaves it, has.
KEPT = 256


@helper
def workspace(n_slots, lanes):
    """Zeros that begin with a cache line: vectors across two lines load at half the speed."""
    line = 8
    buffer = np.zeros(n_slots * lanes + line)
    skip = -(buffer.ctypes.data // buffer.itemsize) % line
    return buffer[skip : skip + n_slots * lanes].reshape(n_slots, lanes)


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
