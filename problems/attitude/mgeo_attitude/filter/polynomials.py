"""Compiled exact discretization of attitude and gyro bias by polynomials of the rate matrix.

With W = -[ω×], all matrices of equation (2) of docs/explanation/models-and-filter.md for attitude
and bias are polynomials of W. Because W³ = -|ω|² W, a polynomial has three coefficients (p, q, r),
which represent p I + q W + r W². The series of F and Q are sums of such triples. They take a ninth
of the time of `discretization.discretize`, which matters if the body rate changes in every step.
The process noise must be equal about all axes, since Q is otherwise not a polynomial of W.
"""

import math

from mgeo_attitude._compiled import helper

#: Largest |ω| dt [rad] for which the series is summed directly. A longer step is halved first.
MAX_SERIES_ANGLE = 0.5
#: Size of a term, relative to the first term, at which the series ends.
TERM_TOLERANCE = 1e-18


@helper
def discretize_isotropic(decay, densities, rate, duration, F, Q, J, W):
    """Compute the transition matrix and the process noise of attitude and gyro bias for one step.

    The results are written to the arrays F and Q. The array J receives the attitude change per unit
    of a constant rate error.

    Parameters
    ----------
    decay : float
        Decay rate of the bias [1/s].
    densities : tuple of two floats
        Noise densities of attitude and bias, equal about all axes.
    rate : array, shape (3,)
        Body rate [rad/s].
    duration : float
        Length of the step [s].
    F, Q : arrays, shapes (m, m) and (l, l), m and l >= 6, output
        Nonzero entries of the first six rows and columns.
    J : array, shape (3, 3), output
        Attitude change per unit of a constant rate error.
    W : array, shape (3, 3)
        Scratch space.
    """
    x, y, z = rate[0], rate[1], rate[2]
    W[0, 0], W[0, 1], W[0, 2] = 0.0, z, -y
    W[1, 0], W[1, 1], W[1, 2] = -z, 0.0, x
    W[2, 0], W[2, 1], W[2, 2] = y, -x, 0.0
    square = x * x + y * y + z * z
    step = compute_coefficients(square, decay, densities, duration)
    rotation, by_bias, by_constant, bias, Q_aa, Q_ab, Q_b = step
    for i in range(3):
        for j in range(3):
            unit = 1.0 if i == j else 0.0
            W2 = W[i, 0] * W[0, j] + W[i, 1] * W[1, j] + W[i, 2] * W[2, j]
            F[i, j] = evaluate_entry(rotation, unit, W[i, j], W2)
            F[i, 3 + j] = evaluate_entry(by_bias, unit, W[i, j], W2)
            J[i, j] = evaluate_entry(by_constant, unit, W[i, j], W2)
            Q[i, j] = evaluate_entry(Q_aa, unit, W[i, j], W2)
            Q[i, 3 + j] = Q[3 + j, i] = evaluate_entry(Q_ab, unit, W[i, j], W2)
        F[3 + i, 3 + i] = bias
        Q[3 + i, 3 + i] = Q_b


@helper
def compute_coefficients(square, decay, densities, duration):
    """Compute the transition matrix and the process noise of a step as polynomials of W.

    W is the rate matrix. A triple (p, q, r) represents p I + q W + r W².

    Parameters
    ----------
    square : float
        |ω|² [rad²/s²].
    decay, densities, duration
        See `discretize_isotropic`.

    Returns
    -------
    rotation, by_bias, by_constant : triples
        Attitude error per unit of attitude error, of bias, and of a constant rate error.
    bias : float
        Bias per unit of bias.
    Q_aa, Q_ab : triples
        Covariance of the attitude, and of attitude and bias.
    Q_b : float
        Variance of the bias.
    """
    h, halvings = duration, 0
    size = max(math.sqrt(square), decay)
    while size * h > MAX_SERIES_ANGLE:
        h, halvings = 0.5 * h, halvings + 1
    rotation = rotation_m = (1.0, 0.0, 0.0)
    by_bias = by_bias_m = by_constant = by_constant_m = Q_ab = Q_ab_m = (0.0, 0.0, 0.0)
    bias = bias_m = 1.0
    Q_aa = Q_aa_m = (densities[0] * h, 0.0, 0.0)
    Q_b = Q_b_m = densities[1] * h
    constant_m, m, bound = 1.0, 1, 1.0
    while bound > TERM_TOLERANCE:
        f, g = h / m, h / (m + 1)
        p = multiply_by_W(by_bias_m, square)
        by_bias_m = (f * (p[0] - bias_m), f * p[1], f * p[2])
        p = multiply_by_W(by_constant_m, square)
        by_constant_m = (f * (p[0] + constant_m), f * p[1], f * p[2])
        p = multiply_by_W(rotation_m, square)
        rotation_m = (f * p[0], f * p[1], f * p[2])
        bias_m, constant_m = -f * decay * bias_m, 0.0
        # The next term of Q is A Q + Q Aᵀ, and the transpose of (p, q, r) is (p, -q, r).
        p, q = multiply_by_W(Q_aa_m, square), multiply_by_W(Q_ab_m, square)
        Q_aa_m = (2.0 * g * (p[0] - Q_ab_m[0]), 0.0, 2.0 * g * (p[2] - Q_ab_m[2]))
        Q_ab_m = (
            g * (q[0] - decay * Q_ab_m[0] - Q_b_m),
            g * (q[1] - decay * Q_ab_m[1]),
            g * (q[2] - decay * Q_ab_m[2]),
        )
        Q_b_m *= -2.0 * g * decay
        rotation, by_bias, by_constant = (
            add_triples(rotation, rotation_m),
            add_triples(by_bias, by_bias_m),
            add_triples(by_constant, by_constant_m),
        )
        Q_aa, Q_ab = add_triples(Q_aa, Q_aa_m), add_triples(Q_ab, Q_ab_m)
        bias, Q_b = bias + bias_m, Q_b + Q_b_m
        if m > 2:  # The effect of bias noise on the attitude starts with the second term.
            bound *= 2.0 * size * h / m
        m += 1
    for _ in range(halvings):
        # Doubling the step gives Q + F Q Fᵀ and F F.
        a = add_triples(
            multiply_polynomials(rotation, Q_aa, square),
            multiply_polynomials(by_bias, transpose_triple(Q_ab), square),
        )
        b = add_triples(multiply_polynomials(rotation, Q_ab, square), scale_triple(by_bias, Q_b))
        a = add_triples(
            multiply_polynomials(a, transpose_triple(rotation), square),
            multiply_polynomials(b, transpose_triple(by_bias), square),
        )
        Q_aa, Q_ab = add_triples(Q_aa, a), add_triples(Q_ab, scale_triple(b, bias))
        Q_b += bias * bias * Q_b
        by_bias = add_triples(
            multiply_polynomials(rotation, by_bias, square), scale_triple(by_bias, bias)
        )
        by_constant = add_triples(multiply_polynomials(rotation, by_constant, square), by_constant)
        rotation, bias = multiply_polynomials(rotation, rotation, square), bias * bias
    return rotation, by_bias, by_constant, bias, Q_aa, Q_ab, Q_b


@helper
def evaluate_entry(a, unit, w, w2):
    """Return an entry of the matrix polynomial p I + q W + r W².

    The triple `a` contains the coefficients p, q and r; `unit`, `w` and `w2` are the same entry of
    I, W and W².
    """
    return a[0] * unit + a[1] * w + a[2] * w2


@helper
def multiply_by_W(a, square):
    """Multiply a polynomial of the rate matrix W, given as a coefficient triple, by W."""
    return 0.0, a[0] - square * a[2], a[1]


@helper
def multiply_polynomials(a, b, square):
    """Multiply two polynomials of the rate matrix W, given as coefficient triples."""
    once, twice = multiply_by_W(b, square), multiply_by_W(multiply_by_W(b, square), square)
    return (
        a[0] * b[0] + a[1] * once[0] + a[2] * twice[0],
        a[0] * b[1] + a[1] * once[1] + a[2] * twice[1],
        a[0] * b[2] + a[1] * once[2] + a[2] * twice[2],
    )


@helper
def add_triples(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@helper
def scale_triple(a, f):
    return f * a[0], f * a[1], f * a[2]


@helper
def transpose_triple(a):
    return a[0], -a[1], a[2]
