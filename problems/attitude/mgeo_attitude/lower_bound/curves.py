"""Lower bounds of the covariance as curves over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.scenario.criteria import RequiredSigma
from mgeo_attitude.scenario.scenario import Scenario


class BlockBounds(NamedTuple):
    """Lower bounds on the covariance of a three-component state block, such as the gyro bias.

    Attributes
    ----------
    variance_sum : array, shape (n,)
        Bound on the sum of the three variances.
    max_variance : array, shape (n,)
        Bound on the largest variance.
    log_det : array, shape (n,)
        Bound on the natural logarithm of the determinant if all other states are known.
    """

    variance_sum: Floats
    max_variance: Floats
    log_det: Floats

    def combine_with(self, other: BlockBounds) -> BlockBounds:
        """Return the element-wise maximum of two lower bounds, which is also a lower bound."""
        return BlockBounds(*map(np.maximum, self, other))

    def raise_to_sum(self, variance_sum: Floats) -> BlockBounds:
        """Return a copy of the bounds that also includes another lower bound on the sum of the
        variances.

        The other bound has the shape (n,). The determinant is unchanged, since the bound on the sum
        does not assume that other states are known.
        """
        return self._replace(
            variance_sum=np.maximum(self.variance_sum, variance_sum),
            max_variance=np.maximum(self.max_variance, variance_sum / 3.0),
        )


def bounds_from_eigenvalues(variances: Floats) -> BlockBounds:
    """Return lower bounds on the variances of a state block, given lower bounds on its covariance
    eigenvalues.

    The eigenvalues have the shape (n, 3). The eigenvectors are unknown.
    """
    total = variances.sum(axis=1)
    return BlockBounds(total, total / 3.0, np.log(variances).sum(axis=1))


def bounds_from_covariances(covariances: Floats) -> BlockBounds:
    """Return lower bounds on the variances of a state block, given a lower bound on its covariance
    matrix at each time.

    The matrices have the shape (n, 3, 3).
    """
    diagonals = np.diagonal(covariances, axis1=1, axis2=2)
    log_det = np.linalg.slogdet(covariances)[1]
    return BlockBounds(diagonals.sum(axis=1), diagonals.max(axis=1), log_det)


def bounds_from_information(initial_information: Floats, max_trace: Floats) -> BlockBounds:
    """Return lower bounds on the variances of a state block, given its initial information and an
    upper bound on the measured information.

    The upper bound limits the trace of the measured information. With the initial information Y and
    the measured information K, the covariance is (Y + K)⁻¹. By equation (3) of
    docs/explanation/lower-bound.md the best K has the eigenvectors of Y and raises the smallest
    eigenvalues to a common level (water filling), because the bounds are convex and decreasing
    functions of the eigenvalues.

    Parameters
    ----------
    initial_information : array, shape (3, 3)
        Y, positive definite.
    max_trace : array, shape (n,)
        Largest trace of K at each of n times.
    """
    return bounds_from_eigenvalues(apply_water_filling(initial_information, max_trace))


def apply_water_filling(initial_information: Floats, max_trace: Floats) -> Floats:
    """Return the eigenvalues of the smallest covariance that measurements can produce.

    The eigenvalues have the shape (n, 3). The trace of the measurements' information matrix is at
    most `max_trace`. Distributing it over the axes by water-filling minimizes both trace and
    determinant; see `bounds_from_information`.
    """
    eigenvalues = np.linalg.eigvalsh(initial_information)
    counts = np.arange(1, len(eigenvalues) + 1)
    level = ((max_trace[:, None] + np.cumsum(eigenvalues)) / counts).min(axis=1)
    variances: Floats = 1.0 / np.maximum(eigenvalues, level[:, None])
    return variances


def propagate_unobserved(
    initial_covariance: Floats, decay: float, noise_density: Floats, times: Floats
) -> Floats:
    """Return the covariance of a Gauss-Markov error that is never measured, at n times.

    Parameters
    ----------
    initial_covariance : array, shape (3, 3)
        Initial covariance.
    decay : float
        Decay rate λ [1/s].
    noise_density : array, shape (3,)
        Noise density of each axis.
    times : array, shape (n,)
        Times [s].

    Returns
    -------
    array, shape (n, 3, 3)
    """
    exponent = 2.0 * decay * times
    # This is (1 - exp(-2 λ t)) / 2 λ, whose limit for λ = 0 is t.
    growth = times if decay == 0.0 else -np.expm1(-exponent) / (2.0 * decay)
    return np.exp(-exponent)[:, None, None] * initial_covariance + noise_density * growth[
        :, None, None
    ] * np.eye(3)


@dataclass(frozen=True)
class LowerBound:
    """Lower bounds on the filter covariance that hold for every plan of a scenario.

    Attributes
    ----------
    times : array, shape (n,)
        Times [s].
    trace : array, shape (n,)
        Bound on the weighted trace of the covariance.
    trace_at_end : array, shape (n,)
        Bound on the weighted trace of a plan that ends at the time. With the convergence rule
        "trace", the decrease over the convergence window must also be small. Infinite at times at
        which no plan can end.
    variance_sum : dict of array, shape (n,)
        Bound on the sum of the variances of each 3-vector of the state, squared filter units.
    max_variance : dict of array, shape (n,)
        Bound on the largest variance of each 3-vector.
    criteria : dict of array, shape (n,)
        Bounds on the objectives "normalized_trace", "log_det" and "max_eigenvalue".
    earliest_times : dict of float
        Earliest time [s] at which a plan can satisfy each key of ``required_sigma``; infinite if
        that is impossible within the duration.
    relaxations : tuple of str
        One line for each relaxation, see `list_relaxations`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario, compute_lower_bound
    >>> scenario = Scenario.from_dict({"preset": "paper", "required_sigma": {"attitude_deg": 0.1}})
    >>> compute_lower_bound(scenario).earliest_times
    {'attitude_deg': 278.0}
    """

    times: Floats
    trace: Floats
    trace_at_end: Floats
    variance_sum: Mapping[str, Floats]
    max_variance: Mapping[str, Floats]
    criteria: Mapping[str, Floats]
    earliest_times: Mapping[str, float]
    relaxations: tuple[str, ...]

    def compute_sigma(self, block: str) -> Floats:
        """Return the lower bound on the largest 1-sigma of a state block, in filter units.

        The result has one value per time.

        Raises
        ------
        KeyError
            If the block is not in the state.
        """
        return np.sqrt(self.max_variance[block])

    def evaluate_trace(self, times: Floats) -> Floats:
        """Return the lower bound on the weighted trace of the covariance at given times [s].

        The bound is that of the nearest sample. A NaN time gives NaN.
        """
        is_finite = np.isfinite(times)
        steps = np.rint(times[is_finite] / self.times[1]).astype(np.int64)
        bounds = np.full(len(times), np.nan)
        bounds[is_finite] = self.trace[steps]
        return bounds


def assemble_bounds(
    scenario: Scenario,
    model: FilterModel,
    block_bounds: Mapping[str, BlockBounds],
    relaxations: tuple[str, ...],
) -> LowerBound:
    """Build the `LowerBound` of a scenario from the bounds of all state blocks.

    Parameters
    ----------
    scenario : Scenario
    model : FilterModel
    block_bounds : mapping of str to BlockBounds
        Bounds of each block of the suite.
    relaxations : tuple of str
        One line for each relaxation.
    """
    suite, names = model.suite, model.suite.blocks
    blocks = {name: block_bounds[name].variance_sum for name in names}
    worst = {name: block_bounds[name].max_variance for name in names}
    trace = _sum([weight * blocks[n] for n, weight in zip(names, model.weights[::3], strict=True)])
    required = RequiredSigma(scenario.required_sigma).list_sigmas(suite.units)
    times = model.times
    earliest = {
        unit.build_key(name): _find_first_time(times, worst[name] <= sigma**2)
        for (name, unit), sigma in zip(suite.units.items(), required, strict=True)
        if sigma < np.inf
    }
    return LowerBound(
        times=times,
        trace=trace,
        trace_at_end=_bound_trace_at_end(model, trace),
        variance_sum=blocks,
        max_variance=worst,
        criteria=_bound_criteria(model, block_bounds),
        earliest_times=earliest,
        relaxations=relaxations,
    )


def _bound_trace_at_end(model: FilterModel, trace: Floats) -> Floats:
    """Return lower bounds on the weighted trace at the end of a plan, one per end time.

    See equation (8) of docs/explanation/lower-bound.md.
    """
    if model.rule != "trace":
        return trace
    window = model.window_steps
    before = np.concatenate([np.full(window, np.inf), trace[: len(trace) - window]])
    ending = np.maximum(trace, (1.0 - model.relative_decrease) * before)
    ending[-1] = trace[-1]  # A plan without convergence ends with the scenario.
    return ending


def _bound_criteria(model: FilterModel, bounds: Mapping[str, BlockBounds]) -> dict[str, Floats]:
    """Return lower bounds on the objectives of the normalized covariance, such as its largest
    eigenvalue, keyed by objective.

    The objectives are the mean variance, the log determinant and the largest eigenvalue. Each bound
    has one value per time. See equation (7) of docs/explanation/models-and-filter.md.
    """
    suite = model.suite
    states = suite.calibrated_indices
    names = [suite.blocks[state // 3] for state in states[::3]]
    if not names:
        return {}
    sigma = model.initial_sigma[states]
    widest = sigma.reshape(-1, 3).max(axis=1) ** 2
    shares = [
        bounds[name].variance_sum / square for name, square in zip(names, widest, strict=True)
    ]
    start = np.linalg.slogdet(model.initial_correlation[np.ix_(states, states)])[1]
    log_det = _sum([bounds[name].log_det for name in names]) - 2.0 * np.log(sigma).sum() - start
    return {
        "normalized_trace": _sum(shares) / len(states),
        "log_det": log_det / np.log(10.0) / len(states),
        "max_eigenvalue": np.max(shares, axis=0) / 3.0,
    }


def _find_first_time(times: Floats, is_satisfied: np.ndarray) -> float:
    return float(times[is_satisfied.argmax()]) if is_satisfied.any() else float("inf")


def _sum(values: list[Floats]) -> Floats:
    total: Floats = np.sum(values, axis=0)
    return total
