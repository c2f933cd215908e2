"""Exact discretization of attitude and bias as polynomials in the rate, compiled.

With W = -[ω×] all that equation (2) makes of attitude and bias are polynomials in W, and because of
W³ = -|ω|² W of three coefficients: (p, q, r) stands for p I + q W + r W². So the series are sums of
such triples: a ninth of the time of `discretization.discretize`, for steps each at a rate of its
own. The noise is alike about all axes, or else it is no polynomial.
"""

import math

from mgeo_attitude._compiled import helper

#: |ω| dt up to which the series converges fast; beyond, the step is halved first.
SERIES = 0.5
#: Terms smaller than this, relative to the first, are left out.
NEGLIGIBLE = 1e-18


@helper
def discretize_alike(decay, densities, rate, duration, F, Q, J, W):
    """F and Q of a step, equation (7), of attitude and bias.

    Parameters
    ----------
    decay : float
        Of the bias [1/s].
    densities : tuple of two floats
        Of the noise that drives attitude and bias, about each axis.
    rate : array, shape (3,)
        [rad/s]
    duration : float
        [s]
    F, Q : arrays, shapes (m, m) and (l, l), m and l >= 6
        Their first six rows and columns are written where they are not zero.
    J : array, shape (3, 3), written
        What a constant that adds to the rate turns the attitude by.
    W : array, shape (3, 3)
        Room for -[ω×].
    """
    x, y, z = rate[0], rate[1], rate[2]
    W[0, 0], W[0, 1], W[0, 2] = 0.0, z, -y
    W[1, 0], W[1, 1], W[1, 2] = -z, 0.0, x
    W[2, 0], W[2, 1], W[2, 2] = y, -x, 0.0
    square = x * x + y * y + z * z
    step = coefficients(square, decay, densities, duration)
    turn, by_bias, by_constant, bias, Q_aa, Q_ab, Q_b = step
    for i in range(3):
        for j in range(3):
            unit = 1.0 if i == j else 0.0
            W2 = W[i, 0] * W[0, j] + W[i, 1] * W[1, j] + W[i, 2] * W[2, j]
            F[i, j] = matrix(turn, unit, W[i, j], W2)
            F[i, 3 + j] = matrix(by_bias, unit, W[i, j], W2)
            J[i, j] = matrix(by_constant, unit, W[i, j], W2)
            Q[i, j] = matrix(Q_aa, unit, W[i, j], W2)
            Q[i, 3 + j] = Q[3 + j, i] = matrix(Q_ab, unit, W[i, j], W2)
        F[3 + i, 3 + i] = bias
        Q[3 + i, 3 + i] = Q_b


@helper
def coefficients(square, decay, densities, duration):
    """Of F and Q of a step, for |ω|².

    Attitude by attitude, by bias and by what else changes its rate; bias by bias; covariances of
    attitude, of attitude and bias, and of bias.
    """
    h, halvings = duration, 0
    size = max(math.sqrt(square), decay)
    while size * h > SERIES:
        h, halvings = 0.5 * h, halvings + 1
    turn = turn_m = (1.0, 0.0, 0.0)
    by_bias = by_bias_m = by_constant = by_constant_m = Q_ab = Q_ab_m = (0.0, 0.0, 0.0)
    bias = bias_m = 1.0
    Q_aa = Q_aa_m = (densities[0] * h, 0.0, 0.0)
    Q_b = Q_b_m = densities[1] * h
    rest, m, bound = 1.0, 1, 1.0
    while bound > NEGLIGIBLE:
        f, g = h / m, h / (m + 1)
        p = times_W(by_bias_m, square)
        by_bias_m = (f * (p[0] - bias_m), f * p[1], f * p[2])
        p = times_W(by_constant_m, square)
        by_constant_m = (f * (p[0] + rest), f * p[1], f * p[2])
        p = times_W(turn_m, square)
        turn_m = (f * p[0], f * p[1], f * p[2])
        bias_m, rest = -f * decay * bias_m, 0.0
        # A Q + Q Aᵀ; the transposed of (p, q, r) is (p, -q, r)
        p, q = times_W(Q_aa_m, square), times_W(Q_ab_m, square)
        Q_aa_m = (2.0 * g * (p[0] - Q_ab_m[0]), 0.0, 2.0 * g * (p[2] - Q_ab_m[2]))
        Q_ab_m = (
            g * (q[0] - decay * Q_ab_m[0] - Q_b_m),
            g * (q[1] - decay * Q_ab_m[1]),
            g * (q[2] - decay * Q_ab_m[2]),
        )
        Q_b_m *= -2.0 * g * decay
        turn, by_bias, by_constant = (
            sum3(turn, turn_m),
            sum3(by_bias, by_bias_m),
            sum3(by_constant, by_constant_m),
        )
        Q_aa, Q_ab = sum3(Q_aa, Q_aa_m), sum3(Q_ab, Q_ab_m)
        bias, Q_b = bias + bias_m, Q_b + Q_b_m
        if m > 2:  # how the bias's noise reaches the attitude begins with the second term
            bound *= 2.0 * size * h / m
        m += 1
    for _ in range(halvings):
        # Q + F Q Fᵀ and F F
        a = sum3(product(turn, Q_aa, square), product(by_bias, transposed(Q_ab), square))
        b = sum3(product(turn, Q_ab, square), scaled(by_bias, Q_b))
        a = sum3(product(a, transposed(turn), square), product(b, transposed(by_bias), square))
        Q_aa, Q_ab = sum3(Q_aa, a), sum3(Q_ab, scaled(b, bias))
        Q_b += bias * bias * Q_b
        by_bias = sum3(product(turn, by_bias, square), scaled(by_bias, bias))
        by_constant = sum3(product(turn, by_constant, square), by_constant)
        turn, bias = product(turn, turn, square), bias * bias
    return turn, by_bias, by_constant, bias, Q_aa, Q_ab, Q_b


@helper
def matrix(a, unit, w, w2):
    """An entry of the matrix that a triple stands for."""
    return a[0] * unit + a[1] * w + a[2] * w2


@helper
def times_W(a, square):
    """W a."""
    return 0.0, a[0] - square * a[2], a[1]


@helper
def product(a, b, square):
    """a b."""
    once, twice = times_W(b, square), times_W(times_W(b, square), square)
    return (
        a[0] * b[0] + a[1] * once[0] + a[2] * twice[0],
        a[0] * b[1] + a[1] * once[1] + a[2] * twice[1],
        a[0] * b[2] + a[1] * once[2] + a[2] * twice[2],
    )


@helper
def sum3(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@helper
def scaled(a, f):
    return f * a[0], f * a[1], f * a[2]


@helper
def transposed(a):
    return a[0], -a[1], a[2]
