"""The limit as it is handed on: curves over time."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.bound.block import Block
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.scenario import Scenario
from mgeo_attitude.scenario.settings import RequiredSigma, blocks_of


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

    def or_below(self, other: LimitCurves) -> LimitCurves:
        """What no plan of either is below."""

        def least(one: Mapping[str, Any], two: Mapping[str, Any]) -> dict[str, Any]:
            return {name: np.minimum(one[name], two[name]) for name in one}

        return dataclasses.replace(
            self,
            trace=np.minimum(self.trace, other.trace),
            ending=np.minimum(self.ending, other.ending),
            blocks=least(self.blocks, other.blocks),
            worst=least(self.worst, other.worst),
            criteria=least(self.criteria, other.criteria),
            earliest={k: min(time, other.earliest[k]) for k, time in self.earliest.items()},
        )

    def sigma(self, block: str) -> Floats:
        """1-sigma of the worst axis of a 3-vector, filter's units, shape (n,).

        Raises
        ------
        KeyError
            For one that is not in the state.
        """
        sigma: Floats = np.sqrt(self.worst[block])
        return sigma

    def at(self, times: Floats) -> Floats:
        """Of the trace, at times [s] that are those of samples, or NaN; shape (m,)."""
        known = np.isfinite(times)
        steps = np.rint(times[known] / self.times[1]).astype(np.int64)
        least = np.full(len(times), np.nan)
        least[known] = self.trace[steps]
        return least

    def of_objective(self, name: str) -> Floats | None:
        """That of an objective at the end of a plan, shape (n,); None of one that has none."""
        blocks = blocks_of(name)
        if blocks:
            return _sum([self.blocks[block] for block in blocks])
        return self.ending if name == "trace" else self.criteria.get(name)


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
