"""Errors that read like the attitude's, or the field's, but turn with the body.

A misalignment that all sensors share reads like an error of the attitude, a bias of all
magnetometers like an error of the field. What tells them apart is that the body turns, no faster
than maneuvers may, while the attitude walks as the gyro's noise lets it, the field as its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.bound.curves import least


@dataclass(frozen=True)
class Look:
    """What one sensor tells of a carrier, an error c along GCRS, and of its own that read alike.

    Attributes
    ----------
    carrier : str
    told : array, shape (n,)
        Trace of the information about c in each sample.
    turned : dict of Turned
        Of each error e of the sensor in body axes that reads as c = G Cᵀ e does: what is told of e.
    """

    carrier: str
    told: Floats
    turned: dict[str, Turned]


class Turned(NamedTuple):
    """What is told of an error that turns with the body.

    Attributes
    ----------
    told : array, shape (n,)
        Trace of the information about it in each sample.
    v : array, shape (n, 3), or None
        G = [v×] along GCRS, as a misalignment reads like an error of the vector v; or G = 1.
    """

    told: Floats
    v: Floats | None

    def like(self, other: Turned) -> bool:
        """Whether G is the same."""
        if self.v is None or other.v is None:
            return self.v is other.v
        return bool((self.v == other.v).all())


class Carrier(NamedTuple):
    """How an error along GCRS varies: of a step its decay and least noise; what is known of it."""

    decay: float
    noise: float
    known: Floats


def cost_of_following(carrier: Carrier, angle: float, v: Floats | None, n: int) -> Floats:
    """What it costs a carrier to follow an error of the body until each sample: equation (29).

    Parameters
    ----------
    carrier : Carrier
    angle : float
        By which the body turns in a step at most [rad].
    v : array, shape (n, 3), or None
        See `Turned`.

    Returns
    -------
    array, shape (n,)
        Trace of the information that its dynamics tell of the error; not less than there is.
    """
    costs, decay, along = np.zeros(n), carrier.decay, 1.0 + 2.0 * np.cos(min(angle, np.pi))
    if v is None:  # |R - decay|² of the rotation R of a step, whose trace is `along` at least
        costs[0] = np.trace(carrier.known)
        costs[1:] = 3.0 * (1.0 + decay**2) - 2.0 * decay * along
    else:  # |[v'×] R - decay [v×]|², in which tr [v'×]ᵀ[v×] R = (v' v) tr R - v' R v
        size, alike = np.linalg.norm(v, axis=1), np.sum(v[1:] * v[:-1], axis=1)
        costs[0] = 2.0 * size[0] ** 2 * np.linalg.eigvalsh(carrier.known)[-1]
        least_trace = np.minimum(along * alike, 3.0 * alike) - size[1:] * size[:-1]
        costs[1:] = 2.0 * (size[1:] ** 2 + (decay * size[:-1]) ** 2 - decay * least_trace)
    costs[1:] /= carrier.noise
    return np.cumsum(costs)


def common_modes(
    name: str, carrier: Carrier, looks: Sequence[Look], known: dict[str, Floats], angle: float
) -> Iterator[tuple[str, Floats]]:
    """Least sums of variances of errors that read like a carrier, and of it: equation (28).

    Parameters
    ----------
    name : str
        The carrier's.
    carrier : Carrier
    looks : sequence of Look
        At it, of all sensors that see it.
    known : dict of array, shape (3, 3)
        Information about each 3-vector at the start; they are not correlated.
    angle : float
        By which the body turns in a step at most [rad].

    Yields
    ------
    tuple of str and array, shape (n,)
        Of one error there may be several bounds.
    """
    if carrier.noise <= 0.0:  # it is known but for its start
        return
    told = [np.cumsum(look.told) for look in looks]
    for look in looks:
        for block, own in look.turned.items():
            size = 1.0 if own.v is None else np.sum(own.v**2, axis=1).max()
            against = cost_of_following(carrier, angle, own.v, len(own.told))
            for other, all_told in zip(looks, told, strict=True):
                if other is not look:
                    follow = [known[b] for b, it in other.turned.items() if it.like(own)]
                    against = against + _both(size * all_told, follow)
            along = np.cumsum(own.told)
            yield block, least(known[block], along * against / (along + against)).total
            if own.v is None:  # the carrier is the error's, turned: it follows all the way
                against = against + _both(along, [known[block]])
                yield name, least(np.zeros((3, 3)), against).total


def _both(told: Floats, follow: Sequence[Floats]) -> Floats:
    """What a sensor tells against it, whose own error follows as far as its start lets it."""
    if not follow:
        return told
    start = float(np.trace(follow[0]))
    return told * start / (told + start)
