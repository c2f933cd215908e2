"""Sequential quadratic programming within limits, which asks for points as `quasi_newton` does."""

from __future__ import annotations

from collections.abc import Generator
from queue import SimpleQueue
from threading import Thread
from typing import Any

import numpy as np

from mgeo_attitude._typing import Floats


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
        As of `quasi_newton.minimize_bounded`.
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
