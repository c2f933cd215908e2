"""What slopes of a plan cost: by differences as the polish takes them, and by a reverse sweep.

``python docs/studies/adjoint.py`` prints times of one plan of the paper's satellite of ten
maneuvers and 1,000 s, with one sample in ten as the polish has. The reverse sweep is a prototype
in numba for this satellite's 18 states, checked by differences of itself; its time is compared
with that of its own forward pass, and with that of the differences. It is not in the polish: one
plan's two passes take longer than the differences of 41, eight of which a vector holds and which
have their beginnings and discretizations in common.
"""

import time

import numba
import numpy as np
from mgeo_attitude import AttitudeManeuverProblem, Scenario, evaluate
from mgeo_attitude.refine.descent import Descent
from mgeo_attitude.refine.judging import at_time
from mgeo_attitude.refine.roughly import Roughly

TIME, COUNT, N = 1000.0, 10, 18
#: First column of the misalignment and of the bias of each of the two sensors.
BLOCKS = np.array([[6, 9], [12, 15]])


@numba.njit(cache=True)
def cross(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


@numba.njit(cache=True)
def rows(v, sensor):
    """H of a vector sensor."""
    H = np.zeros((3, N))
    H[:, :3] = cross(v)
    H[:, BLOCKS[sensor, 0] : BLOCKS[sensor, 0] + 3] = cross(v)
    for i in range(3):
        H[i, BLOCKS[sensor, 1] + i] = 1.0
    return H


@numba.njit(cache=True)
def forward(P, F, Q, v, r):
    """Covariance at the end; F (k, n, n), directions v (k, 2, 3). All that the sweep needs, too."""
    k = len(F)
    kept = np.empty((k, 2, N, N))
    gains = np.empty((k, 2, N, 3))
    for i in range(k):
        P = F[i] @ P @ F[i].T + Q
        for s in range(2):
            H = rows(v[i, s], s)
            PHt = P @ H.T
            K = PHt @ np.linalg.inv(H @ PHt + r[s] * np.eye(3))
            P = P - K @ PHt.T
            kept[i, s], gains[i, s] = P, K
    return P, kept, gains


@numba.njit(cache=True)
def reverse(S, F, v, r, kept, gains):
    """Slopes of tr(S P) with respect to the directions, shape (k, 2, 3), and to F, (k, n, n)."""
    k = len(F)
    by_v, by_F = np.zeros((k, 2, 3)), np.zeros((k, N, N))
    for i in range(k - 1, -1, -1):
        for s in range(1, -1, -1):
            H, P, K = rows(v[i, s], s), kept[i, s], gains[i, s]
            # dP = -(P dHt Ht' + its transpose) / r, so tr(S dP) = -2 tr(dH P S P Ht) / r
            M = (H @ P) @ S @ P * (-2.0 / r[s])
            for first in (0, BLOCKS[s, 0]):
                B = M[:, first : first + 3]
                by_v[i, s, 0] += B[2, 1] - B[1, 2]
                by_v[i, s, 1] += B[0, 2] - B[2, 0]
                by_v[i, s, 2] += B[1, 0] - B[0, 1]
            SK = S @ K
            T = S - SK @ H
            S = T - H.T @ (K.T @ T)
        if i:
            by_F[i] = 2.0 * S @ F[i] @ kept[i - 1, 1]
        S = F[i].T @ S @ F[i]
    return by_v, by_F


def setting(k, rng):
    """Numbers of the size of the paper's; times depend on none of them."""
    sigma = np.repeat([0.17, 1e-5, 0.01, 0.003, 0.02, 0.01], 3)
    F = np.tile(np.eye(N), (k, 1, 1))
    F[:, :3, :3] = np.linalg.qr(np.eye(3) + 0.1 * rng.standard_normal((k, 3, 3)))[0]
    F[:, :3, 3:6] = -10.0 * F[:, :3, :3]
    v = rng.standard_normal((k, 2, 3))
    v /= np.linalg.norm(v, axis=2, keepdims=True)
    Q = np.diag(np.repeat([1e-8, 1e-16, 0.0, 0.0, 0.0, 0.0], 3))
    return np.diag(sigma**2), F, Q, v, np.array([1e-5, 1e-4])


def checked(k=20):
    """The greatest relative error of the sweep's slopes."""
    rng = np.random.default_rng(1)
    P, F, Q, v, r = setting(k, rng)
    _, kept, gains = forward(P, F, Q, v, r)
    by_v, _ = reverse(np.eye(N), F, v, r, kept, gains)
    worst = 0.0
    for _ in range(20):
        i, s, axis = rng.integers(k), rng.integers(2), rng.integers(3)
        ends = []
        for change in (1e-5, -1e-5):
            other = v.copy()
            other[i, s, axis] += change
            ends.append(np.trace(forward(P, F, Q, other, r)[0]))
        difference = (ends[0] - ends[1]) / 2e-5
        worst = max(worst, abs(difference - by_v[i, s, axis]) / np.abs(by_v).max())
    return worst


def best_of(work, repeats=30):
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return 1e3 * min(times)


def main():
    print(f"slopes of the sweep beside differences: {checked():.1e} of the greatest")
    problem = AttitudeManeuverProblem(
        Scenario.from_dict(
            {"preset": "paper", "maneuvers": {"count": COUNT}, "convergence": {"rule": "end"}}
        )
    )
    at = Roughly(at_time(problem)).at(TIME)
    (design,) = problem.starts(1, np.random.default_rng(1))
    descent = Descent(at, TIME, COUNT)
    z = descent.variables(design)
    designs = np.repeat(descent.designs(z), 8, axis=0)
    designs[:, 0::4] += 1e-3 * np.arange(8)[:, None]
    for n in (1, 8):
        took = best_of(lambda n=n: evaluate(at.model, designs[:n], 1, until=descent.steps))
        print(f"kernel, {n} plans: {took:.2f} ms")
    print(f"differences, {len(z) + 1} designs: {best_of(lambda: descent._taken(z)):.2f} ms")
    k = descent.steps
    P, F, Q, v, r = setting(k, np.random.default_rng(1))
    _, kept, gains = forward(P, F, Q, v, r)
    one = best_of(lambda: forward(P, F, Q, v, r))
    back = best_of(lambda: reverse(np.eye(N), F, v, r, kept, gains))
    print(f"reverse sweep over forward pass, both by numba: {back / one:.2f}; {one + back:.2f} ms")


if __name__ == "__main__":
    main()
