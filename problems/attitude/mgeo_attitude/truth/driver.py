"""One run of truth and estimator: the text of this module ends every generated module."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit

from ..filter.discretization import turn

if TYPE_CHECKING:  # defined above this text in the generated module, see codegen.py
    CACHE: bool
    N_STATES: int
    N_DYNAMIC: int
    N_SENSORS: int
    N_READINGS: int
    ROTATIONS: np.ndarray
    N_LOCAL: np.ndarray
    LOCAL: np.ndarray
    N_CURVED: np.ndarray
    CURVED: np.ndarray

    def measured(sensor: int, v: Any, C: Any, x: Any, y: Any) -> None:
        """Readings y of a sensor."""

    def innovation(sensor: int, y: Any, v: Any, C: Any, x: Any, r: Any, H: Any, B: Any) -> None:
        """Innovation r with its derivatives."""

    def gyro_measured(rate: Any, x: Any, out: Any) -> None:
        """Rate that the gyro reports."""

    def gyro_corrected(rate: Any, x: Any, out: Any) -> None:
        """Body rate from the reported one."""


BIAS = 3  # the gyro's bias is its first state


@njit(error_model="numpy", cache=CACHE)
def rotation_matrix(g):
    """R(g), see `rotation.rotate`."""
    k = 1.0 / (1.0 + 0.25 * (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]))
    K = cross_matrix(g)
    return np.eye(3) + k * (K + 0.5 * product(K, K))


@njit(error_model="numpy", cache=CACHE)
def cross_matrix(g):
    return np.array([[0.0, -g[2], g[1]], [g[2], 0.0, -g[0]], [-g[1], g[0], 0.0]])


@njit(error_model="numpy", cache=CACHE)
def product(A, B):
    """A B. At this size plain loops beat a BLAS call, and never change in order."""
    out = np.zeros((A.shape[0], B.shape[1]))
    for i in range(A.shape[0]):
        for k in range(A.shape[1]):
            for j in range(B.shape[1]):
                out[i, j] += A[i, k] * B[k, j]
    return out


@njit(error_model="numpy", cache=CACHE)
def compose(a, b):
    """The vector of R(a) R(b)."""
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    out = np.empty(3)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = (a[i] + b[i] + 0.5 * (a[j] * b[k] - a[k] * b[j])) / (1.0 - 0.25 * dot)
    return out


@njit(error_model="numpy", cache=CACHE)
def between(C, estimate):
    """The vector θ of C = R(-θ) Ĉ."""
    D = product(estimate, C.T.copy())
    k = 2.0 / (1.0 + D[0, 0] + D[1, 1] + D[2, 2])
    return np.array(
        [k * (D[2, 1] - D[1, 2]), k * (D[0, 2] - D[2, 0]), k * (D[1, 0] - D[0, 1])]
    )


@njit(error_model="numpy", cache=CACHE)
def correct(C, x, e):
    """Take an error e out of an estimate, in place: attitude C and states x."""
    C[:] = product(rotation_matrix(-e[:3]), C)
    for i in range(3, N_STATES):
        if not is_rotation(i):
            x[i] += e[i]
    for first in ROTATIONS:
        x[first : first + 3] = compose(x[first : first + 3], e[first : first + 3])


@njit(error_model="numpy", cache=CACHE)
def is_rotation(i):
    for first in ROTATIONS:
        if first <= i < first + 3:
            return True
    return False


@njit(error_model="numpy", cache=CACHE)
def error_of(C, x, true_C, true_x):
    """The error e that `correct` would have to take out."""
    e = true_x - x
    e[:3] = between(true_C, C)
    for first in ROTATIONS:
        e[first : first + 3] = compose(-x[first : first + 3], true_x[first : first + 3])
    return e


@njit(error_model="numpy", cache=CACHE)
def turn_errors(P, first, e):
    """P for the errors of a rotation that remain once e is taken out.

    What remains of an error g is the vector of R(-e) R(g), whose derivative at g = e is J.
    """
    J = (np.eye(3) - 0.5 * cross_matrix(e)) / (1.0 + 0.25 * (e[0] ** 2 + e[1] ** 2 + e[2] ** 2))
    rows = product(J, P[first : first + 3])
    P[first : first + 3] = rows
    P[:, first : first + 3] = rows.T
    P[first : first + 3, first : first + 3] = product(rows[:, first : first + 3], J.T.copy())


@njit(error_model="numpy", cache=CACHE)
def predict(P, F, Q):
    """P ← F P Fᵀ + Q, equation (3); F and Q of the dynamic states."""
    FP = product(F, P[:N_DYNAMIC])
    P[:N_DYNAMIC] = FP
    P[:, :N_DYNAMIC] = FP.T
    P[:N_DYNAMIC, :N_DYNAMIC] = product(FP[:, :N_DYNAMIC].copy(), F.T.copy()) + Q


@njit(error_model="numpy", cache=CACHE)
def curvature(P, sensor, B, shift, S):
    """Add what the innovation's second derivatives B cause to its mean and covariance S.

    For e ~ N(0, P) the term ½ eᵀ B e has the mean ½ tr(B P) and covariance ½ tr(B P B' P).
    """
    n = N_CURVED[sensor]
    T, BT = np.empty((n, n)), np.empty((3, n, n))
    for a in range(n):
        for b in range(n):
            i, j = CURVED[sensor, a], CURVED[sensor, b]
            T[a, b] = P[LOCAL[sensor, i], LOCAL[sensor, j]]
    for q in range(3):
        BT[q] = product(B[q, :n, :n], T)
        for a in range(n):
            shift[q] += 0.5 * BT[q, a, a]
    for q in range(3):
        for r in range(3):
            for a in range(n):
                for b in range(n):
                    S[q, r] += 0.5 * BT[q, a, b] * BT[r, b, a]


@njit(error_model="numpy", cache=CACHE)
def update(C, x, P, sensor, y, noise, v, R, options, r, H, B):
    """Update an estimate with a sensor's readings y and feed the error back; returns the NIS.

    Parameters
    ----------
    C, x, P : estimate, in place
    noise : array, shape (3,)
        Measurement noise, in the innovation.
    v : array, shape (3,)
        Reference vector, GCRS.
    R : array, shape (3,)
        Variances of the noise.
    options : array of int
        See `estimator.Estimator`.
    r, H, B : work space
    """
    aligned, second_order, reset, iterations = options
    n = N_LOCAL[sensor]
    e, nis = np.zeros(N_STATES), 0.0
    C_now, x_now = C.copy(), x.copy()
    for iteration in range(iterations):
        if iteration > 0:
            C_now[:] = C
            x_now[:] = x
            correct(C_now, x_now, e)
        body = C_now[:, 0] * v[0] + C_now[:, 1] * v[1] + C_now[:, 2] * v[2]
        if aligned:
            x_aligned = x_now.copy()
            for first in ROTATIONS:
                x_aligned[first : first + 3] = 0.0
            innovation(sensor, y, body, C_now.ravel(), x_now, r, H, B)
            z = r + noise
            innovation(sensor, y, body, C_now.ravel(), x_aligned, r, H, B)
        else:
            innovation(sensor, y, body, C_now.ravel(), x_now, r, H, B)
            z = r + noise
        PHt, S = np.zeros((N_STATES, 3)), np.diag(R)
        for i in range(N_STATES):
            for q in range(3):
                for c in range(n):
                    PHt[i, q] += P[i, LOCAL[sensor, c]] * H[q, c]
        for q in range(3):
            for c in range(n):
                z[q] += H[q, c] * e[LOCAL[sensor, c]]
                for p in range(3):
                    S[q, p] += H[q, c] * PHt[LOCAL[sensor, c], p]
        if second_order:
            curvature(P, sensor, B, z, S)
        L = cholesky(S)
        w = forward(L, z)
        if iteration == 0:
            nis = w[0] ** 2 + w[1] ** 2 + w[2] ** 2
        G = np.empty((N_STATES, 3))
        for i in range(N_STATES):
            G[i] = forward(L, PHt[i])
            e[i] = G[i, 0] * w[0] + G[i, 1] * w[1] + G[i, 2] * w[2]
    for i in range(N_STATES):
        for j in range(i + 1):
            P[i, j] -= G[i, 0] * G[j, 0] + G[i, 1] * G[j, 1] + G[i, 2] * G[j, 2]
            P[j, i] = P[i, j]
    correct(C, x, e)
    if reset:
        turn_errors(P, 0, e[:3])
        for first in ROTATIONS:
            turn_errors(P, first, e[first : first + 3])
    return nis


@njit(error_model="numpy", cache=CACHE)
def cholesky(A):
    """Lower L of A = L Lᵀ; not positive definite gives NaN."""
    n = A.shape[0]
    L = np.zeros((n, n))
    for j in range(n):
        for i in range(j, n):
            value = A[i, j]
            for k in range(j):
                value -= L[i, k] * L[j, k]
            L[i, j] = np.sqrt(value) if i == j else value / L[j, j]
    return L


@njit(error_model="numpy", cache=CACHE)
def forward(L, b):
    """Solve L w = b."""
    w = np.empty(len(b))
    for i in range(len(b)):
        value = b[i]
        for k in range(i):
            value -= L[i, k] * w[k]
        w[i] = value / L[i, i]
    return w


@njit(
    "void(float64[:,::1], int64[::1], float64[:,:,::1], float64[:,:,::1], float64[:,:,::1],"
    "float64[:,:,::1], boolean[:,::1], float64[:,::1], float64[:,::1], float64, float64[:,::1],"
    "float64[::1], float64[::1], float64[:,::1], float64[:,:,::1], int64[::1], int64[::1],"
    "float64[:,::1], float64[:,::1], float64[::1], float64[:,::1], int64[:,::1])",
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
    available,
    view,
    R,
    dt,
    F_rest,
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
):
    """Fly one plan once: truth, measurements and the estimate from them.

    Parameters
    ----------
    rates : array, shape (n_maneuvers, 3)
        Body rates [rad/s].
    maneuver : array, shape (n_steps,)
        Which one is flown in each step.
    F, Q : arrays, shape (n_maneuvers, n_dynamic, n_dynamic)
        Transition and process noise of the dynamic states at the planned rates.
    plan : array, shape (n_steps + 1, 3, 3)
        Planned attitude, GCRS to body.
    references, available : arrays, shapes (n_steps + 1, n_sensors, 3) and (n_steps + 1, n_sensors)
        See `FilterModel`.
    view : array, shape (n_sensors, 4)
        Boresight and cosine of the field of view.
    R : array, shape (n_sensors, 3)
        Noise variances.
    dt : float
        Step [s].
    F_rest : array, shape (n_dynamic, n_dynamic)
        Transition at rest: how the gyro's states go on, and what they turn the attitude by.
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
    """
    true_x, x = true_errors.copy(), np.zeros(N_STATES)
    start = rotation_matrix(-true_errors[:3])
    C, P = np.eye(3), np.diag(sigma * sigma)
    r, y = np.empty(3), np.empty(N_READINGS)
    H = np.zeros((3, LOCAL.shape[1]))
    B = np.zeros((3, CURVED.shape[1], CURVED.shape[1]))
    reported, rate = np.empty(3), np.empty(3)
    record = 0
    for k in range(len(maneuver) + 1):
        if k > 0:
            m = maneuver[k - 1]
            # the gyro reports the mean over the step, noise and drift of the bias included
            mean = true_x.copy()
            drive = gyro_noise[k - 1]
            for i in range(3):
                mean[BIAS + i] = -(F_rest[i, BIAS + i] * true_x[BIAS + i] + drive[i]) / dt
            gyro_measured(rates[m], mean, reported)
            for i in range(3, N_DYNAMIC):
                true_x[i] = F_rest[i, i] * true_x[i] + drive[i]

            mean = x.copy()
            for i in range(3):
                mean[BIAS + i] = -F_rest[i, BIAS + i] * x[BIAS + i] / dt
            gyro_corrected(reported, mean, rate)
            step = turn(rate, dt)
            C = product(step, C)
            for i in range(3, N_DYNAMIC):
                x[i] *= F_rest[i, i]
            Fk = F[m].copy()
            Fk[:3, :3] = step
            predict(P, Fk, Q[m])

            true_C = product(plan[k], start)
            for sensor in range(N_SENSORS):
                v = references[k, sensor]
                body = true_C[:, 0] * v[0] + true_C[:, 1] * v[1] + true_C[:, 2] * v[2]
                cosine = 0.0
                for i in range(3):
                    cosine += view[sensor, i] * body[i]
                if available[k, sensor] and cosine >= view[sensor, 3]:
                    measured(sensor, body, true_C.ravel(), true_x, y)
                    nis[record, sensor] += update(
                        C, x, P, sensor, y, noise[k, sensor], v, R[sensor], options, r, H, B
                    )
                    updates[record, sensor] += 1
        if k == records[record]:
            e = error_of(C, x, product(plan[k], start), true_x)
            w = forward(cholesky(P), e)
            for i in range(N_STATES):
                errors[record, i] = e[i]
                variances[record, i] = P[i, i]
                nees[record] += w[i] * w[i]
            record += 1
            if record == len(records):
                return
