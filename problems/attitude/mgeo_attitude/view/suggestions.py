"""Suggestions for required 1-sigmas that a longer search cannot reach."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.view.plans import Plans

#: Remaining share of an initial 1-sigma above which an error counts as unobserved.
_UNOBSERVED_SHARE = 0.9
#: Share of a variance above which another error counts as its source.
_SOURCE_SHARE = 0.5


def suggest_changes(plans: Plans) -> list[str]:
    """Suggest how to change a scenario whose required 1-sigmas no plan reaches, with one line of
    text per requirement.

    A requirement is listed if all plans exceed it and if, in the plan that comes closest, most of
    the variance is due to the correlation with an error that the plan does not observe. An example
    is a misalignment of the gyro, which rotates with the whole body.
    """
    model, result = plans.problem.model, plans.nominal
    P = result.covariance[np.isfinite(result.trace)]
    variances = np.diagonal(P, axis1=1, axis2=2)
    lines, units = [], list_block_units(model.suite)
    for block, unit in enumerate(units):
        states = slice(3 * block, 3 * block + 3)
        worst = variances[:, states].max(axis=1)
        if not len(P) or worst.min() <= model.required_sigma[states][0] ** 2:
            continue
        nearest = P[int(worst.argmin())]
        axis = 3 * block + int(np.diag(nearest)[states].argmax())
        source, remaining = _find_error_source(nearest, model.initial_covariance, axis)
        if source is not None:
            name = units[source].label
            lines.append(
                f"Required 1-sigma of {unit.label}: {name} causes most of the error, and the "
                f"maneuvers do not make it observable ({100.0 * remaining:.0f} % of its initial "
                f"1-sigma is left). Reduce the initial uncertainty of {name}, or relax the "
                "requirement."
            )
    return lines


def _find_error_source(P: Floats, P0: Floats, state: int) -> tuple[int | None, float]:
    """Find the error, such as a gyro misalignment, that causes most of the variance of a state and
    that the plan hardly reduces.

    Return its block index, and the ratio of its final to its initial 1-sigma in the direction that
    correlates with the state. Return None and 0 if there is no such error.
    """
    # Test the state's own block first: if it is the source, no other block is.
    for block in sorted(range(len(P) // 3), key=lambda block: block != state // 3):
        states = slice(3 * block, 3 * block + 3)
        along = np.linalg.solve(P[states, states], P[states, state])
        part = float(P[state, states] @ along)
        if part <= _SOURCE_SHARE * P[state, state]:
            continue
        remaining = float(np.sqrt(part / (along @ P0[states, states] @ along)))
        if remaining > _UNOBSERVED_SHARE:
            return block, remaining
    return None, 0.0
