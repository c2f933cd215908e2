"""What a plan is worth, in one line: how long it takes, and what is known then."""

from __future__ import annotations

import math

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.suite import Suite, block_units
from mgeo_attitude.view.plans import MOST_SAMPLES, UNKNOWN, Plans, Times


def answers(plans: Plans) -> list[str]:
    """The `answer` of each plan."""
    model, duration = plans.problem.model, plans.problem.scenario.duration
    t_ends, _, covariances = plans.exactly
    found = zip(t_ends.tolist(), covariances, plans.times, plans.ends.tolist(), strict=True)
    return [
        answer(
            model.suite,
            t_end,
            covariance,
            t_end < model.longest,
            over_flights,
            overrun(end, duration),
        )
        for t_end, covariance, over_flights, end in found
    ]


def answer(
    suite: Suite,
    t_end: float,
    covariance: Floats,
    converged: bool,
    over_flights: Times = UNKNOWN,
    beyond: str | None = None,
) -> str:
    """Time to converge, and the 1-sigma of the worst body axis of the attitude and of each bias.

    A time that is promised over flights comes first: it is what to rely on.

    Parameters
    ----------
    t_end : float
        When the filter has converged or the run ended [s]; NaN if its covariance was lost.
    covariance : array, shape (n_states, n_states)
        Of the error state then.
    over_flights : Times, optional
        Times to converge that are promised and kept over flights.
    beyond : str, optional
        That the plan ends after the scenario's duration, see `overrun`.
    """
    if not math.isfinite(t_end):
        return "the filter's covariance lost positivity"
    sigma = np.sqrt(np.diag(covariance)).reshape(-1, 3).max(axis=1)
    parts = []
    for block, name, worst in zip(block_units(suite), suite.blocks, sigma, strict=True):
        if name == "attitude" or name.endswith(".bias"):
            parts.append(f"{block.label} {two_digits(worst * block.factor)} {block.unit}")
    known = f"{', '.join(parts)} (1-sigma, worst body axis)"
    kept, promised = over_flights
    late = None if kept is None else within(kept)
    if promised is not None:
        own = f"robust time {span(promised)}" if promised < math.inf else "no robust time"
        after = f"{span(t_end)}, then" if converged else f"not converged, after {span(t_end)}"
        return "; ".join(filter(None, [own, late, f"flown exactly {after} {known}", beyond]))
    after = f"{span(t_end)}; then" if converged else f"not converged; after {span(t_end)}"
    return "; ".join(filter(None, [f"{after} {known}", late, beyond]))


def overrun(end: float, duration: float) -> str | None:
    """That a plan's slew back ends at `end`, after the scenario's duration [s]; None if not."""
    if not duration < end < math.inf:
        return None
    return f"slew back until {span(end)}, {span(end - duration)} after duration"


def within(kept: float) -> str:
    """When most samples converge [s], in words."""
    if kept == math.inf:
        return f"fewer than {MOST_SAMPLES} converge"
    return f"{MOST_SAMPLES} converge within {span(kept)}"


def span(seconds: float) -> str:
    """A time as people say it, to the second: 1 h 40 min 5 s."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = [(hours, "h"), (minutes, "min"), (rest, "s")]
    return " ".join(f"{value} {unit}" for value, unit in parts if value) or "0 s"


def two_digits(value: float) -> str:
    """A number above 0 with two significant digits, all of them if it has more before the point."""
    digits = 1 - math.floor(math.log10(float(f"{value:.1e}")))
    return f"{value:.{max(digits, 0)}f}"
