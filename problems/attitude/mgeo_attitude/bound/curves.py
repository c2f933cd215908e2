"""The limit as it is handed on: what covariances are not below, as curves over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.scenario.goals import RequiredSigma
from mgeo_attitude.scenario.scenario import Scenario


class Block(NamedTuple):
    """Lower bounds at n times, each for every plan.

    Attributes
    ----------
    total : array, shape (n,)
        Of the sum of the three variances.
    worst : array, shape (n,)
        Of the largest of them.
    log_det : array, shape (n,)
        Of the natural logarithm of the determinant, if all else were known.
    """

    total: Floats
    worst: Floats
    log_det: Floats

    def or_above(self, other: Block) -> Block:
        """Where two are proved, the higher one."""
        return Block(*map(np.maximum, self, other))

    def or_above_sum(self, total: Floats) -> Block:
        """Where a sum of the three is proved that is higher, while all else is not known."""
        return self._replace(
            total=np.maximum(self.total, total), worst=np.maximum(self.worst, total / 3.0)
        )


def in_any_axes(variances: Floats) -> Block:
    """From least eigenvalues, shape (n, 3), whose axes are not known."""
    total = variances.sum(axis=1)
    return Block(total, total / 3.0, np.log(variances).sum(axis=1))


def in_these_axes(covariances: Floats) -> Block:
    """From covariances that none is below, shape (n, 3, 3)."""
    diagonals = np.diagonal(covariances, axis1=1, axis2=2)
    log_det = np.linalg.slogdet(covariances)[1]
    return Block(diagonals.sum(axis=1), diagonals.max(axis=1), log_det)


def least(known: Floats, gained: Floats) -> Block:
    """Of P = (Y + K)⁻¹ with a K of which only the trace is bounded.

    The information fills up the eigenvalues of Y from the smallest: as far as it can they end
    equal. For a function of eigenvalues that is convex and falls, a K that has the axes of Y is
    the best, and of these the one that leaves them as equal as can be: equation (21).

    Parameters
    ----------
    known : array, shape (3, 3)
        Y, positive definite.
    gained : array, shape (n,)
        Greatest trace of K, which is positive semidefinite.
    """
    return in_any_axes(filled(known, gained))


def filled(known: Floats, gained: Floats) -> Floats:
    """Eigenvalues of that P, shape (n, 3)."""
    eigenvalues = np.linalg.eigvalsh(known)
    counts = np.arange(1, len(eigenvalues) + 1)
    level = ((gained[:, None] + np.cumsum(eigenvalues)) / counts).min(axis=1)
    variances: Floats = 1.0 / np.maximum(eigenvalues, level[:, None])
    return variances


def unobserved(start: Floats, decay: float, walk: Floats, times: Floats) -> Floats:
    """Covariance of an error e' = -λ e + noise of densities that nothing measures.

    Parameters
    ----------
    start : array, shape (3, 3)
    decay : float
        λ [1/s].
    walk : array, shape (3,)
        Densities per axis.
    times : array, shape (n,)
        [s]

    Returns
    -------
    array, shape (n, 3, 3)
    """
    twice = 2.0 * decay * times
    # (1 - exp(-2 λ t)) / 2 λ, which is t without decay
    grown = times if decay == 0.0 else -np.expm1(-twice) / (2.0 * decay)
    return np.exp(-twice)[:, None, None] * start + walk * grown[:, None, None] * np.eye(3)


@dataclass(frozen=True)
class LimitCurves:
    """What no plan is below, at n times.

    Attributes
    ----------
    times : array, shape (n,)
        [s]
    trace : array, shape (n,)
        Of the weighted trace of the covariance.
    ending : array, shape (n,)
        Of the same where a plan ends: by the rule "trace" it has fallen but little for a window.
        Infinite while none can have ended.
    blocks : dict of array, shape (n,)
        Of the sum of the variances of each 3-vector of the state, filter's units squared.
    worst : dict of array, shape (n,)
        Of the largest of the three.
    criteria : dict of array, shape (n,)
        Of the objectives "normalized_trace", "log_det" and "max_eigenvalue".
    earliest : dict of float
        For each key of ``required_sigma`` the time [s] before which no plan meets it; infinite if
        none does within the duration.
    given_away : tuple of str
        What the bound does not ask for, beside that each 3-vector counts as if all else were known.

    Examples
    --------
    >>> from mgeo_attitude import Scenario, limit
    >>> scenario = Scenario.from_dict({"preset": "paper", "required_sigma": {"attitude_deg": 0.1}})
    >>> limit(scenario).earliest
    {'attitude_deg': 278.0}
    """

    times: Floats
    trace: Floats
    ending: Floats
    blocks: Mapping[str, Floats]
    worst: Mapping[str, Floats]
    criteria: Mapping[str, Floats]
    earliest: Mapping[str, float]
    given_away: tuple[str, ...]

    def sigma(self, block: str) -> Floats:
        """1-sigma of the worst axis of a 3-vector, filter's units, shape (n,).

        Raises
        ------
        KeyError
            For one that is not in the state.
        """
        return np.sqrt(self.worst[block])

    def at(self, times: Floats) -> Floats:
        """Of the trace, at times [s] that are those of samples, or NaN; shape (m,)."""
        known = np.isfinite(times)
        steps = np.rint(times[known] / self.times[1]).astype(np.int64)
        least = np.full(len(times), np.nan)
        least[known] = self.trace[steps]
        return least


def curves(
    scenario: Scenario,
    model: FilterModel,
    found: Mapping[str, Block],
    given_away: tuple[str, ...],
) -> LimitCurves:
    """Those of a scenario from what is `found` of each 3-vector of its state."""
    suite, names = model.suite, model.suite.blocks
    blocks = {name: found[name].total for name in names}
    worst = {name: found[name].worst for name in names}
    trace = _sum([weight * blocks[n] for n, weight in zip(names, model.weights[::3], strict=True)])
    required = RequiredSigma(scenario.required_sigma).of(suite.units)
    times = model.times
    earliest = {
        unit.key(name): _first(times, worst[name] <= sigma**2)
        for (name, unit), sigma in zip(suite.units.items(), required, strict=True)
        if sigma < np.inf
    }
    return LimitCurves(
        times=times,
        trace=trace,
        ending=_ending(model, trace),
        blocks=blocks,
        worst=worst,
        criteria=_criteria(model, found),
        earliest=earliest,
        given_away=given_away,
    )


def _ending(model: FilterModel, trace: Floats) -> Floats:
    """The trace of a plan that ends: equation (27)."""
    if model.rule != "trace":
        return trace
    window = model.window_steps
    before = np.concatenate([np.full(window, np.inf), trace[: len(trace) - window]])
    ending = np.maximum(trace, (1.0 - model.relative_decrease) * before)
    ending[-1] = trace[-1]  # a plan may also end there without having converged
    return ending


def _criteria(model: FilterModel, found: Mapping[str, Block]) -> dict[str, Floats]:
    """Those of equation (13), over what is calibrated."""
    suite = model.suite
    states = suite.calibrated
    names = [suite.blocks[state // 3] for state in states[::3]]
    if not names:
        return {}
    sigma = model.initial_sigma[states]
    widest = sigma.reshape(-1, 3).max(axis=1) ** 2
    shares = [found[name].total / square for name, square in zip(names, widest, strict=True)]
    start = np.linalg.slogdet(model.initial_correlation[np.ix_(states, states)])[1]
    log_det = _sum([found[name].log_det for name in names]) - 2.0 * np.log(sigma).sum() - start
    return {
        "normalized_trace": _sum(shares) / len(states),
        "log_det": log_det / np.log(10.0) / len(states),
        "max_eigenvalue": np.max(shares, axis=0) / 3.0,
    }


def _first(times: Floats, met: np.ndarray) -> float:
    return float(times[met.argmax()]) if met.any() else float("inf")


def _sum(values: list[Floats]) -> Floats:
    total: Floats = np.sum(values, axis=0)
    return total
