"""Momentum and torque of the wheels along plans, compiled: nothing is simulated but the attitude.

The satellite's angular momentum H changes by external torques only. In body axes it is C (H₀ + D)
with the attitude C, H₀ = C₀ᵀ (A h₀ + J ω₀) at the start, and D = ∫ Cᵀ T dt of the torques
T = 3 μ / r⁵ r × J r + m × B. What the wheels hold of it is A h = H - J ω, and their torque
A dh/dt = T - J dω/dt - ω × H. A wheel's load is what both are by the plan alone, and the magnitude
of what the disturbances T and D add times a margin.

Coils may unload the wheels. Their dipole m = b × τ / |b|², τ = -H / t, none greater than a coil's,
is held for a step and takes out what of H is across the field b (cross-product law: Camillo &
Markley, Journal of Guidance and Control 3 (1980) 563-568; `maneuvers.drives` drives the body by the
same). H is known to it: by wheels' speeds and gyro. The load is then what the wheels hold of H
with the disturbances as they are modeled and what the coils gave, and besides the magnitude of
disturbances times the margin less one: what is not modeled is not unloaded either.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from mgeo_attitude._compiled import entry, helper
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment.constants import EARTH_MU
from mgeo_attitude.filter.discretization import turn
from mgeo_attitude.filter.momentum import MomentumBudget
from mgeo_attitude.maneuvers.rigid_body import assign, assign_matrix, cross, limited, product
from mgeo_attitude.maneuvers.schedule import Schedule

#: Part of a step below which a rate changes at once.
_AT_ONCE = 1e-12


def wheel_loads(
    budget: MomentumBudget,
    plan: Schedule,
    end_steps: Ints,
    step: float,
    threads: int,
    first_step: int = 0,
) -> Floats:
    """Greatest momentum [N m s] and torque [N m] of a wheel until `end_steps`, shape (n, 2).

    They are looked at in every filter step of `step` seconds from the first one on, at both ends.
    """
    found = np.zeros((len(end_steps), 2))
    wheels = budget.inertia, budget.allocation, budget.circulating
    start = budget.attitude, budget.rate, budget.momentum, first_step
    outside = budget.position, budget.field, budget.dipole, budget.gradient, budget.margin
    coils = budget.coils, budget.response

    def some(part: slice) -> None:
        stretches = plan.rates[part], plan.end_rates[part], plan.starts[part]
        _greatest(stretches, end_steps[part], step, start, wheels, outside, coils, found[part])

    size = -(-len(end_steps) // threads)
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(some, (slice(k * size, (k + 1) * size) for k in range(threads))))
    return found


@helper
def gravity_gradient(inertia: Floats, position: Floats, out: Floats) -> None:
    """out ← 3 μ / r⁵ r × J r [N m], for the position from the Earth's center in body axes [m]."""
    square = position[0] ** 2 + position[1] ** 2 + position[2] ** 2
    product(inertia, position, out)
    cross(position, out, out)
    for i in range(3):
        out[i] *= 3.0 * EARTH_MU / (square * square * math.sqrt(square))


@entry(
    "void(Tuple((float64[:,:,::1], float64[:,:,::1], int64[:,::1])), int64[::1], float64,"
    "Tuple((float64[:,::1], float64[::1], float64[::1], int64)),"
    "Tuple((float64[:,::1], float64[:,::1], float64[::1])),"
    "Tuple((Array(float64, 2, 'C', readonly=True), float64[:,::1], float64[::1], float64,"
    "float64)),"
    "Tuple((float64[::1], float64)), float64[:,::1])"
)
def _greatest(plan, end_steps, step, start, wheels, outside, coils, found):  # type: ignore[no-untyped-def]
    """`wheel_loads`, written to `found`."""
    rates, end_rates, starts = plan
    inertia = wheels[0]
    initial_attitude, initial_rate, momentum, first = start
    position, field, dipole, gradient, margin = outside
    largest, response = coils
    unloads = largest[0] > 0.0
    if unloads:
        margin -= 1.0
    C, turned, old = initial_attitude.copy(), np.eye(3), np.eye(3)
    rate, acceleration = np.zeros(3), np.zeros(3)
    torque, magnetic, vector = np.zeros(3), np.zeros(3), np.zeros(3)
    added, now, last = np.zeros(3), np.zeros(3), np.zeros(3)
    own, extra, room = np.zeros(3), np.zeros(3), np.zeros((4, 3))
    held, given, unloaded = np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(len(end_steps)):
        assign_matrix(initial_attitude, C)
        assign(initial_rate, rate)
        for a in range(3):
            added[a] = held[a] = unloaded[a] = 0.0
        m, n_stretches = -1, starts.shape[1]
        for k in range(end_steps[i] + 1):
            product(C, position[k], vector)
            gravity_gradient(inertia, vector, torque)
            product(C, field[k], vector)
            cross(dipole, vector, magnetic)
            for a in range(3):
                torque[a] = gradient * torque[a] + magnetic[a]
            product(C.T, torque, now)
            if k > 0:
                for a in range(3):
                    added[a] += 0.5 * step * (last[a] + now[a])
            assign(now, last)
            product(C, momentum, own)
            product(C, added, extra)
            if unloads:  # the dipole of the step that ends gives half of its torque here
                _give(held, vector, C, 0.5 * step, magnetic, unloaded)
                product(C, unloaded, given)
                for a in range(3):
                    own[a] += extra[a] + given[a]
                    given[a] = torque[a] + magnetic[a]
            if k > 0:
                assign(end_rates[i, m], rate)
            if k > first:  # at the end of a step
                _load(rate, acceleration, own, extra, torque, given, wheels, margin, room, found[i])
            if unloads:  # and that of the next one the first half
                for a in range(3):
                    given[a] = -own[a] / response
                limited(vector, given, largest, held)
                _give(held, vector, C, 0.5 * step, magnetic, unloaded)
                for a in range(3):
                    given[a] = torque[a] + magnetic[a]
            if k == end_steps[i]:
                break
            before = m
            while m + 1 < n_stretches and starts[i, m + 1] <= k:
                m += 1
            if m > before:  # and at the beginning of one of another rate
                assign_matrix(turn(rates[i, m], step), turned)
                if not _accelerate(rate, rates[i, m], end_rates[i, m], step, acceleration):
                    assign(rates[i, m], rate)
            if k == first or (m > before and k > first):
                _load(rate, acceleration, own, extra, torque, given, wheels, margin, room, found[i])
            assign_matrix(C, old)
            for a in range(3):
                product(turned, old[:, a], vector)
                assign(vector, C[:, a])


@helper
def _give(dipole, b, C, time, torque, unloaded):  # type: ignore[no-untyped-def]
    """torque ← m × b, body axes; unloaded, GCRS, has what it gives in a time besides."""
    cross(dipole, b, torque)
    for a in range(3):
        for c in range(3):
            unloaded[a] += time * C[c, a] * torque[c]


@helper
def _load(rate, acceleration, own, extra, torque, given, wheels, margin, room, found):  # type: ignore[no-untyped-def]
    """Raise `found` to the momentum and torque of the most loaded wheel, if they are greater.

    `own` is the satellite's momentum in body axes, `given` the torque that counts with it, `extra`
    what disturbances added, `torque` what they are, of which the magnitude counts. There is `room`,
    shape (4, 3), because to make it takes as long as all else.
    """
    inertia, allocation, circulating = wheels
    spin, needed, turning, turned = room[0], room[1], room[2], room[3]
    product(inertia, rate, spin)
    product(inertia, acceleration, needed)
    cross(rate, own, turning)
    cross(rate, extra, turned)
    for row in range(len(allocation)):
        momentum, its_extra, effort, its_disturbance = circulating[row], 0.0, 0.0, 0.0
        for a in range(3):
            share = allocation[row, a]
            momentum += share * (own[a] - spin[a])
            its_extra += share * extra[a]
            effort += share * (needed[a] + turning[a] - given[a])
            its_disturbance += share * (torque[a] - turned[a])
        found[0] = max(found[0], abs(momentum) + margin * abs(its_extra))
        found[1] = max(found[1], abs(effort) + margin * abs(its_disturbance))


@helper
def _accelerate(before, mean, end, step, out):  # type: ignore[no-untyped-def]
    """Angular acceleration of a step [rad/s²], and whether it is one of a ramp.

    The rate moves straight from `before` to `end` in a part p of the step: its mean is 1 - p / 2 of
    the way.
    """
    out[0] = out[1] = out[2] = 0.0
    change, moved = 0.0, 0.0
    for a in range(3):
        change += (end[a] - before[a]) ** 2
        moved += (end[a] - before[a]) * (mean[a] - before[a])
    ramp = moved < change * (1.0 - _AT_ONCE)
    if ramp:
        for a in range(3):
            out[a] = (end[a] - before[a]) * change / (2.0 * (change - moved) * step)
    return ramp
