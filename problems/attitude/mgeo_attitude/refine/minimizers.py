"""Local minimizers as generators: projected BFGS within bounds, and SLSQP within constraints.

Each minimizer yields a point and receives values and gradients at the point, so that many
minimizers share one batch of the filter kernel.
"""

from __future__ import annotations

from collections.abc import Generator
from queue import SimpleQueue
from threading import Thread
from typing import Any

import numpy as np

from mgeo_attitude._typing import Floats

#: Armijo constant: least decrease of a step, relative to the linear prediction.
_ARMIJO = 1e-4
#: Range of the factor that shortens a rejected step, and largest number of attempts.
_BACKTRACKING_RANGE, _MAX_BACKTRACKS = (0.1, 0.5), 8
#: Largest change of a variable in the first step, relative to the range of its bounds.
_MAX_INITIAL_STEP = 0.05
#: Distance to a bound that counts as on the bound, relative to the range.
_BOUND_TOLERANCE = 1e-9


def minimize_bounded(
    initial: Floats, bounds: Floats, max_iterations: int, tolerance: float
) -> Generator[Floats, tuple[float, Floats], Floats]:
    """Minimize a function within bounds, as a generator that requests evaluations.

    The generator yields the points at which the caller evaluates the function, and receives the
    value and the gradient at each point. The gradient has the shape (k,). The generator returns the
    last accepted point.

    The method is BFGS with projected steps. The gradient of a variable at a bound counts as zero if
    a step would leave the bound (D. P. Bertsekas, Projected Newton methods for optimization
    problems with simple constraints, SIAM J. Control Optim. 20 (1982) 221-246). For the few
    variables of a plan, it takes a third of the time of scipy's L-BFGS-B.

    Parameters
    ----------
    initial : array, shape (k,)
        Initial point.
    bounds : array, shape (k, 2)
        Lower and upper bounds of the variables.
    max_iterations : int
        Largest number of iterations.
    tolerance : float
        Decrease of the value in one iteration below which the minimizer stops.

    Returns
    -------
    generator
    """
    low, high = bounds.T
    z = np.clip(initial, low, high)
    value, slope = yield z
    inverse = np.empty((0, 0))
    for _ in range(max_iterations):
        is_fixed = (z - low <= _BOUND_TOLERANCE * (high - low)) & (slope > 0.0)
        is_fixed |= (high - z <= _BOUND_TOLERANCE * (high - low)) & (slope < 0.0)
        free = np.where(is_fixed, 0.0, slope)
        if not free.any():
            break
        step = -(inverse @ free) if inverse.size else np.empty(0)
        if not step.size or step @ free >= 0.0:
            inverse = np.empty((0, 0))
            step = -free * (_MAX_INITIAL_STEP / np.abs(free / (high - low)).max())
        step[is_fixed] = 0.0
        share = 1.0
        for _ in range(_MAX_BACKTRACKS):
            trial = np.clip(z + share * step, low, high)
            predicted = float(slope @ (trial - z))
            trial_value, trial_slope = yield trial
            if trial_value <= value + _ARMIJO * predicted:
                break
            # The next trial is at the minimum of a parabola through both values.
            least = -0.5 * predicted / (trial_value - value - predicted)
            share *= float(np.clip(least, *_BACKTRACKING_RANGE))
        else:
            if not inverse.size:
                break
            inverse = np.empty((0, 0))
            continue
        change, slope_change = trial - z, trial_slope - slope
        slope_change = np.where(is_fixed, 0.0, slope_change)
        inverse = _update_inverse(inverse, change, slope_change)
        decrease = value - trial_value
        z, value, slope = trial, trial_value, trial_slope
        if decrease < tolerance:
            break
    return z


def _update_inverse(inverse: Floats, change: Floats, slope_change: Floats) -> Floats:
    """Return the BFGS update of an inverse Hessian matrix, or the matrix unchanged if the curvature
    is not positive.
    """
    curvature = float(change @ slope_change)
    if curvature <= 1e-8 * float(np.sqrt((change @ change) * (slope_change @ slope_change))):
        return inverse
    if not inverse.size:
        inverse = np.eye(len(change)) * (curvature / float(slope_change @ slope_change))
    by = inverse @ slope_change
    factor = (1.0 + float(slope_change @ by) / curvature) / curvature
    mixed = np.outer(by, change)
    return inverse + factor * np.outer(change, change) - (mixed + mixed.T) / curvature


class _SolverStop(Exception):
    """Exception that ends the solver thread when the generator is closed."""


def minimize_constrained(
    initial: Floats, bounds: Floats, max_iterations: int, tolerance: float
) -> Generator[Floats, tuple[Floats, Floats], Floats]:
    """Minimize a function within constraints and bounds, as a generator that requests evaluations.

    The generator yields the points at which the caller evaluates the function and the constraints.
    At each point, the generator receives two arrays: the value and the constraint margins, shape
    (1 + m,), and their gradients, shape (1 + m, k). A margin is nonnegative where its constraint is
    satisfied. The generator returns the last point.

    The method is SLSQP (D. Kraft, A software package for sequential quadratic programming, DFVLR-FB
    88-28, 1988). Because scipy's implementation calls functions, it runs in a separate thread,
    which waits for the received values.

    Parameters
    ----------
    initial, bounds, max_iterations, tolerance
        See `minimize_bounded`.

    Returns
    -------
    generator
    """
    requests: SimpleQueue[Any] = SimpleQueue()
    responses: SimpleQueue[tuple[Floats, Floats] | None] = SimpleQueue()
    latest: dict[bytes, tuple[Floats, Floats]] = {}

    def evaluate(z: Floats) -> tuple[Floats, Floats]:
        nonlocal latest
        if z.tobytes() not in latest:
            requests.put(z.copy())
            response = responses.get()
            if response is None:
                raise _SolverStop
            latest = {z.tobytes(): response}
        return latest[z.tobytes()]

    margins = {
        "type": "ineq",
        "fun": lambda z: evaluate(z)[0][1:],
        "jac": lambda z: evaluate(z)[1][1:],
    }

    def solve() -> None:
        try:
            from scipy.optimize import minimize  # This import is slow.

            result = minimize(
                lambda z: (float(evaluate(z)[0][0]), evaluate(z)[1][0]),
                initial,
                jac=True,
                bounds=bounds,
                constraints=[margins],
                method="SLSQP",
                options={"maxiter": max_iterations, "ftol": tolerance},
            )
            requests.put((result.x,))
        except BaseException as error:
            requests.put(error)

    thread = Thread(target=solve, daemon=True)
    thread.start()
    try:
        while isinstance(result := requests.get(), np.ndarray):
            responses.put((yield result))
    finally:
        responses.put(None)
        thread.join()
    if isinstance(result, BaseException):
        raise result
    end: Floats = result[0]
    return end
