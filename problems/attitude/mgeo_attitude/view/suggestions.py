"""Suggestions for required 1-sigmas that a longer search does not reach."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.view.plans import Plans

#: Remaining share of an initial 1-sigma above which an error counts as not observed.
_UNOBSERVED_SHARE = 0.9
#: Share of a variance above which another error counts as its source.
_SOURCE_SHARE = 0.5


def suggest_changes(plans: Plans) -> list[str]:
    """Return a line for each required 1-sigma that an unobserved error keeps out of reach.

    The nearest plans are examined. A requirement is listed if all of them exceed it because of the
    correlation with an error that they do not observe, such as a misalignment of the gyro that
    rotates with the whole body.
    """
    model, result = plans.problem.model, plans.nominal
    P = result.covariance[np.isfinite(result.trace)]
    variances = np.diagonal(P, axis1=1, axis2=2)
    lines, units = [], list_block_units(model.suite)
    for block, unit in enumerate(units):
        own = slice(3 * block, 3 * block + 3)
        worst = variances[:, own].max(axis=1)
        if not len(P) or worst.min() <= model.required_sigma[own][0] ** 2:
            continue
        nearest = P[int(worst.argmin())]
        axis = 3 * block + int(np.diag(nearest)[own].argmax())
        source, left = _find_error_source(nearest, model.initial_covariance, axis)
        if source is not None:
            name = units[source].label
            lines.append(
                f"required 1-sigma of {unit.label}: most of the error is caused by {name}, which "
                f"these plans do not observe ({left:.0%} of its initial 1-sigma is left): reduce "
                f"the initial uncertainty of {name}, or relax the requirement"
            )
    return lines


def _find_error_source(P: Floats, P0: Floats, state: int) -> tuple[int | None, float]:
    """Return the unobserved block that causes most of a state's variance, or None.

    The second value is the remaining share of the block's initial 1-sigma, in the direction that
    correlates with the state.
    """
    # Test the state's own block first: if it is the source, no other block is.
    for block in sorted(range(len(P) // 3), key=lambda block: block != state // 3):
        of = slice(3 * block, 3 * block + 3)
        along = np.linalg.solve(P[of, of], P[of, state])
        part = float(P[state, of] @ along)
        if part <= _SOURCE_SHARE * P[state, state]:
            continue
        left = float(np.sqrt(part / (along @ P0[of, of] @ along)))
        if left > _UNOBSERVED_SHARE:
            return block, left
    return None, 0.0
