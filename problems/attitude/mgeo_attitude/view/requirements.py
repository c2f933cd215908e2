"""Required 1-sigmas that no longer search reaches."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.suite import block_units
from mgeo_attitude.view.plans import Plans

#: Share of an initial 1-sigma from which on nothing was learned.
_NOTHING = 0.9
#: Share of a variance from which on an error is called its source.
_SOURCE = 0.5


def ways_out(plans: Plans) -> list[str]:
    """Return which required 1-sigmas no longer search reaches, as far as the nearest plans tell.

    A line for each that all of them exceed because of an error of which they learn nothing, such as
    a misalignment of the gyro that turns with the whole body: it leaves what it is correlated with
    as badly known as it is itself.
    """
    model, result = plans.problem.model, plans.exactly
    P = result.covariance[np.isfinite(result.trace)]
    variances = np.diagonal(P, axis1=1, axis2=2)
    lines, units = [], block_units(model.suite)
    for block, unit in enumerate(units):
        own = slice(3 * block, 3 * block + 3)
        worst = variances[:, own].max(axis=1)
        if not len(P) or worst.min() <= model.required_sigma[own][0] ** 2:
            continue
        nearest = P[int(worst.argmin())]
        axis = 3 * block + int(np.diag(nearest)[own].argmax())
        source, left = _source(nearest, model.initial_covariance, axis)
        if source is not None:
            name = units[source].label
            lines.append(
                f"required 1-sigma of {unit.label}: most of it is the error of {name}, of which "
                f"these plans learn nothing ({left:.0%} of its initial 1-sigma is left): know "
                f"{name} better at the start, or relax the requirement"
            )
    return lines


def _source(P: Floats, P0: Floats, state: int) -> tuple[int | None, float]:
    """Return the block whose unlearned error is most of a state's variance, if there is one.

    And the share of its initial 1-sigma that is left, in the direction that matters.
    """
    # the block of the state itself first: it needs no other source
    for block in sorted(range(len(P) // 3), key=lambda block: block != state // 3):
        of = slice(3 * block, 3 * block + 3)
        along = np.linalg.solve(P[of, of], P[of, state])
        part = float(P[state, of] @ along)
        if part <= _SOURCE * P[state, state]:
            continue
        left = float(np.sqrt(part / (along @ P0[of, of] @ along)))
        if left > _NOTHING:
            return block, left
    return None, 0.0
