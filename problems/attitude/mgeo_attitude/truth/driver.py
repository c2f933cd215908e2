"""One run of truth and estimator: the text of this module ends every generated module."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit

from ..filter.discretization import turn
from .algebra import cholesky, copy, forward, multiply, predict, transform, turn_back

if TYPE_CHECKING:  # above this text in the generated module, see codegen.py
    from .correction import CACHE, N_STATES, error_of, update, workspace

    N_DYNAMIC: int
    N_SENSORS: int
    N_READINGS: int

    def measured(sensor: int, v: Any, C: Any, x: Any, y: Any) -> None:
        """Readings y of a sensor."""

    def gyro_measured(rate: Any, x: Any, out: Any) -> None:
        """Rate that the gyro reports."""

    def gyro_corrected(rate: Any, x: Any, out: Any) -> None:
        """Body rate from the reported one."""


BIAS = 3  # the gyro's bias is its first state


@njit(error_model="numpy", cache=CACHE)
def count_inside(cones, sun, count):
    """Add one to the count of each cone that a direction, body axes, is inside of."""
    for i in range(len(cones)):
        count[i] += cones[i, 0] * sun[0] + cones[i, 1] * sun[1] + cones[i, 2] * sun[2] > cones[i, 3]


@njit(
    "void(float64[:,::1], int64[::1], float64[:,:,::1], float64[:,:,::1], float64[:,:,::1],"
    "float64[:,:,::1], float64[:,:,::1], boolean[:,::1], float64[:,::1], float64[:,::1], float64,"
    "float64[:,::1], float64[:,::1], float64[::1], float64[::1], float64[:,::1], float64[:,:,::1],"
    "int64[::1], int64[::1], float64[:,::1], float64[:,::1], float64[::1], float64[:,::1],"
    "int64[:,::1], float64[:,::1], float64[:,::1], int64, int64[:,::1])",
    error_model="numpy",
    nogil=True,
    cache=CACHE,
)
def run(
    rates,
    maneuver,
    F,
    Q,
    plan,
    references,
    true_references,
    available,
    view,
    R,
    dt,
    F_rest,
    true_F_rest,
    sigma,
    true_errors,
    gyro_noise,
    noise,
    options,
    records,
    errors,
    variances,
    nees,
    nis,
    updates,
    sun,
    cones,
    n_watched,
    inside,
):
    """Fly one plan once: truth, measurements and the estimate from them.

    What the truth is like and what the estimator believes may differ.

    Parameters
    ----------
    rates : array, shape (n_maneuvers, 3)
        Body rates [rad/s].
    maneuver : array, shape (n_steps,)
        Which one is flown in each step.
    F, Q : arrays, shape (n_maneuvers, n_dynamic, n_dynamic)
        Transition and process noise of the dynamic states at the planned rates, as believed.
    plan : array, shape (n_steps + 1, 3, 3)
        Planned attitude, GCRS to body.
    references, true_references : arrays, shape (n_steps + 1, n_sensors, 3)
        What the sensors look at, as believed and in truth; see `FilterModel`.
    available : array, shape (n_steps + 1, n_sensors)
        Whether they can, in truth.
    view : array, shape (n_sensors, 4)
        Boresight and cosine of the true field of view.
    R : array, shape (n_sensors, 3)
        Noise variances, as believed.
    dt : float
        Step [s].
    F_rest, true_F_rest : arrays, shape (n_dynamic, n_dynamic)
        Transition at rest, as believed and in truth: how the gyro's states go on, and what they
        turn the attitude by.
    sigma : array, shape (n_states,)
        Initial 1-sigma that the estimator believes.
    true_errors : array, shape (n_states,)
        Attitude error and the true state of gyro and sensors at the start.
    gyro_noise : array, shape (n_steps, n_dynamic)
        Process noise of each step, at rest.
    noise : array, shape (n_steps + 1, n_sensors, 3)
        Measurement noise.
    options : array of int
        See `estimator.Estimator`.
    records : array, shape (n_records,)
        Steps at which to record, increasing.
    errors, variances : arrays, shape (n_records, n_states), written
        Errors of the estimate and the variances it claims.
    nees : array, shape (n_records,), written
        Their normalized square.
    nis, updates : arrays, shape (n_records, n_sensors), written
        Sum of the normalized squares of the innovations since the record before, and their number.
    sun : array, shape (n_steps + 1, 3)
        Direction to the Sun where it shines, else zero, GCRS.
    cones : array, shape (n_cones, 4)
        Axis of each keep-out cone, body axes, and cosine of its half-angle.
    n_watched : int
        Samples, from the start, at which to look at them.
    inside : array, shape (2, n_cones), written
        Number of these at which the Sun was inside: with the satellite steered by the estimate,
        and as it flies here, open loop.
    """
    n = N_STATES
    true_x, x, mean, e, w = true_errors.copy(), np.zeros(n), np.zeros(n), np.empty(n), np.empty(n)
    start, true_C, C, M = np.eye(3), np.eye(3), np.eye(3), np.empty((3, 3))
    turn_back(start, true_errors, 0, M)
    P, L, FP, Fk = np.zeros((n, n)), np.empty((n, n)), np.empty((N_DYNAMIC, n)), F[0].copy()
    for i in range(n):
        P[i, i] = sigma[i] ** 2
    y, body, reported, rate = np.empty(N_READINGS), np.empty(3), np.empty(3), np.empty(3)
    work = workspace()
    record = 0
    for k in range(len(maneuver) + 1):
        multiply(plan[k], start, true_C)
        if k > 0:
            m = maneuver[k - 1]
            drive = gyro_noise[k - 1]
            # the gyro reports the mean over the step, noise and drift of the bias included
            for i in range(3, N_DYNAMIC):
                mean[i] = true_x[i]
                true_x[i] = true_F_rest[i, i] * true_x[i] + drive[i]
            for i in range(3):
                mean[BIAS + i] = -(true_F_rest[i, BIAS + i] * mean[BIAS + i] + drive[i]) / dt
            gyro_measured(rates[m], mean, reported)

            for i in range(3, N_DYNAMIC):
                mean[i] = x[i]
                x[i] *= F_rest[i, i]
            for i in range(3):
                mean[BIAS + i] *= -F_rest[i, BIAS + i] / dt
            gyro_corrected(reported, mean, rate)
            step = turn(rate, dt)
            multiply(step, C, M)
            copy(M, C)
            copy(F[m], Fk)
            for i in range(3):
                for j in range(3):
                    Fk[i, j] = step[i, j]
            predict(P, Fk, Q[m], FP)

        if k < n_watched:
            # a controller on the estimate would have made C the plan's, and true_C what C lacks
            transform(plan[k], sun[k], body)
            transform(C.T, body, reported)
            transform(true_C, reported, body)
            count_inside(cones, body, inside[0])
            transform(true_C, sun[k], body)
            count_inside(cones, body, inside[1])

        if k > 0:
            for sensor in range(N_SENSORS):
                transform(true_C, true_references[k, sensor], body)
                cosine = 0.0
                for i in range(3):
                    cosine += view[sensor, i] * body[i]
                if available[k, sensor] and cosine >= view[sensor, 3]:
                    measured(sensor, body, true_C, true_x, y)
                    nis[record, sensor] += update(
                        C,
                        x,
                        P,
                        sensor,
                        y,
                        noise[k, sensor],
                        references[k, sensor],
                        R[sensor],
                        options,
                        work,
                    )
                    updates[record, sensor] += 1
        if k == records[record]:
            error_of(C, x, true_C, true_x, e)
            cholesky(P, L)
            forward(L, e, w)
            for i in range(n):
                errors[record, i] = e[i]
                variances[record, i] = P[i, i]
                nees[record] += w[i] * w[i]
            record += 1
            if record == len(records):
                return
