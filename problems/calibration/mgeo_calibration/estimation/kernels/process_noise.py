"""Process noise of many steps with different rates, for unequal noise about the axes."""

import numpy as np
from mgeo_attitude._compiled import compile_cached
from mgeo_attitude.filter.discretization import discretize


@compile_cached("void(float64, float64[::1], float64[:,::1], float64[::1], float64[:,:,::1])")
def compute_process_noise(decay, density, rates, durations, Q):
    """Write the process noise covariances of n steps to Q, for gyro noise that differs between
    axes.

    Equation (8) of docs/explanation/models-and-filter.md gives the covariance. Q is not a
    polynomial in the rate, unlike in `kinematics.discretize_steps`.

    Parameters
    ----------
    decay : float
        Inverse correlation time of the bias [1/s].
    density : array, shape (6,)
        Power spectral densities of the noise of attitude and bias about each axis.
    rates, durations : arrays, shapes (n, 3) and (n,)
        Body rates and durations of the steps.
    Q : array, shape (n, l, l), l >= 6
        Output: the first six rows and columns are written.
    """
    A = np.zeros((6, 6))
    for i in range(3):
        A[i, 3 + i], A[3 + i, 3 + i] = -1.0, -decay
    for n in range(len(rates)):
        x, y, z = rates[n, 0], rates[n, 1], rates[n, 2]
        A[0, 1], A[1, 0] = z, -z
        A[1, 2], A[2, 1] = x, -x
        A[2, 0], A[0, 2] = y, -y
        Q[n, :6, :6] = discretize(A, density, durations[n])[1]
