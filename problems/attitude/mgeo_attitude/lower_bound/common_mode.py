"""Bounds for body-fixed errors that look like an attitude error or a field error.

A misalignment common to all sensors looks like an attitude error; a bias common to all
magnetometers looks like a field error. Only rotation of the body separates them, at rates that
maneuvers allow, while the attitude error drifts with the gyro noise and the field error with its
own process noise.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.lower_bound.curves import bounds_from_information


@dataclass(frozen=True)
class CarrierInformation:
    """Information of one sensor about an inertial error, and its body-fixed errors that look alike.

    Attributes
    ----------
    carrier : str
        Block of the inertial error c, which is fixed in GCRS.
    trace : array, shape (n,)
        Trace of the information about c in each sample.
    body_fixed_errors : dict of Turned
        Body-fixed errors e of the sensor whose readings equal those of c = G Cᵀ e.
    """

    carrier: str
    trace: Floats
    body_fixed_errors: dict[str, BodyFixedError]


class BodyFixedError(NamedTuple):
    """Information about a body-fixed error that looks like a carrier.

    Attributes
    ----------
    trace : array, shape (n,)
        Trace of the information in each sample.
    v : array, shape (n, 3), or None
        G = [v×] in GCRS, for a misalignment, which looks like an error of the vector v; else G = 1.
    """

    trace: Floats
    v: Floats | None

    def has_same_transformation(self, other: BodyFixedError) -> bool:
        """Return whether both errors have the same G."""
        if self.v is None or other.v is None:
            return self.v is other.v
        return bool((self.v == other.v).all())


class Carrier(NamedTuple):
    """Inertial error that a body-fixed error may resemble.

    Attributes
    ----------
    decay, noise : float
        Decay factor and least noise variance of a step.
    initial_information : array, shape (3, 3)
        Initial information.
    """

    decay: float
    noise: float
    initial_information: Floats


def compute_following_cost(
    carrier: Carrier, max_angle: float, v: Floats | None, n_samples: int
) -> Floats:
    """Return the information against a carrier that follows a body-fixed error, equation (29).

    Parameters
    ----------
    carrier : Carrier
    max_angle : float
        Largest rotation of the body in a step [rad].
    v : array, shape (n, 3), or None
        See `BodyFixedError`.
    n_samples : int
        Number of samples.

    Returns
    -------
    array, shape (n,)
        Upper bound on the trace of the information about the error, from the carrier's dynamics up
        to each sample.
    """
    costs, decay, along = (
        np.zeros(n_samples),
        carrier.decay,
        1.0 + 2.0 * np.cos(min(max_angle, np.pi)),
    )
    if v is None:  # |R - decay|² for the rotation R of a step, whose trace is at least `along`.
        costs[0] = np.trace(carrier.initial_information)
        costs[1:] = 3.0 * (1.0 + decay**2) - 2.0 * decay * along
    else:  # |[v'×] R - decay [v×]|², where tr [v'×]ᵀ[v×] R = (v' v) tr R - v' R v.
        size, alike = np.linalg.norm(v, axis=1), np.sum(v[1:] * v[:-1], axis=1)
        costs[0] = 2.0 * size[0] ** 2 * np.linalg.eigvalsh(carrier.initial_information)[-1]
        least_trace = np.minimum(along * alike, 3.0 * alike) - size[1:] * size[:-1]
        costs[1:] = 2.0 * (size[1:] ** 2 + (decay * size[:-1]) ** 2 - decay * least_trace)
    costs[1:] /= carrier.noise
    return np.cumsum(costs)


def bound_common_modes(
    name: str,
    carrier: Carrier,
    observations: Sequence[CarrierInformation],
    initial_information: dict[str, Floats],
    max_angle: float,
) -> Iterator[tuple[str, Floats]]:
    """Yield lower bounds on variance sums of body-fixed errors and their carrier, equation (28).

    Parameters
    ----------
    name : str
        Block of the carrier.
    carrier : Carrier
    observations : sequence of Look
        Information of all sensors that observe the carrier.
    initial_information : dict of array, shape (3, 3)
        Initial information about each block; blocks are not correlated.
    max_angle : float
        Largest rotation of the body in a step [rad].

    Yields
    ------
    tuple of str and array, shape (n,)
        Block and bound. A block may have several bounds.
    """
    if carrier.noise <= 0.0:  # A carrier without process noise cannot follow the body.
        return
    totals = [np.cumsum(look.trace) for look in observations]
    for look in observations:
        for block, own in look.body_fixed_errors.items():
            size = 1.0 if own.v is None else np.sum(own.v**2, axis=1).max()
            against = compute_following_cost(carrier, max_angle, own.v, len(own.trace))
            for other, all_told in zip(observations, totals, strict=True):
                if other is not look:
                    follow = [
                        initial_information[b]
                        for b, it in other.body_fixed_errors.items()
                        if it.has_same_transformation(own)
                    ]
                    against = against + _reduce_by_following(size * all_told, follow)
            along = np.cumsum(own.trace)
            yield (
                block,
                bounds_from_information(
                    initial_information[block], along * against / (along + against)
                ).variance_sum,
            )
            if own.v is None:  # The carrier is the rotated error and can follow it completely.
                against = against + _reduce_by_following(along, [initial_information[block]])
                yield name, bounds_from_information(np.zeros((3, 3)), against).variance_sum


def _reduce_by_following(information: Floats, following_errors: Sequence[Floats]) -> Floats:
    """Return the information of another sensor, reduced if its own error can look the same.

    The prior of that error limits how far the error can follow.
    """
    if not following_errors:
        return information
    start = float(np.trace(following_errors[0]))
    return information * start / (information + start)
