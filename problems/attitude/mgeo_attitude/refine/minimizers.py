"""Local minimizers that ask for points: a quasi-Newton method within bounds, and SLSQP.

Each is a generator that yields a point and is sent the values and slopes there, so that many of
them share one batch of the kernel.
"""

from __future__ import annotations

from collections.abc import Generator
from queue import SimpleQueue
from threading import Thread
from typing import Any

import numpy as np

from mgeo_attitude._typing import Floats

#: Share of the fall that the slope promises which a step must bring.
_ARMIJO = 1e-4
#: By how much a step that does not is shortened, at least and at most, and how often.
_SHORTER, _TRIES = (0.1, 0.5), 8
#: Greatest change of a variable by the first step, of the range between its bounds.
_FIRST = 0.05
#: Of the range between bounds, what is as good as on one.
_ON = 1e-9


def minimize_bounded(
    start: Floats, bounds: Floats, iterations: int, enough: float
) -> Generator[Floats, tuple[float, Floats], Floats]:
    """Where a function is less than at the start, within bounds, shape (k,).

    It asks for the points that it yields, and is sent value and slopes, shape (k,), of each: so
    several can go on side by side.

    BFGS with the slopes of variables on a bound that they would leave taken as zero (D. P.
    Bertsekas, Projected Newton methods for optimization problems with simple constraints, SIAM J.
    Control Optim. 20 (1982) 221-246), each step projected onto the bounds. At this size it takes a
    third of the time of scipy's L-BFGS-B, whose library waits in threads.

    Parameters
    ----------
    bounds : array, shape (k, 2)
        Least and greatest.
    iterations : int
        The most.
    enough : float
        A fall of the value that is not worth another iteration.
    """
    low, high = bounds.T
    z = np.clip(start, low, high)
    value, slope = yield z
    inverse = np.empty((0, 0))
    for _ in range(iterations):
        held = (z - low <= _ON * (high - low)) & (slope > 0.0)
        held |= (high - z <= _ON * (high - low)) & (slope < 0.0)
        free = np.where(held, 0.0, slope)
        if not free.any():
            break
        step = -(inverse @ free) if inverse.size else np.empty(0)
        if not step.size or step @ free >= 0.0:
            inverse = np.empty((0, 0))
            step = -free * (_FIRST / np.abs(free / (high - low)).max())
        step[held] = 0.0
        share = 1.0
        for _ in range(_TRIES):
            tried = np.clip(z + share * step, low, high)
            promised = float(slope @ (tried - z))
            found, other = yield tried
            if found <= value + _ARMIJO * promised:
                break
            # where a parabola through both values has its least
            least = -0.5 * promised / (found - value - promised)
            share *= float(np.clip(least, *_SHORTER))
        else:
            if not inverse.size:
                break
            inverse = np.empty((0, 0))
            continue
        moved, turned = tried - z, other - slope
        turned = np.where(held, 0.0, turned)
        inverse = _updated(inverse, moved, turned)
        fall = value - found
        z, value, slope = tried, found, other
        if fall < enough:
            break
    return z


def _updated(inverse: Floats, moved: Floats, turned: Floats) -> Floats:
    """The inverse Hessian after a step, by BFGS; as before where the curvature is no positive."""
    curvature = float(moved @ turned)
    if curvature <= 1e-8 * float(np.sqrt((moved @ moved) * (turned @ turned))):
        return inverse
    if not inverse.size:
        inverse = np.eye(len(moved)) * (curvature / float(turned @ turned))
    by = inverse @ turned
    factor = (1.0 + float(turned @ by) / curvature) / curvature
    mixed = np.outer(by, moved)
    return inverse + factor * np.outer(moved, moved) - (mixed + mixed.T) / curvature


class _Left(Exception):
    """Nobody answers any more."""


def minimize_constrained(
    start: Floats, bounds: Floats, iterations: int, enough: float
) -> Generator[Floats, tuple[Floats, Floats], Floats]:
    """Where a function is less than at the start and no margin is negative, within bounds.

    It asks for the points that it yields, and is sent value and margins, shape (1 + m,), and their
    slopes, shape (1 + m, k), of each. The method is SLSQP (D. Kraft, A software package for
    sequential quadratic programming, DFVLR-FB 88-28, 1988). As scipy's calls for what it wants, it
    has a thread of its own, which waits for the answers.

    Parameters
    ----------
    start, bounds, iterations, enough
        As of `minimize_bounded`.
    """
    asked: SimpleQueue[Any] = SimpleQueue()
    answers: SimpleQueue[tuple[Floats, Floats] | None] = SimpleQueue()
    last: dict[bytes, tuple[Floats, Floats]] = {}

    def known(z: Floats) -> tuple[Floats, Floats]:
        nonlocal last
        if z.tobytes() not in last:
            asked.put(z.copy())
            answer = answers.get()
            if answer is None:
                raise _Left
            last = {z.tobytes(): answer}
        return last[z.tobytes()]

    margins = {
        "type": "ineq",
        "fun": lambda z: known(z)[0][1:],
        "jac": lambda z: known(z)[1][1:],
    }

    def solve() -> None:
        try:
            from scipy.optimize import minimize  # which takes long to import

            found = minimize(
                lambda z: (float(known(z)[0][0]), known(z)[1][0]),
                start,
                jac=True,
                bounds=bounds,
                constraints=[margins],
                method="SLSQP",
                options={"maxiter": iterations, "ftol": enough},
            )
            asked.put((found.x,))
        except BaseException as error:
            asked.put(error)

    thread = Thread(target=solve, daemon=True)
    thread.start()
    try:
        while isinstance(found := asked.get(), np.ndarray):
            answers.put((yield found))
    finally:
        answers.put(None)
        thread.join()
    if isinstance(found, BaseException):
        raise found
    end: Floats = found[0]
    return end
