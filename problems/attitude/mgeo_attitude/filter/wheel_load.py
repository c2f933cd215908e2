"""Compiled computation of the momentum and torque of the reaction wheels along plans.

The attitude follows the plan exactly, and wheel dynamics are not simulated. The angular momentum H
of the satellite changes by external torques only. In body axes H = C (H₀ + D), with the attitude C,
the initial momentum H₀ = C₀ᵀ (A h₀ + J ω₀), and D = ∫ Cᵀ T dt of the torques
T = 3 μ / r⁵ r × J r + m × B. The wheels store A h = H - J ω, and their torque is
A dh/dt = T - J dω/dt - ω × H. The load of a wheel is its share of the undisturbed plan, plus a
margin factor times the magnitude of the contribution of the disturbances T and D.

Magnetorquers may unload the wheels. Their dipole m = b × τ / |b|² with τ = -H / t, limited to the
maximum of each magnetorquer, is constant in a step and removes the part of H across the field b
(cross-product law: Camillo & Markley, Journal of Guidance and Control 3 (1980) 563-568). The law
also controls the body in `maneuvers.actuation`. H is measured with wheel speeds and gyro. The load
then includes the modeled disturbances and the unloading torques, plus the margin factor minus one
times the magnitude of the disturbances, since the unmodeled part is not unloaded.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from mgeo_attitude._compiled import compile_on_first_call, helper
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment.constants import EARTH_MU
from mgeo_attitude.filter.discretization import compute_step_rotation
from mgeo_attitude.filter.momentum import MomentumBudget
from mgeo_attitude.maneuvers.rigid_body import (
    assign,
    assign_matrix,
    cross,
    limit_dipole,
    multiply_matrix,
)
from mgeo_attitude.maneuvers.schedule import Schedule

#: Duration of a ramp, relative to the step, below which the rate change is instantaneous.
_INSTANT_RAMP_FRACTION = 1e-12


def compute_wheel_loads(
    budget: MomentumBudget,
    plan: Schedule,
    end_steps: Ints,
    step: float,
    threads: int,
    first_step: int = 0,
) -> Floats:
    """Compute the largest wheel momentum [N m s] and wheel torque [N m] of each design.

    The result has shape (n, 2), with the largest value of any wheel along the plan. The loads are
    evaluated at both ends of each filter step.

    Parameters
    ----------
    budget : MomentumBudget
    plan : Schedule
        Body rates of n designs.
    end_steps : array of int, shape (n,)
        Last step of each design.
    step : float
        Filter step [s].
    threads : int
    first_step : int
        First step whose loads are evaluated.
    """
    loads = np.zeros((len(end_steps), 2))
    wheels = budget.inertia, budget.allocation, budget.null_space_momentum
    start = budget.attitude, budget.rate, budget.momentum, first_step
    disturbances = (
        budget.position,
        budget.field,
        budget.residual_dipole,
        budget.gravity_gradient,
        budget.disturbance_margin,
    )
    magnetorquers = budget.magnetorquer_dipole, budget.unloading_time_constant

    def compute_part(part: slice) -> None:
        rate_arrays = plan.rates[part], plan.end_rates[part], plan.starts[part]
        _compute_loads(
            rate_arrays,
            end_steps[part],
            step,
            start,
            wheels,
            disturbances,
            magnetorquers,
            loads[part],
        )

    size = -(-len(end_steps) // threads)
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(compute_part, (slice(k * size, (k + 1) * size) for k in range(threads))))
    return loads


@helper
def compute_gravity_gradient(inertia: Floats, position: Floats, out: Floats) -> None:
    """Compute the gravity-gradient torque [N m] in body axes, and write it to `out`.

    The inertia [kg m²] and the geocentric position [m] are also in body axes.
    """
    square = position[0] ** 2 + position[1] ** 2 + position[2] ** 2
    multiply_matrix(inertia, position, out)
    cross(position, out, out)
    for i in range(3):
        out[i] *= 3.0 * EARTH_MU / (square * square * math.sqrt(square))


@compile_on_first_call(
    "void(Tuple((float64[:,:,::1], float64[:,:,::1], int64[:,::1])), int64[::1], float64,"
    "Tuple((float64[:,::1], float64[::1], float64[::1], int64)),"
    "Tuple((float64[:,::1], float64[:,::1], float64[::1])),"
    "Tuple((Array(float64, 2, 'C', readonly=True), float64[:,::1], float64[::1], float64,"
    "float64)),"
    "Tuple((float64[::1], float64)), float64[:,::1])"
)
def _compute_loads(plan, end_steps, step, start, wheels, disturbances, magnetorquers, loads):  # type: ignore[no-untyped-def]
    rates, end_rates, starts = plan
    inertia = wheels[0]
    initial_attitude, initial_rate, momentum, first_step = start
    position, field, dipole, gradient, margin = disturbances
    max_dipole, time_constant = magnetorquers
    unloads = max_dipole[0] > 0.0
    if unloads:
        margin -= 1.0
    C, rotation, old_attitude = initial_attitude.copy(), np.eye(3), np.eye(3)
    rate, acceleration = np.zeros(3), np.zeros(3)
    torque, magnetic, vector = np.zeros(3), np.zeros(3), np.zeros(3)
    impulse, inertial_torque, last_inertial_torque = np.zeros(3), np.zeros(3), np.zeros(3)
    body_momentum, extra_momentum, scratch = np.zeros(3), np.zeros(3), np.zeros((4, 3))
    applied_dipole, modeled_torque, unloaded = np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(len(end_steps)):
        assign_matrix(initial_attitude, C)
        assign(initial_rate, rate)
        for a in range(3):
            impulse[a] = applied_dipole[a] = unloaded[a] = 0.0
        m, n_stretches = -1, starts.shape[1]
        for k in range(end_steps[i] + 1):
            multiply_matrix(C, position[k], vector)
            compute_gravity_gradient(inertia, vector, torque)
            multiply_matrix(C, field[k], vector)
            cross(dipole, vector, magnetic)
            for a in range(3):
                torque[a] = gradient * torque[a] + magnetic[a]
            multiply_matrix(C.T, torque, inertial_torque)
            if k > 0:
                for a in range(3):
                    impulse[a] += 0.5 * step * (last_inertial_torque[a] + inertial_torque[a])
            assign(inertial_torque, last_inertial_torque)
            multiply_matrix(C, momentum, body_momentum)
            multiply_matrix(C, impulse, extra_momentum)
            if unloads:  # Trapezoidal rule: add the second half of the impulse of the last step.
                _apply_dipole(applied_dipole, vector, C, 0.5 * step, magnetic, unloaded)
                multiply_matrix(C, unloaded, modeled_torque)
                for a in range(3):
                    body_momentum[a] += extra_momentum[a] + modeled_torque[a]
                    modeled_torque[a] = torque[a] + magnetic[a]
            if k > 0:
                assign(end_rates[i, m], rate)
            if k > first_step:  # Evaluate the load at the end of the last step.
                _update_maxima(
                    rate,
                    acceleration,
                    body_momentum,
                    extra_momentum,
                    torque,
                    modeled_torque,
                    wheels,
                    margin,
                    scratch,
                    loads[i],
                )
            if unloads:  # Add the first half of the impulse of the next step.
                for a in range(3):
                    modeled_torque[a] = -body_momentum[a] / time_constant
                limit_dipole(vector, modeled_torque, max_dipole, applied_dipole)
                _apply_dipole(applied_dipole, vector, C, 0.5 * step, magnetic, unloaded)
                for a in range(3):
                    modeled_torque[a] = torque[a] + magnetic[a]
            if k == end_steps[i]:
                break
            before = m
            while m + 1 < n_stretches and starts[i, m + 1] <= k:
                m += 1
            if m > before:  # The rate changes at this step.
                assign_matrix(compute_step_rotation(rates[i, m], step), rotation)
                if not _compute_acceleration(
                    rate, rates[i, m], end_rates[i, m], step, acceleration
                ):
                    assign(rates[i, m], rate)
            if k == first_step or (m > before and k > first_step):
                _update_maxima(
                    rate,
                    acceleration,
                    body_momentum,
                    extra_momentum,
                    torque,
                    modeled_torque,
                    wheels,
                    margin,
                    scratch,
                    loads[i],
                )
            assign_matrix(C, old_attitude)
            for a in range(3):
                multiply_matrix(rotation, old_attitude[:, a], vector)
                assign(vector, C[:, a])


@helper
def _apply_dipole(dipole, b, C, time, torque, unloaded):  # type: ignore[no-untyped-def]
    """Write the torque of a magnetic dipole to `torque`, and add its impulse to `unloaded`.

    The dipole, the magnetic field b and the torque are in body axes. The impulse is the torque
    times `time`, in GCRS.
    """
    cross(dipole, b, torque)
    for a in range(3):
        for c in range(3):
            unloaded[a] += time * C[c, a] * torque[c]


@helper
def _update_maxima(  # type: ignore[no-untyped-def]
    rate,
    acceleration,
    body_momentum,
    extra_momentum,
    torque,
    modeled_torque,
    wheels,
    margin,
    scratch,
    maxima,
):
    """Update the largest wheel momentum and torque so far with the wheel loads at one instant.

    `body_momentum` is the momentum of the satellite in body axes, and `modeled_torque` the modeled
    torque. `extra_momentum` and `torque` are the momentum and torque of the disturbances, of which
    the magnitude is added. `scratch`, shape (4, 3), is allocated by the caller, since an allocation
    would double the run time.
    """
    inertia, allocation, circulating = wheels
    spin, inertial_torque, gyroscopic, gyroscopic_extra = (
        scratch[0],
        scratch[1],
        scratch[2],
        scratch[3],
    )
    multiply_matrix(inertia, rate, spin)
    multiply_matrix(inertia, acceleration, inertial_torque)
    cross(rate, body_momentum, gyroscopic)
    cross(rate, extra_momentum, gyroscopic_extra)
    for row in range(len(allocation)):
        momentum, disturbance_momentum, wheel_torque, disturbance_torque = (
            circulating[row],
            0.0,
            0.0,
            0.0,
        )
        for a in range(3):
            share = allocation[row, a]
            momentum += share * (body_momentum[a] - spin[a])
            disturbance_momentum += share * extra_momentum[a]
            wheel_torque += share * (inertial_torque[a] + gyroscopic[a] - modeled_torque[a])
            disturbance_torque += share * (torque[a] - gyroscopic_extra[a])
        maxima[0] = max(maxima[0], abs(momentum) + margin * abs(disturbance_momentum))
        maxima[1] = max(maxima[1], abs(wheel_torque) + margin * abs(disturbance_torque))


@helper
def _compute_acceleration(before, mean, end, step, out):  # type: ignore[no-untyped-def]
    """Write the angular acceleration [rad/s²] in a filter step to `out`.

    The arguments are the body rates before the step, averaged over the step, and at its end. Return
    True if the rate changes gradually, in a ramp. After an instantaneous change, the acceleration
    is zero. The rate changes linearly from `before` to `end` in a fraction p of the step. The mean
    rate of the step therefore has 1 - p / 2 of the change.
    """
    out[0] = out[1] = out[2] = 0.0
    change, moved = 0.0, 0.0
    for a in range(3):
        change += (end[a] - before[a]) ** 2
        moved += (end[a] - before[a]) * (mean[a] - before[a])
    ramp = moved < change * (1.0 - _INSTANT_RAMP_FRACTION)
    if ramp:
        for a in range(3):
            out[a] = (end[a] - before[a]) * change / (2.0 * (change - moved) * step)
    return ramp
