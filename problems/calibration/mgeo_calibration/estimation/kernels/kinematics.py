"""Products of rotations, and discretization of many steps with different rates."""

import numpy as np
from mgeo_attitude._compiled import compile_cached
from mgeo_attitude.filter.polynomials import discretize_isotropic


@compile_cached("void(float64[:,:,::1], float64[:,:,::1])")
def accumulate_rotations(step_rotations, R):
    """Write to R the rotation matrices from the body frame at each sample to the body frame at the
    first sample.

    R[0] is the identity, and R[k + 1] = R[k] step_rotations[k]ᵀ.

    Parameters
    ----------
    step_rotations : array, shape (n, 3, 3)
        Rotation matrix of each step.
    R : array, shape (n + 1, 3, 3)
        Output: rotation matrices from the body frame at each sample to that at the first sample.
    """
    for i in range(3):
        for j in range(3):
            R[0, i, j] = 1.0 if i == j else 0.0
    for k in range(len(step_rotations)):
        for i in range(3):
            a, b, c = R[k, i, 0], R[k, i, 1], R[k, i, 2]
            for j in range(3):
                R[k + 1, i, j] = (
                    a * step_rotations[k, j, 0]
                    + b * step_rotations[k, j, 1]
                    + c * step_rotations[k, j, 2]
                )


@compile_cached(
    "void(float64, UniTuple(float64, 2), float64[:,:,::1], float64[:,::1], float64[::1], "
    "float64[:,:,::1], float64[:,:,::1])"
)
def discretize_steps(decay, densities, rate_derivatives, rates, durations, F, Q):
    """Write the transition matrices and process noise covariances of n steps to F and Q.

    The result equals that of `filter.discretization.discretize` for each step; see equation (8) of
    docs/explanation/models-and-filter.md.

    Parameters
    ----------
    decay : float
        Inverse correlation time of the bias [1/s].
    densities : tuple of two floats
        Power spectral densities of the noise of attitude and bias, equal about all axes.
    rate_derivatives : array, shape (3, 3, k)
        Derivative of the attitude rate by the gyro's k constant errors, for each component of the
        rate.
    rates, durations : arrays, shapes (n, 3) and (n,)
        Body rates and durations of the steps.
    F, Q : arrays, shapes (n, m, m), m >= 6 + k, and (n, l, l), l >= 6
        Output, zero on input. Only the rows and columns of attitude and gyro are written.
    """
    k = rate_derivatives.shape[2]
    W, J = np.empty((3, 3)), np.empty((3, 3))
    for n in range(len(rates)):
        discretize_isotropic(decay, densities, rates[n], durations[n], F[n], Q[n], J, W)
        x, y, z = rates[n, 0], rates[n, 1], rates[n, 2]
        for m in range(k):
            for i in range(3):
                F[n, i, 6 + m] = 0.0
            for j in range(3):
                f = (
                    x * rate_derivatives[0, j, m]
                    + y * rate_derivatives[1, j, m]
                    + z * rate_derivatives[2, j, m]
                )
                for i in range(3):
                    F[n, i, 6 + m] += J[i, j] * f
            F[n, 6 + m, 6 + m] = 1.0
