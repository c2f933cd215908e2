"""How the trace at the end of plans changes with the rates, in about the time of six runs."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.adjoint import places
from mgeo_attitude.filter.evaluator import available_threads
from mgeo_attitude.filter.kernel import lanes, load_adjoint, load_backward, load_kernel
from mgeo_attitude.filter.layout import layout, transition_pattern
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.variants import constants_of, dynamics_of, initial_values
from mgeo_attitude.maneuvers.schedule import Schedule
from mgeo_attitude.sensors.gyro import is_uneven
from mgeo_attitude.sensors.suite import Suite

#: Attitudes at which it is tried whether a sensor's H has constant and linear terms alone.
_TRIED = 3
#: Longest run [steps] whose covariances are kept until it has been gone through backward.
_LONGEST = 2000


def has_slopes(model: FilterModel, n_steps: int) -> bool:
    """Whether `slopes` are those of a model, of runs of so many steps.

    Rates change at once and are all that moves it; H has terms that are constant and linear in the
    attitude's matrix; no state is considered.
    """
    suite = model.suite
    simple = model.slew_limits is None and model.budget is None and not model.monitors.total
    simple = simple and n_steps <= _LONGEST and not (suite.considered.size or suite.following)
    return simple and all(_is_affine(suite, index) for index in range(len(suite.sensors)))


@cache
def _is_affine(suite: Suite, index: int) -> bool:
    """Whether a sensor's H depends on the attitude's matrix so, and not on the rate."""
    sensor, rng = suite.sensors[index], np.random.default_rng(0)
    if sensor.delay() or sensor.influences or sensor.max_rate() < np.inf:
        return False
    vectors = rng.standard_normal((len(suite.looks(index)), 3))

    def H(attitude: Floats) -> Floats:
        v, *gradient = vectors @ attitude.T
        found: Floats = suite.measurement_matrix(sensor, v, attitude, gradient)
        return found

    constant = H(np.zeros((3, 3)))
    for _ in range(_TRIED):
        one, other = rng.standard_normal((2, 3, 3))
        if not np.allclose(H(one) + H(2.0 * other), H(one + 2.0 * other) + constant, rtol=1e-10):
            return False
    return True


def slopes(
    model: FilterModel, plan: Schedule, stops: Ints, threads: int | None = None
) -> tuple[Floats, Floats]:
    """Trace after so many steps, shape (n,), and its derivatives by the rates [1/(rad/s)].

    Of a model that `has_slopes`. The latter have the shape of `plan.rates`, zero where a rate is
    not flown. A covariance that lost positivity gives NaN.
    """
    suite, gated, n = model.suite, model.gated, len(stops)
    matrices, densities = dynamics_of([model])
    trace, found = np.empty(n), np.zeros(plan.rates.shape)
    kernel, back = load_kernel(suite, gated), load_adjoint(suite, gated)
    run = load_backward().run
    arguments: tuple[Any, ...] = (
        (kernel.step.address, kernel.check.address, back.back.address, lanes()),
        tuple(layout(suite, gated)),
        tuple(places(suite, gated)),
        np.zeros(1, dtype=np.int64),
        (np.ascontiguousarray(plan.rates), np.ascontiguousarray(plan.starts), stops),
        (
            matrices[0],
            densities[0],
            np.array(transition_pattern(suite)),
            model.step,
            model.by_polynomials and densities.shape[1] == 6 and not is_uneven(densities),
        ),
        model.table,
        (constants_of(model, [model])[0], initial_values(model, [model])[0], model.weights),
        trace,
        found,
    )
    others = min(threads or available_threads(), -(-n // lanes())) - 1
    with ThreadPoolExecutor(max(others, 1)) as pool:  # it makes no thread before it needs one
        futures = [pool.submit(run, *arguments) for _ in range(others)]
        run(*arguments)
    for future in futures:
        future.result()
    return trace, found
