"""Rigid-body motion under a dipole that is constant in a step, compiled; used by
`MagnetorquerDrive`.

With q from body axes to the body axes at the start of a step and b the field in body axes,

    dq/dt = q (0, ω) / 2,   db/dt = b × ω,   J dω/dt = m × b - ω × J ω

are quadratic, so that the Taylor coefficients of all three follow from each other by Cauchy
products. The step is exact to rounding, whatever its length, without an error tolerance.
"""

from __future__ import annotations

import math

import numpy as np

from mgeo_attitude._compiled import compile_on_first_call, helper

#: Number of terms of the Taylor series, and rotation angle [rad] up to which they suffice.
_TERMS, _ANGLE = 20, 0.25
#: Size of a term, relative to the largest term, below which the series ends.
_NEGLIGIBLE = 1e-17


@compile_on_first_call(
    "void(Tuple((float64[:,::1], float64[:,::1], float64[:,::1], float64[::1])),"
    "Tuple((float64[::1], float64[::1], float64, float64)), float64[:,::1],"
    "Tuple((float64[:,:,::1], int64[:,::1])), float64,"
    "float64[:,:,::1], float64[:,:,::1], boolean[:,::1])"
)
def compute_driven_rates(body, law, field, plan, step, mean, end, free):  # type: ignore[no-untyped-def]
    """Simulate the rotation of a satellite under magnetorquer control for each design.

    In each step, the mean body rate, the final body rate, and whether the magnetorquers are off are
    written to the arrays `mean`, `end` and `free`. `MagnetorquerDrive.compute_rates` describes
    these arrays.
    """
    inertia, inverse, initial_attitude, initial_rate = body
    largest, residual, near, response = law
    rates, starts = plan
    n_maneuvers = starts.shape[1]
    C, old, rotation = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    rate, b, dipole, torque = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    middle, q = np.empty(3), np.empty(4)
    scratch = np.empty((4, _TERMS + 1, 4))
    for i in range(len(rates)):
        assign_matrix(initial_attitude, C)
        assign(initial_rate, rate)
        m, off = -1, True
        for k in range(mean.shape[1]):
            before = m
            while m + 1 < n_maneuvers and starts[i, m + 1] <= k:
                m += 1
            off = off and m == before
            if not off:
                off = _distance(rate, rates[i, m]) <= near
            free[i, k] = off
            for a in range(3):
                middle[a] = 0.5 * (field[k, a] + field[k + 1, a])
            multiply_matrix(C, middle, b)
            for a in range(3):
                dipole[a] = 0.0
            if not off:
                for a in range(3):
                    middle[a] = (rates[i, m, a] - rate[a]) / response
                multiply_matrix(inertia, middle, torque)
                multiply_matrix(inertia, rate, middle)
                cross(rate, middle, middle)
                for a in range(3):
                    torque[a] += middle[a]
                limit_dipole(b, torque, largest, dipole)
            for a in range(3):
                dipole[a] += residual[a]
            _propagate(rate, b, dipole, inertia, inverse, step, q, scratch)
            assign(rate, end[i, k])
            _rotation_vector(q, middle)
            for a in range(3):
                mean[i, k, a] = middle[a] / step
            _to_body(q, rotation)
            assign_matrix(C, old)
            for r in range(3):
                for c in range(3):
                    C[r, c] = (
                        rotation[r, 0] * old[0, c]
                        + rotation[r, 1] * old[1, c]
                        + rotation[r, 2] * old[2, c]
                    )


@helper
def limit_dipole(b, torque, largest, dipole):  # type: ignore[no-untyped-def]
    """Compute the limited dipole for a control torque, and write it to `dipole`.

    The dipole is scaled down if a component exceeds its maximum. This is the cross-product law b ×
    τ / |b|² with the torque τ.
    """
    cross(b, torque, dipole)
    square = b[0] * b[0] + b[1] * b[1] + b[2] * b[2]
    most = 1.0
    for a in range(3):
        dipole[a] = dipole[a] / square if square > 0.0 else 0.0
        most = max(most, abs(dipole[a]) / largest[a])
    for a in range(3):
        dipole[a] /= most


@helper
def _propagate(rate, b, dipole, inertia, inverse, step, q, scratch):  # type: ignore[no-untyped-def]
    """Integrate the rotation of the satellite over one filter step.

    The body rate and the field in body axes are updated in place. The rotation is written to the
    quaternion `q`.
    """
    w, f, s, momentum = scratch[0], scratch[1], scratch[2], scratch[3]
    speed, push = 0.0, 0.0
    for a in range(3):
        speed += rate[a] * rate[a]
        push += (dipole[a] / inertia[a, a]) ** 2
    push = math.sqrt(push * (b[0] * b[0] + b[1] * b[1] + b[2] * b[2]))
    fastest = math.sqrt(speed) + push * step
    parts = max(1, math.ceil(fastest * step / _ANGLE))
    h = step / parts
    q[0], q[1], q[2], q[3] = 1.0, 0.0, 0.0, 0.0
    net_torque, spin = np.empty(3), np.empty(3)
    for _ in range(parts):
        for a in range(3):
            w[0, a], f[0, a] = rate[a], b[a]
        assign(q, s[0])
        scale = max(fastest, 1e-300)
        size = 1.0
        for n in range(_TERMS):
            multiply_matrix(inertia, w[n], momentum[n])
            cross(dipole, f[n], net_torque)
            for a in range(3):
                f[n + 1, a] = 0.0
            for a in range(4):
                s[n + 1, a] = 0.0
            for j in range(n + 1):
                x, y = w[j], momentum[n - j]
                net_torque[0] -= x[1] * y[2] - x[2] * y[1]
                net_torque[1] -= x[2] * y[0] - x[0] * y[2]
                net_torque[2] -= x[0] * y[1] - x[1] * y[0]
                v, y = f[n - j], f[n + 1]
                y[0] += v[1] * x[2] - v[2] * x[1]
                y[1] += v[2] * x[0] - v[0] * x[2]
                y[2] += v[0] * x[1] - v[1] * x[0]
                p, y = s[n - j], s[n + 1]
                y[0] -= p[1] * x[0] + p[2] * x[1] + p[3] * x[2]
                y[1] += p[0] * x[0] + p[2] * x[2] - p[3] * x[1]
                y[2] += p[0] * x[1] + p[3] * x[0] - p[1] * x[2]
                y[3] += p[0] * x[2] + p[1] * x[1] - p[2] * x[0]
            multiply_matrix(inverse, net_torque, spin)
            size *= h
            most, quaternion_term = 0.0, 0.0
            for a in range(3):
                w[n + 1, a] = spin[a] / (n + 1)
                f[n + 1, a] /= n + 1
                rate[a] += size * w[n + 1, a]
                b[a] += size * f[n + 1, a]
                most = max(most, abs(w[n + 1, a]))
            for a in range(4):
                s[n + 1, a] *= 0.5 / (n + 1)
                q[a] += size * s[n + 1, a]
                quaternion_term = max(quaternion_term, abs(s[n + 1, a]))
            if size * most <= _NEGLIGIBLE * scale and size * quaternion_term <= _NEGLIGIBLE:
                break
    length = math.sqrt(q[0] ** 2 + q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    for a in range(4):
        q[a] /= length


@helper
def _rotation_vector(q, out):  # type: ignore[no-untyped-def]
    """Write the rotation vector of a unit quaternion, scalar first, to `out`."""
    sine = math.sqrt(q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    factor = 2.0 * math.atan2(sine, q[0]) / sine if sine > 0.0 else 2.0
    for a in range(3):
        out[a] = factor * q[1 + a]


@helper
def _to_body(q, out):  # type: ignore[no-untyped-def]
    """Write the rotation matrix of the quaternion `q` to `out`.

    The matrix converts vectors from body axes at the start of a step to body axes at its end.
    """
    w, x, y, z = q[0], q[1], q[2], q[3]
    out[0, 0], out[1, 1] = 1.0 - 2.0 * (y * y + z * z), 1.0 - 2.0 * (x * x + z * z)
    out[2, 2] = 1.0 - 2.0 * (x * x + y * y)
    out[0, 1], out[1, 0] = 2.0 * (x * y + w * z), 2.0 * (x * y - w * z)
    out[0, 2], out[2, 0] = 2.0 * (x * z - w * y), 2.0 * (x * z + w * y)
    out[1, 2], out[2, 1] = 2.0 * (y * z + w * x), 2.0 * (y * z - w * x)


@helper
def _distance(a, b):  # type: ignore[no-untyped-def]
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@helper
def multiply_matrix(A, x, out):  # type: ignore[no-untyped-def]
    for i in range(3):
        out[i] = A[i, 0] * x[0] + A[i, 1] * x[1] + A[i, 2] * x[2]


@helper
def cross(a, b, out):  # type: ignore[no-untyped-def]
    x, y, z = b[0], b[1], b[2]
    out[0], out[1], out[2] = a[1] * z - a[2] * y, a[2] * x - a[0] * z, a[0] * y - a[1] * x


@helper
def assign(x, out):  # type: ignore[no-untyped-def]
    """Copy the elements of an array x to the array `out`.

    The loop replaces ``out[:] = x``, which numba takes seconds to compile for shapes that might
    differ.
    """
    for i in range(len(out)):
        out[i] = x[i]


@helper
def assign_matrix(A, out):  # type: ignore[no-untyped-def]
    for i in range(len(out)):
        assign(A[i], out[i])
